//! Lengths of the arrays in the messages.
//!
//! The package `rt-core` defines most of these limits too, because neither package may depend on
//! the other. `border.rs` of `rt-process` does not compile if a limit differs between them.

use crate::words::Fault;

/// Largest number of spheres in a [`crate::message::StateFrame`].
pub const MAX_SPHERES: usize = 4096;
/// Largest number of cells of layered tissue in a [`crate::message::StateFrame`].
pub const MAX_CELLS: usize = 8192;
/// Largest number of clips on tubes in a [`crate::message::StateFrame`]. A clip on two tubes counts
/// twice.
pub const MAX_CLIPPED: usize = 24;
/// Largest number of sutures in a [`crate::message::StateFrame`].
pub const MAX_SUTURES: usize = 8;
/// Largest number of stones in a [`crate::message::StateFrame`].
pub const MAX_STONES: usize = 30;
/// Largest number of links of tubes in a [`crate::message::StateFrame`].
pub const MAX_TUBE_LINKS: usize = 2048;
/// Largest number of capsules in a [`crate::message::ToolFrame`].
pub const MAX_CAPSULES: usize = 16;
/// Largest number of dents in a [`crate::message::ToolFrame`].
pub const MAX_DENTS: usize = 64;
/// Largest number of records in a [`crate::message::TimingBatch`].
pub const TIMING_BATCH: usize = 64;
/// Number of stages of a tick: see [`crate::message::STAGE_NAMES`].
pub const STAGES: usize = 7;
/// Largest friction in a [`crate::scene::TrocarRecord`], N.
pub const TROCAR_FRICTION_MAX_N: f32 = 8.0;
/// Largest elasticity of the wall in a [`crate::scene::TrocarRecord`], N m/rad.
pub const TROCAR_WALL_MAX_NM_RAD: f32 = 2.0;
/// Number of kinds of faults that a [`crate::message::TimingBatch`] counts.
pub const FAULTS: usize = Fault::ALL.len();
