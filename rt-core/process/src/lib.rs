//! The realtime process: locked memory, a pinned `SCHED_FIFO` thread, embassy's raw executor on
//! it, the 1 kHz tick, and the publishing thread beside it.
//!
//! ```text
//! run (main thread)   checks, opens, starts; then sleeps and watches
//!  ├─ tick            FIFO 80, own core: sample → … → force → … → publish; no system call that
//!  │                  blocks but the sleep to the next absolute deadline, no heap, no iceoryx2
//!  └─ publishing      FIFO 40, other cores: owns every iceoryx2 object
//! ```
//!
//! Between the threads are only lock-free queues (loan handover for frames) and atomics.

pub mod alloc_counter;
mod config;
pub mod control;
mod error;
pub mod executor;
pub mod realtime;
pub mod schedule;
mod summary;
pub mod time_driver;

use core::sync::atomic::AtomicBool;

pub use config::{Realtime, RtConfig};
pub use error::RtError;
pub use summary::{Ended, Ready, RtSummary};

/// Runs the realtime process until `stop` is set, a host's command ends it, or
/// [`RtConfig::periods_max`] periods are over. Calls `on_ready` once, when it ticks.
///
/// Blocks the calling thread, which should take the signals (`signal_hook::flag` on `stop`). The
/// force is zero when it returns, however it returns.
///
/// # Errors
/// As [`RtError`] says: why it did not start, or broke off.
pub fn run(
    config: &RtConfig,
    _stop: &AtomicBool,
    _on_ready: impl FnOnce(&Ready),
) -> Result<RtSummary, RtError> {
    config.check()?;
    Err(RtError::SceneContent("the tick is being built".into()))
}
