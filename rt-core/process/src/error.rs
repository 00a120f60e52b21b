//! Errors of a run.

use shared_mem::scene::SceneError;
use shared_mem::service::ServiceError;

use crate::admission::Admission;

/// Reasons for which the realtime process did not start or broke off.
#[derive(Debug, thiserror::Error)]
pub enum RtError {
    /// A setting is out of its range.
    #[error("{what} is {value}, allowed are {min} to {max}")]
    Config {
        /// Name of the setting.
        what: &'static str,
        /// Its value.
        value: u64,
        /// Smallest allowed value.
        min: u64,
        /// Largest allowed value.
        max: u64,
    },
    /// The compiled scene is invalid.
    #[error("scene: {0}")]
    Scene(#[from] SceneError),
    /// The core refuses the scene.
    #[error("scene does not fit the simulation: {0}")]
    Core(rt_core::scene::SceneError),
    /// No level of the scene fits this machine, and the policy is strict.
    #[error("{}; take a coarser scene (`calot prepare --spheres`) or run without --strict and --must-fit", .0.in_words())]
    DoesNotFit(Box<Admission>),
    /// Linux does not grant realtime, and it was required.
    #[error("realtime is required (--strict) and was refused: {}", refused.join("; "))]
    NotRealtime {
        /// Refusals of Linux, each with its remedy.
        refused: Vec<String>,
    },
    /// The station is taken, or its services do not open.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// A configured device cannot be opened or does not answer.
    #[error("{device}: {source}")]
    Device {
        /// Haptic device, tracker, pedal, or the station file.
        device: &'static str,
        /// Error from `hardware`.
        source: hardware::HardwareError,
    },
    /// The oscilloscope's line cannot be used.
    #[error(
        "scope line {tty}: {source}; name the port of a UART that has modem lines (--scope-tty)"
    )]
    ScopeLine {
        /// The port.
        tty: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The system refused a thread.
    #[error("cannot start the {thread} thread: {source}; is memory or the process limit used up?")]
    Thread {
        /// Name of the thread.
        thread: &'static str,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The start time lies beyond the end of the session.
    #[error(
        "the session is {length_s:.3} s long, so it cannot start at {from_s} s; allowed are 0 to \
         less than its length (--from)"
    )]
    NothingToShow {
        /// Start time, s.
        from_s: f64,
        /// Length up to the end or the first gap, s.
        length_s: f64,
    },
    /// A thread panicked, which is a bug. The force was set to zero before the thread ended.
    #[error("the {thread} thread panicked: {message}; the force is zero; please report this")]
    Panicked {
        /// Name of the thread.
        thread: &'static str,
        /// Message of the panic.
        message: String,
    },
    /// The tick did not end when asked. The cause is a bug, or a machine that does not run the
    /// thread.
    #[error(
        "the tick's thread did not end within {waited_ms} ms of the request; it was taken off the \
         realtime scheduler; the device's own watchdog, if it has one, sets the force to zero"
    )]
    Wedged {
        /// Time waited, ms.
        waited_ms: u64,
    },
}
