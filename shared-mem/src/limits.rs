//! Lengths of the arrays in the messages.
//!
//! The package `rt-core` defines the same limits once more, because neither package may depend on
//! the other. `border.rs` of `rt-process` compares both and does not compile if they differ.

use crate::words::Fault;

/// Most spheres in a [`crate::message::StateFrame`].
pub const MAX_SPHERES: usize = 4096;
/// Most cells of layered tissue in a [`crate::message::StateFrame`].
pub const MAX_CELLS: usize = 8192;
/// Most clips on tubes in a [`crate::message::StateFrame`]. A clip on two tubes counts twice.
pub const MAX_CLIPPED: usize = 24;
/// Most sutures in a [`crate::message::StateFrame`].
pub const MAX_SUTURES: usize = 8;
/// Most capsules in a [`crate::message::ToolFrame`].
pub const MAX_CAPSULES: usize = 16;
/// Most records in a [`crate::message::TimingBatch`].
pub const TIMING_BATCH: usize = 64;
/// Number of stages of a tick. In order: sample, tool, contact, solve, force, procedure, publish.
pub const STAGES: usize = 7;
/// Number of kinds of faults that a [`crate::message::TimingBatch`] counts.
pub const FAULTS: usize = Fault::ALL.len();
