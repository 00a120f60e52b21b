//! WoodenHaptics: the open, laser-cut device with a Teensy, and its text protocol.
//!
//! The host sends motor currents, and the firmware answers each message with its encoder counts.
//! The firmware sends nothing unasked, and switches the motors off 100 ms after the last command.
//! The protocol has no checksum.

pub mod device;
mod driver;
pub mod mechanism;
pub mod wire;

pub use driver::WoodyHaptic;
