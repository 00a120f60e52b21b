//! Rust twins of the shaders' structs, and the shaders' sources. A test compares sizes and offsets.

use bytemuck::{Pod, Zeroable};

/// `Frame` in `frame.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[allow(missing_docs)] // explained in frame.wgsl
pub struct Frame {
    pub clip_from_world: [[f32; 4]; 4],
    pub shadow_from_world: [[f32; 4]; 4],
    pub camera: [f32; 4],
    pub forward: [f32; 4],
    pub up: [f32; 4],
    pub light: [f32; 4],
    pub light_axis: [f32; 4],
    pub scope: [f32; 4],
    pub adapt: [f32; 4],
    pub film: [f32; 4],
    pub wear: [f32; 4],
    pub counts: [u32; 4],
    pub capsules: [[f32; 4]; 8],
    pub stones: [[f32; 4]; SHADING_STONES],
}

/// `Look` in `light.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)] // explained in light.wgsl
pub struct Look {
    pub low: [f32; 4],
    pub high: [f32; 4],
    pub streak: [f32; 4],
    pub slope: [f32; 4],
    pub wet: [f32; 4],
    pub scatter: [f32; 4],
    pub lobule: [f32; 4],
    pub cell: [f32; 4],
    pub veil: [f32; 4],
}

pub use super::trees::Tree;
use crate::effects::STAINS;

/// `Disc` in `effects.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)] // explained in effects.wgsl
pub struct Disc {
    pub at: [f32; 4],
    pub colour: [f32; 4],
    pub look: [f32; 4],
    pub along: [f32; 4],
}

/// `Stains` in `light.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)] // explained in light.wgsl
pub struct Stains {
    pub places: [[f32; 4]; STAINS],
    pub count: [u32; 4],
    pub window: [f32; 4],
    pub scale: [f32; 4],
    pub up: [f32; 4],
}

/// Largest number of capsules that shade the tissue around them.
pub const SHADING_CAPSULES: usize = 4;
/// Rows of the material table.
pub const LOOKS: usize = 16;
/// Largest number of gallstones that shade the tissue around them.
pub const SHADING_STONES: usize = 12;
/// Number of places for rigid parts: those of an instrument and the trocar, then the clips, then
/// the gallstones.
pub const PARTS: usize = 64;

/// Every shader module: name and complete source.
pub const SHADERS: [(&str, &str); 8] = [
    (
        "tissue",
        concat!(
            include_str!("frame.wgsl"),
            include_str!("light.wgsl"),
            include_str!("tissue.wgsl")
        ),
    ),
    (
        "rigid",
        concat!(
            include_str!("frame.wgsl"),
            include_str!("light.wgsl"),
            include_str!("rigid.wgsl")
        ),
    ),
    (
        "inside",
        concat!(
            include_str!("frame.wgsl"),
            include_str!("light.wgsl"),
            include_str!("inside.wgsl")
        ),
    ),
    (
        "effects",
        concat!(
            include_str!("frame.wgsl"),
            include_str!("light.wgsl"),
            include_str!("effects.wgsl")
        ),
    ),
    (
        "scope mask",
        concat!(include_str!("frame.wgsl"), include_str!("scope_mask.wgsl")),
    ),
    (
        "exposure",
        concat!(include_str!("frame.wgsl"), include_str!("exposure.wgsl")),
    ),
    ("bloom", include_str!("bloom.wgsl")),
    (
        "lens",
        concat!(include_str!("frame.wgsl"), include_str!("lens.wgsl")),
    ),
];

/// Source of a module.
#[must_use]
pub fn shader(name: &str) -> &'static str {
    SHADERS
        .iter()
        .find(|(known, _)| *known == name)
        .map_or("", |(_, source)| source)
}
