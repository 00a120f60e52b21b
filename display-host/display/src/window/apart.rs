//! The window on a thread of its own, so that the process survives the loss of its screen.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use super::{WindowConfig, run, server};
use crate::DisplayError;
use crate::headless::{Observed, Outcome};

/// Period at which the connection to the screen is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// The window's thread has the stack of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// Runs the window as [`run`] does. If it fails, or its screen goes, the caller goes on. A window
/// whose X server has gone leaves its thread behind: Xlib does not come back from there.
///
/// # Errors
/// See [`DisplayError`].
pub fn run_apart(
    config: WindowConfig,
    stop: Arc<AtomicBool>,
    mut observer: impl FnMut(Observed<'_>) + Send + 'static,
) -> Result<Outcome, DisplayError> {
    let lost = |detail: &str| {
        let detail = detail.to_owned();
        Err(DisplayError::WindowLost { detail })
    };
    server::survive_its_loss();
    let (tell, told) = mpsc::channel();
    let window = move || {
        let _ = tell.send(run(&config, &stop, &mut observer));
    };
    let named = std::thread::Builder::new().name("calot-window".to_owned());
    if let Err(error) = named.stack_size(STACK_BYTES).spawn(window) {
        let detail = format!("its thread cannot be started: {error}");
        return Err(DisplayError::NoWindow { detail });
    }
    loop {
        match told.recv_timeout(LOOK_EVERY) {
            Ok(outcome) => return outcome,
            Err(RecvTimeoutError::Timeout) if server::is_lost() => {
                return lost("the X server ended");
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return lost("it panicked"),
        }
    }
}
