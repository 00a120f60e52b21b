//! OpenIGTLink: reports the poses of instrument and endoscope to 3D Slicer, PLUS and others.
//!
//! This module is for a process that may wait, never for the realtime process. The caller hands
//! over poses at any rate. In each call the server accepts clients and sends the poses, without a
//! thread and without blocking.

mod server;
pub mod wire;

pub use server::Server;
