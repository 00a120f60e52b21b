//! What `calot run` understands about tasks.

use std::path::PathBuf;

use assess::{Difficulty, Task};
use clap::{Args, ValueEnum};
use surgeon::Surgeon;

use crate::args::{StoreFile, parse_difficulty, parse_task, parse_trainee};

/// A task that is assessed while it runs.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Task")]
pub(crate) struct TaskArgs {
    /// Assess this task: identify, clamp, cut, disconnect, full (all four), free (practice), scope
    /// (endoscope drill). Leaves debrief.html beside the session
    #[arg(long, value_name = "TASK", value_parser = parse_task, conflicts_with = "attach")]
    pub(crate) task: Option<Task>,
    /// beginner: hints; trainee: alarms and progress; exam: time alone [default: trainee]
    #[arg(long, value_name = "HOW", value_parser = parse_difficulty, requires = "task")]
    pub(crate) difficulty: Option<Difficulty>,
    /// Who has placed the sutures that hang the gallbladder: given: they are there; own: the
    /// trainee places them, with grasper and pedal (identify, full, free) [default: given]
    #[arg(
        long,
        value_name = "WHOSE",
        value_enum,
        default_value_t,
        requires = "task"
    )]
    pub(crate) sutures: Sutures,
    /// Pass rules and weights (TOML) [default: the built-in ones, see `calot report --rules-file`]
    #[arg(long, value_name = "FILE", requires = "task")]
    pub(crate) rules: Option<PathBuf>,
    /// A scripted surgeon works the task, with the emulated devices
    #[arg(long, value_name = "WHO", value_enum, requires_all = ["task", "headless"])]
    pub(crate) hand: Option<Surgeon>,
    /// Keep what it came to in the store, under this name
    #[arg(long, value_name = "NAME", value_parser = parse_trainee, requires = "task")]
    pub(crate) trainee: Option<String>,
    #[command(flatten)]
    pub(crate) store: StoreFile,
}

/// Whose sutures hang the gallbladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Sutures {
    /// The scene's.
    #[default]
    Given,
    /// The trainee's.
    Own,
}
