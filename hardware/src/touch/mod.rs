//! 3D Systems' Touch (and the Phantoms before it) through the vendor's `libHD.so`.
//!
//! The library is opened at run time and never closed: nothing of it is linked, and its driver
//! does not survive being loaded twice. Its own thread calls us a thousand times a second; what
//! it brings and takes passes through sequence locks, so that neither side ever waits.

mod driver;
mod hd;

pub use driver::TouchHaptic;

/// Damping of a Touch: 0.2 N s/m of its hinges (assumed), and what 0.26 N of dry friction (data
/// sheet) take from a tremor of 0.2 m/s, `4 f / (π v)`.
pub const DAMPING_N_S_M: f32 = 1.85;
/// Delay of a Touch on USB: a millisecond for the sample, one for the motors. Assumed.
pub const DELAY_S: f32 = 0.002;
