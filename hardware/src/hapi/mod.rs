//! Haply's hAPI boards: binary commands over a serial line, and the flat two-armed linkage (2DIY).
//!
//! The protocol has no frame, checksum or watchdog: the board holds the last torque for as long as
//! it has power. So zero torque is the first thing that the driver sends, what it does when answers
//! stay away, and its last words when it is dropped. A host that is killed, and a board that does
//! not read, leave the torque on, and where the arms are then taken it may be more force than was
//! asked for: keep the board's switch within reach.
//!
//! Its encoders count from where the handle is when the board is set up. Only a person knows where
//! that is, so after a loss a board is asked with patience, and never set up as if it were at home:
//! one that has lost its place is told angles that no arm has, and refused until it is powered
//! anew.
//!
//! Source: Haply's firmware `Haply_M3_Firmware_V1_5` and API (commands, limit of the torque, and
//! what a set-up does), its `Pantograph` of 2021 and examples (arms, encoders, directions of the
//! three generations). Not published: gear, friction, what the motors bear; see [`pantograph`].

pub mod device;
mod driver;
pub mod pantograph;
pub mod wire;

pub(crate) use driver::BAUD;
pub use driver::HapiHaptic;
