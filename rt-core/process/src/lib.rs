//! The realtime process: locked memory, a pinned `SCHED_FIFO` thread with embassy's raw executor
//! and the 1 kHz tick, and the publishing thread.
//!
//! ```text
//! run (main thread)   checks, starts the threads; then sleeps and watches the tick
//!  ├─ tick            FIFO 80, own core: sample → … → force → … → publish. It blocks only in the
//!  │                  sleep to the next absolute deadline. It uses no heap and no iceoryx2
//!  ├─ publishing      FIFO 40, other cores: owns every iceoryx2 object
//!  └─ devices         FIFO 81, other cores: opens the devices and reopens lost ones
//! ```
//!
//! The priorities are the defaults. While the tick runs, the threads share only lock-free queues
//! and atomics. Frames for the display pass through the queues of the loan handover.

mod account;
pub mod admission;
/// Writes a line to standard error. Unlike `eprintln!` it does not panic when the reader is gone,
/// because the thread that watches the tick must not die of that.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}
pub(crate) use say;

pub mod alloc_counter;
mod border;
pub mod budget;
mod config;
pub mod control;
mod devices;
mod echoed;
mod error;
pub mod executor;
mod fit;
mod frames;
mod handle_pedal;
mod handover;
mod held_back;
mod held_pedal;
mod inputs;
pub mod notice;
pub mod phase;
pub mod probe;
mod publisher;
pub mod realtime;
mod reconnect;
pub mod refusal;
pub mod rehearsal;
pub mod replay;
mod run;
pub mod runaway;
mod scene;
pub mod schedule;
pub mod scope_line;
mod settings;
mod shared;
mod silence;
mod storage;
mod summary;
mod thread;
mod tick;
mod tick_thread;
pub mod time_driver;
pub mod trial;
mod watch;

pub use config::{AdmissionPolicy, Realtime, RtConfig, Scheduler};
pub use error::RtError;
pub use run::run;
pub use summary::{DeviceReport, Ended, Ready, RtSummary};
pub use watch::FORCE_ZERO_WITHIN;
