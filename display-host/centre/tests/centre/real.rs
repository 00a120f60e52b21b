//! A real station, from its start to its result.

use std::process::Stdio;

use serde_json::json;

use crate::house::House;
use crate::support::{Killed, calot, wait};

/// A run of a trainee called Kim that joins this centre as `theatre-1`. Its messages go to
/// `run.log`.
fn run(house: &House, task: &[&str], out: &str) -> Killed {
    let name = format!("test-{}-centre", std::process::id());
    let mut run = calot();
    // The settings of the user who runs the test do not count.
    run.env("XDG_CONFIG_HOME", house.file("settings"));
    run.args(["run", "--headless", "--frames", "0", "--no-realtime"]);
    run.arg("--task").args(task);
    run.args(["--station", &name, "--trainee", "Kim", "--store"]);
    run.arg(house.file("store.sqlite"));
    run.arg("--out").arg(house.file(out));
    run.args(["--centre", &house.centre.stations, "--centre-keys"]);
    run.arg(house.file("keys/theatre-1"));
    let log = std::fs::File::create(house.file("run.log")).expect("a file");
    let run = run.stdout(Stdio::null()).stderr(log);
    Killed(run.spawn().expect("a run"))
}

#[test]
fn a_real_station_is_seen_takes_a_remark_and_leaves_its_result() {
    let house = House::open(&["theatre-1"], &["theatre-1"]);
    // Free practice that somebody ends.
    let mut practice = run(&house, &["free", "--seconds", "900"], "practice");
    let mut page = house.page();
    let state = wait("the station runs", || {
        page.look();
        let state = &page.stations.get("theatre-1")?["state"];
        (state["running"] == true && !state["task"].is_null() && !state["realtime"].is_null())
            .then(|| state.clone())
    });
    assert_eq!(
        (&state["trainee"], &state["task"]["name"]),
        (&json!("Kim"), &json!("free"))
    );
    assert_eq!(state["realtime"], false, "the run was asked not to be");
    page.ask(&json!({"enlarge": "theatre-1"}));
    wait("pictures of both sizes", || {
        page.look();
        let seen = |kind| page.pictures.contains_key(&(kind, "theatre-1".to_owned()));
        (seen('t') && seen('v')).then_some(())
    });
    page.ask(&json!({"enlarge": null}));
    page.ask(&json!({"remark": {"station": "theatre-1", "text": "Slowly"}}));
    let outcome = wait("the remark is answered", || {
        page.look();
        page.remark.clone()
    });
    assert_eq!(outcome, "done");
    end(&practice);
    let said = || std::fs::read_to_string(house.file("run.log")).expect("a log");
    let status = wait("the practice ends", || {
        page.look();
        practice.0.try_wait().expect("a child")
    });
    assert!(status.success(), "{}", said());
    let summary = std::fs::read_to_string(house.file("practice/summary.json"));
    assert!(summary.expect("a summary").contains("Slowly"));
    wait("it is gone", || {
        page.look();
        (page.present() == 0).then_some(())
    });

    // An operation with an injury: this hand cuts a vessel that no clip closes.
    let mut operation = run(&house, &["clamp", "--hand", "unclamped"], "operation");
    let status = wait("the operation ends", || {
        page.look();
        operation.0.try_wait().expect("a child")
    });
    assert!(status.success(), "{}", said());
    assert!(!house.centre.logged("alarm").is_empty(), "{}", said());
    let people = page.get(&house.centre, &house.file("ca.pem"), "/api/people");
    assert_eq!(
        (&people[0]["name"], &people[0]["sessions"]),
        (&json!("Kim"), &json!(2)),
        "{}",
        said()
    );
}

/// Asks a process to end, as Ctrl-C does.
fn end(process: &Killed) {
    let id = process.0.id().cast_signed();
    let id = rustix::process::Pid::from_raw(id).expect("a process");
    rustix::process::kill_process(id, rustix::process::Signal::INT).expect("a signal");
}
