//! Options of `calot run` that concern tasks.

use std::path::PathBuf;

use assess::{Difficulty, Task};
use clap::{Args, ValueEnum};
use surgeon::Surgeon;

use crate::args::{NewTrainee, StoreFile, parse_difficulty, parse_task, parse_trainee};

/// Options of the task that Calot assesses during the run.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Task")]
pub(crate) struct TaskArgs {
    /// Assess this task: basics (first steps), scope (endoscope drill), identify, clamp, cut,
    /// disconnect, full (identify to disconnect, in one operation) or free (practice). Writes
    /// debrief.html into the folder of --out
    #[arg(long, value_name = "TASK", value_parser = parse_task, conflicts_with = "attach")]
    pub(crate) task: Option<Task>,
    /// Guidance for the trainee. beginner: hints, alarms and progress; trainee: alarms and
    /// progress; exam: only the task and the time, until the end [default: trainee]
    #[arg(long, value_name = "HOW", value_parser = parse_difficulty, requires = "task")]
    pub(crate) difficulty: Option<Difficulty>,
    /// Sutures that suspend the gallbladder. given: the scene begins with them; own: the trainee
    /// places them with grasper and pedal (identify, full and free only)
    #[arg(
        long,
        value_name = "WHOSE",
        value_enum,
        default_value_t,
        requires = "task"
    )]
    pub(crate) sutures: Sutures,
    /// File (TOML) with the rules for a pass and the weights of the score [default: the built-in
    /// rules; `calot report --rules-file` prints them]
    #[arg(long, value_name = "FILE", requires = "task")]
    pub(crate) rules: Option<PathBuf>,
    /// Let a scripted surgeon perform the task with the emulated devices. Without --headless, the
    /// window shows the operation
    #[arg(long, value_name = "WHO", value_enum, requires = "task")]
    pub(crate) hand: Option<Surgeon>,
    /// Keep the result in the store under this trainee's name, e.g. Ada. Without it, recording and
    /// debrief lie in the folder of the session, and the result counts for nobody
    #[arg(long, value_name = "NAME", value_parser = parse_trainee, requires = "task")]
    pub(crate) trainee: Option<String>,
    #[command(flatten)]
    pub(crate) new_trainee: NewTrainee,
    #[command(flatten)]
    pub(crate) store: StoreFile,
}

/// Origin of the sutures that suspend the gallbladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Sutures {
    /// The scene has them in place.
    #[default]
    Given,
    /// The trainee places them.
    Own,
}
