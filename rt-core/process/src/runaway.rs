//! A tick that never sleeps: the kernel tells us, we take the core away from it.
//!
//! `RLIMIT_RTTIME` bounds how long a realtime thread may run without sleeping once. Past the soft
//! limit the process gets `SIGXCPU`, and the main thread takes the tick off the realtime scheduler;
//! past the hard limit, when not even the main thread gets a core, the kernel kills the process.
//! Either way the device's own watchdog (100 ms at most), where it has one, has dropped the force
//! before.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::io;
use std::sync::Arc;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal_hook::SigId;
use signal_hook::consts::SIGXCPU;

/// Longest run of a realtime thread without a sleep: hundreds of periods.
const SOFT_US: u64 = 200_000;
/// Then the kernel ends it.
const HARD_US: u64 = 2_000_000;

/// Watches for runaway realtime threads of this process for as long as it lives.
#[derive(Debug)]
pub struct RunawayGuard {
    tripped: Arc<AtomicBool>,
    handler: SigId,
}

impl RunawayGuard {
    /// Sets the limits and the handler.
    ///
    /// # Errors
    /// What the system says.
    pub fn arm() -> io::Result<Self> {
        let tripped = Arc::new(AtomicBool::new(false));
        // The handler first: the signal's own action is to end the process.
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

    /// Whether a thread ran away.
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
