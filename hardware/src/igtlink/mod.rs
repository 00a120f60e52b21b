//! OpenIGTLink: reports instrument, endoscope, force and events to 3D Slicer, PLUS and others, and
//! answers their questions.
//!
//! This module is for a process that may wait, never for the realtime process. The caller hands
//! over messages at any rate. In each call the server accepts clients, answers requests and sends
//! the messages, without a thread and without blocking.
//!
//! ```text
//! wire     header, checksum and the two header versions
//! message  bodies of the messages that Calot sends
//! request  requests of clients, cut out of a stream of bytes
//! client   one connection: what it may read, what it asked for
//! server   all connections, and the newest messages for those who ask
//! ```

mod client;
pub mod message;
mod request;
mod server;
pub mod wire;

pub use server::Server;
