//! Lengths of the arrays in the messages.
//!
//! The core has limits of its own, because neither package may depend on the other. `border.rs` of
//! `rt-process` sees both and does not compile if they differ.

use crate::words::Fault;

/// Spheres in a [`crate::message::StateFrame`].
pub const MAX_SPHERES: usize = 4096;
/// Cells of layered tissue in a [`crate::message::StateFrame`].
pub const MAX_CELLS: usize = 8192;
/// Clips on tubes in a [`crate::message::StateFrame`]. A clip on two tubes counts twice.
pub const MAX_CLIPPED: usize = 24;
/// Sutures in a [`crate::message::StateFrame`].
pub const MAX_SUTURES: usize = 8;
/// Capsules in a [`crate::message::ToolFrame`].
pub const MAX_CAPSULES: usize = 16;
/// Records in a [`crate::message::TimingBatch`].
pub const TIMING_BATCH: usize = 64;
/// Stages of a tick, in order: sample, tool, contact, solve, force, procedure, publish.
pub const STAGES: usize = 7;
/// Kinds of faults that a [`crate::message::TimingBatch`] counts.
pub const FAULTS: usize = Fault::ALL.len();
