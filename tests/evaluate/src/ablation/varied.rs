//! The core's tuned values that this build can vary: none. `ablation` puts another file in this
//! one's place in its copy of the sources.

/// Names of the values, and what the sources give them.
pub(super) const NAMES: [(&str, &str); 0] = [];

/// Multiplies a value by a factor.
pub(super) fn vary(_: usize, _: f32) {}

/// True if the core has read a value since [`forget_reads`].
pub(super) fn was_read(_: usize) -> bool {
    false
}

/// Forgets which values were read.
pub(super) fn forget_reads() {}
