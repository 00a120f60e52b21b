//! The local store: trainees by a name of their choice, what their sessions came to, what they
//! answered, what instructors wrote. One SQLite file that its user alone can read; nothing of a
//! person but the name.
//!
//! ```text
//! trainee ─┬─< session ─┬─ metrics (JSON)
//!          │            └─< sheet     GOALS items, by an instructor
//!          └─< answer                 questionnaires
//! ```
//!
//! Sessions are named by UUIDs of version 7: [`Store::merge`] makes stores of several stations one
//! without a coordinator.

mod error;
mod export;
mod merge;
mod open;
mod questionnaire;
mod sessions;
mod sheet;

pub use error::StoreError;
pub use merge::{EXAMPLE_SQL, Merged};
pub use open::{SCHEMA_VERSION, Store, new_id};
pub use questionnaire::{Item, ItemSummary, Questionnaire};
pub use sessions::{SessionRecord, Trainee, check_name};
pub use sheet::GOALS;

#[cfg(test)]
mod tests;
