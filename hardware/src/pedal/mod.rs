//! Foot pedals without the rig protocol: USB pedals, which are keyboards to the kernel
//! ([`EvdevPedal`]), and plain switches on a serial line's control wires ([`ModemPedal`]).
//!
//! Both report the pressed switches at every poll. An unplugged pedal is reported as lost, and its
//! switches count as released. If cut and coagulate are pressed together, the core decides.

pub mod debounce;
mod evdev;
mod joined;
mod modem;

pub use evdev::{EvdevPedal, Roles, find};
pub use joined::JoinedPedals;
pub use modem::{ModemLines, ModemPedal, SerialLines};
