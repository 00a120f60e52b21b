//! OpenIGTLink: tells 3D Slicer, PLUS and others where instrument and endoscope are.
//!
//! For a process that may wait, never for the realtime one. The caller hands over poses as often
//! as it likes; the server accepts clients and sends, without a thread and without blocking.

mod server;
pub mod wire;

pub use server::Server;
