//! `calot devices` through the real program on emulated devices: what a rig builder does.

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};

use serde_json::Value;
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
