//! Names of the stages of a tick.

use shared_mem::message::STAGES;

/// Stages of a tick, in the order in which they run.
pub(crate) const STAGE_NAMES: [&str; STAGES] = [
    "sample",
    "tool",
    "contact",
    "solve",
    "force",
    "procedure",
    "publish",
];
