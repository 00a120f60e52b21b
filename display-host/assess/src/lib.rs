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

mod alarm;
mod anatomy;
mod assessment;
pub mod metrics;
mod procedure;
pub mod report;
mod rules;
mod scope_drill;
mod step;
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
pub use task::{Difficulty, Outcome, Task};

#[cfg(test)]
mod tests;
