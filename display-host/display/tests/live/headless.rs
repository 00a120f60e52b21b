//! The headless display over real shared memory, with a simulated controller.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use display_host::DisplayError;
use display_host::headless::{Ended, HeadlessConfig, Observed, run};
use display_host::latency::now_ns;
use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::{Controller, Host, Station};
use shared_mem::words::EventKind;

use crate::support;

/// Path of the scene, which every test maps, and its checked content.
fn scene() -> &'static (tempfile::TempPath, SceneFile) {
    static SCENE: OnceLock<(tempfile::TempPath, SceneFile)> = OnceLock::new();
    SCENE.get_or_init(|| {
        let path = tempfile::NamedTempFile::new()
            .expect("the test's own set-up")
            .into_temp_path();
        std::fs::write(&path, support::scene_bytes(24)).expect("the test's own set-up");
        let scene = support::scene(24);
        (path, scene)
    })
}

fn config(name: &str, seconds: f64, frames: u32) -> (HeadlessConfig, tempfile::TempDir) {
    let out = tempfile::tempdir().expect("the test's own set-up");
    let config = HeadlessConfig {
        station: Station::new(&format!("{name}-{}", std::process::id()))
            .expect("the test's own set-up"),
        scene: scene().0.to_path_buf(),
        seconds,
        out_dir: out.path().join("frames"),
        size: Some([160, 120]),
        frames,
        patience: Duration::from_secs(20),
        tick_cpu: None,
        task_over: None,
        task: None,
        need_pictures: frames > 0,
    };
    (config, out)
}

/// Frames published by a simulated controller.
struct Play {
    state: Box<StateFrame>,
    tools: ToolFrame,
    tick: u64,
    events: u64,
}

impl Play {
    fn new() -> Self {
        let scene = &scene().1;
        Self {
            state: support::state(scene, 0.006),
            tools: support::tools(scene, 0.006, 0.3),
            tick: 0,
            events: 0,
        }
    }

    fn step(&mut self, controller: &Controller) {
        self.tick += 1;
        let now = now_ns();
        (self.state.tick, self.tools.tick) = (self.tick, self.tick);
        (self.state.sample_ns, self.tools.sample_ns) = (now - 700_000, now - 700_000);
        (self.state.at_ns, self.tools.at_ns) = (now, now);
        self.tools.contact_count = 3;
        controller
            .state
            .send_copy(*self.state)
            .expect("the test's own set-up");
        controller
            .tools
            .send_copy(self.tools)
            .expect("the test's own set-up");
    }

    fn event(&mut self, controller: &Controller, kind: u32) {
        let mut event: EventMsg = bytemuck::Zeroable::zeroed();
        event.sequence = self.events;
        event.kind = kind;
        self.events += 1;
        controller
            .events
            .send_copy(event)
            .expect("the test's own set-up");
    }
}

/// Simulates a controller until `stop`.
fn play(
    station: &Station,
    stop: &Arc<AtomicBool>,
    mut each: impl FnMut(&mut Play, &Controller) + Send + 'static,
) -> std::thread::JoinHandle<()> {
    let (station, stop) = (station.clone(), stop.clone());
    std::thread::spawn(move || {
        let controller = Controller::open(&station).expect("the test's own set-up");
        let mut play = Play::new();
        while !stop.load(Ordering::Relaxed) {
            each(&mut play, &controller);
            std::thread::sleep(Duration::from_millis(4));
        }
    })
}

#[test]
fn a_run_leaves_pictures_latencies_and_everything_it_heard() {
    let (config, out) = config("pictures", 2.0, 3);
    let over = Arc::new(AtomicBool::new(false));
    let controller = play(&config.station, &over, |play, controller| {
        play.step(controller);
        if play.tick == 50 {
            play.event(controller, EventKind::Grasp.number());
        }
        let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
        batch.sequence = play.tick;
        controller.timing.send_copy(*batch).unwrap();
    });
    let (mut events, mut batches, mut progress) = (0, 0, 0);
    let outcome = run(&config, &AtomicBool::new(false), &mut |seen| match seen {
        Observed::Event(_) => events += 1,
        Observed::Timing(_) => batches += 1,
        Observed::Progress(_) => progress += 1,
        _ => {}
    });
    over.store(true, Ordering::Relaxed);
    controller.join().unwrap();
    let outcome = outcome.unwrap();

    assert_eq!(outcome.ended, Ended::TimeOver);
    assert!(outcome.adapter.is_some());
    assert_eq!(events, 1);
    assert!(batches > 50 && progress >= 3, "{batches} {progress}");
    assert_eq!(outcome.counters.malformed, 0);
    let mut names: Vec<_> = std::fs::read_dir(out.path().join("frames"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let wanted = [
        "before_press.png",
        "deepest_press.png",
        "frame_0000.png",
        "frame_0001.png",
        "frame_0002.png",
        "grasp.png",
    ];
    assert_eq!(names, wanted);
    assert_eq!(outcome.frames.len(), 6);
    for frame in &outcome.frames {
        use std::os::unix::fs::PermissionsExt as _;
        let path = frame.path.as_ref().unwrap();
        let mode = std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0, "{} is its user's alone", path.display());
        let picture = image::open(frame.path.as_ref().unwrap()).unwrap();
        assert_eq!((picture.width(), picture.height()), (160, 120));
        // "Before the press" may be the scene at rest, which no controller has sent.
        if !frame.live {
            continue;
        }
        // The simulated controller puts 0.7 ms between sample and state.
        let [motion, publish] = [frame.motion_to_picture_ns(), frame.publish_to_frame_ns()];
        assert!(motion >= publish + 700_000, "{motion} {publish}");
    }
    assert!(outcome.frames.iter().any(|frame| frame.live));
}

#[test]
fn silence_from_the_start_is_an_error_that_names_the_command() {
    let (mut config, _out) = config("silent", 1.0, 0);
    config.patience = Duration::from_millis(300);
    let mut progress = 0;
    let error = run(&config, &AtomicBool::new(false), &mut |seen| {
        progress += u32::from(matches!(seen, Observed::Progress(_)));
    });
    let Err(error @ DisplayError::NoController { .. }) = error else {
        panic!("{error:?}");
    };
    assert!(error.to_string().contains("calot rt"), "{error}");
    assert!(progress > 0);
}

#[test]
fn another_scene_is_refused_by_name() {
    let (config, _out) = config("other-scene", 1.0, 0);
    let over = Arc::new(AtomicBool::new(false));
    let controller = play(&config.station, &over, |play, controller| {
        play.state.scene_id = [0xab; 16];
        play.tools.scene_id = [0xab; 16];
        play.step(controller);
    });
    let error = run(&config, &AtomicBool::new(false), &mut |_| {}).unwrap_err();
    over.store(true, Ordering::Relaxed);
    controller.join().unwrap();
    let text = error.to_string();
    assert!(matches!(error, DisplayError::OtherScene { .. }), "{text}");
    assert!(
        text.contains("abababab") && text.contains("blobs"),
        "{text}"
    );
}

#[test]
fn garbage_is_counted_and_skipped() {
    let (config, _out) = config("garbage", 0.6, 0);
    let over = Arc::new(AtomicBool::new(false));
    let controller = play(&config.station, &over, |play, controller| {
        match play.tick % 4 {
            1 => play.state.spheres[3].center_m[1] = f32::NAN,
            2 => play.state.sphere_count = u32::MAX,
            3 => play.tools.capsule_count = 4000,
            _ => {
                *play = Play {
                    tick: play.tick,
                    ..Play::new()
                }
            }
        }
        play.step(controller);
    });
    let mut bad = 0;
    let outcome = run(&config, &AtomicBool::new(false), &mut |seen| match seen {
        Observed::State(state) => bad += u32::from(state.spheres().is_none()),
        Observed::Tools(tools) => bad += u32::from(tools.capsules().is_none()),
        _ => {}
    });
    over.store(true, Ordering::Relaxed);
    controller.join().unwrap();
    let counters = outcome.unwrap().counters;
    assert_eq!(bad, 0);
    assert!(
        counters.malformed > 3 && counters.states > 3,
        "{counters:?}"
    );
}

#[test]
fn a_controller_that_dies_ends_the_run_and_one_that_returns_does_not() {
    let (mut config, _out) = config("dies", 120.0, 0);
    config.patience = Duration::from_secs(6);
    let station = config.station.clone();
    let seen = Arc::new(AtomicU32::new(0));
    let states = seen.clone();
    let controllers = std::thread::spawn(move || {
        for first_tick in [1_000_000, 0] {
            let over = Arc::new(AtomicBool::new(false));
            let controller = play(&station, &over, move |play, controller| {
                play.tick = play.tick.max(first_tick);
                play.step(controller);
            });
            let before = states.load(Ordering::Relaxed);
            while states.load(Ordering::Relaxed) < before + 20 && !controller.is_finished() {
                std::thread::sleep(Duration::from_millis(20));
            }
            over.store(true, Ordering::Relaxed);
            controller.join().unwrap();
        }
    });
    let outcome = run(&config, &AtomicBool::new(false), &mut |it| {
        if let Observed::State(_) = it {
            seen.fetch_add(1, Ordering::Relaxed);
        }
    });
    // Lets the controllers end after a run that failed.
    seen.store(u32::MAX / 2, Ordering::Relaxed);
    controllers.join().unwrap();
    let outcome = outcome.unwrap();
    assert_eq!(outcome.ended, Ended::ControllerGone);
    assert_eq!(outcome.counters.restarts, 1, "{:?}", outcome.counters);
    assert_eq!(outcome.warnings.len(), 1);
}

#[test]
fn a_stop_ends_it_at_once() {
    let (config, _out) = config("stop", 60.0, 0);
    let over = Arc::new(AtomicBool::new(false));
    let controller = play(&config.station, &over, |play, controller| {
        play.step(controller);
    });
    let stop = AtomicBool::new(false);
    let outcome = run(&config, &stop, &mut |seen| {
        if let Observed::State(_) = seen {
            stop.store(true, Ordering::Relaxed);
        }
    });
    over.store(true, Ordering::Relaxed);
    controller.join().unwrap();
    assert_eq!(outcome.unwrap().ended, Ended::Stopped);
}

#[test]
fn a_picture_that_cannot_be_and_a_run_without_end_are_refused() {
    let (mut bad, _out) = config("bad", f64::NAN, 0);
    let refused = run(&bad, &AtomicBool::new(false), &mut |_| {});
    assert!(matches!(refused, Err(DisplayError::Seconds(_))));
    (bad.seconds, bad.frames, bad.size) = (1.0, 1, Some([16, 9000]));
    let refused = run(&bad, &AtomicBool::new(false), &mut |_| {});
    assert!(matches!(refused, Err(DisplayError::Size { .. })));
}

#[test]
fn a_missing_scene_and_a_station_with_all_its_displays_are_refused() {
    let (mut config, out) = config("refused", 1.0, 0);
    let mut displays = Vec::new();
    let full = loop {
        match Host::open(&config.station) {
            Ok(display) => displays.push(display),
            Err(error) => break error,
        }
    };
    let error = run(&config, &AtomicBool::new(false), &mut |_| {}).unwrap_err();
    assert!(matches!(error, DisplayError::Service(_)), "{error:?}");
    assert_eq!(error.to_string(), full.to_string());
    let whole = format!(
        "station '{}' has {} readers (every display, recorder, link and surgeon counts) already; close one",
        config.station.name(),
        displays.len()
    );
    assert_eq!(error.to_string(), whole);
    config.scene = out.path().join("none.calot");
    let error = run(&config, &AtomicBool::new(false), &mut |_| {}).unwrap_err();
    assert!(matches!(error, DisplayError::Scene(_)), "{error:?}");
    let said = error.to_string();
    assert!(said.contains("none.calot"), "{said}");
}

#[test]
fn without_a_driver_the_run_goes_on_and_says_what_to_install() {
    let out = std::process::Command::new(std::env::current_exe().unwrap())
        .args([
            "headless::in_a_process_without_a_driver",
            "--exact",
            "--nocapture",
        ])
        .env("VK_DRIVER_FILES", "/dev/null")
        .env("VK_ICD_FILENAMES", "/dev/null")
        .env("WGPU_BACKEND", "vulkan")
        .env("CALOT_NO_DRIVER", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{said}");
    let ran = String::from_utf8_lossy(&out.stdout);
    assert!(ran.contains("1 passed"), "no test of that name: {ran}");
}

/// Runs in the process that the test above starts, and does nothing otherwise.
#[test]
fn in_a_process_without_a_driver() {
    if std::env::var_os("CALOT_NO_DRIVER").is_none() {
        return;
    }
    let (mut config, _out) = config("no-driver", 0.5, 2);
    let over = Arc::new(AtomicBool::new(false));
    let controller = play(&config.station, &over, |play, controller| {
        play.step(controller);
    });
    config.need_pictures = false;
    let (mut states, never) = (0, AtomicBool::new(false));
    let outcome = run(&config, &never, &mut |seen| {
        states += u32::from(matches!(seen, Observed::State(_)));
    });
    config.need_pictures = true;
    let needed = run(&config, &never, &mut |_| {});
    over.store(true, Ordering::Relaxed);
    controller.join().unwrap();
    let outcome = outcome.unwrap();
    assert_eq!(outcome.ended, Ended::TimeOver);
    assert!(outcome.adapter.is_none() && outcome.frames.is_empty() && states > 20);
    assert!(
        outcome.warnings[0].contains("mesa-vulkan-drivers"),
        "{:?}",
        outcome.warnings
    );
    assert!(matches!(needed, Err(DisplayError::NoAdapter { .. })));
}
