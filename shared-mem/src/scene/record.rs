//! Records of a compiled scene.

use bytemuck::{Pod, Zeroable};

use crate::message::PoseMsg;

/// Spheres that one skin vertex is bound to, at most.
pub const BINDINGS: usize = 8;
/// Spheres that one contact vertex follows, at most.
pub const CONTACT_BINDINGS: usize = 12;
/// Stands for the second sphere of an [`AttachmentRecord`] that ends at a point of the world.
pub const WORLD: u32 = u32::MAX;
/// The quantised weights of a vertex sum to this.
pub const WEIGHT_SUM: u32 = 65_535;

/// Anatomical kind of an organ. It selects the look and the role in the procedure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
#[allow(missing_docs)]
pub enum OrganKind {
    Liver = 1,
    Gallbladder = 2,
    CysticDuct = 3,
    CysticArtery = 4,
    BileDuct = 5,
    Stomach = 6,
    Intestine = 7,
    Fat = 8,
    ConnectiveTissue = 9,
    AbdominalWall = 10,
    Vessel = 11,
}

impl OrganKind {
    /// All kinds.
    pub const ALL: [Self; 11] = [
        Self::Liver,
        Self::Gallbladder,
        Self::CysticDuct,
        Self::CysticArtery,
        Self::BileDuct,
        Self::Stomach,
        Self::Intestine,
        Self::Fat,
        Self::ConnectiveTissue,
        Self::AbdominalWall,
        Self::Vessel,
    ];

    /// The kind with this number.
    #[must_use]
    pub fn from_u32(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u32 == number)
    }
}

/// Places of devices, ports and target. A scene has one.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RoomRecord {
    /// Scene's name, UTF-8, padded with zeros.
    pub name: [u8; 64],
    /// Gravity, m/s².
    pub gravity_m_s2: [f32; 3],
    /// Base frame of the haptic device.
    pub world_from_device: PoseMsg,
    /// Transmitter frame of the tracker.
    pub world_from_tracker: PoseMsg,
    /// The instrument's trocar, m.
    pub instrument_port_m: [f32; 3],
    /// From the handle to the tip, along the shaft, m.
    pub instrument_length_m: f32,
    /// The endoscope's port, m.
    pub endoscope_port_m: [f32; 3],
    /// Camera before the first tracker sample: looks along −z, y up.
    pub world_from_camera: PoseMsg,
    /// Point on the skin of the target organ at which the scripted hand works, m.
    pub target_m: [f32; 3],
    /// Outward normal there.
    pub target_normal: [f32; 3],
    /// Index of the target organ.
    pub target_organ: u32,
    /// Time of a breath, s; 0: nobody breathes.
    pub breath_s: f32,
}

/// A material. The SI values are the tissue's; the dimensionless ones tune the paper's method.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MaterialRecord {
    /// kg/m³.
    pub density_kg_m3: f32,
    /// Young's modulus, Pa.
    pub young_pa: f32,
    /// Poisson's ratio, 0..0.5.
    pub poisson: f32,
    /// Share of a link's stretch corrected in an iteration, 0..=1 (paper Eq. 4–5).
    pub stretch_stiffness: f32,
    /// Share of the way to the Laplacian target, 0..=1 (paper Eq. 8).
    pub laplacian_stiffness: f32,
    /// Fraction of velocity lost per second.
    pub damping_per_s: f32,
    /// Hooke constant of the haptic force, N/m.
    pub contact_stiffness_n_m: f32,
    /// Strain-rate damping: the time by which stress runs ahead of strain (Kelvin–Voigt:
    /// viscosity over modulus), s.
    pub retardation_s: f32,
    /// Coulomb friction on a moist steel tool: tangential over normal force.
    pub friction: f32,
    /// Energy that it takes to tear or cut a unit of area, J/m²; 0: does not tear.
    pub toughness_j_m2: f32,
}

/// An organ: ranges into the other sections.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct OrganRecord {
    /// Name, UTF-8, padded with zeros.
    pub name: [u8; 32],
    /// An [`OrganKind`] as a number.
    pub kind: u32,
    /// Spheres: first and count.
    pub spheres: [u32; 2],
    /// Links: first and count. A link joins spheres of its own organ.
    pub links: [u32; 2],
    /// Tetrahedra: first and count. Between spheres of its own organ.
    pub tetrahedra: [u32; 2],
    /// Number of its links, from the first, that carry load beside the tetrahedra. The others serve
    /// the paper's method and list neighbours.
    pub elastic_links: u32,
    /// Steps in a tick that its stiffness needs.
    pub substeps: u32,
    /// Share of gravity that acts: 0 if the shape at rest is the one in the body, where weight is
    /// in balance; 1 if it is the unloaded one.
    pub gravity_share: f32,
    /// Displacement of its held spheres by a breath, m.
    pub breath_m: [f32; 3],
    /// Skin vertices: first and count. Bound to spheres of its own organ.
    pub vertices: [u32; 2],
    /// Skin triangles: first and count. Of vertices of its own organ.
    pub triangles: [u32; 2],
    /// Volume inside the skin at rest, m³.
    pub volume_m3: f32,
    /// Material.
    pub material: MaterialRecord,
}

/// A sphere at rest.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SphereRecord {
    /// Centre, world frame, m.
    pub center_m: [f32; 3],
    /// Radius, m.
    pub radius_m: f32,
    /// Mass, kg.
    pub mass_kg: f32,
    /// 1: attached to its surroundings.
    pub held: u32,
}

/// A distance constraint.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LinkRecord {
    /// First sphere, index into the scene's spheres.
    pub a: u32,
    /// Second sphere.
    pub b: u32,
    /// Length at rest, m.
    pub rest_length_m: f32,
    /// Stretch per force, m/N; of the first `elastic_links` of an organ.
    pub compliance_m_n: f32,
}

/// Four spheres of one organ with the tissue between and around them.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TetraRecord {
    /// Its corners, indices into the scene's spheres; `det(b − a, c − a, d − a)` is positive.
    pub spheres: [u16; 4],
    /// The share of the organ's volume that it carries, m³.
    pub volume_m3: f32,
}

/// A thread or band between spheres of two organs, or between a sphere and the world.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct AttachmentRecord {
    /// First sphere, index into the scene's spheres.
    pub a: u32,
    /// Second sphere, or [`WORLD`].
    pub b: u32,
    /// Its end in the world, m, if `b` is [`WORLD`].
    pub anchor_m: [f32; 3],
    /// Length at rest, m; 0 holds the two together.
    pub rest_length_m: f32,
    /// Stretch per force, m/N.
    pub compliance_m_n: f32,
    /// 1: pulls and never pushes (a suture).
    pub is_thread: u32,
    /// Energy that it takes to tear it, J; 0: does not tear.
    pub tear_j: f32,
}

/// A skin vertex and the spheres that move it (paper Eq. 9–12).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct VertexRecord {
    /// Position at rest, world frame, m.
    pub position_m: [f32; 3],
    /// Outward unit normal at rest.
    pub normal: [f32; 3],
    /// Spheres it follows, indices into the scene's spheres; unused ones repeat the first.
    pub spheres: [u16; BINDINGS],
    /// Their weights; sum is [`WEIGHT_SUM`], unused ones are zero.
    pub weights: [u16; BINDINGS],
}

/// A vertex of the contact skin, which tools meet; coarser than the skin that is drawn.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct ContactVertexRecord {
    /// Spheres of one organ that it follows, indices into the scene's spheres; unused ones have
    /// weight 0.
    pub spheres: [u16; CONTACT_BINDINGS],
    /// Their weights; the sum is 1. Some may be negative.
    pub weights: [f32; CONTACT_BINDINGS],
    /// Triangles around it: first and count, each by its two other corners.
    pub fan: [u32; 2],
    /// A force on it reaches the spheres as if spread over a Gaussian `exp(−r²/A²)`: A, m.
    pub patch_m: f32,
    /// Mean curvature of the skin at rest, 1/m: positive where it bulges outwards.
    pub curvature_per_m: f32,
}

/// Cells under one contact vertex, at most.
pub const COLUMNS: usize = 6;

/// A cell of layered tissue (fat, connective tissue): a hexahedron that is removed whole. It
/// belongs to the organ of its spheres. The cells of an organ follow each other.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct CellRecord {
    /// Its corners, indices into the scene's cell corners. Bit 0 of a corner's place is along the
    /// course, bit 1 around it, bit 2 outwards; the three ways are right-handed.
    pub corners: [u16; 8],
    /// The cells across its faces: back and on along the course, back and on around it, inwards,
    /// outwards; [`super::NO_CELL`] where there is none. Each names the other.
    pub neighbours: [u16; 6],
    /// Spheres of one organ that its middle follows, the nearest first. The cell belongs to the
    /// nearest. Unused ones have weight 0.
    pub spheres: [u16; CONTACT_BINDINGS],
    /// Their weights; the sum is 1. Some may be negative.
    pub weights: [f32; CONTACT_BINDINGS],
    /// Middle at rest, world frame, m.
    pub center_m: [f32; 3],
    /// Mean length along the course, around it, and outwards, m.
    pub extent_m: [f32; 3],
    /// Volume at rest, m³.
    pub volume_m3: f32,
    /// Energy that it takes to remove it, J.
    pub energy_j: f32,
    /// Layer, 0 the innermost.
    pub layer: u8,
    /// Region: [`CellRecord::NOWHERE`], `TRIANGLE`, `LOWER_BED`, `UPPER_BED`. The cleared share of
    /// a region is the volume of its removed cells ([`crate::message::Event::Removed`]) over that
    /// of all its cells.
    pub region: u8,
    /// Zero.
    pub reserved: [u8; 2],
}

impl CellRecord {
    /// In no named region.
    pub const NOWHERE: u8 = 0;
    /// In Calot's triangle: between cystic duct, bile duct and liver.
    pub const TRIANGLE: u8 = 1;
    /// In the lower third of the gallbladder's bed, at its neck.
    pub const LOWER_BED: u8 = 2;
    /// In the rest of the bed.
    pub const UPPER_BED: u8 = 3;
}

/// Cells of layered tissue under a contact vertex. The number of removed cells behind each of these
/// tells how far the surface has receded there.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct CellColumnRecord {
    /// The cells under it, the nearest first; [`super::NO_CELL`] where there are fewer.
    pub cells: [u16; COLUMNS],
    /// The face of each, and of those behind it, that leads away from the surface.
    pub inwards: [u8; COLUMNS],
    /// Zero.
    pub reserved: [u8; 2],
}

/// A fixed name field from a string, cut at a character border.
#[must_use]
pub fn name_from_str<const N: usize>(name: &str) -> [u8; N] {
    let mut field = [0; N];
    let end = (0..=name.len().min(N))
        .rev()
        .find(|&i| name.is_char_boundary(i))
        .unwrap_or(0);
    field[..end].copy_from_slice(&name.as_bytes()[..end]);
    field
}

/// The string in a fixed name field, up to the first zero; `None` if it is not UTF-8.
#[must_use]
pub fn str_from_name(field: &[u8]) -> Option<&str> {
    let end = field.iter().position(|&b| b == 0).unwrap_or(field.len());
    core::str::from_utf8(&field[..end]).ok()
}
