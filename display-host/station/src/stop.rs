//! One flag that Ctrl-C, SIGTERM and a dead parent set.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Installs the handlers. A second Ctrl-C ends the process at once.
///
/// # Errors
/// What the system says.
pub(crate) fn flag() -> std::io::Result<Arc<AtomicBool>> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first one only sets the flag, the second finds it set.
        signal_hook::flag::register_conditional_shutdown(signal, 130, stop.clone())?;
        signal_hook::flag::register(signal, stop.clone())?;
    }
    Ok(stop)
}

/// Asks the kernel for SIGTERM when the parent dies, so that no child outlives its station.
///
/// # Errors
/// What the system says.
pub(crate) fn end_with_parent() -> std::io::Result<()> {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};
    set_parent_process_death_signal(Some(Signal::TERM))?;
    // The parent may have died before that took effect: then init has adopted us.
    if getppid().is_none_or(|parent| parent.is_init()) {
        return Err(std::io::Error::other(
            "the process that started this one is gone",
        ));
    }
    Ok(())
}
