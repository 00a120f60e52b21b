//! A real window on a virtual screen (Xvfb). Without Xvfb the test says so and skips.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use display_host::DisplayError;
use display_host::headless::{Ended, Observed};
use display_host::latency::now_ns;
use display_host::window::{WindowConfig, run};
use shared_mem::service::{Controller, Station};

use crate::support;

/// Resolution of the skins, in both processes.
const RINGS: usize = 32;
/// Environment variable of the process that opens the window: path of the scene.
const IN_CHILD: &str = "CALOT_WINDOW_TEST_SCENE";
/// Environment variable of that process if the window is to be disturbed and its graphics device
/// lost: path of a file that ends the process.
const TROUBLED_UNTIL: &str = "CALOT_WINDOW_TEST_UNTIL";
/// Extension of a further file, which is created once the device is lost.
const LOST: &str = "lost";
/// Number of pictures before the loss of the device.
const LOST_AFTER: u64 = 4;
/// Least number of pictures after the loss: in the new window, and after the halt.
const GOES_ON: usize = 2;
/// Longest wait on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);

/// A virtual screen that ends with its owner.
struct VirtualScreen {
    server: Child,
    display: String,
}

impl VirtualScreen {
    fn start(pixels_in: &Path) -> Option<Self> {
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1000x640x24",
                "-nolisten",
                "tcp",
                "-fbdir",
            ])
            .arg(pixels_in)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut line = String::new();
        let stdout = server.stdout.take()?;
        BufReader::new(stdout).read_line(&mut line).ok()?;
        let display = format!(":{}", line.trim());
        Some(Self { server, display })
    }
}

impl Drop for VirtualScreen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A process that ends with its test, even if the test fails.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Pixels of the screen as stored by Xvfb (XWD: a header of big-endian words, then rows).
fn pixels(dir: &Path) -> image::RgbImage {
    let bytes = std::fs::read(dir.join("Xvfb_screen0")).expect("Xvfb keeps its pixels there");
    let word = |i: usize| {
        u32::from_be_bytes(bytes[4 * i..4 * i + 4].try_into().expect("four bytes")) as usize
    };
    let (header, width, height, row, colours) = (word(0), word(4), word(5), word(12), word(19));
    let data = &bytes[header + 12 * colours..];
    image::RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let at = y as usize * row + x as usize * 4;
        image::Rgb([data[at + 2], data[at + 1], data[at]])
    })
}

/// Number of different colours on the screen.
fn colours(dir: &Path) -> usize {
    let shown = pixels(dir);
    let distinct: std::collections::HashSet<_> = shown.pixels().map(|p| p.0).collect();
    distinct.len()
}

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "waited for {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Resizes, unmaps and maps the window, stops its process for a while, and loses its graphics
/// device: each time the picture returns.
#[test]
fn a_window_in_trouble_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let Some(screen) = VirtualScreen::start(dir.path()) else {
        eprintln!("SKIPPED: Xvfb is not installed (apt-get install xvfb); no window was tested");
        return;
    };
    let tool = |words: &[&str]| {
        let mut tool = Command::new("xdotool");
        let output = tool.args(words).env("DISPLAY", &screen.display).output();
        let output = output.ok()?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    if tool(&["version"]).is_none() {
        eprintln!(
            "SKIPPED: xdotool is not installed (apt-get install xdotool); no trouble was made"
        );
        return;
    }
    let scene = dir.path().join("scene.calot");
    std::fs::write(&scene, support::scene_bytes(RINGS)).unwrap();
    let until = dir.path().join("until");
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["window::in_the_window_s_process", "--exact", "--nocapture"])
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .env(IN_CHILD, &scene)
        .env(TROUBLED_UNTIL, &until)
        .spawn()
        .unwrap();
    let mut child = Killed(child);
    let window = || tool(&["search", "--onlyvisible", "--name", "^Calot: "]).unwrap_or_default();
    let is_colourful = || colours(dir.path()) > 2000;
    let lost = until.with_extension(LOST);
    wait_for("the loss of the device", || {
        let end = child.0.try_wait().unwrap();
        assert!(end.is_none(), "the window's process failed: {end:?}");
        lost.exists()
    });
    let mut now = String::new();
    wait_for("a smaller window after it, and the picture in it", || {
        now = window();
        tool(&["windowsize", &now, "500", "400"]);
        let shown = pixels(dir.path());
        let is_dark = |x: u32, y: u32| shown.get_pixel(x, y).0 == [0; 3];
        let is_one = !now.is_empty() && !now.contains('\n');
        is_one && is_dark(900, 600) && is_dark(990, 20) && is_colourful()
    });
    tool(&["windowunmap", &now]);
    wait_for("an empty screen", || colours(dir.path()) < 10);
    tool(&["windowmap", &now]);
    wait_for("the picture when it is seen again", is_colourful);
    let pid = child.0.id().to_string();
    let signal = |name: &str| Command::new("kill").args([name, &pid]).status().unwrap();
    signal("-STOP");
    std::thread::sleep(Duration::from_secs(2));
    signal("-CONT");
    let before = pixels(dir.path());
    wait_for("another picture after the halt", || {
        pixels(dir.path()) != before
    });
    std::fs::write(&until, "").unwrap();
    let end = child.0.wait().unwrap();
    assert!(end.success(), "the window's process failed: {end}");
}

#[test]
fn a_window_shows_picture_and_panel() {
    let dir = tempfile::tempdir().unwrap();
    let Some(screen) = VirtualScreen::start(dir.path()) else {
        eprintln!("SKIPPED: Xvfb is not installed (apt-get install xvfb); no window was tested");
        return;
    };
    let scene = dir.path().join("scene.calot");
    std::fs::write(&scene, support::scene_bytes(RINGS)).unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["window::in_the_window_s_process", "--exact", "--nocapture"])
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .env(IN_CHILD, &scene)
        .spawn()
        .unwrap();
    // Judge the screen while the window is open.
    let mut colourful = 0;
    let end = loop {
        std::thread::sleep(Duration::from_millis(200));
        let now = colours(dir.path());
        if now > colourful {
            colourful = now;
            if let Some(path) = std::env::var_os("CALOT_WINDOW_PICTURE") {
                pixels(dir.path()).save(path).unwrap();
            }
        }
        if let Some(end) = child.try_wait().unwrap() {
            break end;
        }
    };
    assert!(end.success(), "the window's process failed: {end}");
    assert!(
        colourful > 2000,
        "only {colourful} colours were on the screen"
    );
}

/// Runs in the process that a test above starts, and does nothing otherwise.
#[test]
fn in_the_window_s_process() {
    let Some(path) = std::env::var_os(IN_CHILD) else {
        return;
    };
    let scene = support::scene(RINGS);
    let station = Station::new(&format!("window-{}", std::process::id())).unwrap();
    let over = Arc::new(AtomicBool::new(false));
    let controller = std::thread::spawn({
        let (station, over) = (station.clone(), over.clone());
        move || {
            let controller = Controller::open(&station).unwrap();
            let mut state = support::state(&scene, 0.01);
            let mut tools = support::tools(&scene, 0.01, 0.5);
            tools.switches = 16;
            while !over.load(Ordering::Relaxed) {
                let now = now_ns();
                (state.sample_ns, tools.sample_ns) = (now - 500_000, now - 500_000);
                (state.at_ns, tools.at_ns) = (now, now);
                state.tick += 1;
                controller.state.send_copy(*state).unwrap();
                controller.tools.send_copy(tools).unwrap();
                std::thread::sleep(Duration::from_millis(5));
            }
        }
    });
    let until = std::env::var_os(TROUBLED_UNTIL).map(std::path::PathBuf::from);
    let config = WindowConfig {
        station,
        scene: path.into(),
        size: [1000, 640],
        scope_angle: 0.0,
        cold_lens: false,
        muted: false,
        seconds: Some(PATIENCE.as_secs_f64() * 4.0),
        lose_device_after: until.is_some().then_some(LOST_AFTER),
        tick_cpu: None,
        settings: display_host::ui::Settings::default(),
        task: None,
        pictures: None,
        instructor: false,
        watched: false,
        simulated: [false; 3],
        replayed_task: None,
        acts: None,
        replay: None,
        recording: None,
        patch: None,
    };
    // Run until some pictures are drawn. A busy machine takes seconds for each.
    let (stop, mut states) = (AtomicBool::new(false), 0);
    let outcome = run(&config, &stop, &mut |seen| {
        states += u32::from(matches!(seen, Observed::State(_)));
        let is_enough = match &until {
            Some(file) => file.exists(),
            None => states >= 8,
        };
        stop.fetch_or(is_enough, Ordering::Relaxed);
        if let (Observed::Warning(text), Some(until)) = (&seen, &until)
            && text.contains("lost")
        {
            std::fs::write(until.with_extension(LOST), "").unwrap();
        }
    });
    over.store(true, Ordering::Relaxed);
    controller.join().unwrap();
    let outcome = outcome.unwrap();
    assert_eq!(outcome.ended, Ended::Stopped);
    assert!(outcome.adapter.is_some());
    if until.is_some() {
        assert!(
            outcome.warnings.iter().any(|it| it.contains("lost")),
            "{:?}",
            outcome.warnings
        );
        let least = LOST_AFTER as usize + GOES_ON;
        assert!(
            outcome.frames.len() >= least,
            "{} frames",
            outcome.frames.len()
        );
    }
    assert!(outcome.frames.len() >= 2, "{} frames", outcome.frames.len());
    // A frame that repeats a tick is not live.
    assert!(outcome.frames.iter().any(|frame| frame.live));
    for frame in &outcome.frames {
        assert!(frame.shown_ns >= frame.submitted_ns);
        assert!(frame.motion_to_picture_ns() >= 500_000);
    }
}

#[test]
fn without_a_screen_the_error_names_the_way_on() {
    let out = Command::new(std::env::current_exe().unwrap())
        .args([
            "window::in_a_process_without_a_screen",
            "--exact",
            "--nocapture",
        ])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env("CALOT_NO_SCREEN", "1")
        .output()
        .unwrap();
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
}

/// Runs in the process that the test above starts, and does nothing otherwise.
#[test]
fn in_a_process_without_a_screen() {
    if std::env::var_os("CALOT_NO_SCREEN").is_none() {
        return;
    }
    let scene = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(scene.path(), support::scene_bytes(12)).unwrap();
    let config = WindowConfig {
        station: Station::new(&format!("dark-{}", std::process::id())).unwrap(),
        scene: scene.path().to_owned(),
        size: [640, 480],
        scope_angle: 0.0,
        cold_lens: false,
        muted: false,
        seconds: Some(1.0),
        lose_device_after: None,
        tick_cpu: None,
        settings: display_host::ui::Settings::default(),
        task: None,
        pictures: None,
        instructor: false,
        watched: false,
        simulated: [false; 3],
        replayed_task: None,
        acts: None,
        replay: None,
        recording: None,
        patch: None,
    };
    let error = run(&config, &AtomicBool::new(false), &mut |_| {}).unwrap_err();
    assert!(matches!(error, DisplayError::NoWindow { .. }), "{error}");
    assert!(error.to_string().contains("--headless"), "{error}");
}
