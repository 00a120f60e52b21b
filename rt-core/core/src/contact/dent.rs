//! Dents of tools in tissue: the part of a contact that spheres are too coarse to show.

use crate::math::Vec3;

/// The dent under a piece of a tool's part. The spheres have yielded to the tool already; the skin
/// that they carry still reaches into the piece by `depth_m`. The contact law gives the force for
/// this depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dent {
    /// Index of the organ.
    pub organ: u8,
    /// Middle of the piece's axis, world frame, m.
    pub center_m: Vec3,
    /// Half of the piece's axis, m; zero for a round end.
    pub half_m: Vec3,
    /// Radius of the piece, m.
    pub radius_m: f32,
    /// Unit vector from tissue to tool, along which the tissue pushes.
    pub normal: Vec3,
    /// Depth of the tool below the skin of the spheres, along the normal, m; above zero.
    pub depth_m: f32,
}
