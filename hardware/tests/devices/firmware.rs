//! The firmware header in C: its bytes, its likeness with the device of this package, its sketches,
//! and the conformance suite on a device that is made of it.
//!
//! The tests call the machine's compilers. They fail where there are none.
#![allow(unsafe_code)] // functions of a shared library in C

mod alike;
mod compiler;
mod mistakes;
mod rig;
mod sketches;
mod twin;
mod vectors;
