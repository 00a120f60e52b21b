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
//!
//! # Flow and trust
//!
//! The realtime process knows nothing of either. To the station `serve` is one more host; to
//! displays `watch` is a controller that refuses commands.
//!
//! The watcher asks for what is newer than what it has (`wire`). It has four questions on their way
//! while answers are quick, one while they are late (`pace`). So it paces itself: a slow line gets
//! fewer pictures, a stopped one asks for nothing. Events are asked for by number until they came
//! (4096 are kept). Nothing of a watcher is kept at the station. Each has a thread there, which it
//! holds up alone. Only the used part of a frame is sent, and it is checked on arrival as if
//! anybody had sent it. Stamps are turned to the watcher's clock by the quickest answer (`clock`).
//! The compiled scene comes in parts and is believed by its identity. Both sides prove themselves
//! in TLS 1.3 by certificates of one authority, a station's for serving, a watcher's for asking
//! (`make_keys.sh`). Without certificates it works on this computer only.

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
