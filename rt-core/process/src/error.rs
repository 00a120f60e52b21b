//! Why a run did not start, or broke off.

use shared_mem::scene::SceneError;
use shared_mem::service::ServiceError;

/// Why the realtime process did not start, or broke off.
#[derive(Debug, thiserror::Error)]
pub enum RtError {
    /// A number of the configuration is out of its range.
    #[error("{what} is {value}, allowed are {min} to {max}")]
    Config {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: u64,
        /// Least allowed.
        min: u64,
        /// Most allowed.
        max: u64,
    },
    /// The compiled scene is refused.
    #[error("scene: {0}")]
    Scene(#[from] SceneError),
    /// The core does not take the scene.
    #[error("scene does not fit the simulation: {0}")]
    Core(rt_core::scene::SceneError),
    /// No level of the scene fits this machine, and the run is strict.
    #[error("{}; take a coarser scene (`calot prepare --spheres`) or run without --strict", .0.in_words())]
    DoesNotFit(Box<crate::admission::Admission>),
    /// The station is taken, or the services do not open.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// A device that is configured cannot be opened or does not answer.
    #[error("{device}: {source}")]
    Device {
        /// Which: haptic device, tracker, pedal, or the station file that names them.
        device: &'static str,
        /// What `hardware` says.
        source: hardware::HardwareError,
    },
    /// The oscilloscope's line cannot be driven.
    #[error(
        "scope line {tty}: {source}; name the port of a UART that has modem lines (--scope-tty)"
    )]
    ScopeLine {
        /// The port.
        tty: std::path::PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// The system refused a thread.
    #[error("cannot start the {thread} thread: {source}; is memory or the process limit used up?")]
    Thread {
        /// Which.
        thread: &'static str,
        /// The system's words.
        source: std::io::Error,
    },
    /// A session is to be shown from a time on that it does not have.
    #[error(
        "the session is {length_s:.3} s long, so nothing of it comes after {from_s} s; allowed are 0 to \
         less than its length (--from)"
    )]
    NothingToShow {
        /// From when on.
        from_s: f64,
        /// How long it is, up to its end or first gap.
        length_s: f64,
    },
    /// A thread panicked: a bug. The force was set to zero on the way out.
    #[error("the {thread} thread panicked: {message}; the force is zero; please report this")]
    Panicked {
        /// Which.
        thread: &'static str,
        /// Its last words.
        message: String,
    },
    /// The tick did not end when asked: a bug, or a machine that stands still.
    #[error(
        "the tick did not end within {waited_ms} ms after it was asked to; it was taken off the \
         realtime scheduler; the device's own watchdog, if it has one, takes its force away"
    )]
    Wedged {
        /// How long was waited.
        waited_ms: u64,
    },
}
