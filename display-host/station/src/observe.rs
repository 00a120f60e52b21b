//! `calot observe`: an instructor's window on a running station. The window sends requests for
//! acts, and the station decides.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use clap::Args;
use display_host::headless::Observed;
use display_host::window::{self, WindowConfig};
use shared_mem::service::Station;

use crate::args::{
    LanguageName, LookArgs, SceneArgs, ScopeName, parse_seconds, parse_size, parse_station,
};
use crate::folder::{Folder, running_scene};
use crate::problem::Problem;
use crate::say;
use crate::scene;
use crate::settings;
use crate::stop;

/// Interval between two searches for a station that does not run yet.
const LOOK_EVERY: Duration = Duration::from_millis(200);

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The window shows the trainee's picture, the score, steps, alarms and metrics of the task (also in an
exam), and histograms of the tick. Up to six displays may watch. In it you can point (a click on the
picture), pause, fog the lens, start bleeding, let a clip slip, and write a remark. The station
records each act and tells the trainee. In an exam it takes remarks only.

Examples:
  calot observe                          station 'main' of this computer, as soon as it runs
  calot observe --station left
  calot observe --scene triangle.calot   a station whose `calot rt` was started by hand")]
pub(crate) struct ObserveArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// Scene that the station runs [default: the one that its `calot run` names]
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) scene: Option<String>,
    /// Folder with the meshes that the recipe names, e.g. /data/hra [default: folder of the recipe]
    #[arg(long, value_name = "DIR", requires = "scene")]
    pub(crate) meshes: Option<PathBuf>,
    /// Angle between the endoscope's view and its shaft, degrees, in this window only; the key S
    /// changes it
    #[arg(long, value_enum, default_value_t = ScopeName::Straight)]
    pub(crate) scope: ScopeName,
    /// Language of the interface [default: that of LANG]
    #[arg(long, value_enum)]
    pub(crate) language: Option<LanguageName>,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Size of the window, pixels, e.g. 1280x720
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// End after this time, s [default: when the window is closed]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Play the station's sounds
    #[arg(long)]
    pub(crate) sound: bool,
}

pub(crate) fn run(args: &ObserveArgs) -> Result<ExitCode, Problem> {
    window::answers()?;
    let stop = stop::flag()?;
    let station = Station::new(&args.station)?;
    let folder = Folder::open(&args.station, true)?;
    let Some(scene) = scene(args, &folder, &stop)? else {
        say::note(format_args!(
            "there was nothing to see: station '{}' did not run",
            args.station
        ));
        return Ok(ExitCode::FAILURE);
    };
    let config = WindowConfig {
        station,
        scene,
        size: args.size.unwrap_or([1280, 720]),
        scope_angle: args.scope.radians(),
        cold_lens: false,
        muted: !args.sound,
        seconds: args.seconds,
        lose_device_after: None,
        tick_cpu: None,
        settings: args.look.settings(args.language),
        task: None,
        pictures: None,
        instructor: true,
        watched: false,
        simulated: [false; 3],
        replayed_task: None,
        acts: None,
        replay: None,
        recording: None,
        patch: None,
    };
    window::run(&config, &stop, &mut |observed| match observed {
        Observed::Warning(text) => say::note(format_args!("warning: {text}")),
        Observed::Settings(changed) => settings::keep(&changed),
        _ => {}
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Compiles `--scene`. Without it, waits until the station names its scene. Returns `None` if the
/// command was stopped before, or its time is over.
fn scene(
    args: &ObserveArgs,
    folder: &Folder,
    stop: &AtomicBool,
) -> Result<Option<PathBuf>, Problem> {
    if let Some(scene) = &args.scene {
        let named = SceneArgs {
            scene: scene.clone(),
            meshes: args.meshes.clone(),
        };
        return scene::compile(&named, &folder.scene()).map(Some);
    }
    let mut said = false;
    let start = Instant::now();
    let is_over = || {
        args.seconds
            .is_some_and(|s| start.elapsed().as_secs_f64() >= s)
    };
    while !stop.load(Relaxed) && !is_over() {
        if let Some(scene) = running_scene(&args.station)? {
            return Ok(Some(scene));
        }
        if !said {
            say::note(format_args!(
                "waiting for station '{0}': start it with `calot run --station {0}`; if `calot rt` was \
                 started by hand, name its scene with --scene",
                args.station
            ));
            said = true;
        }
        std::thread::sleep(LOOK_EVERY);
    }
    Ok(None)
}
