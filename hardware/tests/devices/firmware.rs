//! Tests the firmware header in C: its bytes, its agreement with the device in Rust, the sketches
//! that use it, and the conformance suite on a device that is built with it.
//!
//! The tests call the machine's compilers. They fail on a machine without compilers.
#![allow(unsafe_code)] // functions of a shared library in C

mod alike;
mod compiler;
mod mistakes;
mod rig;
mod sketches;
mod twin;
mod vectors;
