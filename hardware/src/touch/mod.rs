//! 3D Systems' Touch (and the Phantoms before it) through the vendor's `libHD.so`.
//!
//! The library is opened at run time and never closed: nothing of it is linked, and its driver
//! does not survive being loaded twice. Its own thread calls us a thousand times a second; what
//! it brings and takes passes through sequence locks, so that neither side ever waits.

mod driver;
mod hd;
mod slot;

pub use driver::TouchHaptic;
