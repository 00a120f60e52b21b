//! Calot's devices: drivers, wire formats, emulators and fault injection.
//!
//! ```text
//! rig      our own serial protocol: haptic devices and pedals of rig builders (PROTOCOL.md)
//! bird     Ascension Flock-of-Birds protocol: the endoscope's tracker
//! pedal    foot pedals that are USB keyboards, or switches on a serial line's CTS and DSR
//! touch    3D Systems' Touch, through its own library opened at run time
//! dhd      Force Dimension's devices and Novint's Falcon, through libdhd opened at run time
//! woody    WoodenHaptics' text protocol and linkage
//! hapi     Haply's hAPI boards and their flat two-armed linkage
//! inverse3 Haply Inverse3, through its maker's service on this computer
//! list     what is plugged in
//! igtlink  OpenIGTLink server: poses for 3D Slicer and PLUS, outside of the realtime process
//! station  the file that names a station's devices, and opens them
//! line     a serial line that neither blocks nor allocates
//! gate     holds back samples that cannot be true
//! vendor   opening a vendor's library: limits, guards, and errors with their remedy
//! slot     the newest value, from one thread to another
//! emulate  the devices of a whole station behind ptys, a scripted hand at the handle
//! conformance  one suite for every driver, emulated device and real device
//! feel     a person tests axes, units and signs of positions and forces
//! characterise  friction, inertia, damping, delay and stiffness limit of a haptic device
//! ```
//!
//! Drivers implement the ports of `rt-core` ([`rt_core::port`]). The main thread opens a device
//! (handshake, time-outs, error messages). The tick calls `poll` and `send`, which neither block
//! nor allocate; the bytes that one call reads are bounded.
//!
//! All bytes from a line are untrusted until a wire module has parsed them. It checks lengths,
//! checksums and ranges; beyond it there are only finite SI values.
//!
//! Without the default feature `std` only [`rig::frame`], [`rig::wire`], [`rig::device`] and the
//! figures of a Touch remain: `no_std`, no `alloc`, for the firmware of a rig.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]

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
mod line;
#[cfg(feature = "std")]
pub mod list;
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
mod vendor;
#[cfg(feature = "std")]
pub mod woody;

#[cfg(feature = "std")]
pub use error::HardwareError;
#[cfg(feature = "std")]
pub use line::{Holder, holders, socket_holders};
