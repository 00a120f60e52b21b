//! The local store: trainees under names they chose, the results of their sessions, their answers
//! to questionnaires, and instructors' assessment sheets. It is one SQLite file that only its user
//! can read. The chosen name is the only personal datum in it.
//!
//! ```text
//! trainee ─┬─< session ─┬─ metrics (JSON)
//!          │            ├─< sheet     GOALS items, by an instructor
//!          │            └── scripted   marks a session that no person worked
//!          └─< answer                 questionnaires
//! ```
//!
//! The name of a session is a UUID of version 7, so [`Store::merge`] can join the stores of several
//! stations without a coordinator.

mod error;
mod export;
mod merge;
mod open;
mod questionnaire;
mod schema;
mod sessions;
mod sheet;

pub use error::StoreError;
pub use merge::{EXAMPLE_SQL, Merged};
pub use open::{Store, new_id};
pub use questionnaire::{Item, ItemSummary, Questionnaire};
pub use schema::SCHEMA_VERSION;
pub use sessions::{Hand, SessionRecord, Trainee, check_name};
pub use sheet::GOALS;

#[cfg(test)]
mod tests;
