//! One flag that Ctrl-C, SIGTERM, a closed terminal and a dead parent set.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Installs the handlers. A second Ctrl-C ends the process at once.
///
/// # Errors
/// What the system says.
pub(crate) fn flag() -> std::io::Result<Arc<AtomicBool>> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::flag::{register, register_conditional_shutdown};
    let stop = Arc::new(AtomicBool::new(false));
    // In this order: the first Ctrl-C finds the flag clear, and the next handler sets it.
    let interrupted = Arc::new(AtomicBool::new(false));
    register_conditional_shutdown(SIGINT, 130, interrupted.clone())?;
    register(SIGINT, interrupted)?;
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        register(signal, stop.clone())?;
    }
    Ok(stop)
}

/// Asks the kernel for SIGTERM when `parent` dies, so that no child outlives its station.
///
/// # Errors
/// When it is dead already, and what the system says.
pub(crate) fn end_with_parent(parent: i32) -> std::io::Result<()> {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};
    set_parent_process_death_signal(Some(Signal::TERM))?;
    // It may have died before that took effect: then somebody else has adopted us.
    if getppid().map(|pid| pid.as_raw_nonzero().get()) != Some(parent) {
        return Err(std::io::Error::other(format!(
            "process {parent}, which started this one, is gone"
        )));
    }
    Ok(())
}
