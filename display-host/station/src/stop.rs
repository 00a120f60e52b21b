//! Signals, and the flag that ends a command: Ctrl-C, SIGTERM, a closed terminal and a dead parent
//! set it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Lets a write beyond the limit of `ulimit -f` fail with an error instead of ending the process.
///
/// # Errors
///
/// The system's error.
pub(crate) fn outlive_file_limit() -> std::io::Result<()> {
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default()).map(drop)
}

/// Installs the handlers and returns the flag. A second Ctrl-C ends the process at once.
///
/// # Errors
///
/// The system's error.
pub(crate) fn flag() -> std::io::Result<Arc<AtomicBool>> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::flag::{register, register_conditional_shutdown};
    let stop = Arc::new(AtomicBool::new(false));
    // The order matters: at the first Ctrl-C, the handler that ends the process finds the flag
    // clear, and the next handler sets it.
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
///
/// If `parent` is dead already, or the system's error.
pub(crate) fn end_with_parent(parent: i32) -> std::io::Result<()> {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};
    set_parent_process_death_signal(Some(Signal::TERM))?;
    // If the parent died before this took effect, another process has adopted us.
    if getppid().map(|pid| pid.as_raw_nonzero().get()) != Some(parent) {
        return Err(std::io::Error::other(format!(
            "process {parent}, which started this one, is gone"
        )));
    }
    Ok(())
}
