//! `calot devices feel --window`: a test of a device by hand, guided by a window on a virtual
//! screen, with an emulated rig.

use std::path::Path;
use std::process::Output;
use std::time::Duration;

use serde_json::Value;
use shared_mem::service::Station;
use system_tests::screen::VirtualScreen;
use system_tests::{Program, calot, finish, said, station_name, turn, wait_until};

use crate::devices::Emulated;
use crate::hand::SteeringDisplay;
use crate::launcher::screen;

/// Largest number of attempts with a device that does not answer in time.
const TRIES: usize = 5;

/// An emulated rig in a hand that holds it where it is.
fn held(folder: &Path) -> (Emulated, SteeringDisplay) {
    let name = station_name("by-hand");
    let words = ["--station", &name, "--gamepad", "off"];
    let emulated = Emulated::led(folder, &words);
    let steering = SteeringDisplay::start(&Station::new(&name).expect("a plain name"));
    (emulated, steering)
}

/// Starts the test of the rig in this folder, in a window.
fn feel(screen: &VirtualScreen, folder: &Path, more: &[&str]) -> Program {
    let mut calot = calot();
    calot
        .args(["devices", "feel", "--window", "--language", "en", "--json"])
        .args(more)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY");
    if more.is_empty() {
        calot.arg(folder.join("haptic"));
    }
    Program::start(&mut calot)
}

/// The window and its title.
fn shown(screen: &VirtualScreen) -> Option<(String, String)> {
    screen.windows().pop()
}

/// Answers with keys until the title begins with `end`. Returns the window.
fn lead(screen: &VirtualScreen, feel: &mut Program, end: &str) -> Option<String> {
    let mut found = None;
    wait_until("the step", || {
        if feel.ended().is_some() {
            return true;
        }
        let Some((window, title)) = shown(screen) else {
            return false;
        };
        let step = title.strip_prefix("Calot: ").unwrap_or_default();
        if step.starts_with(end) {
            found = Some(window);
            return true;
        }
        let key = match step.split_whitespace().next() {
            Some("Move" | "Hold" | "Stand") => Some("Return"),
            Some("Which") => Some("u"),
            Some("Is" | "Does") => Some("n"),
            _ => None,
        };
        if let Some(key) = key {
            screen.press(&window, key);
        }
        std::thread::sleep(Duration::from_millis(300));
        false
    });
    found
}

/// The one JSON object on standard output.
fn json(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text} {}", said(output)))
}

fn check<'a>(report: &'a Value, name: &str) -> Option<&'a Value> {
    let checks = report["checks"].as_array().expect("a list of checks");
    checks.iter().find(|it| it["name"] == name)
}

#[test]
fn the_window_leads_to_the_outcome_and_the_results_go_where_the_terminal_puts_them() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let Some(screen) = screen(folder) else {
        return;
    };
    let _held = held(folder);
    let file = folder.join("station.toml");
    let haptic = folder.join("haptic");
    let text = format!("# mine\n[haptic]\ndriver = \"rig\"\npath = {haptic:?}\n");
    std::fs::write(&file, text).expect("it can be written");
    let path = file.to_str().expect("a path in UTF-8");
    let words = ["--station-file", path, "--out", path, "--overwrite"];
    // A busy machine may hold samples back until the test ends by itself.
    let report = (0..TRIES).find_map(|_| {
        let mut feel = feel(&screen, folder, &words);
        let window = lead(&screen, &mut feel, "The device");
        if let Some(window) = &window {
            screen.leave(window, &mut feel);
        }
        let output = feel.finish();
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let report = window.map(|_| json(&output))?;
        match check(&report, "end") {
            None => Some(report),
            Some(end) => {
                println!("it ended early: {end}");
                None
            }
        }
    });
    let report = report.expect("an outcome");
    assert_eq!(report["passed"], false, "{report}");
    let right = check(&report, "move right").expect("a check");
    assert_eq!(right["result"], "fail", "nobody moved it: {report}");
    // The test pressed the key for "up" after each push.
    for (name, result) in [("push up", "pass"), ("push right", "fail")] {
        let push = check(&report, name).unwrap_or_else(|| panic!("{report}"));
        assert_eq!(push["result"], result, "{report}");
    }
    let scale = check(&report, "scale").expect("a check");
    assert_eq!(scale["result"], "skipped", "{report}");
    let written = std::fs::read_to_string(&file).expect("it is written");
    assert!(written.starts_with("# mine\n[haptic]"), "{written}");
    assert!(
        written.contains("[haptic.felt]\npassed = false"),
        "{written}"
    );
}

/// Early end of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    Esc,
    Destroyed,
    ScreenGone,
}

#[test]
fn a_test_that_ends_early_has_stopped_as_in_the_terminal() {
    let _turn = turn();
    for end in [End::Esc, End::Destroyed, End::ScreenGone] {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let Some(mut screen) = screen(folder) else {
            return;
        };
        let _held = held(folder);
        let mut feel = feel(&screen, folder, &[]);
        let Some(window) = lead(&screen, &mut feel, "Move") else {
            panic!("{end:?}: {}", said(&feel.finish()));
        };
        match end {
            End::Esc => {
                screen.press(&window, "Escape");
                let _ = screen.window("Calot: The device did not pass");
                screen.leave(&window, &mut feel);
            }
            End::Destroyed => screen.destroy(&window),
            End::ScreenGone => screen.kill(),
        }
        let output = feel.finish();
        assert_eq!(output.status.code(), Some(1), "{end:?}: {}", said(&output));
        let report = json(&output);
        let ended = check(&report, "end").expect("a check");
        assert_eq!(ended["result"], "fail", "{end:?}: {report}");
        let words = ended["said"].as_str().unwrap_or_default();
        assert!(words.contains("was stopped"), "{end:?}: {report}");
        let is_lost = matches!(end, End::Destroyed | End::ScreenGone);
        let names_loss = said(&output).contains("the window was lost");
        assert_eq!(names_loss, is_lost, "{end:?}: {}", said(&output));
    }
}

#[test]
fn without_a_screen_the_terminal_is_named_before_the_device_is_opened() {
    let mut calot = calot();
    calot.args(["devices", "feel", "/nowhere/rig", "--window"]);
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        calot.env_remove(name);
    }
    let output = finish(&mut calot);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("Leave `--window` out"), "{said}");
    assert!(said.contains("DISPLAY"), "{said}");
    assert!(!said.contains("/nowhere/rig"), "{said}");
}
