//! Header and section table of a compiled scene's file.

use super::SceneId;

pub(super) const HEADER_BYTES: usize = 64;
pub(super) const TABLE_ENTRY_BYTES: usize = 32;
pub(super) const ALIGN: usize = 64;
/// Number of sections that every scene has.
pub(super) const SECTIONS_MIN: usize = 14;
/// Number of sections of a scene with a trocar and without stones.
pub(super) const SECTIONS_WITH_TROCAR: usize = 15;
/// Number of sections of a scene with stones, which has all sections.
pub(super) const SECTIONS: usize = 16;

/// Header of one level in the file.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Header {
    pub(super) magic: [u8; 8],
    pub(super) version: u32,
    pub(super) sections: u32,
    pub(super) identity: SceneId,
    pub(super) bytes: u64,
    pub(super) reserved: u64,
}

/// Bytes of header and section table.
pub(super) const fn head_bytes(sections: usize) -> usize {
    HEADER_BYTES + sections * TABLE_ENTRY_BYTES
}

/// One row of the section table. The sections have the order of [`super::SceneData`]'s fields.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Section {
    pub(super) kind: u32,
    pub(super) element_bytes: u32,
    pub(super) offset: u64,
    pub(super) count: u64,
    pub(super) reserved: u64,
}
