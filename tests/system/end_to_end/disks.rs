//! Disks that fill up, fail, are slow or are too small: the results remain, and the exit code
//! reports the fault.

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use serde_json::Value;
use system_tests::disk::{Disk, Manner};
use system_tests::{calot, finish, may_be_realtime, root, said, station_name, summary};

/// Runs a shell script in a mount namespace of its own, with the program as `$0`, these arguments,
/// and a station's name in `STATION`. `None`: this user may not mount.
fn in_namespace(script: &str, arguments: &[&Path], station: &str) -> Option<Output> {
    if !may_be_realtime() {
        eprintln!("SKIPPED: only root may mount a disk; no full disk was tested");
        return None;
    }
    let program = calot();
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", script]);
    command.arg(program.get_program()).args(arguments);
    command.env("STATION", station).current_dir(root());
    for (name, value) in program.get_envs() {
        command.env(name, value.unwrap_or_default());
    }
    Some(finish(&mut command))
}

#[test]
fn a_disk_that_fills_up_costs_the_exit_code_and_nothing_that_came_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let [disk, out] = ["disk", "out"].map(|it| folder.path().join(it));
    std::fs::create_dir_all(&disk).expect("a folder");
    // The disk has room at the start. Something else fills it while the session runs.
    let script = r#"mount -t tmpfs -o size=40m none "$1" || exit 99
        (while [ ! -s "$1/s.mcap" ]; do sleep 0.1; done
         sleep 2; cat /dev/zero > "$1/filler") 2> /dev/null &
        "$0" run --headless --seconds 5 --frames 0 --no-realtime --station "$STATION" \
            --record "$1/s.mcap" --out "$2"
        code=$?; cp "$1/s.mcap" "$2"; exit $code"#;
    let Some(output) = in_namespace(script, &[&disk, &out], &station_name("filled")) else {
        return;
    };
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("does not take the recording"), "{said}");
    let came_to = summary(&out);
    let warnings = came_to["warnings"].to_string();
    assert!(warnings.contains("ends early"), "{warnings}");
    let page = std::fs::read_to_string(out.join("report.html")).expect("a report");
    assert!(page.contains("ends early"));
    let replayed = finish(calot().arg("replay").arg(out.join("s.mcap")).arg("--json"));
    let replayed: Value = serde_json::from_slice(&replayed.stdout).expect("JSON");
    assert_eq!(replayed["first_difference"], Value::Null, "{replayed:#}");
    let ticks = replayed["ticks"].as_u64();
    assert!(ticks > Some(500), "{replayed:#}");
    assert!(came_to["ticks"].as_u64() > ticks, "the run went on");
}

#[test]
fn a_place_that_takes_no_recording_is_refused_before_a_device_is_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|it| it.success()));
    let refused = |command: &mut Command, path: &Path| {
        let words = [
            "run",
            "--headless",
            "--frames",
            "0",
            "--haptic",
            "/dev/none",
        ];
        command
            .args(words)
            .args(["--station", &station_name("refused")]);
        command.arg("--record").arg(path).arg("--out").arg(&out);
        let output = finish(command);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(!said.contains("/dev/none"), "a device came first: {said}");
        said
    };
    let text = refused(&mut calot(), &pipe);
    assert!(text.contains("this is a pipe"), "{text}");
    // A file size limit that is too small for any recording is named in the error. The signal of
    // the limit does not kill the program.
    let program = calot();
    let mut limited = Command::new("prlimit");
    limited.arg("--fsize=4000000").arg(program.get_program());
    limited.current_dir(root());
    for (name, value) in program.get_envs() {
        limited.env(name, value.unwrap_or_default());
    }
    let text = refused(&mut limited, &folder.path().join("s.mcap"));
    assert!(text.contains("ulimit -f"), "{text}");

    let disk = folder.path().join("disk");
    std::fs::create_dir_all(&disk).expect("a folder");
    let script = r#"mount -t tmpfs -o ro none "$1" || exit 99
        "$0" run --headless --frames 0 --haptic /dev/none --station "$STATION" --out "$1""#;
    if let Some(output) = in_namespace(script, &[&disk], &station_name("read-only")) {
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("Read-only file system"), "{said}");
        assert!(!said.contains("/dev/none"), "{said}");
    }
}

/// Records for some seconds on a disk that behaves in this manner. Returns exit code, standard
/// error and summary. `None`: no such disk can be mounted here.
fn recorded_on(manner: Manner, test: &str) -> Option<(Option<i32>, String, Value)> {
    let folder = tempfile::tempdir().expect("a folder");
    let [at, out] = ["disk", "out"].map(|it| folder.path().join(it));
    std::fs::create_dir_all(&at).expect("a folder");
    let Some(disk) = Disk::mount(&at, manner) else {
        eprintln!("SKIPPED: no FUSE here; no slow or failing disk was tested");
        return None;
    };
    let mut command = calot();
    command
        .args(["run", "--headless", "--frames", "0", "--seconds", "4"])
        .args(["--no-realtime", "--station", &station_name(test)])
        .arg("--record")
        .arg(at.join("s.mcap"))
        .arg("--out")
        .arg(&out);
    let output = finish(&mut command);
    drop(disk);
    Some((output.status.code(), said(&output), summary(&out)))
}

#[test]
fn a_disk_that_fails_is_reported_and_a_slow_one_loses_nothing() {
    let slow = Manner {
        delay: Duration::from_millis(100),
        ..Manner::default()
    };
    let Some((code, said, came_to)) = recorded_on(slow, "slow") else {
        return;
    };
    assert_eq!(code, Some(0), "{said}");
    let recording = &came_to["recording"];
    assert_eq!(recording["missing"], 0, "{recording}");
    let slowest = recording["slowest_write_ms"].as_u64();
    assert!(slowest >= Some(100), "{recording}");

    let written = recording["bytes"].as_u64().expect("a size");
    let failing = Manner {
        error_after: Some((written * 3 / 4, 5)),
        ..Manner::default()
    };
    let losing = Manner {
        sync_error: Some(5),
        ..Manner::default()
    };
    let limited = Manner {
        error_after: Some((written * 3 / 4, 122)),
        ..Manner::default()
    };
    for (manner, test, words) in [
        (failing, "failing", "Input/output error"),
        (losing, "losing", "Input/output error"),
        (limited, "quota", "uota exceeded"),
    ] {
        let Some((code, said, came_to)) = recorded_on(manner, test) else {
            return;
        };
        assert_eq!(code, Some(1), "{test}: {said}");
        assert!(said.contains(words), "{test}: {said}");
        let warnings = came_to["warnings"].to_string();
        assert!(warnings.contains(words), "{test}: {warnings}");
        assert!(
            came_to["ticks"].as_u64() > Some(1000),
            "{test}: the run went on"
        );
    }
}
