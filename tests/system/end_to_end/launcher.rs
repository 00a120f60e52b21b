//! `calot start` on a virtual screen, used by keyboard alone: choice of a task, operation, debrief,
//! questionnaire and sheet. An instructor watches.

use std::path::{Path, PathBuf};

use session::Session;
use shared_mem::message::CommandMsg;
use system_tests::screen::VirtualScreen;
use system_tests::{Program, calot, finish, said, station_name, summary, turn, wait_until};

/// Least size of a recording that counts as an operation, bytes.
const WORKED_BYTES: u64 = 100_000;

pub(crate) fn screen(folder: &Path) -> Option<VirtualScreen> {
    let screen = VirtualScreen::start(folder);
    if screen.is_none() {
        eprintln!(
            "SKIPPED: Xvfb or xdotool is not installed (apt-get install xvfb xdotool); no window was tested"
        );
    }
    screen
}

fn on(screen: &VirtualScreen, words: &[&str]) -> Program {
    let mut calot = calot();
    calot.args(words).env("DISPLAY", &screen.display);
    Program::start(calot.env_remove("WAYLAND_DISPLAY"))
}

/// Starts the launcher with the built-in scene. Returns the launcher, its store and its sessions
/// folder.
pub(crate) fn start(
    screen: &VirtualScreen,
    station: &str,
    folder: &Path,
) -> (Program, PathBuf, PathBuf) {
    let (store, sessions) = (folder.join("store.sqlite"), folder.join("sessions"));
    let words = [
        "start",
        "--station",
        station,
        "--store",
        text(&store),
        "--sessions",
        text(&sessions),
        "--scene",
        "built-in",
        "--language",
        "en",
        "--",
        "--no-realtime",
        "--mute",
        "--size",
        "640x480",
    ];
    (on(screen, &words), store, sessions)
}

pub(crate) fn only_folder(of: &Path) -> Option<PathBuf> {
    Some(std::fs::read_dir(of).ok()?.next()?.ok()?.path())
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

#[test]
fn keyboard_leads_from_the_start_to_the_debrief() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let station = station_name("start");
    let (mut launcher, store, sessions) = start(&screen, &station, folder.path());
    let desk = &screen.window("Calot: Start");
    // Key 2 chooses the endoscope drill, key 9 free practice. N moves to the name.
    screen.press_and_see(desk, "2");
    screen.press_and_see(desk, "9");
    screen.press_and_see(desk, "n");
    for letter in ["a", "d", "a"] {
        screen.press_and_see(desk, letter);
    }
    screen.press_and_see(desk, "Return");
    let is_shown = |title: &str| screen.windows().iter().any(|it| it.1 == title);
    wait_until("the operation", || {
        if is_shown("Calot: Start") {
            screen.press(desk, "Return");
        }
        is_shown("Calot: Operation")
    });

    let recording = || only_folder(&sessions).map(|it| it.join("session.mcap"));
    let bytes = || recording().and_then(|it| Some(it.metadata().ok()?.len()));
    wait_until("some work", || bytes() > Some(WORKED_BYTES));
    wait_until("the debrief", || {
        // Esc ends the operation in its own window.
        if let Some((window, _)) = screen.windows().iter().find(|it| it.0 != *desk) {
            screen.press(window, "Escape");
        }
        is_shown("Calot: Debrief")
    });
    let out = only_folder(&sessions).expect("the session's folder");
    let came_to = summary(&out);
    assert_eq!(came_to["task"], "free", "{came_to:#}");
    assert_eq!(came_to["difficulty"], "beginner");
    assert!(out.join("debrief.html").exists());

    let ask = |words: &[&str]| -> serde_json::Value {
        let store = text(&store);
        let output = finish(calot().args(["store", "--store", store]).args(words));
        assert!(output.status.success(), "{}", said(&output));
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    assert_eq!(ask(&["list", "ada", "--json"])[0]["id"], came_to["session"]);

    screen.press(desk, "q");
    let _ = screen.window("Calot: Questionnaire");
    for _ in 0..14 {
        screen.press_and_see(desk, "4");
    }
    screen.press(desk, "Return");
    let _ = screen.window("Calot: Debrief");
    let answers = ask(&["answers", "--json"]);
    assert_eq!(
        (&answers[13]["count"], &answers[13]["mean"]),
        (&1.into(), &4.0.into())
    );

    screen.press(desk, "i");
    let _ = screen.window("Calot: Instructor's assessment");
    for _ in 0..5 {
        screen.press_and_see(desk, "3");
    }
    screen.press(desk, "Return");
    let _ = screen.window("Calot: Debrief");
    let sheet = &ask(&["export", "ada"])["trainees"][0]["sessions"][0]["sheet"];
    assert_eq!(sheet["Tissue handling"], 3, "{sheet}");

    // Leave from the debrief or the problem screen to the start screen, then quit.
    screen.leave_launcher(desk, &mut launcher);
    let output = launcher.finish();
    assert!(output.status.success(), "{}", said(&output));
}

/// The launcher reports a program that cannot run, and continues.
#[test]
fn an_operation_that_cannot_begin_leads_back_to_the_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let file = folder.path().join("station.toml");
    std::fs::write(
        &file,
        "[haptic]\ndriver = \"rig\"\npath = \"/nowhere/rig\"\n",
    )
    .expect("written");
    let mut launcher = on(
        &screen,
        &[
            "start",
            "--station",
            &station_name("fails"),
            "--store",
            text(&folder.path().join("store.sqlite")),
            "--station-file",
            text(&file),
            "--scene",
            "built-in",
            "--language",
            "en",
        ],
    );
    let desk = &screen.window("Calot: Start");
    screen.press(desk, "Return");
    let _ = screen.window("Calot: Operation did not start");
    // Leave from the debrief or the problem screen to the start screen, then quit.
    screen.leave_launcher(desk, &mut launcher);
    let output = launcher.finish();
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("/nowhere/rig"), "{}", said(&output));
}

/// Instructors join before the station starts and while it runs. They see the station and change
/// nothing.
#[test]
fn instructors_come_and_go_and_change_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let station = station_name("observed");
    let observe = || {
        on(
            &screen,
            &[
                "observe",
                "--station",
                &station,
                "--language",
                "en",
                "--size",
                "640x480",
            ],
        )
    };
    let early = observe();
    let out = folder.path().join("out");
    let mut calot = calot();
    calot
        .args([
            "run",
            "--headless",
            "--frames",
            "0",
            "--no-realtime",
            "--seconds",
            "600",
        ])
        .args(["--task", "free", "--station", &station, "--out"])
        .arg(&out);
    let run = Program::start(&mut calot);
    let leave = |mut observer: Program| {
        let window = || screen.windows().into_iter().next().map(|it| it.0);
        wait_until("the instructor's window", || window().is_some());
        let shown = window().expect("it is there");
        wait_until("a picture", || {
            // In the trainee's window P would pause the station.
            screen.press(&shown, "p");
            let pixels = screen.pixels();
            let colours: std::collections::HashSet<_> = pixels.chunks(4).collect();
            colours.len() > 1500
        });
        screen.leave(&shown, &mut observer);
        let output = observer.finish();
        assert!(output.status.success(), "{}", said(&output));
    };
    leave(early);
    leave(observe());
    system_tests::signal(run.id(), rustix::process::Signal::TERM);
    let output = run.finish();
    assert!(output.status.success(), "{}", said(&output));
    let came_to = summary(&out);
    assert_eq!(came_to["outcome"], "practised", "{came_to:#}");
    let session = Session::open(&out.join("session.mcap")).expect("a session");
    let kinds: Vec<u32> = session.map(|it| u32::from(it.command & 15)).collect();
    // Free practice begins without a command.
    assert!(!kinds.is_empty());
    assert!(!kinds.contains(&CommandMsg::PAUSE));
}
