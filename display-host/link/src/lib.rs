//! Watching a station from other computers.
//!
//! ```text
//! station ─ shared memory ─► calot link serve ═ TLS ═► calot link watch ─ shared memory ─► display
//! ```
//!
//! `serve` and `watch` are processes of their own; the realtime process knows neither. To the
//! station, `serve` is a reader of shared memory like any display. To displays, `watch` is a
//! controller that refuses commands.
//!
//! # Flow
//!
//! The watcher asks for data that are newer than its own ([`wire`]). It keeps up to four questions
//! under way while answers are quick, and one while they are late (`pace`). A slow line therefore
//! carries fewer frames, and no frame waits for long. A stopped watcher asks for nothing. The
//! watcher asks for events by number until they arrive; `serve` keeps the last 4096. `serve` has a
//! thread for each watcher, so that a slow watcher delays only itself, and does not store what a
//! watcher has received. A message holds only the used part of a frame. The watcher converts time
//! stamps to its own clock, and the quickest answer sets the offset (`clock`). The compiled scene
//! comes in parts. The watcher accepts the whole if its identity is the one in the state.
//!
//! # Trust
//!
//! Everything from the line is checked before use, as if anybody had sent it. Both sides
//! authenticate each other by TLS 1.3 with certificates of one authority (`make_keys.sh`). One kind
//! of certificate allows a station to serve, another allows a watcher to ask. Without certificates,
//! both sides must run on the same computer.

mod address;
mod clock;
mod desk;
mod error;
mod inbox;
mod line;
mod pace;
mod parts;
mod reason;
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
