//! 3D Systems' Touch (and the Phantoms before it) through the vendor's `libHD.so`.
//!
//! The library is opened at run time, so nothing is linked. It is never closed, because the
//! vendor's driver does not survive a second loading. The library's own thread calls this driver a
//! thousand times a second. Samples and forces pass through sequence locks, so that neither side
//! waits.

#[cfg(feature = "std")]
mod driver;
#[cfg(feature = "std")]
mod hd;

#[cfg(feature = "std")]
pub use driver::TouchHaptic;

/// Damping of a Touch, N s/m: 0.2 of the hinges (assumed), plus the equivalent viscous damping
/// `4 f / (π v)` of Coulomb friction f = 0.26 N (data sheet) at v = 0.2 m/s, the speed of a tremor.
pub const DAMPING_N_S_M: f32 = 1.85;
/// Delay of a Touch on USB: 1 ms for the sample, 1 ms for the motors. Assumed.
pub const DELAY_S: f32 = 0.002;
