//! What a trainee did, judged: tasks, metrics, score. It sees only the course of an operation as a session
//! has it ([`session::Entry`]), so that what is said while it runs and what is made of the recording are
//! the same numbers, bit for bit.
//!
//! ```text
//! session::Entry ─► Assessment ─┬─ Tally      metrics (metrics/definition.rs says what each is)
//!                               ├─ Procedure  the task: how far, passed or failed, and why
//!                               └─ Alarms     what was wrong, and when
//!                                     └─► Status while it runs, Assessed at its end
//! ```
//!
//! Pass rules and weights are a file (`rules.toml` beside this one is the built-in one).

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
