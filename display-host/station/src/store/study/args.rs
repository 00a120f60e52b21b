//! Options of `calot store study`.

use std::path::PathBuf;

use assess::{Difficulty, Task};
use clap::{Args, ValueEnum};

use crate::args::{parse_difficulty, parse_task};
use crate::output::Overwrite;

/// Options of `calot store study`.
#[derive(Debug, Clone, Args)]
pub(crate) struct StudyArgs {
    /// Property by which trainees are grouped
    #[arg(long, value_name = "WHAT", value_enum, default_value_t)]
    pub(super) by: By,
    /// Compare this task only [default: every task that has sessions]
    #[arg(long, value_name = "TASK", value_parser = parse_task)]
    pub(super) task: Option<Task>,
    /// Difficulty [default: the most frequent of each task]
    #[arg(long, value_name = "HOW", value_parser = parse_difficulty)]
    pub(super) difficulty: Option<Difficulty>,
    /// Include sessions of scripted hands, realtime or not
    #[arg(long)]
    pub(super) scripted: bool,
    /// Include sessions of people that were not realtime
    #[arg(long)]
    pub(super) not_realtime: bool,
    /// Include only trainees who consented; without this option, leave out those who refused
    #[arg(long)]
    pub(super) consented: bool,
    /// Write the trainees' names instead of numbers
    #[arg(long)]
    pub(super) names: bool,
    /// Folder for study.csv and study.html. In the table, an apostrophe goes before a text that
    /// begins with =, +, - or @, so that a spreadsheet does not take it for a formula
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: Overwrite,
}

/// Property by which trainees are grouped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum By {
    /// The trainees' cohort
    #[default]
    Cohort,
    /// The site of their sessions
    Site,
    /// The driver of the haptic device
    Driver,
}

impl By {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cohort => "cohort",
            Self::Site => "site",
            Self::Driver => "driver",
        }
    }
}
