//! Options that several commands share, and their values.

use std::ffi::OsString;
use std::io::IsTerminal as _;
use std::path::PathBuf;

use assess::{Difficulty, Task};
use clap::{Args, ValueEnum};
use display_host::ui::{Look, Settings};
use display_host::words::Language;
use store::{Store, StoreError};

use crate::home;
use crate::problem::Problem;
use crate::say;
use crate::settings;

/// Tasks that need duct, artery and layered tissue.
pub(crate) const IN_TRIANGLE: [&str; 6] =
    ["basics", "identify", "clamp", "cut", "disconnect", "full"];

/// Scene of a task that needs a certain scene. `--scene` overrides it.
pub(crate) fn scene_of(task: &str) -> Option<&'static str> {
    match task {
        "phantom" => Some("phantom"),
        task => IN_TRIANGLE.contains(&task).then_some("triangle"),
    }
}

/// Scene to run.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct SceneArgs {
    /// Scene: `built-in` (liver and gallbladder), `triangle` (with Calot's triangle; the default of
    /// a task that needs it), `triangle-variant` (duct and artery take another course), `phantom`
    /// (for drills), `patient:NAME` (ada, berta, clara, dora, edith or frieda, from easy to hard),
    /// `patient:SEED` (any number), a recipe (.toml), a mesh (.obj .stl .ply .gltf .glb) or a
    /// compiled scene (.calot)
    #[arg(long, value_name = "NAME|FILE", default_value = "built-in",
        default_value_ifs = Task::ALL.map(|task| ("task", task.name(), scene_of(task.name()).or(Some("built-in")))))]
    pub(crate) scene: String,
    /// Folder with the meshes that the recipe names, e.g. /data/hra [default: folder of the recipe]
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
}

/// Real devices. `run` emulates a device that is not named; `rt` runs without it.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Devices")]
pub(crate) struct DeviceArgs {
    /// Serial device of the haptic device, e.g. /dev/ttyACM0
    #[arg(long, value_name = "TTY")]
    pub(crate) haptic: Option<PathBuf>,
    /// Serial device of the endoscope's tracker, e.g. /dev/ttyUSB0
    #[arg(long, value_name = "TTY")]
    pub(crate) tracker: Option<PathBuf>,
    /// Serial device of the foot pedal, e.g. /dev/ttyUSB1
    #[arg(long, value_name = "TTY")]
    pub(crate) pedal: Option<PathBuf>,
    /// File that names devices of any driver, their limits and their positions; `calot devices
    /// --help` shows an example. The options above override it
    #[arg(long, value_name = "FILE")]
    pub(crate) station_file: Option<PathBuf>,
}

/// Realtime options of the controller.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Realtime")]
pub(crate) struct RealtimeArgs {
    /// Core of the control tick, counted from 0 [default: the last one]
    #[arg(long, value_name = "N")]
    pub(crate) core: Option<usize>,
    /// SCHED_FIFO priority of the control tick; a higher number goes first
    #[arg(long, value_name = "2-99", default_value_t = 80, value_parser = clap::value_parser!(u8).range(2..=99))]
    pub(crate) priority: u8,
    /// Spin this long before each tick instead of sleeping, µs. Wake-ups come earlier and cost
    /// processor time
    #[arg(long, value_name = "µs", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=500))]
    pub(crate) spin: u64,
    /// Let the ticks follow the arrivals of the haptic device's samples, by at most 1 µs a tick, so
    /// that samples wait less for the tick. While the arrivals are irregular, the ticks stay in
    /// place
    #[arg(long)]
    pub(crate) follow_device: bool,
    /// Realtime scheduler of Linux. fifo pins the tick to --core; deadline reserves time for each
    /// tick, on any core
    #[arg(long, value_enum, default_value_t = SchedulerName::Fifo)]
    pub(crate) scheduler: SchedulerName,
    /// Refuse to run if Linux does not grant realtime, or if the scene does not fit (--must-fit)
    #[arg(long, conflicts_with = "no_realtime")]
    pub(crate) strict: bool,
    /// Refuse a scene if the worst tick measured on this machine exceeds 70 % of the period and no
    /// coarser level fits
    #[arg(long)]
    pub(crate) must_fit: bool,
    /// Compiled scene to take if the finer one does not fit. Repeat the option for further levels,
    /// finest first
    #[arg(long, value_name = "FILE")]
    pub(crate) coarser: Vec<PathBuf>,
    /// Hold this modem line of --scope-tty high during each tick, for an oscilloscope; see
    /// --scope-mark
    #[arg(long, value_enum, requires = "scope_tty")]
    pub(crate) scope_line: Option<ScopeLineName>,
    /// Serial port of --scope-line, e.g. /dev/ttyS0. Use a real UART: over USB each change waits
    /// for a transfer
    #[arg(long, value_name = "TTY", requires = "scope_line")]
    pub(crate) scope_tty: Option<PathBuf>,
    /// Moment at which --scope-line falls: the end of the tick, or when its force has left
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = ScopeMarkName::Tick, requires = "scope_line")]
    pub(crate) scope_mark: ScopeMarkName,
    /// Run without realtime scheduling, for machines that refuse it. Every report says so
    #[arg(long)]
    pub(crate) no_realtime: bool,
}

/// A scheduler, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum SchedulerName {
    /// SCHED_FIFO, pinned to a core
    #[default]
    Fifo,
    /// SCHED_DEADLINE
    Deadline,
}

/// A language, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LanguageName {
    /// English
    En,
    /// Deutsch
    De,
}

impl LanguageName {
    /// The requested language; otherwise that of the kept settings, or else of the locale.
    pub(crate) fn or_users(asked: Option<Self>) -> Language {
        match asked {
            Some(Self::En) => Language::English,
            Some(Self::De) => Language::German,
            None => settings::language().unwrap_or_else(|| {
                let set = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
                let locale = set("LC_ALL").or_else(|| set("LC_MESSAGES"));
                Language::of_locale(&locale.or_else(|| set("LANG")).unwrap_or_default())
            }),
        }
    }
}

/// Look of a window, and sensitivity of mouse and keyboard.
#[derive(Debug, Clone, Copy, Default, Args)]
#[command(next_help_heading = "Window")]
pub(crate) struct LookArgs {
    /// Size of all text, per cent of the usual one [default: that of the last settings, else 100]
    #[arg(long, value_name = "PERCENT",
          value_parser = clap::value_parser!(u16).range(80..=200))]
    pub(crate) text_size: Option<u16>,
    /// Use colours of high contrast
    #[arg(long)]
    pub(crate) high_contrast: bool,
    /// Swap the mouse's buttons and move the panel to the other side, for a left hand at the mouse
    #[arg(long)]
    pub(crate) left_handed: bool,
    /// Motion of the instrument for a motion of mouse or key, per cent of the usual one [default:
    /// that of the last settings, else 100]
    #[arg(long, value_name = "PERCENT",
          value_parser = clap::value_parser!(u16).range(25..=400))]
    pub(crate) sensitivity: Option<u16>,
}

impl LookArgs {
    /// Settings at the start of a window. Options override kept settings, and these the defaults.
    pub(crate) fn settings(self, language: Option<LanguageName>) -> Settings {
        let kept = settings::kept();
        Settings {
            language: LanguageName::or_users(language),
            look: Look {
                text_percent: self.text_size.unwrap_or(kept.look.text_percent),
                high_contrast: self.high_contrast || kept.look.high_contrast,
                left_handed: self.left_handed || kept.look.left_handed,
                sensitivity_percent: self.sensitivity.unwrap_or(kept.look.sensitivity_percent),
            },
            sound: kept.sound,
        }
    }
}

/// An endoscope, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum ScopeName {
    /// Looks along its shaft
    #[default]
    #[value(name = "0")]
    Straight,
    /// Looks 30 degrees off its shaft
    #[value(name = "30")]
    Thirty,
    /// Looks 45 degrees off its shaft
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

/// A modem line, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ScopeLineName {
    /// Request to send
    Rts,
    /// Data terminal ready
    Dtr,
}

/// Mark of the modem line, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum ScopeMarkName {
    /// High from the beginning of the tick to its end
    #[default]
    Tick,
    /// High from the beginning of the tick until its force has left
    Force,
}

/// Options of the controller, for every command that starts one.
#[derive(Debug, Clone, Args)]
pub(crate) struct ControllerArgs {
    #[command(flatten)]
    pub(crate) devices: DeviceArgs,
    #[command(flatten)]
    pub(crate) realtime: RealtimeArgs,
}

impl RealtimeArgs {
    /// Arguments that give `calot rt` the same options.
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
            option("--scope-mark", &typed(self.scope_mark.to_possible_value()));
        }
        let flags = [
            (self.no_realtime, "--no-realtime"),
            (self.strict, "--strict"),
            (self.must_fit, "--must-fit"),
            (self.follow_device, "--follow-device"),
        ];
        words.extend(flags.into_iter().filter(|f| f.0).map(|f| f.1.into()));
        words
    }
}

/// Gamepad of the emulated hand.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct GamepadArgs {
    /// Gamepad that leads the emulated hand: auto (the first one plugged in, once it is used), off,
    /// or a path, e.g. /dev/input/event5
    #[arg(long, value_name = "auto|off|PATH", default_value = "auto", value_parser = parse_gamepad)]
    pub(crate) gamepad: GamepadName,
}

/// A gamepad, as typed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) enum GamepadName {
    /// The first one plugged in.
    #[default]
    Auto,
    /// No gamepad.
    Off,
    /// The gamepad at this path.
    Path(PathBuf),
}

impl GamepadName {
    /// The value as typed.
    pub(crate) fn word(&self) -> &std::ffi::OsStr {
        match self {
            Self::Auto => "auto".as_ref(),
            Self::Off => "off".as_ref(),
            Self::Path(path) => path.as_os_str(),
        }
    }
}

pub(crate) fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err("a time is 0.1 to 86400 seconds".into()),
    }
}

pub(crate) fn parse_station(text: &str) -> Result<String, String> {
    match shared_mem::service::Station::check_name(text) {
        Ok(()) => Ok(text.to_owned()),
        Err(error) => Err(error.to_string()),
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

/// Parses a size in pixels, e.g. `1280x720`.
pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some([w, h]) if (64..=7680).contains(&w) && (64..=4320).contains(&h) => Ok([w, h]),
        _ => Err("a size is WIDTHxHEIGHT in pixels, 64x64 to 7680x4320, e.g. 1280x720".into()),
    }
}

/// File of the store.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct StoreFile {
    /// File of the store, which keeps trainees and results [default: calot/store.sqlite in
    /// $XDG_DATA_HOME or ~/.local/share]
    #[arg(long, value_name = "FILE", global = true)]
    pub(crate) store: Option<PathBuf>,
}

impl StoreFile {
    /// Path of the file.
    pub(crate) fn path(&self) -> Result<PathBuf, Problem> {
        if let Some(path) = &self.store {
            return Ok(path.clone());
        }
        let data =
            home::data().ok_or("there is no home folder; name the store's file with --store")?;
        Ok(data.join("store.sqlite"))
    }

    pub(crate) fn open(&self) -> Result<Store, Problem> {
        Ok(Store::open(&self.path()?)?)
    }

    /// Opens the store to read only.
    pub(crate) fn read(&self) -> Result<Store, Problem> {
        Ok(Store::read(&self.path()?)?)
    }

    /// Like [`StoreFile::read`]. Returns `None` if `--store` is absent and the default file does
    /// not exist.
    pub(crate) fn read_if_any(&self) -> Result<Option<Store>, Problem> {
        match Store::read(&self.path()?) {
            Err(StoreError::Missing { .. }) if self.store.is_none() => Ok(None),
            other => Ok(Some(other?)),
        }
    }
}

/// The option that allows a new name to resemble a known one.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct NewTrainee {
    /// Add the trainee even if the name looks like that of another trainee
    #[arg(long)]
    pub(crate) new_trainee: bool,
}

impl NewTrainee {
    /// Asks in the terminal about a new name that resembles a trainee's name: is it another
    /// person's? Refuses the name if it is not, or without a terminal.
    pub(crate) fn confirm(self, store: &Store, name: &str) -> Result<(), Problem> {
        match store.alike(name)?.filter(|_| !self.new_trainee) {
            None => Ok(()),
            Some(known) => confirm_other(
                &format!("'{name}' looks like '{known}', who is in the store"),
                "--new-trainee",
            ),
        }
    }
}

/// The option that allows a new rater's name to resemble a known one.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct NewRater {
    /// Add the rater even if the name looks like that of another rater
    #[arg(long)]
    pub(crate) new_rater: bool,
}

impl NewRater {
    /// Asks in the terminal about a new name that resembles a rater's name: is it another person's?
    /// Refuses the name if it is not, or without a terminal.
    pub(crate) fn confirm(self, store: &Store, rater: &str) -> Result<(), Problem> {
        match store.alike_rater(rater)?.filter(|_| !self.new_rater) {
            None => Ok(()),
            Some(known) => confirm_other(
                &format!("the rater '{rater}' looks like the rater '{known}' of the store"),
                "--new-rater",
            ),
        }
    }
}

/// Asks in the terminal if a name is another person's. Refuses the name if it is not, or without a
/// terminal. `resemblance` says which known name it resembles.
fn confirm_other(resemblance: &str, option: &str) -> Result<(), Problem> {
    if std::io::stdin().is_terminal() {
        say::note(format_args!("{resemblance}. Is it another person? [y/N]"));
        let mut line = String::new();
        std::io::stdin().read_line(&mut line)?;
        if matches!(line.trim(), "y" | "Y" | "yes") {
            return Ok(());
        }
    }
    Err(format!("{resemblance}. Use that name, or add {option} if it is another person").into())
}

pub(crate) fn parse_trainee(text: &str) -> Result<String, String> {
    store::check_name(text).map_err(|error| error.to_string())
}

pub(crate) fn parse_task(text: &str) -> Result<Task, String> {
    Task::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = Task::ALL.into_iter().map(Task::name).collect();
        format!("a task is one of {}", names.join(", "))
    })
}

pub(crate) fn parse_difficulty(text: &str) -> Result<Difficulty, String> {
    Difficulty::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = Difficulty::ALL.into_iter().map(Difficulty::name).collect();
        format!("a difficulty is one of {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_positive_and_finite() {
        assert_eq!(parse_seconds("2.5"), Ok(2.5));
        for bad in ["", "0", "-1", "NaN", "inf", "1e300", "ten"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
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
