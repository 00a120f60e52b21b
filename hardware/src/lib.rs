//! Calot's devices: drivers, wire formats, emulators and fault injection.
//!
//! ```text
//! arrivals tells from the times of samples what a serial adapter or the USB does to them
//! rig      our own serial protocol, for self-built haptic devices and pedals (PROTOCOL.md)
//! bird     Ascension Flock-of-Birds protocol: the endoscope's tracker
//! pedal    foot pedals that are USB keyboards, or switches on a serial line's CTS and DSR
//! touch    3D Systems' Touch, through its own library opened at run time
//! dhd      Force Dimension's devices and Novint's Falcon, through libdhd opened at run time
//! woody    WoodenHaptics' text protocol and linkage
//! hapi     Haply's hAPI boards and their flat two-armed linkage
//! inverse3 Haply Inverse3, through its maker's service on this computer
//! list     lists the devices that are plugged in
//! igtlink  OpenIGTLink server: poses for 3D Slicer and PLUS, outside of the realtime process
//! station  the file that names a station's devices, and opens them
//! light    light sensors: a photodiode at a serial port's pin, a sound card or a board of a rig
//! line     a serial line that neither blocks nor allocates
//! gate     holds back implausible jumps of samples that come without a checksum
//! vendor   opens a vendor's library: limits, guards, and errors with their remedy
//! slot     hands the newest value from one thread to another
//! emulate  emulates a station's devices behind ptys, with a scripted hand at the handle
//! conformance  tests every driver with an emulated or a real device
//! feel     leads a person through a test of axes, units and signs of positions and forces
//! characterise  measures friction, inertia, damping, delay and stiffness limit of a haptic device
//! ```
//!
//! Drivers implement the ports (traits) of `rt-core` ([`rt_core::port`]). Opening a device may take
//! seconds, because the driver waits for a handshake or a time-out. So a thread other than the
//! tick's opens the device. The tick calls `poll` and `send`, which neither block nor allocate. The
//! number of bytes that one call reads is bounded.
//!
//! Bytes from a line are untrusted until a wire module has parsed them. The wire module checks
//! lengths, ranges and, if the protocol has them, checksums, and passes on only finite values in SI
//! units.
//!
//! Without the default feature `std` only [`rig::frame`], [`rig::wire`], [`rig::device`] and the
//! figures of a Touch remain. The firmware of a rig uses them: they are `no_std` and need no
//! `alloc`.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]

#[cfg(feature = "std")]
pub mod arrivals;
#[cfg(feature = "std")]
pub mod bird;
#[cfg(feature = "std")]
pub mod characterise;
#[cfg(feature = "std")]
pub mod conformance;
#[cfg(feature = "std")]
pub mod dhd;
#[cfg(feature = "std")]
pub mod emulate;
#[cfg(feature = "std")]
mod error;
#[cfg(feature = "std")]
pub mod feel;
#[cfg(feature = "std")]
mod gate;
#[cfg(feature = "std")]
pub mod hapi;
#[cfg(feature = "std")]
pub mod igtlink;
#[cfg(feature = "std")]
pub mod inverse3;
#[cfg(feature = "std")]
pub mod light;
#[cfg(feature = "std")]
mod line;
#[cfg(feature = "std")]
pub mod list;
#[cfg(feature = "std")]
mod motion;
#[cfg(feature = "std")]
mod noise;
#[cfg(feature = "std")]
pub mod pedal;
pub mod rig;
#[cfg(feature = "std")]
mod slot;
#[cfg(feature = "std")]
pub mod station;
pub mod touch;
#[cfg(feature = "std")]
mod trail;
#[cfg(feature = "std")]
mod vendor;
#[cfg(feature = "std")]
pub mod woody;

#[cfg(feature = "std")]
pub use error::HardwareError;
#[cfg(feature = "std")]
pub use line::{Holder, holders, socket_holders};
