//! Tests of whole devices: drivers against emulated ones (behind ptys, a loopback socket, USB
//! packets and fake vendor libraries), the conformance suite, `feel`, any bytes, polls without
//! allocation, and firmware in C.

mod any_bytes;
mod conformance;
mod dhd;
mod drivers;
mod every_fault;
mod fake_dhd;
mod feel;
mod firmware;
mod hapi;
mod hostile;
mod inverse3;
mod no_alloc;
mod station;
mod support;
mod touch;
mod trakstar;
