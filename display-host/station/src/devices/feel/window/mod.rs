//! Leads a person through `feel` in a window. The test runs on a thread of its own, so that
//! neither a slow picture nor a lost screen holds up the device.

mod desk;
mod guide;
mod signs;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use display_host::DisplayError;
use display_host::window::{answers, show_page_apart};
use display_host::words::{Language, Words};
use hardware::feel::{Felt, Guide as _, feel};
use rt_core::port::{ForceCommand, HapticDevice};

use self::desk::Desk;
use self::guide::Windowed;
use self::signs::Signs;
use crate::problem::Problem;

/// Inner size of the window, pixels. With its frame it fits on a screen of 1280 × 800.
const SIZE: [u32; 2] = [1280, 720];

/// Device that is tested, and settings of the test.
pub(super) struct Bench {
    pub(super) device: Box<dyn HapticDevice + Send>,
    /// Seed of the order of the pushes.
    pub(super) seed: u64,
    /// Set by Ctrl-C.
    pub(super) stop: Arc<AtomicBool>,
}

/// Checks that a window can be opened. The caller opens the device afterwards.
///
/// # Errors
///
/// There is no screen.
pub(super) fn check() -> Result<(), Problem> {
    answers().map_err(without_window)
}

/// Adds to the error of a missing screen that the test works in the terminal too.
fn without_window(error: DisplayError) -> Problem {
    match error {
        DisplayError::NoWindow { detail } => format!(
            "cannot open a window: {detail}. Leave `--window` out: then the terminal leads through \
             the test"
        )
        .into(),
        other => other.into(),
    }
}

/// Runs the test and shows it until the window is closed. `report` gets the results when the test
/// ends. Returns true if the device passed.
///
/// # Errors
///
/// The window is lost, or `report` fails. In both cases the device is without force.
pub(super) fn lead(
    bench: Bench,
    language: Language,
    report: impl FnOnce(&Felt) -> Result<(), Problem> + Send,
) -> Result<bool, Problem> {
    let Bench {
        mut device,
        seed,
        stop,
    } = bench;
    let can = device.capabilities();
    let signs = Arc::new(Signs::default());
    let (desk, mut guide) = Desk::new(Words::new(language), &can, &signs, &stop);
    let no_window = &AtomicBool::new(false);
    let test = move || {
        keep_quiet(&mut *device, &mut guide);
        if no_window.load(SeqCst) {
            return Ok(false);
        }
        let felt = feel(&mut *device, &mut guide, seed);
        drop(device);
        let reported = report(&felt).map_err(|problem| problem.to_string());
        guide.end(&felt.report);
        reported.map(|()| felt.report.passed())
    };
    std::thread::scope(|threads| {
        let named = std::thread::Builder::new().name("calot-feel".to_owned());
        let test = named.spawn_scoped(threads, test)?;
        let shown = show_page_apart(SIZE, stop, desk);
        no_window.store(shown.is_err() && !signs.is_seen(), SeqCst);
        // Without a window nobody can answer. So end the test and every force.
        signs.halt();
        let passed = test
            .join()
            .unwrap_or_else(|it| std::panic::resume_unwind(it));
        shown.map_err(without_window)?;
        Ok(passed?)
    })
}

/// Reads the device, without force, until the person sees the window or the test must end.
fn keep_quiet(device: &mut dyn HapticDevice, guide: &mut Windowed) {
    while !guide.is_seen() && !guide.is_stopped() {
        let now_ns = guide.wait();
        let _ = device.poll(now_ns);
        device.send(ForceCommand::default(), now_ns);
    }
}
