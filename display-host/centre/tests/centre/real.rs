//! A real station, from its start to its result.

use std::process::Stdio;

use serde_json::json;

use crate::house::House;
use crate::support::{Killed, calot, wait};

#[test]
fn a_real_station_is_seen_takes_a_remark_and_leaves_its_result() {
    let house = House::open(&["theatre-1"], &["theatre-1"]);
    let name = format!("test-{}-centre", std::process::id());
    let mut run = calot();
    // Nobody's settings hold.
    run.env("XDG_CONFIG_HOME", house.file("settings"));
    run.args([
        "run",
        "--headless",
        "--task",
        "clamp",
        "--hand",
        "unclamped",
        "--frames",
        "0",
    ]);
    run.args([
        "--station",
        &name,
        "--trainee",
        "Kim",
        "--no-realtime",
        "--store",
    ]);
    run.arg(house.file("store.sqlite"))
        .arg("--out")
        .arg(house.file("out"));
    run.args(["--centre", &house.centre.stations, "--centre-keys"])
        .arg(house.file("keys/theatre-1"));
    let log = std::fs::File::create(house.file("run.log")).expect("a file");
    let mut run = Killed(
        run.stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .expect("a run"),
    );
    let mut page = house.page();
    let state = wait("the station runs", || {
        page.look();
        let state = &page.stations.get("theatre-1")?["state"];
        (state["running"] == true && !state["task"].is_null() && !state["realtime"].is_null())
            .then(|| state.clone())
    });
    assert_eq!(
        (&state["trainee"], &state["task"]["name"]),
        (&json!("Kim"), &json!("clamp"))
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
    let status = wait("the run ends", || {
        page.look();
        run.0.try_wait().expect("a child")
    });
    let said = std::fs::read_to_string(house.file("run.log")).expect("a log");
    assert!(status.success(), "{said}");
    let people = page.get(&house.centre, &house.file("ca.pem"), "/api/people");
    assert_eq!(
        (&people[0]["name"], &people[0]["sessions"]),
        (&json!("Kim"), &json!(1)),
        "{said}"
    );
    wait("it is gone", || {
        page.look();
        (page.present() == 0).then_some(())
    });
    let summary = std::fs::read_to_string(house.file("out/summary.json")).expect("a summary");
    assert!(summary.contains("Slowly"), "the remark is recorded");
    assert!(
        !house.centre.logged("alarm").is_empty(),
        "it cuts what no clip closes"
    );
}
