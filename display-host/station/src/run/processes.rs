//! Processes of a station: the controller, and an emulator for the devices that are not named.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use display_host::report::DeviceSummary;
use hardware::station::StationFile;
use shared_mem::message::STAGES;
use shared_mem::scene::SceneFile;

use super::args::RunArgs;
use super::player::Player;
use crate::args::DeviceArgs;
use crate::children::{EndedEarly, Process, args as words, option};
use crate::problem::Problem;
use crate::rt::DOES_NOT_FIT;
use crate::say;
use crate::scene;

/// Longest time until a child is ready. The handshake of a real device takes seconds.
const PATIENCE_TO_START: Duration = Duration::from_secs(60);

/// Running processes.
pub(crate) struct Running {
    /// Children in the order in which they started. The controller is last.
    pub(crate) children: Vec<Process>,
    /// Level of the scene that the controller took. The display must show it.
    pub(crate) scene: PathBuf,
    /// Warnings: the controller is not realtime, with the causes, or a coarser level of the scene
    /// runs.
    pub(crate) warnings: Vec<String>,
    /// Devices that the controller opened.
    pub(crate) devices: Vec<DeviceSummary>,
    /// Time of each stage in the worst tick of the controller's trial, ns; `None` without a trial.
    pub(crate) admitted_ns: Option<[u64; STAGES]>,
}

/// A running controller and the level of the scene that it took.
struct Controller {
    process: Process,
    scene: PathBuf,
    /// Warning that the finest level of the scene did not fit this machine.
    coarser: Option<String>,
}

/// Starts an emulator for the devices that are not named, then the controller.
pub(crate) fn start(
    args: &RunArgs,
    player: Player,
    scene: &Path,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<Running, Problem> {
    let named = &args.controller.devices;
    let emulated = Emulated::for_missing(named, folder)?;
    let mut children = Vec::new();
    if emulated.any() {
        let words = emulated.words(args, player, scene);
        children.push(Process::start("emulate", &words, PATIENCE_TO_START, stop)?);
    }
    let controller = control(args, &emulated.with(named), scene, folder, stop)?;
    let mut warnings = not_realtime(controller.process.ready_text());
    warnings.extend(controller.coarser);
    let devices = devices(controller.process.ready_text());
    let admitted_ns = admitted(controller.process.ready_text());
    children.push(controller.process);
    Ok(Running {
        children,
        scene: controller.scene,
        warnings,
        devices,
        admitted_ns,
    })
}

/// Folder of the emulated devices, and which devices are emulated.
struct Emulated {
    folder: PathBuf,
    haptic: bool,
    tracker: bool,
    pedal: bool,
}

impl Emulated {
    /// Emulates each device that neither `named` nor its station file names.
    fn for_missing(named: &DeviceArgs, folder: &Path) -> Result<Self, Problem> {
        let file = named.station_file.as_deref().map(StationFile::read);
        let file = file.transpose()?.unwrap_or_default();
        Ok(Self {
            folder: folder.join("devices"),
            haptic: named.haptic.is_none() && file.haptic.is_none(),
            tracker: named.tracker.is_none() && file.tracker.is_none(),
            pedal: named.pedal.is_none() && file.pedal.is_none(),
        })
    }

    fn any(&self) -> bool {
        self.haptic || self.tracker || self.pedal
    }

    /// Arguments of the emulator.
    fn words(&self, args: &RunArgs, player: Player, scene: &Path) -> Vec<OsString> {
        let mut emulate = words([
            &"emulate",
            &"--with-parent",
            &std::process::id().to_string(),
            &"--dir",
            &self.folder,
            &"--scene",
            &scene,
            &"--seed",
            &args.seed.to_string(),
            &"--station",
            &args.station,
            &"--hand",
            &player.emulated_hand(),
            &"--gamepad",
            &args.gamepad.gamepad.word(),
        ]);
        if let Some(core) = args.controller.realtime.core {
            emulate.extend(["--tick-core".into(), core.to_string().into()]);
        }
        emulate
    }

    /// Devices that the controller opens.
    fn with(&self, named: &DeviceArgs) -> DeviceArgs {
        let path = |named: &Option<PathBuf>, emulated: bool, name: &str| {
            named.clone().or(emulated.then(|| self.folder.join(name)))
        };
        DeviceArgs {
            haptic: path(&named.haptic, self.haptic, "haptic"),
            tracker: path(&named.tracker, self.tracker, "tracker"),
            pedal: path(&named.pedal, self.pedal, "pedal"),
            station_file: named.station_file.clone(),
        }
    }
}

/// Starts the controller with the finest level of the scene that fits this machine.
fn control(
    args: &RunArgs,
    devices: &DeviceArgs,
    scene: &Path,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<Controller, Problem> {
    let mut scene = scene.to_owned();
    let mut level = 1;
    loop {
        // If the user names coarser levels, the controller chooses among them. Otherwise the next
        // level is compiled here when the present one does not fit.
        let next = match args.controller.realtime.coarser.is_empty() {
            true => scene::coarser(&args.scene, level),
            false => None,
        };
        let words = rt_words(args, devices, &scene, next.is_some());
        let problem = match Process::start("rt", &words, PATIENCE_TO_START, stop) {
            Ok(process) => {
                let finest = level == 1;
                let taken = taken(&process, &scene, &args.controller.realtime.coarser)?;
                let coarser = (!finest || taken != scene).then(|| coarser_level(&taken));
                return Ok(Controller {
                    process,
                    coarser: coarser.transpose()?,
                    scene: taken,
                });
            }
            Err(problem) => problem,
        };
        let refused = problem
            .downcast_ref::<EndedEarly>()
            .filter(|early| early.has_refused);
        let code = refused.and_then(|early| early.status.code());
        match next {
            Some(recipe) if code == Some(DOES_NOT_FIT.into()) => {
                say::note("calot: taking the next coarser level of the scene");
                scene = folder.join(format!("coarser-{level}.calot"));
                scene::bring(&recipe, &scene)?;
            }
            _ => return Err(problem),
        }
        level += 1;
    }
}

/// Arguments of a controller.
fn rt_words(args: &RunArgs, devices: &DeviceArgs, scene: &Path, must_fit: bool) -> Vec<OsString> {
    let mut realtime = args.controller.realtime.clone();
    realtime.must_fit |= must_fit;
    let mut rt = words([
        &"rt",
        &"--with-parent",
        &std::process::id().to_string(),
        &"--scene",
        &scene,
        &"--station",
        &args.station,
    ]);
    rt.extend(realtime.words());
    option(&mut rt, "--haptic", devices.haptic.as_deref());
    option(&mut rt, "--tracker", devices.tracker.as_deref());
    option(&mut rt, "--pedal", devices.pedal.as_deref());
    option(&mut rt, "--station-file", devices.station_file.as_deref());
    rt
}

/// Warning about a controller that reported ready without realtime, with the refusals of Linux. The
/// controller itself has printed the refusals on standard error.
fn not_realtime(ready: &str) -> Vec<String> {
    let ready: serde_json::Value = serde_json::from_str(ready).unwrap_or_default();
    if ready["realtime"] != false {
        return Vec::new();
    }
    let refused = ready["refused"].as_array().into_iter().flatten();
    let refused: Vec<&str> = refused.filter_map(serde_json::Value::as_str).collect();
    vec![format!("NOT REALTIME: {}", refused.join("; "))]
}

/// Devices that the controller names in its answer.
fn devices(ready: &str) -> Vec<DeviceSummary> {
    let ready: serde_json::Value = serde_json::from_str(ready).unwrap_or_default();
    serde_json::from_value(ready["devices"].clone()).unwrap_or_default()
}

/// Time of each stage in the worst tick of the controller's trial, ns; `None` without a trial.
fn admitted(ready: &str) -> Option<[u64; STAGES]> {
    let ready: serde_json::Value = serde_json::from_str(ready).ok()?;
    serde_json::from_value(ready["admission"]["worst_stage_ns"].clone()).ok()
}

/// Level that the controller took, of the scene's own file or of those that the user named.
fn taken(controller: &Process, finest: &Path, coarser: &[PathBuf]) -> Result<PathBuf, Problem> {
    let ready: serde_json::Value = serde_json::from_str(controller.ready_text())?;
    let own = SceneFile::levels(finest).into_iter().skip(1);
    for path in own.chain(coarser.iter().flat_map(|file| SceneFile::levels(file))) {
        let id = SceneFile::open(&path)?.id();
        let id: String = id.iter().map(|byte| format!("{byte:02x}")).collect();
        if ready["scene_id"] == id.as_str() {
            say::note(format_args!(
                "calot: running the coarser level {}",
                path.display()
            ));
            return Ok(path);
        }
    }
    Ok(finest.to_owned())
}

/// Warning that this coarser level of the scene runs.
fn coarser_level(scene: &Path) -> Result<String, Problem> {
    let spheres = SceneFile::open(scene)?.spheres().len();
    Ok(format!(
        "the finest level of the scene does not fit this machine: a coarser one of {spheres} spheres ran; compare \
         it only with runs of this level"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_emulator_gets_the_core_of_the_tick() {
        let emulated = Emulated::for_missing(&DeviceArgs::default(), Path::new("/run/x")).unwrap();
        let line = |core| {
            let mut args = RunArgs::default();
            args.controller.realtime.core = core;
            let words = emulated.words(&args, Player::Script, Path::new("x.calot"));
            let words = words.iter().map(|it| it.to_string_lossy().into_owned());
            words.collect::<Vec<_>>().join(" ")
        };
        assert!(
            line(Some(0)).ends_with("--tick-core 0"),
            "{}",
            line(Some(0))
        );
        assert!(!line(None).contains("--tick-core"), "{}", line(None));
    }

    #[test]
    fn the_cost_of_the_stages_is_read_from_the_controllers_answer() {
        let ready = r#"{"admission": {"worst_stage_ns": [1, 2, 3, 4, 5, 6, 7]}}"#;
        assert_eq!(admitted(ready), Some([1, 2, 3, 4, 5, 6, 7]));
        assert_eq!(admitted(r#"{"admission": null}"#), None);
        assert_eq!(admitted("nonsense"), None);
    }

    #[test]
    fn a_coarser_level_is_a_warning_with_its_spheres() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("coarse.calot");
        let recipe = scene_prepare::Recipe::built_in().unwrap();
        scene::bring(&recipe.with_spheres(120).unwrap(), &path).unwrap();
        let spheres = SceneFile::open(&path).unwrap().spheres().len();
        let warning = coarser_level(&path).unwrap();
        assert!(
            warning.contains(&format!("a coarser one of {spheres} spheres ran")),
            "{warning}"
        );
    }

    #[test]
    fn a_controller_without_realtime_is_a_warning_with_the_cause() {
        let ready = r#"{"realtime": false, "refused": ["SCHED_FIFO was refused", "memory"]}"#;
        assert_eq!(
            not_realtime(ready),
            ["NOT REALTIME: SCHED_FIFO was refused; memory"]
        );
        assert!(not_realtime(r#"{"realtime": true, "refused": ["deep idle"]}"#).is_empty());
    }
}
