//! The station's window.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use shared_mem::service::Station;

use crate::DisplayError;
use crate::headless::{Observed, Outcome};

/// How to run a window.
#[derive(Debug, Clone)]
pub struct WindowConfig {
    /// Station to watch.
    pub station: Station,
    /// Compiled scene.
    pub scene: PathBuf,
    /// Inner size to start with, pixels.
    pub size: [u32; 2],
    /// End after this time; `None`: when the user closes it.
    pub seconds: Option<f64>,
    /// Core of the realtime thread, to stay off.
    pub tick_cpu: Option<usize>,
}

/// Opens the window and runs it until it is closed, `stop` is set, or the time is over. Must be
/// called on the main thread, once a process.
///
/// # Errors
/// As they say.
pub fn run(
    config: &WindowConfig,
    stop: &AtomicBool,
    observer: &mut dyn FnMut(Observed<'_>),
) -> Result<Outcome, DisplayError> {
    let _ = (config, stop, observer);
    Err(DisplayError::NoWindow {
        detail: "not built yet".into(),
    })
}
