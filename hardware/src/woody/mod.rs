//! WoodenHaptics: the open, laser-cut device with a Teensy, and its text protocol.
//!
//! The host sends motor currents; the firmware answers each message with its encoder counts. It
//! sends nothing unasked, has no checksum, and switches the motors off 100 ms after the last
//! command.

pub mod device;
mod driver;
pub mod mechanism;
pub mod wire;

pub use driver::WoodyHaptic;
