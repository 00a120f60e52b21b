//! Tissue near a stone.

use crate::math::Vec3;

/// Tissue near a stone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    /// Gap between stone and tissue, m; below zero they overlap.
    pub(super) gap_m: f32,
    /// Unit vector from the tissue to the stone.
    pub(super) normal: Vec3,
    /// Sphere of the tissue that is nearest to the stone; `None` for the abdomen below the organs.
    pub(super) sphere: Option<u32>,
}
