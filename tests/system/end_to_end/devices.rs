//! `calot devices` as a rig builder runs it: the real program on emulated devices.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, Stdio};

use rustix::process::Signal;
use serde_json::Value;
use system_tests::{calot, compiled, finish, said, signal, station_name, summary, wait_until};

/// Largest number of attempts to hear a device that does not answer within two seconds.
const TRIES: usize = 10;

/// Emulated devices in a folder, for the built-in scene.
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
    pub(super) fn run(folder: &Path, name: &str) -> Self {
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

/// Cores on which a process may run, by its id or `self`: one bit each.
fn allowed_cores(process: &str) -> u128 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).expect("it runs");
    let line = status
        .lines()
        .find_map(|it| it.strip_prefix("Cpus_allowed:"));
    let mask = line.expect("Linux tells").trim().replace(',', "");
    u128::from_str_radix(&mask, 16).expect("a mask of at most 128 cores")
}

#[test]
fn the_emulator_leaves_the_core_of_the_tick_alone() {
    let own = allowed_cores("self");
    if own.count_ones() < 2 {
        return; // the emulated devices must share the only core
    }
    for core in [own.trailing_zeros(), 127 - own.leading_zeros()] {
        let folder = tempfile::tempdir().expect("a folder");
        let emulated = Emulated::led(folder.path(), &["--tick-core", &core.to_string()]);
        let cores = allowed_cores(&emulated.0.id().to_string());
        assert_eq!(cores, own & !(1 << core), "tick on core {core} of {own:b}");
    }
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
    // A busy machine may hold samples back until the command stops, or until a force acts longer
    // than it should. One try has to succeed and to measure the right friction. The library's tests
    // measure the friction more exactly, in simulated time.
    let mut refused = Vec::new();
    let measured = (0..TRIES).find_map(|_| {
        let output = finish(
            calot()
                .arg("devices")
                .args(&words)
                .arg(&haptic)
                .arg("--json"),
        );
        let json = serde_json::from_slice::<Value>(&output.stdout).ok();
        let friction_n = |it: &Value| it["axes"]["x"]["friction_n"]["value"].as_f64();
        let is_right = |it: &Value| friction_n(it).is_some_and(|it| (0.15..0.4).contains(&it));
        if json.as_ref().is_some_and(is_right) {
            return json;
        }
        refused.push(said(&output));
        None
    });
    let measured = measured.unwrap_or_else(|| panic!("no try succeeded: {refused:#?}"));
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
    // A busy machine may hear no sample of the device at all.
    assert!(
        words.is_none_or(|it| it.contains("50 ms") || it.contains("sample")),
        "{report}"
    );
    let wrong = ["emulate", "--dir", "x", "--scene", "x", "--mistake", "none"];
    let output = finish(calot().args(wrong));
    assert!(!output.status.success());
    assert!(said(&output).contains("force-negated"), "{}", said(&output));
}

#[test]
fn noise_of_a_rig_is_named_once_while_it_runs_and_in_what_it_came_to() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let _emulated = Emulated::led(folder, &["--mistake", "noisy"]);
    let [out, err] = ["out", "err"].map(|name| folder.join(name));
    let file = |path| std::fs::File::create(path).expect("a file");
    let rt = calot()
        .args([
            "rt",
            "--no-realtime",
            "--json",
            "--station",
            &station_name("noisy"),
        ])
        .args(["--scene", &compiled("built-in", None), "--haptic"])
        .arg(folder.join("haptic"))
        .stdout(file(&out))
        .stderr(file(&err))
        .spawn();
    let mut rt = Emulated(rt.expect("it starts"));
    let read = |path| std::fs::read_to_string(path).unwrap_or_default();
    let words = "are noisy by more than 0.1 mm, and so its force steps";
    wait_until("it is named", || read(&err).contains(words));
    signal(rt.0.id(), Signal::INT);
    rt.0.wait().expect("it ends");
    assert_eq!(read(&err).matches(words).count(), 1, "{}", read(&err));
    let came_to = read(&out);
    assert!(came_to.contains("noisy_device"), "{came_to}");
}
