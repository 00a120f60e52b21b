//! Assessment of a trainee: tasks, metrics, score. Its only input about an operation is the entries
//! that the session records ([`session::Entry`]). So the assessment of a recording gives the same
//! numbers as that of the running operation, bit for bit.
//!
//! ```text
//! session::Entry ─► Assessment ─┬─ Tally      metrics (definitions: metrics/definition.rs)
//!                               ├─ Procedure  progress of the task, its outcome and the reasons
//!                               └─ Alarms     errors and their times
//!                                     └─► Status while it runs, Assessed at its end
//! ```
//!
//! Pass rules and weights come from a file. The built-in one is `rules.toml` in this package.
//!
//! # Why an assessment can be repeated
//!
//! `calot run --task` gives this library each entry that the recorder writes. `calot report` gives
//! it the entries of the file.
//!
//! One table with a version defines all metrics (`metrics/definition.rs`). One file holds weights,
//! pass rules, forbidden structures and flows (`rules.toml`, or `--rules`). The session keeps a
//! copy of that file.
//!
//! When a vessel is divided, clips may leave part of a side open. The controller reports the open
//! share of the worse side. The vessel counts as divided unclamped if that side is not closed, if
//! it had too few clips, or if it leaks. The critical view of safety is achieved when enough of
//! each region's cells is removed (`CellRecord::region`), and shown when the endoscope held it in
//! its picture from both sides. The recorder measures the picture in identity images, which have
//! the organ at each pixel ([`session::identity`]), so that the assessment needs no graphics card.
//! An identity image shows the organs where they lay at its time, and the instrument among them.
//!
//! The display's panel gets each alarm, the score and the end of the task as a `TaskView`. A
//! `TaskView` names steps and reasons by their kind, so the display needs no rules.
//!
//! The store (package `store`) keeps results under a name that the trainee chose. It keeps no
//! recordings. To forget a trainee, it overwrites the trainee's data in its file. The name of a
//! session is a UUID of version 7, and trainees with equal names are one person. So merging the
//! same store a second time changes nothing.

mod act;
mod alarm;
mod anatomy;
mod assessment;
mod basics;
mod hold;
mod injury;
mod means;
pub mod metrics;
mod phantom;
mod procedure;
pub mod report;
mod rules;
mod scope_drill;
mod steady;
mod step;
mod tally;
mod task;
mod vector;
mod vessel;
mod view;

pub use act::Act;
pub use alarm::{Alarm, AlarmKind};
pub use anatomy::{Anatomy, Region};
pub use assessment::{Assessed, Assessment, Hands, Moment, Path, Status, VERSION};
pub use hold::{Hold, Lack};
pub use injury::{Cause, Injury, InjuryKind, Severity};
pub use metrics::{Metric, Values};
pub use rules::{Least, PassRule, Reference, Rules, RulesError, ShowRule, Steadiness, ViewRule};
pub use scope_drill::DRILL_ORGANS;
pub use shared_mem::words::Instrument;
pub use step::{Advice, Hint, Reason, Step};
pub use tally::BIN_N;
pub use task::{Difficulty, Outcome, Task};
pub use view::{Criterion, Cvs, Shares, Shown, ViewSide};

#[cfg(test)]
mod tests;
