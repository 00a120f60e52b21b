//! Results of a station's store, delivered to a centre: into PostgreSQL, or as xAPI 2.0 statements
//! to a learning record store.
//!
//! ```text
//! store ──► push ─┬─► database   rows in the schema `calot`
//!                 └─► xapi       statements
//! ```
//!
//! The store itself is the queue: a result without a note waits. Each try derives the same id for a
//! result (for a statement, a UUID of version 5 from session and person), and the centre keeps the
//! first result with an id. So a result arrives once, even if a program dies between delivery and
//! note, or two programs deliver at the same time. The next push that reaches a centre also makes
//! the centre forget persons who were forgotten here.
//!
//! Nothing waits longer than [`PATIENCE`] for an answer. No password is printed or kept.

mod address;
mod centre;
mod database;
mod error;
mod push;
mod secret;
mod tables;
mod xapi;

pub use address::Destination;
pub use centre::PATIENCE;
pub use error::DeliverError;
pub use push::{Pushed, Refusal, push};
