//! Host time and the control period.

/// One control period, s.
pub const TICK_S: f32 = 0.001;

/// Host time: nanoseconds of `CLOCK_MONOTONIC`.
pub type TimeNs = u64;
