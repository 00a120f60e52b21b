//! Devices on real ptys: the drivers against the emulated station, the conformance suite, lines
//! that say anything at all, and the promise that a poll allocates nothing.

mod any_bytes;
mod conformance;
mod drivers;
mod every_fault;
mod hapi;
mod hostile;
mod inverse3;
mod no_alloc;
mod station;
mod support;
mod touch;
mod trakstar;
