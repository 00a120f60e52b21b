//! OpenIGTLink: reports the poses of instrument and endoscope to 3D Slicer, PLUS and others.
//!
//! For a process that may wait, never for the realtime one. The caller hands over poses at any
//! rate; the server accepts clients and sends without a thread and without blocking.

mod server;
pub mod wire;

pub use server::Server;
