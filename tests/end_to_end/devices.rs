//! `calot devices` through the real program on emulated devices: what a rig builder does.

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};

use bytemuck::Zeroable as _;
use serde_json::Value;
use shared_mem::message::{DeviceHealth, HandMsg, ToolFrame};
use shared_mem::service::{HandSender, Host, Station};
use system_tests::{calot, finish, said, station_name, summary, wait_until};

/// Emulated devices under a folder, for a scene that is made there.
struct Emulated(Child);

impl Emulated {
    fn start(folder: &Path) -> Self {
        let scene = folder.join("scene.calot");
        let prepared = finish(calot().args(["prepare", "built-in", "--out"]).arg(&scene));
        assert!(prepared.status.success(), "{}", said(&prepared));
        let child = calot()
            .arg("emulate")
            .arg("--scene")
            .arg(&scene)
            .arg("--dir")
            .arg(folder)
            .stdout(Stdio::null())
            .spawn()
            .expect("it starts");
        wait_until("the lines appear", || folder.join("pedal").exists());
        Self(child)
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The last JSON object that it printed, and whether it succeeded.
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
    let position = &said_last["sample"]["pose"]["position_m"];
    assert!(position[2].is_number(), "{said_last}");

    // How a busy machine does in the suite is its own affair; what it says must agree with itself.
    for (name, words) in [
        ("haptic", &["conformance"][..]),
        ("pedal", &["conformance"]),
        ("tracker", &["conformance", "--driver", "bird"]),
    ] {
        let (report, fine) = json_of(words, Some(&folder.join(name)));
        let checks = report["checks"].as_array().expect("a list of checks");
        let failed = checks.iter().filter(|check| check["outcome"] == "fail");
        assert_eq!(failed.count() == 0, fine, "{report}");
        assert_eq!(report["passed"], fine);
        assert_eq!(checks[0]["outcome"], "pass", "{report}");
        assert!(checks.len() > 5, "{report}");
    }
    let wrong = ["conformance", "--driver", "woody", "--seconds", "0.5"];
    let (report, fine) = json_of(&wrong, Some(&haptic));
    assert!(!fine && report["passed"] == false, "{report}");

    // A file names the haptic device; the others are emulated by the run itself.
    let file = folder.join("station.toml");
    let text = format!("[haptic]\ndriver = \"rig\"\npath = {haptic:?}\nforce_max_n = 1.0\n");
    fs::write(&file, text).expect("it can be written");
    let out = folder.join("out");
    let run = |more: &[&str]| {
        let name = station_name("devices");
        finish(
            calot()
                .args(["run", "--headless", "--seconds", "2", "--frames", "0"])
                .args(["--station", &name, "--station-file"])
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

/// Mouse, keyboard and gamepad reach the hand by this service: the test is the display.
#[test]
fn a_person_without_a_device_leads_the_emulated_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = station_name("hand");
    let station = Station::new(&name).expect("a plain name");
    let run = calot()
        .args([
            "run",
            "--headless",
            "--frames",
            "0",
            "--seconds",
            "3600",
            "--station",
            &name,
        ])
        .args(["--gamepad", "off", "--out"])
        .arg(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _run = Emulated(run.expect("it starts"));
    let host = Host::open(&station).expect("a host");
    let sender = HandSender::open(&station).expect("nobody else leads");
    let mut tools = ToolFrame::zeroed();
    let mut message = HandMsg {
        began_ns: 1,
        ..HandMsg::zeroed()
    };
    let tell = |message: &mut HandMsg, tools: &mut ToolFrame| {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        message.at_ns = now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64;
        let heard = sender.send(*message);
        host.newest_tools(tools);
        heard
    };
    wait_until("the hand is led, and the force is on", || {
        tell(&mut message, &mut tools)
            && tools.health[0].status == DeviceHealth::LIVE
            && tools.tick > 500
    });
    // The jaws' joint, in the camera's axes.
    let joint = |tools: &ToolFrame| tools.world_from_instrument.position_m;
    wait_until("it holds still", || {
        let before = joint(&tools);
        for _ in 0..20 {
            tell(&mut message, &mut tools);
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        joint(&tools)
            .iter()
            .zip(before)
            .all(|(now, before)| (now - before).abs() < 2e-4)
    });
    let before = joint(&tools);
    message.moved_m = [0.02, 0.0, 0.0];
    message.buttons = 1;
    message.switches = 2;
    wait_until("the jaws close and the tip goes 2 cm to the right", || {
        tell(&mut message, &mut tools);
        let [x, y, z, w] = tools.world_from_camera.orientation;
        let right = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ];
        let way: f32 = (0..3)
            .map(|i| (joint(&tools)[i] - before[i]) * right[i])
            .sum();
        (0.012..0.028).contains(&way) && tools.jaw < 0.1 && tools.switches & 2 != 0
    });
    // Silence: the foot is off the pedal.
    wait_until("the pedal is released", || {
        host.newest_tools(&mut tools);
        tools.switches & 7 == 0
    });
}
