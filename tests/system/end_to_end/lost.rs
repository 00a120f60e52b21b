//! A window, a screen or a disk is lost in the middle of a run, and the run's results are kept.

use std::path::Path;

use shared_mem::message::StateFrame;
use shared_mem::service::{Host, Station};
use system_tests::screen::VirtualScreen;
use system_tests::{Program, calot, finish, said, station_name, summary, turn, wait_until};

/// Starts a task in a window of this screen, and waits until a second of it has run.
fn operate(screen: &VirtualScreen, station: &str, out: &Path) -> Program {
    let mut calot = calot();
    calot
        .args(["run", "--station", station, "--task", "free", "--mute"])
        .args(["--no-realtime", "--size", "320x240", "--out"])
        .arg(out)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY");
    let run = Program::start(&mut calot);
    let host = Station::new(station).and_then(|it| Host::open(&it));
    let host = host.expect("a station");
    let mut frame: Box<StateFrame> = bytemuck::zeroed_box();
    wait_until("a second of the operation", || {
        host.newest_state(&mut frame) && frame.tick > 1000
    });
    run
}

/// Asserts that the run ended by itself, with exit code 1, the reason, and all results.
fn assert_nothing_is_lost(run: Program, out: &Path, reason: &str) {
    let output = run.finish();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains(reason), "{}", said(&output));
    let summary = summary(out);
    assert_eq!(summary["ended"], "display_lost");
    assert!(summary["warnings"].to_string().contains(reason));
    assert_eq!(summary["task"], "free", "{summary:#}");
    for page in ["report.html", "debrief.html"] {
        assert!(out.join(page).exists(), "{page}");
    }
    let replayed = finish(calot().arg("replay").arg(out.join("session.mcap")));
    assert!(replayed.status.success(), "{}", said(&replayed));
}

#[test]
fn a_window_that_another_program_destroys_loses_no_result() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = VirtualScreen::start(folder.path()) else {
        println!("skipped: Xvfb or xdotool is not installed");
        return;
    };
    let (station, out) = (station_name("destroyed"), folder.path().join("out"));
    let run = operate(&screen, &station, &out);
    let mut found = None;
    wait_until("the station's window", || {
        found = screen.windows().pop();
        found.is_some()
    });
    let (id, _) = found.expect("it is there");
    screen.destroy(&id);
    assert_nothing_is_lost(run, &out, "the window was lost");
}

#[test]
fn a_screen_that_dies_loses_no_result() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(mut screen) = VirtualScreen::start(folder.path()) else {
        println!("skipped: Xvfb or xdotool is not installed");
        return;
    };
    let (station, out) = (station_name("dark"), folder.path().join("out"));
    let run = operate(&screen, &station, &out);
    screen.kill();
    assert_nothing_is_lost(run, &out, "the window was lost");
}

#[test]
fn without_a_screen_windows_are_refused_before_anything_starts() {
    for (words, display) in [
        (&["run"][..], None),
        (&["start"], None),
        (&["observe"], None),
        (&[], Some(":7777")),
        (&["run"], Some(":7777")),
    ] {
        let mut calot = calot();
        calot.args(words);
        for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            calot.env_remove(name);
        }
        if let Some(display) = display {
            calot.env("DISPLAY", display);
        }
        let output = finish(&mut calot);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{words:?}: {said}");
        assert!(said.contains("calot run --headless"), "{words:?}: {said}");
        assert!(said.contains("DISPLAY"), "{words:?}: {said}");
        assert!(!said.contains(".rs:"), "{words:?}: {said}");
    }
}

#[test]
fn a_recording_that_ends_early_fails_the_run_and_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let mut calot = calot();
    calot
        .args(["run", "--headless", "--frames", "0", "--seconds", "2"])
        .args(["--record", "/dev/full", "--station", &station_name("full")])
        .arg("--out")
        .arg(&out);
    let output = finish(&mut calot);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("ends early"), "{}", said(&output));
    let summary = summary(&out);
    assert!(summary["warnings"].to_string().contains("ends early"));
    assert!(out.join("report.html").exists());
}

#[test]
fn a_recording_that_cannot_be_written_is_refused_before_anything_starts() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("missing").join("session.mcap");
    let output = finish(
        calot()
            .args(["run", "--headless", "--frames", "0", "--seconds", "2"])
            .args(["--station", &station_name("missing"), "--record"])
            .arg(&missing)
            .arg("--out")
            .arg(folder.path().join("out")),
    );
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("missing"), "{}", said(&output));
    assert!(!said(&output).contains("ticks"), "{}", said(&output));
}
