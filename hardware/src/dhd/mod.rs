//! Force Dimension's omega, delta, sigma and lambda, and Novint's Falcon, through Force Dimension's
//! `libdhd`. The driver was tested with a fake library only, not yet with a real device.
//!
//! The library's calls block while they exchange data with the device. So a thread of this driver
//! makes these calls a thousand times a second. Samples and forces pass through sequence locks, so
//! that neither side waits.
//!
//! The library adds gravity compensation to every force that the driver sends, even to zero force.
//! The devices brake by themselves when they move too fast or receive nothing.
//!
//! Sources: the library's header `dhdc.h` (3.7, as in `WPI-AIM/ambf`), its documentation (3.14, as
//! in `EmDash00/forcedimension_core-python-docs`), and CHAI3D 3.2, to which Force Dimension
//! contributed.

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
