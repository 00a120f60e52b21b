//! Commands of `calot`. The module of each command defines its options.

use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};

use crate::bare_loop::BareLoopArgs;
use crate::centre::CentreArgs;
use crate::check::CheckArgs;
use crate::devices::args::DevicesArgs;
use crate::emulate::args::EmulateArgs;
use crate::export::args::ExportArgs;
use crate::gallery::GalleryArgs;
use crate::igtlink::IgtlinkArgs;
use crate::jitter::args::JitterArgs;
use crate::link::LinkArgs;
use crate::load::LoadArgs;
use crate::observe::ObserveArgs;
use crate::photon::args::PhotonArgs;
use crate::prepare::args::PrepareArgs;
use crate::replay::args::ReplayArgs;
use crate::report::args::ReportArgs;
use crate::rt::RtArgs;
use crate::run::args::RunArgs;
use crate::say;
use crate::schema::SchemaArgs;
use crate::start::args::StartArgs;
use crate::store::args::StoreArgs;
use crate::tell::TellArgs;

/// Calot: a hard-realtime haptic trainer for transvaginal cholecystectomy.
///
/// Without a command, `calot` runs `calot start`, which needs a screen. `calot run --headless`
/// needs none. Every device that is not named is emulated, with a scripted hand at the handle, so
/// that Calot runs on any machine.
#[derive(Debug, Parser)]
#[command(name = "calot", version, max_term_width = 96)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Opens a window to choose task, help, endoscope and devices, to operate, and to see the
    /// debrief
    Start(StartArgs),
    /// Runs the station: devices, controller, display, report
    Run(Box<RunArgs>),
    /// Opens an instructor's window on a running station: its picture, metrics of its task, tick
    /// times
    Observe(ObserveArgs),
    /// Runs the realtime process alone
    Rt(RtArgs),
    /// Runs the emulated devices alone: ptys under --dir, moved by a scripted hand
    Emulate(EmulateArgs),
    /// Runs a recorded session again and compares every bit; names the first tick and organ that
    /// differ
    Replay(ReplayArgs),
    /// Writes a recorded session as tables, CSV or Parquet: every tick, event and metric
    Export(ExportArgs),
    /// Writes a page about recorded sessions: score, errors, paths, force
    Report(ReportArgs),
    /// Keeps trainees and their sessions: list, learning curve, questionnaire, export, forget
    Store(StoreArgs),
    /// Compiles a recipe and its meshes to a scene, and reports its quality
    Prepare(PrepareArgs),
    /// Draws every organ, instrument and view, and writes a page of the pictures
    Gallery(GalleryArgs),
    /// Measures wake-up latency, period, stages and motion to force, next to cyclictest
    Jitter(Box<JitterArgs>),
    /// Measures the time from a tick, and from a motion, to the light of the screen
    Photon(Box<PhotonArgs>),
    /// Checks this machine for realtime: current state, required state, command that fixes it
    Check(CheckArgs),
    /// Finds, shows, tests and calibrates devices
    Devices(DevicesArgs),
    /// Sends the poses of the instruments to 3D Slicer, PLUS and others, over OpenIGTLink
    Igtlink(IgtlinkArgs),
    /// Shows a station on other computers, with certificates on both sides
    Link(LinkArgs),
    /// Serves a page for the instructors of many stations; `calot centre --help` lists its commands
    Centre(CentreArgs),
    /// Prints the schemas of the JSON that the other commands write
    Schema(SchemaArgs),
    /// Writes what a centre hears of a station to standard output, for `calot-centre`
    #[command(hide = true)]
    Tell(TellArgs),
    /// Runs one of the loads of `jitter`
    #[command(hide = true)]
    Load(LoadArgs),
    /// Runs one of the bare loops of `jitter`
    #[command(hide = true)]
    BareLoop(BareLoopArgs),
}

impl Cli {
    /// Reads the command line. `Err` holds the exit code of help, or of bad usage, which is said.
    pub(crate) fn read() -> Result<Self, ExitCode> {
        Self::try_parse().map_err(|error| {
            // Nobody is there to read it if it cannot be written.
            let _ = error.print();
            if let Some(hint) = hint(&error) {
                say::note(hint);
            }
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
        })
    }
}

/// Advice about a word too many: most often a name was typed without quotes.
fn hint(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let is_word = error.kind() == ErrorKind::UnknownArgument && !word.starts_with('-');
    is_word.then(|| {
        format!("hint: if '{word}' belongs to a name of several words, put quotes around the whole name: '… {word} …'")
    })
}

impl Command {
    /// Command that runs if none is given.
    pub(crate) fn alone() -> Self {
        Self::Start(StartArgs::default())
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
    fn a_name_without_quotes_is_answered_with_a_hint_about_quotes() {
        let hint_of = |words: &str| {
            let error = Cli::try_parse_from(words.split(' ')).unwrap_err();
            hint(&error)
        };
        let said = hint_of("calot run --trainee Dr. Lea Mueller").unwrap();
        assert!(said.contains("'… Lea …'"), "{said}");
        assert_eq!(hint_of("calot run --trainees Ada"), None);
        assert_eq!(hint_of("calot run --help"), None);
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
    fn a_task_that_needs_the_triangle_has_it_as_its_scene() {
        let scene_of = |words: &str| match Cli::parse_from(words.split_whitespace()).command {
            Some(Command::Run(run)) => run.scene.scene,
            _ => unreachable!("it is a run"),
        };
        for (words, scene) in [
            ("calot run", "built-in"),
            ("calot run --task free", "built-in"),
            ("calot run --task clamp", "triangle"),
            ("calot run --task full --scene built-in", "built-in"),
        ] {
            assert_eq!(scene_of(words), scene, "{words}");
        }
    }

    #[test]
    fn the_controller_gets_the_realtime_options_of_the_station() {
        let words = "calot run --core 1 --priority 70 --spin 100 --scheduler deadline --must-fit \
                     --follow-device --coarser a.calot --coarser b.calot --scope-line dtr --scope-tty /dev/ttyS0 --scope-mark force";
        // One of the two at a time, because --strict and --no-realtime exclude each other.
        for last in ["--strict", "--no-realtime"] {
            let asked = Cli::parse_from(words.split_whitespace().chain([last]));
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
        let both = ["calot", "run", "--strict", "--no-realtime"];
        assert!(Cli::try_parse_from(both).is_err());
    }
}
