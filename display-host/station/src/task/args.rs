//! Options of `calot run` that concern tasks.

use std::path::PathBuf;

use assess::{Difficulty, Task};
use clap::{Args, ValueEnum};
use surgeon::Surgeon;

use crate::args::{NewTrainee, StoreFile, parse_difficulty, parse_task, parse_trainee};

/// Task to assess while it runs.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Task")]
pub(crate) struct TaskArgs {
    /// Assess this task: basics (first steps), scope (endoscope drill), identify, clamp, cut,
    /// disconnect, full (the last four) or free (practice). Writes debrief.html next to the session
    #[arg(long, value_name = "TASK", value_parser = parse_task, conflicts_with = "attach")]
    pub(crate) task: Option<Task>,
    /// Help for the trainee: beginner shows hints, trainee shows alarms and progress, exam shows
    /// only the time [default: trainee]
    #[arg(long, value_name = "HOW", value_parser = parse_difficulty, requires = "task")]
    pub(crate) difficulty: Option<Difficulty>,
    /// Sutures that hang the gallbladder. given: they are in place; own: the trainee places them
    /// with grasper and pedal (identify, full and free only)
    #[arg(
        long,
        value_name = "WHOSE",
        value_enum,
        default_value_t,
        requires = "task"
    )]
    pub(crate) sutures: Sutures,
    /// Pass rules and weights (TOML) [default: the built-in rules; `calot report --rules-file`
    /// prints them]
    #[arg(long, value_name = "FILE", requires = "task")]
    pub(crate) rules: Option<PathBuf>,
    /// Let a scripted surgeon work the task on the emulated devices; without --headless, watch it
    /// in the window
    #[arg(long, value_name = "WHO", value_enum, requires = "task")]
    pub(crate) hand: Option<Surgeon>,
    /// Keep the result in the store under this trainee's name, e.g. Ada
    #[arg(long, value_name = "NAME", value_parser = parse_trainee, requires = "task")]
    pub(crate) trainee: Option<String>,
    #[command(flatten)]
    pub(crate) new_trainee: NewTrainee,
    #[command(flatten)]
    pub(crate) store: StoreFile,
}

/// Sutures that hang the gallbladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Sutures {
    /// The scene has them in place.
    #[default]
    Given,
    /// The trainee places them.
    Own,
}
