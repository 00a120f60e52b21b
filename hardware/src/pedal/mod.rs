//! Foot pedals that speak no protocol of ours: USB pedals, which are keyboards to the kernel
//! ([`EvdevPedal`]), and plain switches on a serial line's control wires ([`ModemPedal`]).
//!
//! Both poll all the time and say what is pressed now; a pedal that is unplugged is lost, and
//! lost means released. Two electrodes at once are the core's to judge.

pub mod debounce;
mod evdev;
mod joined;
mod modem;

pub use evdev::{EvdevPedal, Roles, find};
pub use joined::JoinedPedals;
pub use modem::{ModemLines, ModemPedal, SerialLines};
