//! Calot's devices: drivers, wire formats, emulators and fault injection.
//!
//! ```text
//! rig      our own serial protocol, for self-built haptic devices and pedals (PROTOCOL.md)
//! bird     Ascension trackers of the endoscope: Flock of Birds, trakSTAR
//! pedal    foot pedals without our protocol: USB pedals that type keys, switches at CTS and DSR
//! touch    3D Systems' Touch, through its own library opened at run time
//! dhd      Force Dimension's devices and Novint's Falcon, through libdhd opened at run time
//! woody    WoodenHaptics' text protocol and linkage
//! hapi     Haply's hAPI boards and the flat linkage (pantograph) of the 2DIY
//! inverse3 Haply Inverse3, through its maker's service on this computer
//! igtlink  OpenIGTLink server: poses for 3D Slicer and PLUS, outside of the realtime process
//! light    light sensors: a photodiode on a modem pin, a sound card's input or a rig's switch
//!
//! list     lists the devices that are plugged in
//! station  reads the station file and opens the devices that it names
//! conformance  tests every driver with an emulated or a real device
//! feel     guides a person through a test of positions and forces: axes, units, signs
//! characterise  measures friction, inertia, damping, delay and stiffness limit of a haptic device
//! emulate  emulates a station's devices behind ptys, with a scripted hand at the handle
//!
//! line     a serial line that neither blocks nor allocates
//! arrivals recognises from arrival times how a serial adapter or the USB delays samples
//! gate     holds back implausible jumps of samples that come without a checksum
//! motion   judges reported motion: jumps, and velocities that contradict the positions
//! noise    measures the noise of positions
//! trail    computes a handle's velocity from its newest positions
//! vendor   loads a vendor's library: time limits, guards, and errors with their remedy
//! slot     hands the newest value from one thread to another
//! error    errors of all devices, with their remedies
//! ```
//!
//! Drivers implement the ports (traits) of `rt-core` ([`rt_core::port`]). Opening a device may take
//! seconds, because the driver waits until the handshake succeeds or its time is over. So devices
//! are never opened on the tick's thread. The tick calls `poll` and `send`, which neither block nor
//! allocate. The number of bytes that one call reads is bounded.
//!
//! Bytes from a line are untrusted until the protocol's parser (its module `wire`) has accepted
//! them. The parser checks lengths, ranges and, if the protocol has them, checksums. It passes on
//! only finite values in SI units.
//!
//! Without the default feature `std`, only [`rig::frame`], [`rig::wire`], [`rig::device`] and the
//! constants of [`touch`] remain. They are the firmware library of a rig: `no_std`, without
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
