//! The window on a thread of its own, so that the process survives the loss of its screen.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use super::{Page, WindowConfig, run, server, show_page};
use crate::DisplayError;
use crate::headless::{Observed, RunOutcome};

/// Period at which the connection to the screen is checked.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Stack of the window's thread, as large as that of a main thread, bytes.
const STACK_BYTES: usize = 8 << 20;

/// Runs the window as [`run`] does, on a thread of its own. The caller goes on if the window fails
/// or its screen is lost. If the X server ends, the window's thread stays blocked, because Xlib
/// does not return from that error.
///
/// # Errors
/// See [`DisplayError`].
pub fn run_apart(
    config: WindowConfig,
    stop: Arc<AtomicBool>,
    mut observer: impl FnMut(Observed<'_>) + Send + 'static,
) -> Result<RunOutcome, DisplayError> {
    apart(move || run(&config, &stop, &mut observer))
}

/// Shows a page as [`show_page`] does, on a thread of its own as [`run_apart`] does, so that the
/// caller outlives the screen.
///
/// # Errors
/// See [`DisplayError`].
pub fn show_page_apart(
    size: [u32; 2],
    stop: Arc<AtomicBool>,
    mut page: impl Page + Send + 'static,
) -> Result<(), DisplayError> {
    apart(move || show_page(size, &stop, &mut page))
}

fn apart<T: Send + 'static>(
    window: impl FnOnce() -> Result<T, DisplayError> + Send + 'static,
) -> Result<T, DisplayError> {
    let lost = |detail: &str| {
        let detail = detail.to_owned();
        Err(DisplayError::WindowLost { detail })
    };
    server::survive_its_loss();
    let (tell, told) = mpsc::channel();
    let window = move || {
        let _ = tell.send(window());
    };
    let named = std::thread::Builder::new().name("calot-window".to_owned());
    let thread = match named.stack_size(STACK_BYTES).spawn(window) {
        Ok(thread) => thread,
        Err(error) => {
            let detail = format!("its thread cannot be started: {error}");
            return Err(DisplayError::NoWindow { detail });
        }
    };
    loop {
        match told.recv_timeout(LOOK_EVERY) {
            Ok(outcome) => {
                // The window's drivers clean up as its thread ends. The process must not end before
                // that.
                let _ = thread.join();
                return outcome;
            }
            Err(RecvTimeoutError::Timeout) if server::is_lost() => {
                return lost("the X server ended");
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return lost("it panicked"),
        }
    }
}
