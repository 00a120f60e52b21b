//! Watching a station from other computers.
//!
//! ```text
//! station ─ shared memory ─► calot link serve ═ TLS ═► calot link watch ─ shared memory ─► display
//! ```
//!
//! Two processes, of which the realtime process knows nothing. To the station, `serve` is one more
//! host; to displays, `watch` is a controller. The watcher asks for the newest data ([`wire`]): up
//! to four questions ahead while answers are quick, one by one while they are late. A slow line
//! therefore carries fewer pictures, and none of them waits for long. A stopped watcher asks for
//! nothing. Events are asked for again until they arrive. Everything from the line is checked
//! before use. Only a peer with a certificate of the same authority can connect.

mod address;
mod clock;
mod desk;
mod error;
mod inbox;
mod line;
mod pace;
mod serve;
mod watch;
pub mod wire;

pub use address::{Address, Keys};
pub use clock::RemoteClock;
pub use desk::Desk;
pub use error::{LinkError, MAKE_KEYS};
pub use inbox::{Fresh, Inbox};
pub use serve::{Served, serve};
pub use watch::{Seen, WatchConfig, Watched, watch};

/// Time now on `CLOCK_MONOTONIC`, the clock of all stamps, ns.
fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    let (s, ns) = (now.tv_sec, now.tv_nsec);
    u64::try_from(s).unwrap_or(0) * 1_000_000_000 + u64::try_from(ns).unwrap_or(0)
}
