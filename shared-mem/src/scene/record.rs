//! Records of a compiled scene.

use bytemuck::{Pod, Zeroable};

use crate::message::PoseMsg;

/// Largest number of spheres that one skin vertex follows.
pub const BINDINGS: usize = 8;
/// Largest number of spheres that one contact vertex follows.
pub const CONTACT_BINDINGS: usize = 12;
/// Value of [`AttachmentRecord::b`] if the attachment ends at a point of the world.
pub const WORLD: u32 = u32::MAX;
/// Sum of the weights of a skin vertex, which are whole numbers.
pub const WEIGHT_SUM: u32 = 65_535;

/// Anatomical kind of an organ. It determines the organ's appearance and its role in the procedure.
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

/// Positions and poses of devices, ports and target, world frame. A scene has one such record.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RoomRecord {
    /// Scene's name, UTF-8, padded with zeros.
    pub name: [u8; 64],
    /// Gravity, m/s².
    pub gravity_m_s2: [f32; 3],
    /// Pose of the haptic device's base.
    pub world_from_device: PoseMsg,
    /// Pose of the tracker's transmitter.
    pub world_from_tracker: PoseMsg,
    /// The instrument's port (trocar), m.
    pub instrument_port_m: [f32; 3],
    /// Length of the instrument from the handle to the tip, along the shaft, m.
    pub instrument_length_m: f32,
    /// The endoscope's port (trocar), m.
    pub endoscope_port_m: [f32; 3],
    /// Pose of the camera before the first sample of the tracker. The camera looks along −z, and y
    /// is up in the picture.
    pub world_from_camera: PoseMsg,
    /// Point on the skin of the target organ where the scripted hand works, m.
    pub target_m: [f32; 3],
    /// Outward normal of the skin at the target.
    pub target_normal: [f32; 3],
    /// Index of the target organ.
    pub target_organ: u32,
    /// Duration of a breath, s; 0: the patient does not breathe.
    pub breath_s: f32,
}

/// The instrument's trocar. A scene has at most one such record; without it the port neither rubs
/// nor resists tilting. Untilted, the trocar points to the room's target.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TrocarRecord {
    /// Friction of the shaft that slides in the seal, N.
    pub sliding_n: f32,
    /// Friction at which a resting shaft breaks away, N.
    pub breakaway_n: f32,
    /// Elasticity of the abdominal wall against tilting, N m/rad.
    pub wall_nm_rad: f32,
}

/// Stones in the gallbladder. A scene has at most one such record; without it there are none.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct StonesRecord {
    /// Number of stones.
    pub count: u32,
    /// Diameter of each, m.
    pub diameter_m: f32,
    /// Volume inside the gallbladder's wall, m³: bile and stones.
    pub room_m3: f32,
    /// Middle and axes (right, up, back) of the ellipsoid on whose lower half stones come to rest
    /// that miss the organs. Displays draw that half as the bottom of the abdomen.
    pub world_from_bowl: PoseMsg,
    /// The ellipsoid's radii along its axes, m.
    pub bowl_radii_m: [f32; 3],
}

/// A material. The two stiffnesses without a unit are for the inner-sphere paper's method.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MaterialRecord {
    /// Density, kg/m³.
    pub density_kg_m3: f32,
    /// Young's modulus, Pa.
    pub young_pa: f32,
    /// Poisson's ratio, 0..0.5.
    pub poisson: f32,
    /// Share of a link's stretch that one iteration corrects, 0..=1 (paper Eq. 4–5).
    pub stretch_stiffness: f32,
    /// Share of the way to a sphere's Laplacian target (paper Eq. 8) by which one iteration moves
    /// the sphere, 0..=1.
    pub laplacian_stiffness: f32,
    /// Rate at which the velocity decays, 1/s.
    pub damping_per_s: f32,
    /// Stiffness of a sphere's wall under a tool, N/m, in organs without a contact skin.
    pub contact_stiffness_n_m: f32,
    /// Retardation time of the viscous damping (Kelvin–Voigt: viscosity over modulus), s.
    pub retardation_s: f32,
    /// Coefficient of Coulomb friction between the tissue and a moist steel tool.
    pub friction: f32,
    /// Energy of a tear or cut per area, J/m²; 0: the tissue does not tear.
    pub toughness_j_m2: f32,
}

/// An organ: ranges in the other sections, and its material.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct OrganRecord {
    /// Name, UTF-8, padded with zeros.
    pub name: [u8; 32],
    /// An [`OrganKind`] as a number.
    pub kind: u32,
    /// Spheres: first and count.
    pub spheres: [u32; 2],
    /// Links: first and count. They join spheres of this organ.
    pub links: [u32; 2],
    /// Tetrahedra: first and count. Their corners are spheres of this organ.
    pub tetrahedra: [u32; 2],
    /// Number of links that carry load in addition to the tetrahedra: the first ones of the organ.
    /// The inner-sphere paper's method uses all links. All links show which spheres are neighbours.
    pub elastic_links: u32,
    /// Number of substeps in a tick: 1, 2, 4, 8 or 16.
    pub substeps: u32,
    /// Share of gravity that acts on the organ. 0: the rest shape is the shape in the body, in
    /// balance with the weight. 1: the rest shape is the unloaded shape.
    pub gravity_share: f32,
    /// Displacement of the organ's held spheres at full inspiration, world frame, m.
    pub breath_m: [f32; 3],
    /// Skin vertices: first and count. They follow spheres of this organ.
    pub vertices: [u32; 2],
    /// Skin triangles: first and count. Their corners are skin vertices of this organ.
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
    /// 1: the constraints do not move the sphere, because it is fixed or moved by the breath. 0:
    /// they move it.
    pub held: u32,
}

/// A distance constraint between two spheres of one organ.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct LinkRecord {
    /// First sphere, index into the scene's spheres.
    pub a: u32,
    /// Second sphere.
    pub b: u32,
    /// Length at rest, m.
    pub rest_length_m: f32,
    /// Compliance, m/N. Only the first `elastic_links` links of an organ use it.
    pub compliance_m_n: f32,
}

/// A tetrahedron between four spheres of one organ.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct TetraRecord {
    /// The four corners, indices into the scene's spheres; `det(b − a, c − a, d − a)` is positive.
    pub spheres: [u16; 4],
    /// Volume of tissue assigned to this tetrahedron, m³: its own and a part of the organ's volume
    /// outside all tetrahedra. If the tetrahedron joins free and held spheres, the volume is
    /// multiplied by the factor by which the tissue is stiffer there.
    pub volume_m3: f32,
}

/// An attachment: a distance constraint between spheres of two organs, or a sphere and the world.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct AttachmentRecord {
    /// First sphere, index into the scene's spheres.
    pub a: u32,
    /// Second sphere, or [`WORLD`].
    pub b: u32,
    /// End of the attachment in the world, m, if `b` is [`WORLD`].
    pub anchor_m: [f32; 3],
    /// Length at rest, m; 0: the attachment holds the two ends together.
    pub rest_length_m: f32,
    /// Compliance, m/N.
    pub compliance_m_n: f32,
    /// 1: the attachment is a thread (a suture), which only pulls. 0: it pulls and pushes.
    pub is_thread: u32,
    /// Energy that tears the attachment, J; 0: it does not tear.
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
    /// Spheres that the vertex follows, indices into the scene's spheres. Unused entries repeat the
    /// first.
    pub spheres: [u16; BINDINGS],
    /// Weights of the spheres. Their sum is [`WEIGHT_SUM`]; unused entries are zero.
    pub weights: [u16; BINDINGS],
}

/// A vertex of the contact skin: the surface that tools touch. The contact skin is coarser than the
/// drawn skin.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct ContactVertexRecord {
    /// Spheres of one organ that the vertex follows, indices into the scene's spheres. Unused
    /// entries have weight 0.
    pub spheres: [u16; CONTACT_BINDINGS],
    /// Weights of the spheres. Their sum is 1; some may be negative.
    pub weights: [f32; CONTACT_BINDINGS],
    /// Triangles around the vertex: first and count in the scene's contact fans. The contact fans
    /// list the two other corners of each triangle.
    pub fan: [u32; 2],
    /// Width A of the Gaussian `exp(−r²/A²)` that spreads a force on the vertex to the spheres, m.
    pub patch_m: f32,
    /// Mean curvature of the skin at rest, 1/m: positive where it bulges outwards.
    pub curvature_per_m: f32,
}

/// Largest number of cells directly under one contact vertex. Each of them is the first cell of a
/// column.
pub const COLUMNS: usize = 6;

/// A cell of layered tissue (fat, connective tissue): a hexahedron that is removed whole. It
/// belongs to the organ of its spheres. The cells of an organ are consecutive in the list. The
/// layered tissue surrounds an inner organ; the course is that organ's midline.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct CellRecord {
    /// The eight corners, indices into the scene's cell corners. The bits of a corner's position in
    /// this list tell where the corner is: bit 0 is set if it is forwards along the course, bit 1
    /// forwards around it, bit 2 outwards. The three directions are right-handed.
    pub corners: [u16; 8],
    /// Neighbours across the six faces: backwards and forwards along the course, backwards and
    /// forwards around it, inwards, outwards; [`super::NO_CELL`] where there is none. Two
    /// neighbours list each other.
    pub neighbours: [u16; 6],
    /// Spheres of one organ that the middle of the cell follows, the nearest first. The cell
    /// belongs to the nearest sphere. Unused entries have weight 0.
    pub spheres: [u16; CONTACT_BINDINGS],
    /// Weights of the spheres. Their sum is 1; some may be negative.
    pub weights: [f32; CONTACT_BINDINGS],
    /// Middle of the cell at rest, world frame, m.
    pub center_m: [f32; 3],
    /// Mean lengths of the cell along the course, around it, and outwards, m.
    pub extent_m: [f32; 3],
    /// Volume at rest, m³.
    pub volume_m3: f32,
    /// Energy that removes the cell, J.
    pub energy_j: f32,
    /// Number of the layer; 0 is the innermost.
    pub layer: u8,
    /// Region: [`CellRecord::NOWHERE`], `TRIANGLE`, `LOWER_BED` or `UPPER_BED`. The cleared share
    /// of a region is the volume of its removed cells ([`crate::message::Event::Removed`]) divided
    /// by the volume of all its cells.
    pub region: u8,
    /// Zero.
    pub reserved: [u8; 2],
}

impl CellRecord {
    /// In no named region.
    pub const NOWHERE: u8 = 0;
    /// In Calot's triangle: between cystic duct, bile duct and liver.
    pub const TRIANGLE: u8 = 1;
    /// In the lower third of the gallbladder's bed on the liver, at the gallbladder's neck.
    pub const LOWER_BED: u8 = 2;
    /// In the rest of the bed.
    pub const UPPER_BED: u8 = 3;
}

/// Cells of layered tissue directly under a contact vertex. Each is the first of a column of cells
/// that leads away from the surface. The number of removed cells in the columns tells how far the
/// surface has receded.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct CellColumnRecord {
    /// First cell of each column, the nearest column first; [`super::NO_CELL`] in unused entries.
    pub cells: [u16; COLUMNS],
    /// For each column, the face of a cell that points away from the surface: an index into
    /// [`CellRecord::neighbours`].
    pub inwards: [u8; COLUMNS],
    /// Zero.
    pub reserved: [u8; 2],
}

/// A name field with this string, padded with zeros. A string that is too long is cut between two
/// characters.
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

/// The string in a name field, up to the first zero; `None` if it is not UTF-8.
#[must_use]
pub fn str_from_name(field: &[u8]) -> Option<&str> {
    let end = field.iter().position(|&b| b == 0).unwrap_or(field.len());
    core::str::from_utf8(&field[..end]).ok()
}
