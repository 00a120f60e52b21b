//! The opening of a device's handle.

use std::fs;

use system_tests::{calot, finish, said, station_name, summary};

use crate::devices::Emulated;

/// Largest change of the jaws' opening in a tick: they open in 0.15 s.
const OPENED_IN_A_TICK: f64 = 0.001 / 0.15;

/// Most ticks in a row in which jaws that are more shut than the hand may stand still.
const BEHIND_TICKS: u32 = 10;

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

/// Attempts. On a busy machine, late samples can suppress the force for a whole run.
const TRIES: usize = 4;

#[test]
fn the_jaws_follow_a_handle_that_opens_and_its_motor_pushes_back() {
    let failed_n: Vec<f64> = (0..TRIES)
        .map(|_| max_finger_force_n())
        .take_while(|n| *n < 0.1)
        .collect();
    assert!(
        failed_n.len() < TRIES,
        "the motor never pushed: {failed_n:?} N"
    );
}

/// Runs a station whose scripted hand shuts the handle on tissue. Checks every tick of it, and
/// returns the largest force on the fingers, N.
fn max_finger_force_n() -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let _emulated = Emulated::led(folder, &["--handle", "opening"]);
    let (out, tables) = (folder.join("run"), folder.join("tables"));
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
    let export = finish(
        calot()
            .arg("export")
            .arg(out.join("session.mcap"))
            .arg("--csv")
            .arg(&tables),
    );
    assert!(export.status.success(), "{}", said(&export));
    let text = fs::read_to_string(tables.join("ticks.csv")).expect("a table");
    let rows = rows(&text, ["handle_opening", "jaw", "opening_n", "time_s"]);
    let shut = rows.iter().filter(|[hand, ..]| *hand < 0.1).count();
    assert!(
        shut > 500,
        "handle shut for only {shut} ticks, expected more than 500"
    );
    let (mut last, mut behind) = (1.0, 0);
    for [hand, jaw, opening_n, at_s] in &rows {
        // After late samples the jaws may lag, but then they open at nearly their full speed. A
        // busy machine loses ticks now and then.
        let opens = jaw - last > 0.9 * OPENED_IN_A_TICK;
        let follows = hand.is_nan() || *jaw >= hand - 0.05 || opens;
        behind = if follows { 0 } else { behind + 1 };
        assert!(
            behind <= BEHIND_TICKS,
            "jaw {jaw} below hand {hand} at {at_s} s"
        );
        last = *jaw;
        assert!(*opening_n >= 0.0, "{opening_n} N at {at_s} s");
    }
    let most_n = rows.iter().fold(0.0f64, |most, [.., n, _]| most.max(*n));
    assert!(most_n <= 5.0, "{most_n} N");
    most_n
}
