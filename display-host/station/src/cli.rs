//! The commands of `calot`, each with the arguments that stand beside it.

use clap::{Parser, Subcommand};

use crate::bare_loop::BareLoopArgs;
use crate::check::CheckArgs;
use crate::devices::args::DevicesArgs;
use crate::emulate::args::EmulateArgs;
use crate::gallery::GalleryArgs;
use crate::igtlink::IgtlinkArgs;
use crate::jitter::args::JitterArgs;
use crate::link::LinkArgs;
use crate::load::LoadArgs;
use crate::observe::ObserveArgs;
use crate::prepare::args::PrepareArgs;
use crate::replay::args::ReplayArgs;
use crate::report::args::ReportArgs;
use crate::rt::RtArgs;
use crate::run::args::RunArgs;
use crate::start::{self, args::StartArgs};
use crate::store::args::StoreArgs;

/// Calot: a hard-realtime haptic trainer for transvaginal cholecystectomy.
///
/// Without a command it is `calot start` where there is a screen, and else `calot run`. Devices
/// that are not named are emulated, with a scripted hand at the handle, so that it runs on any
/// machine.
#[derive(Debug, Parser)]
#[command(name = "calot", version, max_term_width = 96)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Choose task, help, endoscope and devices in a window, operate, and see what it came to
    Start(StartArgs),
    /// The station: devices, controller, display, report
    Run(Box<RunArgs>),
    /// An instructor's window on a station that runs: its picture, its task's metrics, its ticks
    Observe(ObserveArgs),
    /// The realtime process alone
    Rt(RtArgs),
    /// The emulated devices alone: ptys under --dir, a scripted hand at the handle
    Emulate(EmulateArgs),
    /// Runs a recorded session again: is every bit the same, and if not, about where
    Replay(ReplayArgs),
    /// What a trainee did in recorded sessions, as one page: score, errors, paths, force
    Report(ReportArgs),
    /// Trainees and their sessions: list, learning curves, questionnaire, export, forget
    Store(StoreArgs),
    /// Meshes and a recipe to a compiled scene, with a report of its quality
    Prepare(PrepareArgs),
    /// Every organ, instrument and view as pictures, and a page to look through them
    Gallery(GalleryArgs),
    /// Wake-up latency, period, stages, motion to force: histograms, beside cyclictest's
    Jitter(Box<JitterArgs>),
    /// Is this machine fit for realtime: what is, what should be, the command that mends it
    Check(CheckArgs),
    /// Devices that are plugged in: find them, see them live, test them
    Devices(DevicesArgs),
    /// Tells 3D Slicer, PLUS and others where the instruments are, over OpenIGTLink
    Igtlink(IgtlinkArgs),
    /// Stations seen from other computers, with certificates on both sides
    Link(LinkArgs),
    /// One of `jitter`'s loads
    #[command(hide = true)]
    Load(LoadArgs),
    /// One of `jitter`'s bare loops
    #[command(hide = true)]
    BareLoop(BareLoopArgs),
}

impl Command {
    /// What `calot` alone is.
    pub(crate) fn alone() -> Self {
        match start::has_screen() {
            true => Self::Start(StartArgs::default()),
            false => Self::Run(Box::default()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn calot_alone_has_the_defaults_of_start_and_run() {
        assert!(Cli::parse_from(["calot"]).command.is_none());
        assert_eq!(StartArgs::default().station, "main");
        let args = RunArgs::default();
        assert_eq!(
            (
                args.station.as_str(),
                args.frames,
                args.controller.realtime.priority
            ),
            ("main", 8, 80)
        );
    }

    #[test]
    fn a_controller_is_asked_for_what_the_station_was_asked_for() {
        let words = "calot run --core 1 --priority 70 --spin 100 --scheduler deadline --strict \
                     --coarser a.calot --coarser b.calot --scope-line dtr --scope-tty /dev/ttyS0 \
                     --no-realtime";
        let asked = Cli::parse_from(words.split_whitespace());
        let Some(Command::Run(run)) = asked.command else {
            panic!("{asked:?}");
        };
        let mut rt: Vec<OsString> = ["calot", "rt", "--scene", "x"].map(Into::into).to_vec();
        rt.extend(run.controller.realtime.words());
        let Some(Command::Rt(rt)) = Cli::parse_from(rt).command else {
            panic!("not rt");
        };
        assert_eq!(
            format!("{:?}", rt.controller),
            format!("{:?}", run.controller)
        );
    }
}
