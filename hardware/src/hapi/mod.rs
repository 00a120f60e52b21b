//! Haply's hAPI boards: binary commands over a serial line, and the flat two-armed linkage (2DIY).
//!
//! The protocol has no frame, checksum or watchdog: the board holds the last torque as long as it
//! has power. Therefore the driver sends zero torque when it opens the board, when answers stay
//! away, and when it is dropped. If the host is killed, or the board does not read, the torque
//! stays. If the arms are then moved, the force may exceed what was asked for: keep the board's
//! switch within reach.
//!
//! The encoders count from the handle's position at the set-up, which only a person knows. After a
//! loss the driver therefore repeats its requests and never sets the board up as if the handle were
//! at home. A board that lost its angles gets impossible angles and is refused until its power is
//! switched off and on.
//!
//! Source: Haply's firmware `Haply_M3_Firmware_V1_5` and API (commands, torque limit, effect of a
//! set-up), its `Pantograph` of 2021 and examples (arms, encoders, directions of the three
//! generations). Not published: gear, friction, continuous torque; see [`pantograph`].

pub mod device;
mod driver;
pub mod pantograph;
pub mod wire;

pub(crate) use driver::BAUD;
pub use driver::HapiHaptic;
