//! What `calot jitter` understands.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::{ControllerArgs, SceneArgs, parse_seconds, parse_station};

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot jitter --seconds 60 --out idle
  calot jitter --seconds 60 --load all --out loaded
  calot jitter --seconds 600 --load join --compare burn
  calot jitter --seconds 60 --compare cyclictest,executor,sleep
  calot jitter --seconds 3600 --scope-line rts --scope-tty /dev/ttyS0
  calot jitter --diff idle loaded
  calot jitter --merge monday tuesday --out both

Figures of two programs compare only when they were measured in the same minutes: --compare
takes turns with them. Read ratios, and medians of rounds, before absolute tails.")]
pub(crate) struct JitterArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Name of the station that is measured
    #[arg(long, value_name = "NAME", default_value = "jitter", value_parser = parse_station)]
    pub(crate) station: String,
    /// Time measured, of each program that is compared; up to a day
    #[arg(long, value_name = "N", default_value = "60", value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// What else the machine does meanwhile
    #[arg(long, value_name = "LOAD", value_delimiter = ',')]
    pub(crate) load: Vec<Load>,
    /// Take turns with these programs and report ratios
    #[arg(long, value_name = "PROGRAM", value_delimiter = ',')]
    pub(crate) compare: Vec<Rival>,
    /// Turns that each program takes when several are compared [default: 3, or one each 30 s]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) rounds: Option<u32>,
    /// Where jitter.json, .csv, .html and .trace.json go; renewed every 5 s
    #[arg(long, value_name = "DIR", default_value = "jitter")]
    pub(crate) out: PathBuf,
    /// Add up the runs in these folders (or of these jitter.json) into --out
    #[arg(long, value_name = "RUN", num_args = 2.., conflicts_with_all = ["diff", "load", "compare"])]
    pub(crate) merge: Vec<PathBuf>,
    /// Compare two runs: what the second is, in times the first
    #[arg(long, value_names = ["FIRST", "SECOND"], num_args = 2, conflicts_with_all = ["load", "compare"])]
    pub(crate) diff: Vec<PathBuf>,
    /// Print jitter.json (or the difference) on standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

/// Work that competes with the tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Load {
    /// A thread that computes on each core
    Cpu,
    /// Threads that copy memory and throw everything out of the caches
    Memory,
    /// Files written, synced, read
    Io,
    /// A display that joins, and leaves or is killed, every second
    Join,
    /// The same, and one that draws all the time
    Display,
    /// All of these
    All,
    /// The station is seen from elsewhere (`calot link`): watchers join, stand still, leave and are killed; not
    /// in `all`
    Watch,
}

impl Load {
    /// Those meant, each once.
    pub(crate) fn each(asked: &[Self]) -> Vec<Self> {
        let mut each = match asked.contains(&Self::All) {
            true => vec![Self::Cpu, Self::Memory, Self::Io, Self::Display],
            false => asked.to_vec(),
        };
        each.sort();
        each.dedup();
        each
    }

    /// As it is typed.
    pub(crate) fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// What the station is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Rival {
    /// The kernel testers' own instrument (package rt-tests)
    Cyclictest,
    /// Our executor without the station: what the loop itself costs
    Executor,
    /// A bare loop of clock_nanosleep
    Sleep,
    /// The bare loop, with as much work as the ticks of the station's last turn, in their order
    Burn,
    /// embassy's stock driver for std (`cargo install --path tests/embassy-std`)
    EmbassyStd,
}

impl Rival {
    /// As it is typed; in keys of JSON with `_`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Cyclictest => "cyclictest",
            Self::Executor => "executor",
            Self::Sleep => "sleep",
            Self::Burn => "burn",
            Self::EmbassyStd => "embassy_std",
        }
    }
}

/// `calot load`: one load, until told to end.
#[derive(Debug, Clone, Args)]
pub(crate) struct LoadArgs {
    /// Which
    #[arg(value_name = "LOAD")]
    pub(crate) load: Load,
    /// Where files are written, or the station that is joined
    #[arg(value_name = "DIR|STATION")]
    pub(crate) place: String,
    /// End when this process, which started this one, ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}

/// `calot loop`: a bare loop's latencies as a histogram.
#[derive(Debug, Clone, Args)]
pub(crate) struct LoopArgs {
    /// executor, or sleep
    #[arg(value_name = "KIND")]
    pub(crate) kind: Rival,
    /// How long
    #[arg(long, value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Its core
    #[arg(long)]
    pub(crate) core: usize,
    /// Its priority
    #[arg(long)]
    pub(crate) priority: u8,
    /// As in `calot rt`
    #[arg(long, default_value_t = 0)]
    pub(crate) spin: u64,
    /// File of the work in each period, a line each, in ns
    #[arg(long, value_name = "FILE")]
    pub(crate) work: Option<PathBuf>,
    /// End when this process, which started this one, ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_loads_are_each_of_them_once() {
        assert_eq!(Load::each(&[]), []);
        assert_eq!(
            Load::each(&[Load::Io, Load::Cpu, Load::Io]),
            [Load::Cpu, Load::Io]
        );
        assert_eq!(Load::each(&[Load::All, Load::Cpu]).len(), 4);
    }
}
