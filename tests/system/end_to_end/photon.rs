//! `calot photon` with emulated light sensors that look at the pixels of a virtual screen: one at a
//! sound card, one on a board that speaks the rig protocol.

use std::io::Write as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use display_host::latency::now_ns;
use serde_json::Value;
use shared_mem::message::HandMsg;
use shared_mem::service::{HandSender, Station};
use shared_mem::words::Switches;
use system_tests::compositor::Compositor;
use system_tests::screen::VirtualScreen;
use system_tests::{calot, compiled, documents, said, station_name, turn, wait_until};

use crate::launcher::screen;

/// Samples of the emulated sound card per second.
const RATE_HZ: u64 = 48_000;
/// Delay that the emulated diodes add, ms. The measured times must contain this delay.
const DIODE_MS: u64 = 40;

/// `calot photon` with a short measurement at each place, in a window on this virtual screen.
fn photon(screen: &VirtualScreen, out: &Path) -> Command {
    let mut command = calot();
    command
        .args(["photon", "--seconds", "10", "--longest", "1500", "--json"])
        .args(["--station", &station_name("photon"), "--size", "640x480"])
        .arg("--out")
        .arg(out)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY");
    command
}

/// An emulated photodiode. It reports what the screen showed `DIODE_MS` ago.
struct Diode<'a> {
    screen: &'a VirtualScreen,
    seen: Vec<(Instant, bool)>,
    bright: bool,
}

impl<'a> Diode<'a> {
    fn on(screen: &'a VirtualScreen) -> Self {
        Self {
            screen,
            seen: Vec::new(),
            bright: false,
        }
    }

    /// State of the diode now. It covers all three places, because the square is at only one of
    /// them at a time.
    fn is_bright(&mut self) -> bool {
        let now = Instant::now();
        let bright = [30, 240, 450]
            .into_iter()
            .any(|y| self.screen.is_white(30, y));
        self.seen.push((now, bright));
        let then = now.checked_sub(Duration::from_millis(DIODE_MS));
        let due = self.seen.partition_point(|it| Some(it.0) <= then);
        if let Some((_, bright)) = self.seen.drain(..due).next_back() {
            self.bright = bright;
        }
        self.bright
    }
}

/// Asserts that the report has presentation times, or says why it has none.
fn assert_presented(json: &Value) {
    let told = &json["screen"]["presentation"];
    let count = |key: &str| told[key].as_u64().expect("a number");
    println!("presentation: {told} {}", json["screen"]["presentation_ms"]);
    if told["source"].is_string() {
        assert!(count("flips") + count("copies") > 0, "{told}");
        assert!(told["missing"].is_null());
        // A driver shows a picture soon after it was handed over, even on a busy machine.
        let median = json["screen"]["presentation_ms"]["median"].as_f64();
        assert!(
            median.is_some_and(|ms| ms > -50.0 && ms < 1000.0),
            "{json:#}"
        );
    } else {
        let missing = told["missing"].as_str().unwrap_or_default();
        assert!(
            missing.contains("driver does not provide the times"),
            "{told}"
        );
        assert!(json["screen"]["presentation_ms"].is_null());
    }
}

/// Asserts the sensor and the rows of the report. In each row that pairs a tick's picture with its
/// light, the light must come after the diode's delay.
fn assert_seen(json: &Value, kind: &str, rows: &[(&str, &str)]) {
    documents::check(json);
    assert_eq!(json["complete"], true, "{json:#}");
    assert_eq!(json["sensor"]["kind"], kind);
    assert_presented(json);
    assert!(
        json["screen"]["present_mode"]
            .as_str()
            .is_some_and(|it| it.starts_with("Fifo"))
    );
    let places = json["places"].as_array().expect("places");
    let word = |row: &'_ Value, key: &str| row[key].as_str().expect("a word").to_owned();
    let names: Vec<_> = places
        .iter()
        .map(|it| (word(it, "place"), word(it, "from")))
        .collect();
    let rows: Vec<_> = rows
        .iter()
        .map(|(place, from)| ((*place).to_owned(), (*from).to_owned()))
        .collect();
    assert_eq!(names, rows);
    for row in places.iter().filter(|row| row["from"] == "tick") {
        assert!(row["changes"].as_u64().is_some_and(|n| n >= 1), "{row}");
        // On a busy machine the window may report its pictures too late, and no light has a
        // picture.
        let Some(since_ms) = row["picture_to_light_ms"]["median"].as_f64() else {
            println!("no picture belongs to the light: {row}");
            continue;
        };
        let of = |key: &str, what: &str| row[key][what].as_f64().expect("a time");
        // A picture is stamped when the driver's call returns. The screen may show it up to 20 ms
        // earlier. A busy machine samples the pixels late, so there is no upper limit.
        assert!(since_ms > DIODE_MS as f64 - 20.0, "{row}");
        assert!(
            of("to_light_ms", "median") > of("to_picture_ms", "median"),
            "{row}"
        );
        assert!(
            of("to_light_ms", "max") >= of("to_light_ms", "median"),
            "{row}"
        );
    }
}

/// Waits for `calot photon` and returns its JSON. If it fails, the test fails with its error
/// output.
fn answer(child: Child) -> Value {
    let output = child.wait_with_output().expect("it ran");
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).expect("--json prints JSON")
}

#[test]
fn a_diode_at_a_sound_card_sees_the_tick_and_the_motion() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let out = folder.path().join("out");
    let child = photon(&screen, &out)
        .args(["--audio", "-", "--place", "top,bottom"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let json = hear(child, &screen);
    let rows = [
        ("top", "tick"),
        ("top", "motion"),
        ("bottom", "tick"),
        ("bottom", "motion"),
    ];
    assert_seen(&json, "sound", &rows);
    let page = std::fs::read_to_string(out.join("photon.html")).expect("a page");
    assert!(page.contains("top, from tick") && page.contains("<svg"));
}

/// Lets an emulated diode at a sound card report until `child` ends. Returns the child's JSON.
fn hear(mut child: Child, screen: &VirtualScreen) -> Value {
    let mut card = child.stdin.take().expect("a pipe");
    let (mut diode, begun, mut sent) = (Diode::on(screen), Instant::now(), 0);
    while child.try_wait().expect("a child").is_none() {
        let due = begun.elapsed().as_micros() as u64 * RATE_HZ / 1_000_000;
        let level: i16 = if diode.is_bright() { 9000 } else { -9000 };
        let block: Vec<u8> = (sent..due).flat_map(|_| level.to_le_bytes()).collect();
        sent = due;
        // The program closes its end when it has measured. A write then fails, which is no error.
        let _ = card.write_all(&block);
        std::thread::sleep(Duration::from_millis(1));
    }
    answer(child)
}

#[test]
fn on_wayland_the_light_comes_after_the_compositors_time() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let Some(compositor) = Compositor::start(folder.path(), Some(&screen)) else {
        eprintln!("SKIPPED: weston is not installed (apt-get install weston)");
        return;
    };
    let child = photon(&screen, &folder.path().join("out"))
        .env_remove("DISPLAY")
        .env("WAYLAND_DISPLAY", &compositor.display)
        .args(["--audio", "-", "--place", "top"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let json = hear(child, &screen);
    assert_seen(&json, "sound", &[("top", "tick"), ("top", "motion")]);
    let told = &json["screen"]["presentation"];
    assert_eq!(told["source"], "wp_presentation", "{told}");
    assert_eq!(told["by_hardware"], 0, "this compositor has a clock alone");
    assert!(json["notes"].to_string().contains("from its own clock"));
    let tick = &json["places"][0];
    let Some(since_ms) = tick["presentation_to_light_ms"]["median"].as_f64() else {
        println!("no presentation belongs to the light: {tick}");
        return;
    };
    // The compositor may stamp a picture up to a frame of 60 Hz after the pixels have changed.
    assert!(since_ms > DIODE_MS as f64 - 20.0, "{tick}");
}

#[test]
fn a_diode_on_a_board_of_the_rig_protocol_sees_the_tick() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    // A second emulator is the board. Its pedal's switch is closed while the diode is bright.
    let name = station_name("board");
    let board = folder.path().join("board");
    let mut pedal = calot()
        .args([
            "emulate",
            "--hand",
            "parked",
            "--gamepad",
            "off",
            "--station",
            &name,
        ])
        .arg("--dir")
        .arg(&board)
        .args(["--scene", &compiled("built-in", None)])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    wait_until("the board", || board.join("pedal").exists());
    let over = AtomicBool::new(false);
    let json = std::thread::scope(|scope| {
        let (screen, over, name) = (&screen, &over, &name);
        scope.spawn(move || {
            let station = Station::new(name).expect("a name");
            let sender = HandSender::open(&station).expect("nobody else leads");
            let (mut diode, began_ns) = (Diode::on(screen), now_ns());
            while !over.load(Ordering::Relaxed) {
                let switches = match diode.is_bright() {
                    true => Switches::COAGULATE.bits(),
                    false => 0,
                };
                sender.send(HandMsg {
                    at_ns: now_ns(),
                    began_ns,
                    switches,
                    ..HandMsg::zeroed()
                });
                std::thread::sleep(Duration::from_millis(2));
            }
        });
        let child = photon(screen, &folder.path().join("out"))
            .arg("--board")
            .arg(board.join("pedal"))
            .args(["--place", "middle"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let output = child.wait_with_output().expect("it ran");
        over.store(true, Ordering::Relaxed);
        assert!(output.status.success(), "{}", said(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("--json prints JSON")
    });
    let _ = pedal.kill();
    let _ = pedal.wait();
    assert_seen(&json, "board", &[("middle", "tick"), ("middle", "motion")]);
}

#[test]
fn a_blind_sensor_ends_with_an_error_that_says_what_the_square_did() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let mut child = photon(&screen, &folder.path().join("out"))
        .args(["--audio", "-", "--patience", "6"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    // The pipe stays open and carries no samples.
    let card = child.stdin.take();
    let output = child.wait_with_output().expect("it ran");
    drop(card);
    assert!(!output.status.success());
    let words = said(&output);
    assert!(
        words.contains("the sensor did not see the square (top): it reported 0 changes of light"),
        "{words}"
    );
}
