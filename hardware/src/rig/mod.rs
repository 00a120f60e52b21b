//! Our own serial protocol for rigs (self-built devices), versions 1 and 2. `PROTOCOL.md` documents
//! every byte.
//!
//! [`frame`], [`wire`] and [`device`] are `no_std`, because firmware uses them too. The other
//! modules are the drivers on the host.

#[cfg(feature = "std")]
mod bundles;
pub mod device;
#[cfg(feature = "std")]
mod echo;
pub mod frame;
#[cfg(feature = "std")]
mod handshake_log;
#[cfg(feature = "std")]
mod haptic;
#[cfg(feature = "std")]
mod host;
#[cfg(feature = "std")]
mod judge;
#[cfg(feature = "std")]
mod pedal;
#[cfg(test)]
mod vectors;
#[cfg(feature = "std")]
mod watchdog;
pub mod wire;

#[cfg(feature = "std")]
pub use haptic::{RigHaptic, RigStatus};
#[cfg(feature = "std")]
pub(crate) use host::BAUD;
#[cfg(feature = "std")]
pub use pedal::RigPedal;
#[cfg(feature = "std")]
pub use watchdog::WatchdogDrops;
