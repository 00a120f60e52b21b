//! Force Dimension's omega, delta, sigma and lambda, and Novint's Falcon, through Force Dimension's
//! `libdhd`. No real device has been met: the driver is tested against a fake library.
//!
//! The library's calls block while they talk to the device. A thread of ours makes them a thousand
//! times a second. Samples and forces pass through sequence locks, so that neither side waits.
//!
//! The library compensates gravity with every force that it is sent, also with zero force. Its
//! devices brake by themselves when they move too fast or hear nothing.
//!
//! Sources: the library's header `dhdc.h` (3.7, as in `WPI-AIM/ambf`), its documentation (3.14, as
//! in `EmDash00/forcedimension_core-python-docs`), and CHAI3D 3.2, to which its maker contributed.

mod axes;
mod driver;
mod gripper;
mod library;
mod model;
mod servo;
mod shared;

pub use driver::DhdHaptic;

/// Name under which the loader finds an installed library.
pub const LIBRARY: &str = "libdhd.so.3";
