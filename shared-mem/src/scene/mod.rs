//! The compiled scene: one file that preparation writes and the processes map read-only.
//!
//! ```text
//! header   magic, layout version, section count, identity, length in bytes
//! table    kind, element size, offset and count of each section
//! sections plain records, each 64-byte aligned
//! ```
//!
//! The last two sections, trocar and stones, are absent in a scene without them. So a scene without
//! trocar and stones has the same bytes and identity as before the format had them.
//!
//! A file may hold several levels of detail, finest first. Each level is a complete scene with an
//! identity of its own, and begins at a multiple of 64 bytes.
//!
//! The file is not trusted: [`SceneFile::open`] checks sizes, alignment, identity, indices and
//! numbers before it returns the scene.

mod check;
mod error;
mod file;
mod header;
mod levels;
mod record;
mod write;

pub use error::SceneError;
pub use file::SceneFile;
pub use levels::LEVELS_MAX;
pub use record::{
    AttachmentRecord, BINDINGS, COLUMNS, CONTACT_BINDINGS, CellColumnRecord, CellRecord,
    ContactVertexRecord, LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord,
    SphereRecord, StonesRecord, TetraRecord, TrocarRecord, VertexRecord, WEIGHT_SUM, WORLD,
    name_from_str, str_from_name,
};
pub use write::SceneData;

/// First eight bytes of a compiled scene.
pub const MAGIC: [u8; 8] = *b"CALOTSCN";
/// Version of the file's layout. It changes when a record changes that scenes of a release may
/// have.
pub const LAYOUT_VERSION: u32 = 7;
/// Index that stands for no contact vertex.
pub const NO_CONTACT_VERTEX: u16 = u16::MAX;
/// Index that stands for no cell.
pub const NO_CELL: u16 = u16::MAX;
/// Identity of a scene: BLAKE3 hash of section table and sections. Two processes run the same scene
/// if and only if their scenes have equal identities.
pub type SceneId = [u8; 32];
