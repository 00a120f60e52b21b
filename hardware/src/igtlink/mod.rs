//! OpenIGTLink server. It sends poses, force and events to 3D Slicer, PLUS and other clients, and
//! answers their requests.
//!
//! The realtime process must not use this module. The caller may call the server at any rate. The
//! server has no thread and never blocks: each call accepts clients and answers requests, or sends
//! messages.
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
