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
/// Stack of the window's thread, as large as a main thread's, bytes.
const STACK_BYTES: usize = 8 << 20;

/// Runs the window as [`run`] does, on a thread of its own. The caller goes on if the window fails
/// or its screen is lost. If the X server ends, the window's thread stays blocked, because Xlib
/// would end the process if the handler of that error returned.
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
    let (sender, receiver) = mpsc::channel();
    let window = move || {
        let _ = sender.send(window());
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
        match receiver.recv_timeout(LOOK_EVERY) {
            Ok(outcome) => {
                // The window's drivers clean up as its thread ends, and again as the process ends.
                // Both at once could free memory twice, so this function waits for the thread.
                let _ = thread.join();
                return outcome;
            }
            Err(RecvTimeoutError::Timeout) if server::is_lost() => {
                return lost("the X server ended");
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                let _ = thread.join();
                return lost("it panicked");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::atomic::Ordering::SeqCst;

    use super::*;

    /// Stands for a driver's clean-up as a thread ends.
    struct Frees(Arc<AtomicBool>);

    impl Drop for Frees {
        fn drop(&mut self) {
            std::thread::sleep(4 * LOOK_EVERY);
            self.0.store(true, SeqCst);
        }
    }

    thread_local! {
        static DRIVER: Cell<Option<Frees>> = const { Cell::new(None) };
    }

    #[test]
    fn drivers_have_cleaned_up_once_the_window_is_gone() {
        for panics in [false, true] {
            let is_freed = Arc::new(AtomicBool::new(false));
            let frees = Frees(Arc::clone(&is_freed));
            let outcome = apart(move || {
                DRIVER.set(Some(frees));
                assert!(!panics, "the window panics");
                Ok(())
            });
            assert_eq!(outcome.is_err(), panics);
            assert!(is_freed.load(SeqCst), "panics: {panics}");
        }
    }
}
