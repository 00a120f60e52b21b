//! A station seen from other computers.
//!
//! ```text
//! station ── shared memory ──► calot link serve ══ TLS ══► calot link watch ── shared memory ──► display
//! ```
//!
//! Two processes that the realtime process knows nothing of: to the station `serve` is one more
//! host, and to displays `watch` is a controller. The watcher asks for what is newest ([`wire`]),
//! up to four times ahead while answers are quick and one by one while they are late, so that a
//! slow line gets fewer pictures and soon none that waited for others, a watcher that stands still
//! asks for nothing, and events are asked for again until they came. Whatever comes over the line
//! is checked before anybody sees it. Only who has a certificate of the same authority can connect.

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

/// Now on the clock that all stamps are of (`CLOCK_MONOTONIC`), ns.
fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    let (s, ns) = (now.tv_sec, now.tv_nsec);
    u64::try_from(s).unwrap_or(0) * 1_000_000_000 + u64::try_from(ns).unwrap_or(0)
}
