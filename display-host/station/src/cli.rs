//! What `calot` understands.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use display_host::words::Language;
use scene_prepare::recipe::Unit;

use crate::check::CheckArgs;
use crate::devices::args::DevicesArgs;
use crate::gallery::GalleryArgs;
use crate::jitter::args::{JitterArgs, LoadArgs, LoopArgs};
use crate::launcher::{self, args::StartArgs};
use crate::link::LinkArgs;
use crate::observe::ObserveArgs;
use crate::people::args::StoreArgs;
use crate::replay::args::ReplayArgs;
use crate::report::args::ReportArgs;
use crate::task::args::TaskArgs;

/// Calot: a hard-realtime haptic trainer for transvaginal cholecystectomy.
///
/// Without a command it is `calot start` where there is a screen, and else `calot run`. Devices that
/// are not named are emulated, with a scripted hand at the handle, so that it runs on any machine.
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
    Loop(LoopArgs),
}

impl Command {
    /// What `calot` alone is.
    pub(crate) fn alone() -> Self {
        match launcher::has_screen() {
            true => Self::Start(StartArgs::default()),
            false => Self::Run(Box::default()),
        }
    }
}

/// Which scene.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct SceneArgs {
    /// The scene: `built-in`, `triangle` (Calot's triangle too), `triangle-variant` (duct and
    /// artery run otherwise), a recipe (.toml), a mesh (.obj .stl .ply .gltf .glb), or a compiled
    /// scene (.calot)
    #[arg(long, value_name = "NAME|FILE", default_value = "built-in")]
    pub(crate) scene: String,
    /// Folder that holds the meshes which the recipe names [default: the recipe's own]
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
}

/// Real devices; one that is not named is emulated by `run`, and absent in `rt`.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Devices")]
pub(crate) struct DeviceArgs {
    /// Serial device of the haptic device, e.g. /dev/ttyACM0
    #[arg(long, value_name = "TTY")]
    pub(crate) haptic: Option<PathBuf>,
    /// Serial device of the endoscope's tracker, e.g. /dev/ttyUSB0
    #[arg(long, value_name = "TTY")]
    pub(crate) tracker: Option<PathBuf>,
    /// Serial device of the foot pedal
    #[arg(long, value_name = "TTY")]
    pub(crate) pedal: Option<PathBuf>,
    /// File that names devices of any driver, limits below theirs, and where they stand: the example is
    /// in `calot devices --help`. The options above come first
    #[arg(long, value_name = "FILE")]
    pub(crate) station_file: Option<PathBuf>,
}

/// How the controller runs.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Realtime")]
pub(crate) struct RealtimeArgs {
    /// Core of the control tick [default: the last one]
    #[arg(long, value_name = "N")]
    pub(crate) core: Option<usize>,
    /// SCHED_FIFO priority of the control tick
    #[arg(long, value_name = "2-99", default_value_t = 80, value_parser = clap::value_parser!(u8).range(2..=99))]
    pub(crate) priority: u8,
    /// Spin this long before each tick instead of sleeping: earlier wake-ups for processor time
    #[arg(long, value_name = "µs", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=500))]
    pub(crate) spin: u64,
    /// Linux' realtime scheduler; `deadline`: it guarantees the time of each tick, on any core
    #[arg(long, value_enum, default_value_t = SchedulerName::Fifo)]
    pub(crate) scheduler: SchedulerName,
    /// Refuse a scene whose worst tick, measured here, does not fit, when no coarser level fits
    #[arg(long)]
    pub(crate) strict: bool,
    /// Take this compiled scene when the one before it does not fit; may be given several times,
    /// finest first
    #[arg(long, value_name = "FILE")]
    pub(crate) coarser: Vec<PathBuf>,
    /// Hold a modem line of --scope-tty high during each tick, for an oscilloscope
    #[arg(long, value_enum, requires = "scope_tty")]
    pub(crate) scope_line: Option<ScopeLineName>,
    /// Serial port of that line; a real UART, for behind USB each change takes a transfer
    #[arg(long, value_name = "TTY", requires = "scope_line")]
    pub(crate) scope_tty: Option<PathBuf>,
    /// Do not ask for realtime scheduling; every report says so
    #[arg(long)]
    pub(crate) no_realtime: bool,
}

/// A scheduler, as it is typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum SchedulerName {
    /// SCHED_FIFO, pinned to a core
    #[default]
    Fifo,
    /// SCHED_DEADLINE
    Deadline,
}

/// A language, as it is typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LanguageName {
    /// English
    En,
    /// Deutsch
    De,
}

impl LanguageName {
    /// The language asked for, or else the user's.
    pub(crate) fn or_users(asked: Option<Self>) -> Language {
        match asked {
            Some(Self::En) => Language::English,
            Some(Self::De) => Language::German,
            None => {
                let set = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
                let locale = set("LC_ALL").or_else(|| set("LC_MESSAGES"));
                Language::of_locale(&locale.or_else(|| set("LANG")).unwrap_or_default())
            }
        }
    }
}

/// An endoscope, as it is typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum ScopeName {
    /// It looks along its shaft
    #[default]
    #[value(name = "0")]
    Straight,
    /// 30 degrees off it
    #[value(name = "30")]
    Thirty,
    /// 45 degrees off it
    #[value(name = "45")]
    FortyFive,
}

impl ScopeName {
    pub(crate) fn radians(self) -> f32 {
        let degrees: f32 = match self {
            Self::Straight => 0.0,
            Self::Thirty => 30.0,
            Self::FortyFive => 45.0,
        };
        degrees.to_radians()
    }
}

/// A modem line, as it is typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ScopeLineName {
    /// Request to send
    Rts,
    /// Data terminal ready
    Dtr,
}

/// What a controller is told, by whoever starts one.
#[derive(Debug, Clone, Args)]
pub(crate) struct ControllerArgs {
    #[command(flatten)]
    pub(crate) devices: DeviceArgs,
    #[command(flatten)]
    pub(crate) realtime: RealtimeArgs,
}

impl RealtimeArgs {
    /// The words that ask a `calot rt` for the same.
    pub(crate) fn words(&self) -> Vec<OsString> {
        let mut words: Vec<OsString> = Vec::new();
        let mut option = |name: &str, value: &dyn AsRef<std::ffi::OsStr>| {
            words.extend([name.into(), value.as_ref().to_owned()]);
        };
        let typed = |value: Option<clap::builder::PossibleValue>| {
            value.map_or_else(String::new, |value| value.get_name().to_owned())
        };
        option("--priority", &self.priority.to_string());
        option("--spin", &self.spin.to_string());
        option("--scheduler", &typed(self.scheduler.to_possible_value()));
        if let Some(core) = self.core {
            option("--core", &core.to_string());
        }
        for level in &self.coarser {
            option("--coarser", level);
        }
        if let (Some(line), Some(tty)) = (self.scope_line, &self.scope_tty) {
            option("--scope-line", &typed(line.to_possible_value()));
            option("--scope-tty", tty);
        }
        let flags = [
            (self.no_realtime, "--no-realtime"),
            (self.strict, "--strict"),
        ];
        words.extend(flags.into_iter().filter(|f| f.0).map(|f| f.1.into()));
        words
    }
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot run                                      the station in a window
  calot run --headless --seconds 10 --out out    pictures, summary.json, report.html
  calot run --scene tests/assets/hra-female.toml --meshes DIR
  calot run --task clamp --difficulty beginner   a task, assessed while it runs
  calot run --attach                             only the display of a station that runs")]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Name of the station; two stations on one machine need two names
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// No window: watch, and leave pictures and a report in --out
    #[arg(long)]
    pub(crate) headless: bool,
    /// End after this time [default with --headless: 10; else when the window is closed]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Where summary.json, report.html and pictures go [default with --task: a new folder in out; with
    /// --headless: out]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Pictures of a headless run, spread over its time; 0: none
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub(crate) frames: u32,
    /// Also put the pictures of a headless run into an animated GIF, ten a second
    #[arg(long, value_name = "FILE.gif", requires = "headless")]
    pub(crate) gif: Option<PathBuf>,
    /// Size of a picture or the window, e.g. 1280x720
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Record the session to this file, for `calot replay` [default with --out: DIR/session.mcap]
    #[arg(long, value_name = "FILE", conflicts_with = "attach")]
    pub(crate) record: Option<PathBuf>,
    /// The window's endoscope, by the angle that it looks off its shaft; S takes the next one
    #[arg(long, value_enum, default_value_t = ScopeName::Straight, conflicts_with = "headless")]
    pub(crate) scope: ScopeName,
    /// The interface's language [default: the one of LANG]
    #[arg(long, value_enum, conflicts_with = "headless")]
    pub(crate) language: Option<LanguageName>,
    /// No sound
    #[arg(long)]
    pub(crate) mute: bool,
    /// The endoscope comes cold: its lens fogs until it is wiped (W) or warm
    #[arg(long, conflicts_with = "headless")]
    pub(crate) cold_lens: bool,
    /// Seed of the scripted hand
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) task: TaskArgs,
    #[command(flatten)]
    pub(crate) gamepad: GamepadArgs,
    /// Start no processes: show the station that runs under this name
    #[arg(long)]
    pub(crate) attach: bool,
    /// Print summary.json on standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

impl Default for RunArgs {
    fn default() -> Self {
        /// `calot` alone without a screen is `calot run` alone: the same defaults, from the same place.
        #[derive(Parser)]
        struct Alone {
            #[command(flatten)]
            run: RunArgs,
        }
        Alone::parse_from(["calot"]).run
    }
}

#[derive(Debug, Clone, Args)]
pub(crate) struct RtArgs {
    /// The compiled scene (`calot prepare` makes one)
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// End after this time [default: on Ctrl-C, SIGTERM or a host's command]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// End when this process, which started this one, ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
    /// Print one JSON object when it ticks, one when it ends
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Transforms, 1 mm being 1 mm, in the scene's frame: ToolToReference, HandleToReference,
EndoscopeToReference. ForceToReference moves by 1 mm for each newton on the hand.

In 3D Slicer: module OpenIGTLinkIF, a connector of type Client to the address of --listen.")]
pub(crate) struct IgtlinkArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// Where clients connect; other machines may with 0.0.0.0:18944. There is no password
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:18944")]
    pub(crate) listen: std::net::SocketAddr,
    /// Frames a second
    #[arg(long, value_name = "HZ", default_value_t = 60.0, value_parser = parse_rate)]
    pub(crate) rate_hz: f64,
    /// End after this time [default: on Ctrl-C]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Print one JSON object when it listens, one when it ends
    #[arg(long)]
    pub(crate) json: bool,
}

/// Whether a gamepad may lead the emulated hand.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct GamepadArgs {
    /// Gamepad that leads the emulated hand: `auto` takes the first one that is plugged in, once it
    /// is used; `off`; or its path under /dev/input
    #[arg(long, value_name = "auto|off|PATH", default_value = "auto", value_parser = parse_gamepad)]
    pub(crate) gamepad: GamepadName,
}

/// Which gamepad.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) enum GamepadName {
    /// The first that is plugged in.
    #[default]
    Auto,
    /// None.
    Off,
    /// The one at this path.
    Path(PathBuf),
}

impl GamepadName {
    /// As it is typed.
    pub(crate) fn word(&self) -> &std::ffi::OsStr {
        match self {
            Self::Auto => "auto".as_ref(),
            Self::Off => "off".as_ref(),
            Self::Path(path) => path.as_os_str(),
        }
    }
}

#[derive(Debug, Clone, Args)]
pub(crate) struct EmulateArgs {
    /// Folder for the devices `haptic`, `tracker` and `pedal` (links to ptys)
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// The compiled scene that the scripted hand works in
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// Seed of the hand's tremor and of injected faults
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// A display of this station may take the hand over: mouse and keyboard
    #[arg(long, value_name = "NAME", value_parser = parse_station)]
    pub(crate) station: Option<String>,
    #[command(flatten)]
    pub(crate) gamepad: GamepadArgs,
    /// End when this process, which started this one, ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot prepare built-in --out built-in.calot
  calot prepare triangle --budget-us 300 --levels 3 --out triangle.calot
  calot prepare liver.obj --spheres 581 --json report.json --picture liver.png
  calot prepare tests/assets/hra-female.toml --meshes DIR --out female.calot")]
pub(crate) struct PrepareArgs {
    /// `built-in`, `triangle` (Calot's triangle too), `triangle-variant` (duct and artery run
    /// otherwise), a recipe (.toml) or a mesh (.obj .stl .ply .gltf .glb)
    #[arg(value_name = "RECIPE|MESH")]
    pub(crate) source: String,
    /// Folder that holds the meshes which the recipe names [default: the recipe's own]
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
    /// Spheres in all; several organs share them as their recipe's counts do
    #[arg(long, value_name = "N")]
    pub(crate) spheres: Option<usize>,
    /// Unit of a single mesh: m, cm or mm [default: m, or mm if it would be more than 2 m across]
    #[arg(long, value_name = "UNIT", value_parser = parse_unit)]
    pub(crate) unit: Option<Unit>,
    /// Error budget: as few spheres as leave 95 % of each organ's skin within this distance, mm
    #[arg(long, value_name = "MM", value_parser = parse_budget_mm, conflicts_with = "spheres")]
    pub(crate) budget_mm: Option<f64>,
    /// Time budget: as many spheres as a tick of this time takes, µs
    #[arg(long, value_name = "µs", value_parser = parse_budget_us, conflicts_with = "spheres")]
    pub(crate) budget_us: Option<f64>,
    /// Levels of detail in the file, each of half the spheres of the one before; the finest that
    /// fits its machine runs [default: those of the recipe]
    #[arg(long, value_name = "N", value_parser = parse_levels)]
    pub(crate) levels: Option<usize>,
    /// Where the compiled scene goes [default: nowhere, only the report is printed]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Draw the spheres and springs inside the translucent organs
    #[arg(long, value_name = "FILE.png", value_parser = parse_png)]
    pub(crate) picture: Option<PathBuf>,
    /// Write the report as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

fn parse_budget_mm(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(mm) if (0.05..=50.0).contains(&mm) => Ok(mm),
        _ => Err("an error budget is 0.05 to 50 mm".into()),
    }
}

fn parse_budget_us(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(us) if (5.0..=1000.0).contains(&us) => Ok(us),
        _ => Err("a time budget is 5 to 1000 µs a tick".into()),
    }
}

fn parse_levels(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(levels) if (1..=shared_mem::scene::LEVELS_MAX).contains(&levels) => Ok(levels),
        _ => Err(format!(
            "a file holds 1 to {} levels",
            shared_mem::scene::LEVELS_MAX
        )),
    }
}

fn parse_unit(text: &str) -> Result<Unit, String> {
    match text {
        "m" => Ok(Unit::Metre),
        "cm" => Ok(Unit::Centimetre),
        "mm" => Ok(Unit::Millimetre),
        _ => Err("a unit is m, cm or mm".into()),
    }
}

pub(crate) fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err("a time is 0.1 to 86400 seconds".into()),
    }
}

pub(crate) fn parse_station(text: &str) -> Result<String, String> {
    match shared_mem::service::Station::new(text) {
        Ok(_) => Ok(text.to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hz) if (1.0..=1000.0).contains(&hz) => Ok(hz),
        _ => Err(format!("'{text}' is no rate: 1 to 1000 Hz are")),
    }
}

#[expect(clippy::unnecessary_wraps, reason = "clap's form")]
fn parse_gamepad(text: &str) -> Result<GamepadName, String> {
    Ok(match text {
        "auto" => GamepadName::Auto,
        "off" => GamepadName::Off,
        path => GamepadName::Path(path.into()),
    })
}

fn parse_png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()) {
        Some(extension) if extension.eq_ignore_ascii_case("png") => Ok(path),
        _ => Err("a picture's name ends in .png".into()),
    }
}

/// Pixels, typed as `1280x720`.
pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some([w, h]) if (64..=7680).contains(&w) && (64..=4320).contains(&h) => Ok([w, h]),
        _ => Err("a size is WIDTHxHEIGHT in pixels, 64x64 to 7680x4320, e.g. 1280x720".into()),
    }
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn times_are_positive_and_finite() {
        assert_eq!(parse_seconds("2.5"), Ok(2.5));
        for bad in ["", "0", "-1", "NaN", "inf", "1e300", "ten"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn pictures_are_png() {
        assert_eq!(parse_png("a/b.PNG"), Ok(PathBuf::from("a/b.PNG")));
        for bad in ["", "a", "a.jpg", "png", ".png"] {
            assert!(parse_png(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_have_two_sides_in_range() {
        assert_eq!(parse_size("1280x720"), Ok([1280, 720]));
        for bad in ["", "12", "x", "0x0", "1280x", "99999x99999", "-1x5"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
