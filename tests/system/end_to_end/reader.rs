//! A whole session by a screen reader alone: `calot start` on a virtual screen, worked through the
//! accessibility bus. No key is pressed, and no mouse is moved.

use std::path::Path;

use system_tests::reader::ScreenReader;
use system_tests::screen::VirtualScreen;
use system_tests::{Program, calot, finish, said, station_name, summary, turn, wait_until};

use crate::launcher::{only_folder, screen};

/// Least size of a recording that counts as an operation, bytes.
const WORKED_BYTES: u64 = 100_000;

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

fn is_shown(screen: &VirtualScreen, title: &str) -> bool {
    screen.windows().iter().any(|it| it.1 == title)
}

#[test]
fn a_screen_reader_leads_from_the_start_to_the_debrief() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let Some(reader) = ScreenReader::start() else {
        eprintln!(
            "SKIPPED: AT-SPI is not installed (apt-get install at-spi2-core dbus); no window was read"
        );
        return;
    };
    let store = folder.path().join("store.sqlite");
    let sessions = folder.path().join("sessions");
    let mut launcher = calot();
    launcher
        .args(["start", "--station", &station_name("reader")])
        .args(["--store", text(&store), "--sessions", text(&sessions)])
        .args(["--scene", "built-in", "--language", "en", "--"])
        .args(["--no-realtime", "--mute", "--size", "640x480"])
        .env("XDG_CONFIG_HOME", folder.path())
        .env("DISPLAY", &screen.display)
        .env("DBUS_SESSION_BUS_ADDRESS", &reader.bus)
        .env_remove("WAYLAND_DISPLAY");
    let mut launcher = Program::start(&mut launcher);
    let _ = screen.window("Calot: Start");
    reader.work("Free practice");
    reader.work_until("Begin (Enter)", || is_shown(&screen, "Calot: Operation"));
    let recording = || only_folder(&sessions).map(|it| it.join("session.mcap"));
    let bytes = || recording().and_then(|it| Some(it.metadata().ok()?.len()));
    wait_until("some work", || bytes() > Some(WORKED_BYTES));
    // The operation's own window: its settings pause the task, and its button ends it.
    reader.work_until("Settings", || reader.shows("Back (Esc)"));
    let kept = folder.path().join("calot/settings.toml");
    let kept = || std::fs::read_to_string(&kept).unwrap_or_default();
    reader.work_until("125 %", || kept().contains("text_percent = 125"));
    reader.work_until("Back (Esc)", || !reader.shows("Back (Esc)"));
    reader.work_until("Quit (Esc)", || is_shown(&screen, "Calot: Debrief"));
    let out = only_folder(&sessions).expect("the session's folder");
    let came_to = summary(&out);
    assert_eq!(came_to["task"], "free", "{came_to:#}");
    reader.work_until("Another task", || is_shown(&screen, "Calot: Start"));
    // The launcher has the settings that the operation's window kept.
    reader.work_until("Display and hand", || reader.shows("125 %"));
    reader.work_until("Quit (Ctrl+Q)", || launcher.ended().is_some());
    let output = launcher.finish();
    assert!(output.status.success(), "{}", said(&output));
    let listed = finish(calot().args(["store", "--store", text(&store), "list", "--json"]));
    assert!(listed.status.success(), "{}", said(&listed));
}
