//! People lead the emulated hand, and touch landmarks with a device.

use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bytemuck::Zeroable as _;
use shared_mem::message::{DeviceHealth, HandMsg, ToolFrame};
use shared_mem::service::{HandSender, Host, Station};
use shared_mem::words::{Buttons, Switches};
use system_tests::{calot, station_name, wait_until};

use crate::devices::Emulated;

/// A display that steers the emulated hand from a thread of its own.
pub(super) struct SteeringDisplay {
    message: Arc<Mutex<HandMsg>>,
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl SteeringDisplay {
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

    fn ask(&self, change: impl FnOnce(&mut HandMsg)) {
        change(&mut self.message.lock().expect("nobody panics"));
    }
}

impl Drop for SteeringDisplay {
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
fn calibrated(
    file: &Path,
    steering: &SteeringDisplay,
    residual_mm: &str,
) -> (Vec<[f64; 3]>, String, bool) {
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
            steering.ask(|message| message.moved_m = TOUCHED_M[asked % TOUCHED_M.len()]);
            asked += 1;
            // The hand needs time to move. The program judges when it is still.
            std::thread::sleep(Duration::from_millis(800));
            let _ = writeln!(enter); // a program that gave up reads no more
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
    let steering = SteeringDisplay::start(&Station::new(&name).expect("a plain name"));
    let file = folder.join("station.toml");
    let write = |landmarks: &[[f64; 3]]| {
        let haptic = folder.join("haptic");
        let mut text = format!("[haptic]\ndriver = \"rig\"\npath = {haptic:?}\n");
        for (number, at_m) in landmarks.iter().enumerate() {
            text += &format!("[[landmarks]]\nname = \"L{number}\"\nposition_m = {at_m:?}\n");
        }
        fs::write(&file, text).expect("it can be written");
    };
    // First, landmarks that are elsewhere must not fit.
    write(&[
        [0.0, 0.0, 0.0],
        [0.1, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.0, 0.0, 0.1],
    ]);
    let (_, _, fits) = calibrated(&file, &steering, "0.1");
    assert!(!fits, "landmarks that are elsewhere fit nothing");
    // The first pass measures the places in the frame of the device and accepts any fit. The second
    // pass uses these places, moved, as landmarks. On a busy machine the hand may arrive late at a
    // place: then repeat both passes.
    let found = (0..3).any(|_| {
        write(&[
            [0.0, 0.0, 0.0],
            [0.1, 0.0, 0.0],
            [0.0, 0.1, 0.0],
            [0.0, 0.0, 0.1],
        ]);
        let (measured, _, _) = calibrated(&file, &steering, "1000");
        if measured.len() != TOUCHED_M.len() {
            return false;
        }
        let moved: Vec<_> = measured
            .iter()
            .map(|[x, y, z]| [x * 1e-3 + 0.5, y * 1e-3, z * 1e-3 - 0.25])
            .collect();
        write(&moved);
        let (_, frames, fits) = calibrated(&file, &steering, "1.5");
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

/// Mouse, keyboard and gamepad reach the hand through the `hand` service. The test plays the
/// display.
#[test]
fn a_person_without_a_device_leads_the_emulated_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = station_name("hand");
    let station = Station::new(&name).expect("a plain name");
    let _run = Emulated::run(folder.path(), &name);
    let host = Host::open(&station).expect("a host");
    let steering = SteeringDisplay::start(&station);
    let mut tools = ToolFrame::zeroed();
    wait_until("the hand is led, and the force is on", || {
        host.newest_tools(&mut tools)
            && tools.health[0].status == DeviceHealth::LIVE
            && tools.tick > 500
    });
    // Joint of the jaws, world frame, m.
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
    steering.ask(|message| {
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
    // When the display sends nothing more, the emulated foot releases the pedal.
    drop(steering);
    wait_until("the pedal is released", || {
        host.newest_tools(&mut tools);
        tools.switches().bits() & Switches::PEDALS.bits() == 0
    });
}
