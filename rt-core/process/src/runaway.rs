//! Detection of a tick that never sleeps. Such a tick is taken off its core.
//!
//! `RLIMIT_RTTIME` bounds the time for which a realtime thread may run without a sleep. At the soft
//! limit the process gets `SIGXCPU`, and the main thread takes the tick off the realtime scheduler.
//! If not even the main thread gets a core, the tick reaches the hard limit, and the kernel kills
//! the process. In either case the device's own watchdog (100 ms at most), if it has one, has
//! already set the force to zero.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::io;
use std::sync::Arc;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal_hook::SigId;
use signal_hook::consts::SIGXCPU;

/// Soft limit of a realtime thread's run without a sleep, µs: hundreds of periods.
const SOFT_US: u64 = 200_000;
/// Hard limit at which the kernel ends the process, µs.
const HARD_US: u64 = 2_000_000;

/// Detects runaway realtime threads of this process until it is dropped.
#[derive(Debug)]
pub struct RunawayGuard {
    tripped: Arc<AtomicBool>,
    handler: SigId,
}

impl RunawayGuard {
    /// Sets the limits and the handler.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn arm() -> io::Result<Self> {
        let tripped = Arc::new(AtomicBool::new(false));
        // The handler is set before the limits, because the signal's default action ends the
        // process.
        let handler = signal_hook::flag::register(SIGXCPU, Arc::clone(&tripped))?;
        let lower = |limit: Option<u64>, to| Some(limit.map_or(to, |limit| limit.min(to)));
        let hard = lower(getrlimit(Resource::Rttime).maximum, HARD_US);
        let soft = lower(hard, SOFT_US);
        setrlimit(
            Resource::Rttime,
            Rlimit {
                current: soft,
                maximum: hard,
            },
        )?;
        Ok(Self { tripped, handler })
    }

    /// True if a thread ran away.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.tripped.load(Relaxed)
    }
}

impl Drop for RunawayGuard {
    fn drop(&mut self) {
        signal_hook::low_level::unregister(self.handler);
    }
}
