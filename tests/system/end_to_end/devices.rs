//! `calot devices` as a rig builder runs it: the real program on emulated devices.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bytemuck::Zeroable as _;
use serde_json::Value;
use shared_mem::message::{DeviceHealth, HandMsg, ToolFrame};
use shared_mem::service::{HandSender, Host, Station};
use shared_mem::words::{Buttons, Switches};
use system_tests::{calot, compiled, finish, said, station_name, summary, wait_until};

/// Attempts to hear a device that does not answer within two seconds.
const TRIES: usize = 10;

/// Emulated devices in a folder, for a scene compiled there.
pub(super) struct Emulated(pub(super) Child);

impl Emulated {
    pub(super) fn start(folder: &Path) -> Self {
        Self::led(folder, &[])
    }

    /// Starts the emulator with additional arguments.
    pub(super) fn led(folder: &Path, more: &[&str]) -> Self {
        let child = calot()
            .arg("emulate")
            .arg("--scene")
            .arg(compiled("built-in", None))
            .arg("--dir")
            .arg(folder)
            .args(more)
            .stdout(Stdio::null())
            .spawn()
            .expect("it starts");
        wait_until("the lines appear", || folder.join("pedal").exists());
        Self(child)
    }

    /// Runs a whole station without a window until it is dropped.
    fn run(folder: &Path, name: &str) -> Self {
        let run = calot()
            .args(["run", "--headless", "--frames", "0", "--seconds", "3600"])
            .args(["--gamepad", "off", "--station", name, "--out"])
            .arg(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        Self(run.expect("it starts"))
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A program that does nothing with the handle and feels nothing.
const NOBODY: &str = "#!/bin/sh
while read -r line; do
  case \"$line\" in
    *pushed*) echo '{\"felt\": \"nothing\"}' ;;
    *ask*scale*) echo '{\"scale\": false}' ;;
    *pressed*) echo '{\"pressed_n\": null}' ;;
    *) sleep 0.3; echo '{\"done\": true}' ;;
  esac
done
";

/// Returns the last JSON object that the program printed, and whether the program succeeded.
fn json_of(words: &[&str], path: Option<&Path>) -> (Value, bool) {
    let output = finish(calot().arg("devices").args(words).args(path).arg("--json"));
    let text = String::from_utf8_lossy(&output.stdout);
    let last = text
        .lines()
        .last()
        .unwrap_or_else(|| panic!("{}", said(&output)));
    let json = serde_json::from_str(last).expect("--json prints JSON");
    (json, output.status.success())
}

#[test]
fn a_free_handle_is_measured_and_its_values_come_with_charts() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let emulated = Emulated::led(folder, &["--hand", "none"]);
    let haptic = folder.join("haptic");
    let out = folder.join("measured");
    let out_words = [
        "characterise",
        "--yes",
        "--axis",
        "x",
        "--overwrite",
        "--out",
    ];
    let mut words: Vec<&str> = out_words.to_vec();
    words.push(out.to_str().expect("a plain path"));
    // A busy machine may hold samples back until the command stops.
    let measured = (0..TRIES).find_map(|_| {
        let output = finish(
            calot()
                .arg("devices")
                .args(&words)
                .arg(&haptic)
                .arg("--json"),
        );
        let json = serde_json::from_slice::<Value>(&output.stdout).ok();
        let why = said(&output);
        let known = ["no sample for", "found a fault", "no answer from"];
        let is_busy = known.iter().any(|it| why.contains(it));
        assert!(json.is_some() || is_busy, "{why}");
        json
    });
    let measured = measured.expect("one try on a calm machine");
    let friction_n = measured["axes"]["x"]["friction_n"]["value"].as_f64();
    let friction_n = friction_n.unwrap_or_else(|| panic!("{measured}"));
    // A machine that is late for milliseconds measures less exactly than simulated time does.
    assert!((0.15..0.4).contains(&friction_n), "{measured}");
    assert!(measured["axes"]["y"].is_null(), "{measured}");
    let lines = measured["station_lines"].as_str().unwrap_or_default();
    assert!(lines.contains("delay_s = "), "{measured}");
    let page = fs::read_to_string(out.join("characterise.html")).expect("a page");
    assert!(page.contains("Run-out after a push") && page.contains("</svg>"));
    drop(emulated);
}

#[test]
fn devices_are_watched_and_tested_and_a_station_file_names_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let emulated = Emulated::start(folder);
    let haptic = folder.join("haptic");

    let (listed, fine) = json_of(&["list"], None);
    assert!(fine && listed["devices"].is_array(), "{listed}");

    let (said_last, fine) = json_of(&["watch", "--seconds", "2.5"], Some(&haptic));
    assert!(fine && said_last["device"] == "haptic", "{said_last}");
    assert!(said_last["frames"].as_u64() > Some(10), "{said_last}");
    let table = folder.join("samples.csv");
    let words = ["watch", "--seconds", "1.5", "--csv"];
    json_of(
        &[&words[..], &[table.to_str().expect("UTF-8")]].concat(),
        Some(&haptic),
    );
    let text = fs::read_to_string(&table).expect("a table");
    let columns = text.lines().next().expect("a head").split(',').count();
    assert!(
        text.starts_with("time_s,x_m,y_m,z_m,") && text.lines().count() > 100,
        "{text}"
    );
    assert!(text.lines().all(|line| line.split(',').count() == columns));
    let position = &said_last["sample"]["pose"]["position_m"];
    assert!(position[2].is_number(), "{said_last}");

    // A busy machine may fail a device's timing checks. The report must still agree with its own
    // exit code.
    for (name, words) in [
        ("haptic", &["conformance"][..]),
        ("pedal", &["conformance"]),
        ("tracker", &["conformance", "--driver", "bird"]),
    ] {
        let (mut report, mut fine) = json_of(words, Some(&folder.join(name)));
        for _ in 0..TRIES {
            if report["checks"][0]["result"] == "pass" {
                break;
            }
            // The emulator did not answer in time: ask again.
            (report, fine) = json_of(words, Some(&folder.join(name)));
        }
        let checks = report["checks"].as_array().expect("a list of checks");
        let is_bad = |it: &&Value| it["result"] == "fail" || it["result"] == "not judged";
        assert_eq!(checks.iter().filter(is_bad).count() == 0, fine, "{report}");
        assert_eq!(report["passed"], fine);
        assert_eq!(checks[0]["result"], "pass", "{report}");
        assert!(checks.len() > 5, "{report}");
    }
    let wrong = ["conformance", "--driver", "woody", "--seconds", "0.5"];
    let (report, fine) = json_of(&wrong, Some(&haptic));
    assert!(!fine && report["passed"] == false, "{report}");

    let fails = |report: &Value, check: &str| {
        let checks = report["checks"].as_array().expect("a list of checks");
        let found = checks.iter().find(|it| it["name"] == check);
        found.is_some_and(|it| it["result"] == "fail" && it["said"].is_string())
    };
    let script = folder.join("nobody.sh");
    fs::write(&script, NOBODY).expect("it can be written");
    fs::set_permissions(&script, fs::Permissions::from_mode(0o755)).expect("it can be run");
    let file = folder.join("felt.toml");
    let text = format!("# mine\n[haptic]\ndriver = \"rig\"\npath = {haptic:?}\n");
    fs::write(&file, text).expect("it can be written");
    let [script, file_word] = [&script, &file].map(|it| it.to_str().expect("UTF-8"));
    let words = [
        "feel",
        "--script",
        script,
        "--out",
        file_word,
        "--overwrite",
    ];
    let (report, fine) = json_of(&[&words[..], &["--station-file", file_word]].concat(), None);
    assert!(!fine && report["passed"] == false, "{report}");
    assert!(
        fails(&report, "move right") || fails(&report, "end"),
        "{report}"
    );
    let written = fs::read_to_string(&file).expect("it is written");
    assert!(written.starts_with("# mine\n[haptic]"), "{written}");
    assert!(
        written.contains("[haptic.felt]\npassed = false"),
        "{written}"
    );

    // The file names the haptic device. The run emulates the other devices itself.
    let file = folder.join("station.toml");
    let text = format!("[haptic]\ndriver = \"rig\"\npath = {haptic:?}\nforce_max_n = 1.0\n");
    fs::write(&file, text).expect("it can be written");
    let out = folder.join("out");
    let run = |more: &[&str]| {
        let name = station_name("devices");
        finish(
            calot()
                .args(["run", "--headless", "--seconds", "2", "--frames", "0"])
                .args(["--overwrite", "--station", &name, "--station-file"])
                .arg(&file)
                .arg("--out")
                .arg(&out)
                .args(more),
        )
    };
    let output = run(&[]);
    assert!(output.status.success(), "{}", said(&output));
    assert!(summary(&out)["ticks"].as_u64() > Some(100));

    fs::write(&file, "[haptic]\ndriver = \"rig\"\npath = 7\n").expect("it can be written");
    let output = run(&[]);
    assert_eq!(output.status.code(), Some(1));
    let text = said(&output);
    assert!(
        text.contains("station.toml") && text.contains('3'),
        "{text}"
    );
    drop(emulated);
}

/// A display that leads the emulated hand from a thread of its own.
pub(super) struct Lead {
    message: Arc<Mutex<HandMsg>>,
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Lead {
    pub(super) fn start(station: &Station) -> Self {
        let station = station.clone();
        let first = HandMsg {
            began_ns: 1,
            ..HandMsg::zeroed()
        };
        let message = Arc::new(Mutex::new(first));
        let over = Arc::new(AtomicBool::new(false));
        let (said, ends) = (Arc::clone(&message), Arc::clone(&over));
        let thread = std::thread::spawn(move || {
            let sender = HandSender::open(&station).expect("nobody else leads");
            while !ends.load(Relaxed) {
                let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
                let at_ns = now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64;
                let message = *said.lock().expect("nobody panics");
                sender.send(HandMsg { at_ns, ..message });
                std::thread::sleep(Duration::from_millis(5));
            }
        });
        Self {
            message,
            over,
            thread: Some(thread),
        }
    }

    pub(super) fn ask(&self, change: impl FnOnce(&mut HandMsg)) {
        change(&mut self.message.lock().expect("nobody panics"));
    }
}

impl Drop for Lead {
    fn drop(&mut self) {
        self.over.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Tip positions for each landmark, along the picture's axes, m.
const TOUCHED_M: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [0.03, 0.0, 0.0],
    [0.0, 0.03, 0.0],
    [0.01, 0.01, 0.02],
];

/// Touches every landmark as the program asks for it. Returns the measured places in mm, standard
/// output, and whether the program succeeded.
fn calibrated(file: &Path, lead: &Lead, residual_mm: &str) -> (Vec<[f64; 3]>, String, bool) {
    let mut child = calot()
        .args([
            "devices",
            "calibrate",
            "--residual-mm",
            residual_mm,
            "--station-file",
        ])
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut enter = child.stdin.take().expect("piped");
    let told = BufReader::new(child.stderr.take().expect("piped"));
    let mut measured = Vec::new();
    let mut asked = 0;
    for line in told.lines().map_while(Result::ok) {
        if line.contains("press its first button or Enter") {
            lead.ask(|message| message.moved_m = TOUCHED_M[asked % TOUCHED_M.len()]);
            asked += 1;
            // The hand needs time to move. The program judges when it is still.
            std::thread::sleep(Duration::from_millis(800));
            let _ = writeln!(enter); // one that gave up reads no more
        } else if let Some(numbers) = line.strip_suffix(" mm")
            && line.starts_with("    ")
        {
            let numbers: Vec<f64> = numbers.split_whitespace().flat_map(str::parse).collect();
            measured.extend(<[f64; 3]>::try_from(numbers));
        }
    }
    let output = child.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (measured, text, output.status.success())
}

#[test]
fn touched_landmarks_tell_where_the_device_stands() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let name = station_name("calibrate");
    let _emulated = Emulated::led(folder, &["--station", &name, "--gamepad", "off"]);
    let lead = Lead::start(&Station::new(&name).expect("a plain name"));
    let file = folder.join("station.toml");
    let write = |landmarks: &[[f64; 3]]| {
        let haptic = folder.join("haptic");
        let mut text = format!("[haptic]\ndriver = \"rig\"\npath = {haptic:?}\n");
        for (number, at_m) in landmarks.iter().enumerate() {
            text += &format!("[[landmarks]]\nname = \"L{number}\"\nposition_m = {at_m:?}\n");
        }
        fs::write(&file, text).expect("it can be written");
    };
    // Measure the places in the frame of the device first; this pass accepts any fit.
    write(&[
        [0.0, 0.0, 0.0],
        [0.1, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.0, 0.0, 0.1],
    ]);
    let (_, _, fits) = calibrated(&file, &lead, "0.1");
    assert!(!fits, "landmarks that are elsewhere fit nothing");
    // On a busy machine the hand may arrive late at a place: then repeat both passes.
    let found = (0..3).any(|_| {
        write(&[
            [0.0, 0.0, 0.0],
            [0.1, 0.0, 0.0],
            [0.0, 0.1, 0.0],
            [0.0, 0.0, 0.1],
        ]);
        let (measured, _, _) = calibrated(&file, &lead, "1000");
        if measured.len() != TOUCHED_M.len() {
            return false;
        }
        let moved: Vec<_> = measured
            .iter()
            .map(|[x, y, z]| [x * 1e-3 + 0.5, y * 1e-3, z * 1e-3 - 0.25])
            .collect();
        write(&moved);
        let (_, frames, fits) = calibrated(&file, &lead, "1.5");
        let position = frames
            .lines()
            .find_map(|line| line.strip_prefix("position_m = "));
        let position: Option<[f64; 3]> = position.and_then(|text| serde_json::from_str(text).ok());
        println!("{fits}: {frames}");
        let is_near = |at: [f64; 3]| {
            let off = at.iter().zip([0.5, 0.0, -0.25]).map(|(a, b)| (a - b).abs());
            off.fold(0.0, f64::max) < 5e-3
        };
        fits && frames.contains("[frames.world_from_device]") && position.is_some_and(is_near)
    });
    assert!(found);
}

/// Reads OpenIGTLink messages until one of this name arrives, checks it, and returns its body.
fn transform(stream: &mut TcpStream, wanted: &str) -> [f32; 12] {
    loop {
        let mut header = [0; 58];
        stream.read_exact(&mut header).expect("a message");
        let words = |from: usize, to: usize| {
            let text = String::from_utf8_lossy(&header[from..to]).into_owned();
            text.trim_end_matches('\0').to_owned()
        };
        assert_eq!((header[1], words(2, 14).as_str()), (1, "TRANSFORM"));
        let mut body = [0; 48];
        assert_eq!(header[42..50], 48u64.to_be_bytes());
        stream.read_exact(&mut body).expect("its body");
        if words(14, 34) == wanted {
            let mut numbers = [0.0; 12];
            for (number, bytes) in numbers.iter_mut().zip(body.chunks_exact(4)) {
                *number = f32::from_be_bytes(bytes.try_into().expect("four"));
            }
            return numbers;
        }
    }
}

#[test]
fn other_programs_are_told_where_the_instrument_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = station_name("igtlink");
    let station = Station::new(&name).expect("a plain name");
    let _run = Emulated::run(folder.path(), &name);
    let host = Host::open(&station).expect("a host");
    let mut tools = ToolFrame::zeroed();
    wait_until("it runs", || {
        host.newest_tools(&mut tools) && tools.tick > 500
    });
    let mut server = calot()
        .args([
            "igtlink",
            "--station",
            &name,
            "--listen",
            "127.0.0.1:0",
            "--json",
        ])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut line = String::new();
    let mut told = BufReader::new(server.stdout.take().expect("piped"));
    told.read_line(&mut line).expect("a line");
    let _server = Emulated(server);
    let told: Value = serde_json::from_str(&line).expect("JSON");
    let address = told["listening"].as_str().expect("an address").to_owned();
    let mut stream = TcpStream::connect(&address).expect("it listens");
    for name in [
        "ToolToReference",
        "HandleToReference",
        "EndoscopeToReference",
    ] {
        let numbers = transform(&mut stream, name);
        let [a, b, c, d, e, f, ..] = numbers;
        assert!(
            (a * d + b * e + c * f).abs() < 1e-4,
            "{name}: columns at right angles"
        );
        assert!((a * a + b * b + c * c - 1.0).abs() < 1e-3, "{name}");
    }
    // The camera rests, so the message must equal the frame's pose, in mm.
    let camera = transform(&mut stream, "EndoscopeToReference");
    host.newest_tools(&mut tools);
    for (told_mm, at_m) in camera[9..].iter().zip(tools.world_from_camera.position_m) {
        assert!(
            (told_mm - at_m * 1e3).abs() < 60.0,
            "{told_mm} mm, {at_m} m"
        );
    }
    // Also test a client written by others, if installed (`pip install pyigtl`).
    let script = format!(
        "import pyigtl\nhost, port = '{address}'.split(':')\nclient = pyigtl.OpenIGTLinkClient(host, int(port))\n\
         m = client.wait_for_message('ToolToReference', timeout=60)\nprint(m.matrix[3].tolist())"
    );
    let installed = Command::new("python3")
        .args(["-c", "import pyigtl"])
        .output();
    if installed.is_ok_and(|output| output.status.success()) {
        let output = finish(Command::new("python3").args(["-c", &script]));
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(said.trim(), "[0.0, 0.0, 0.0, 1.0]", "{output:?}");
    } else {
        println!("SKIPPED: pyigtl is not installed; no foreign client was tried");
    }
}

/// Mouse, keyboard and gamepad reach the hand through this service. The test plays the display.
#[test]
fn a_person_without_a_device_leads_the_emulated_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = station_name("hand");
    let station = Station::new(&name).expect("a plain name");
    let _run = Emulated::run(folder.path(), &name);
    let host = Host::open(&station).expect("a host");
    let lead = Lead::start(&station);
    let mut tools = ToolFrame::zeroed();
    wait_until("the hand is led, and the force is on", || {
        host.newest_tools(&mut tools)
            && tools.health[0].status == DeviceHealth::LIVE
            && tools.tick > 500
    });
    // Joint of the jaws in the camera's axes.
    let joint = |tools: &ToolFrame| tools.world_from_instrument.position_m;
    wait_until("it holds still", || {
        let before = joint(&tools);
        std::thread::sleep(Duration::from_millis(100));
        host.newest_tools(&mut tools);
        joint(&tools)
            .iter()
            .zip(before)
            .all(|(now, before)| (now - before).abs() < 2e-4)
    });
    let before = joint(&tools);
    lead.ask(|message| {
        message.moved_m = [0.02, 0.0, 0.0];
        message.buttons = Buttons::GRASP.bits();
        message.switches = Switches::COAGULATE.bits();
    });
    wait_until("the jaws close and the tip goes 2 cm to the right", || {
        host.newest_tools(&mut tools);
        let [x, y, z, w] = tools.world_from_camera.orientation;
        let right = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ];
        let way: f32 = (0..3)
            .map(|i| (joint(&tools)[i] - before[i]) * right[i])
            .sum();
        (0.012..0.028).contains(&way)
            && tools.jaw < 0.1
            && tools.switches().contains(Switches::COAGULATE)
    });
    // When the display falls silent, the foot leaves the pedal.
    drop(lead);
    wait_until("the pedal is released", || {
        host.newest_tools(&mut tools);
        tools.switches().bits() & Switches::PEDALS.bits() == 0
    });
}

#[test]
fn a_rig_with_a_mistake_is_told_which() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let _emulated = Emulated::led(folder, &["--mistake", "watchdog-slow"]);
    let (report, fine) = json_of(&["conformance"], Some(&folder.join("haptic")));
    assert!(!fine && report["passed"] == false, "{report}");
    let checks = report["checks"].as_array().expect("a list of checks");
    let watchdog = checks.iter().find(|it| it["name"] == "watchdog");
    let words = watchdog.and_then(|it| it["said"].as_str());
    // A busy machine may not hear it at all.
    assert!(
        words.is_none_or(|it| it.contains("50 ms") || it.contains("sample")),
        "{report}"
    );
    let wrong = ["emulate", "--dir", "x", "--scene", "x", "--mistake", "none"];
    let output = finish(calot().args(wrong));
    assert!(!output.status.success());
    assert!(said(&output).contains("force-negated"), "{}", said(&output));
}

/// Rows of a table by the names of its columns, empty fields as NaN.
fn rows(text: &str, names: [&str; 4]) -> Vec<[f64; 4]> {
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let at = names.map(|name| head.iter().position(|it| *it == name).expect("a column"));
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        at.map(|i| fields[i].parse().unwrap_or(f64::NAN))
    };
    lines.map(row).collect()
}

#[test]
fn the_jaws_follow_a_handle_that_opens_and_its_motor_pushes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let _emulated = Emulated::led(folder, &["--handle", "opening"]);
    let (out, table) = (folder.join("run"), folder.join("ticks.csv"));
    let run = finish(
        calot()
            .args(["run", "--headless", "--frames", "0", "--seconds", "12"])
            .args(["--gamepad", "off", "--station"])
            .arg(station_name("handle"))
            .arg("--haptic")
            .arg(folder.join("haptic"))
            .arg("--out")
            .arg(&out),
    );
    assert!(run.status.success(), "{}", said(&run));
    let summary = summary(&out);
    let devices = summary["devices"].as_array().expect("devices");
    let device = devices
        .iter()
        .find(|it| it["kind"] == "haptic")
        .expect("one");
    assert_eq!(device["name"], "emulated handle", "{device:#}");
    let travel_m = device["capabilities"]["opening_travel_m"].as_f64();
    assert!(
        travel_m.is_some_and(|it| (it - 0.03).abs() < 1e-6),
        "{device:#}"
    );
    let replay = finish(
        calot()
            .arg("replay")
            .arg(out.join("session.mcap"))
            .arg("--csv")
            .arg(&table),
    );
    assert!(replay.status.success(), "{}", said(&replay));
    let text = std::fs::read_to_string(&table).expect("a table");
    let rows = rows(&text, ["handle_opening", "jaw", "opening_n", "time_s"]);
    let shut = rows.iter().filter(|[hand, ..]| *hand < 0.1).count();
    assert!(
        shut > 500,
        "the hand shuts the handle for seconds: {shut} ticks"
    );
    for [hand, jaw, opening_n, at_s] in &rows {
        assert!(
            hand.is_nan() || *jaw >= hand - 0.05,
            "jaws are nowhere more shut than the hand: {at_s} s"
        );
        assert!(*opening_n >= 0.0, "{opening_n} N at {at_s} s");
    }
    let most_n = rows.iter().fold(0.0f64, |most, [.., n, _]| most.max(*n));
    assert!((0.1..=5.0).contains(&most_n), "{most_n} N");
}
