//! Assessment of a trainee: tasks, metrics, score. It sees only the course of an operation as a
//! session records it ([`session::Entry`]), so an assessment of the recording yields the numbers of
//! the running operation bit for bit.
//!
//! ```text
//! session::Entry ─► Assessment ─┬─ Tally      metrics (definitions: metrics/definition.rs)
//!                               ├─ Procedure  progress of the task, its outcome and the reasons
//!                               └─ Alarms     errors and their times
//!                                     └─► Status while it runs, Assessed at its end
//! ```
//!
//! Pass rules and weights come from a file; `rules.toml` in this package is the built-in one.
//!
//! # Why it can be repeated
//!
//! A pure library: the course of an operation goes in entry by entry (`session::Entry`), status and
//! result come out. `calot run --task` gives it what the recorder writes, as it writes it; `calot
//! report` gives it what the file holds. The entries are the same, so the numbers are, bit for bit.
//!
//! Metrics are one table with a version (`metrics/definition.rs`). Weights, pass rules, forbidden
//! structures and flows are one file (`rules.toml`, or `--rules`), which the session keeps. The
//! controller tells of each division how far clips leave its worse side open. A vessel was divided
//! unclamped if that is not closed, if it had too few clips, or if it leaks. The critical view of
//! safety is the share of removed cells by region (`CellRecord::region`), never the picture. Each
//! alarm, the score and the task's end reach the panel as a `TaskView`, steps and reasons by kind;
//! the display knows nothing of rules.
//!
//! The store keeps results under a chosen name, no recordings. Whoever is forgotten is overwritten
//! in the file. Sessions are named by UUIDs of version 7, and the same name is the same person, so
//! that merging again changes nothing.

mod alarm;
mod anatomy;
mod assessment;
pub mod metrics;
mod procedure;
pub mod report;
mod rules;
mod scope_drill;
mod step;
mod tally;
mod task;
mod vector;
mod vessel;

pub use alarm::{Alarm, AlarmKind};
pub use anatomy::{Anatomy, Region};
pub use assessment::{Assessed, Assessment, Moment, Path, Status, VERSION};
pub use metrics::{Metric, Values};
pub use rules::{Rules, RulesError};
pub use shared_mem::words::Instrument;
pub use step::{Advice, Hint, Reason, Step};
pub use tally::BIN_N;
pub use task::{Difficulty, Outcome, Task};

#[cfg(test)]
mod tests;
