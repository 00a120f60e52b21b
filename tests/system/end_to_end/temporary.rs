//! Stations and commands whose temporary folders differ: a name runs once, and each command either
//! finds the station or fails and says why.

use std::path::Path;
use std::process::Command;

use rustix::process::Signal;
use system_tests::screen::VirtualScreen;
use system_tests::{Program, calot, finish, said, signal, station_name, wait_until};

fn run(name: &str, tmp: &Path, out: &Path) -> Command {
    let mut calot = calot();
    let words = [
        "run",
        "--headless",
        "--seconds",
        "3600",
        "--frames",
        "0",
        "--station",
        name,
    ];
    calot.args(words).arg("--out").arg(out).env("TMPDIR", tmp);
    calot
}

/// Fails, with exit code 1, and says these words.
fn fails(command: &mut Command, words: &str) {
    let output = finish(command);
    assert_eq!(
        output.status.code(),
        Some(1),
        "{command:?}: {}",
        said(&output)
    );
    assert!(
        said(&output).contains(words),
        "{command:?}: {}",
        said(&output)
    );
}

/// Commands that watch a station, for a second.
fn watchers(name: &str, folder: &Path) -> Vec<(Command, Option<VirtualScreen>)> {
    let mut all = Vec::new();
    let screen = VirtualScreen::start(folder);
    if let Some(screen) = screen {
        let mut observe = calot();
        observe
            .args(["observe", "--seconds", "1"])
            .env("DISPLAY", &screen.display);
        observe.env_remove("WAYLAND_DISPLAY");
        all.push((observe, Some(screen)));
    } else {
        println!("skipped: no virtual screen, so nobody observes");
    }
    for words in [
        &["igtlink", "--seconds", "1", "--listen", "127.0.0.1:0"][..],
        &[
            "link",
            "serve",
            "--insecure",
            "--seconds",
            "1",
            "--listen",
            "127.0.0.1:0",
        ],
    ] {
        let mut command = calot();
        command.args(words);
        all.push((command, None));
    }
    for (command, _) in &mut all {
        command.args(["--station", name]);
    }
    all
}

#[test]
fn a_name_runs_once_and_watchers_with_another_temporary_folder_are_told() {
    let [tmp, other, out, beside] = [(); 4].map(|()| tempfile::tempdir().expect("a folder"));
    let name = station_name("temporary");
    let first = Program::start(&mut run(&name, tmp.path(), out.path()));
    let session = out.path().join("session.mcap");
    wait_until("the station records", || {
        std::fs::metadata(&session).is_ok_and(|it| it.len() > 100_000)
    });
    fails(&mut run(&name, other.path(), beside.path()), "runs already");
    for (mut command, _screen) in watchers(&name, out.path()) {
        fails(command.env("TMPDIR", other.path()), "TMPDIR");
    }
    signal(first.id(), Signal::INT);
    let first = first.finish();
    assert!(first.status.success(), "{}", said(&first));
}

#[test]
fn who_waits_for_a_station_that_never_runs_fails() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = station_name("never");
    for (mut command, _screen) in watchers(&name, folder.path()) {
        fails(command.env("TMPDIR", folder.path()), "did not run");
    }
}
