//! The local store: trainees under names they chose, the results of their sessions, their answers
//! to questionnaires, and raters' scoring sheets. It is one SQLite file that only its user can
//! read. Names of trainees and raters are the only personal data in it.
//!
//! ```text
//! trainee ─┬─< session ─┬─ metrics (JSON)
//!          │            ├─ circumstances of the run
//!          │            └─< rating ─< point      scoring sheets
//!          └─< answer                            questionnaires
//! destination ─┬─< delivery                      results that went to a centre
//!              └─< withdrawal                    people whom it has to forget
//! ```
//!
//! The name of a session is a UUID of version 7, so [`Store::merge`] can join the stores of several
//! stations without a coordinator. `schema.rs` documents every table.
//!
//! ```text
//! schema ◄ file ◄ open ◄ trainees ◄ told, sessions ◄ merge   what is kept
//! withdrawal ◄ forgotten ◄──┘    └── outbox ◄ inbox      what goes to a centre, and leaves it
//! names  ◄──┘       └── questionnaire, form ◄ sheet      what is asked
//!                       export, table                    JSON, CSV
//! ```

mod error;
mod export;
mod file;
mod forgotten;
mod form;
mod inbox;
mod merge;
mod names;
mod open;
mod outbox;
mod questionnaire;
mod schema;
mod sessions;
mod sheet;
mod table;
mod text_file;
mod told;
mod trainees;
mod withdrawal;

pub use error::{StoreError, rater_in_words};
pub use forgotten::Gone;
pub use form::{Sheet, SheetItem};
pub use merge::{EXAMPLE_SQL, Merged, OtherOwner};
pub use names::check_name;
pub use open::{Store, new_id};
pub use outbox::{Delivery, Outgoing};
pub use questionnaire::{Answer, Item, ItemSummary, NOT_APPLICABLE, Questionnaire};
pub use schema::SCHEMA_VERSION;
pub use sessions::{Circumstances, Hand, SessionRecord};
pub use sheet::{GOALS, Rating};
pub use table::csv_field;
pub use told::Told;
pub use trainees::{Consent, Trainee};
pub use withdrawal::{Withdrawal, person_id};

#[cfg(test)]
mod tests;
