//! JSON for programs follows its schemas. The runner of a test checks the JSON that the test asks
//! for. This file checks the documents that no other test asks for.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use system_tests::documents::check;
use system_tests::{calot, compiled, finish, said, station_name, summary};

/// Runs the program and returns the JSON that it prints.
#[track_caller]
fn json(command: &mut Command) -> Value {
    let output = finish(command);
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {}", said(&output)))
}

/// Checks one document, or each of an array that is not empty.
#[track_caller]
fn follows(found: &Value, id: &str) {
    let all = found.as_array().cloned();
    let all = all.unwrap_or_else(|| vec![found.clone()]);
    assert!(!all.is_empty(), "nothing of {id}");
    for document in &all {
        assert_eq!(document["schema"], id, "{document:#}");
        check(document);
    }
}

#[test]
fn what_a_session_leads_to_follows_its_schemas() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (out, store) = (folder.join("out"), folder.join("store.sqlite"));
    let mut run = calot();
    run.args(["run", "--headless", "--frames", "0", "--seconds", "4"])
        .args(["--task", "free", "--trainee", "Ada", "--new-trainee"])
        .args(["--json", "--station", &station_name("documents")])
        .arg("--out")
        .arg(&out)
        .arg("--store")
        .arg(&store);
    let printed = json(&mut run);
    follows(&printed, "urn:calot:summary:1");
    assert_eq!(printed, summary(&out), "printed and written are one");
    let session = out.join("session.mcap");

    follows(
        &json(calot().args(["report", "--json"]).arg(&out)),
        "urn:calot:report:1",
    );
    let what_if = ["--json", "--what-if-iterations", "10", "--out"];
    let other = folder.join("what-if");
    let mut replay = calot();
    replay.arg("replay").arg(&session).args(what_if).arg(&other);
    follows(&json(&mut replay), "urn:calot:what-if:1");
    let mut repair = calot();
    repair
        .arg("replay")
        .arg(&session)
        .args(["--repair", "--json"]);
    follows(&json(&mut repair), "urn:calot:repair:1");

    a_recording_is_never_replaced_by_its_surfaces(&session);
    what_is_stored_follows_its_schemas(&store, folder);
}

#[test]
fn the_case_of_a_patient_stands_in_summary_and_debrief() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let mut run = calot();
    run.args(["run", "--headless", "--frames", "0", "--seconds", "2"])
        .args(["--scene", "patient:ada", "--task", "identify", "--json"])
        .args(["--station", &station_name("case")])
        .arg("--out")
        .arg(&out);
    let printed = json(&mut run);
    follows(&printed, "urn:calot:summary:1");
    let ada = &printed["case"];
    assert_eq!(
        (&ada["name"], &ada["course"]),
        (&"ada".into(), &"usual".into())
    );
    assert_eq!(
        (&ada["wall"], &ada["stones"]),
        (&"normal".into(), &1.into())
    );
    let reported = json(calot().args(["report", "--json"]).arg(&out));
    follows(&reported, "urn:calot:report:1");
    assert_eq!(&reported[0]["case"], ada);
    let page = folder.path().join("debrief.html");
    let mut report = calot();
    report
        .args(["report", "--language", "en", "--out"])
        .arg(&page)
        .arg(&out);
    assert!(finish(&mut report).status.success());
    let page = std::fs::read_to_string(page).expect("a page");
    assert!(page.contains("Patient Ada, BMI 20: usual course"), "{page}");
}

fn a_recording_is_never_replaced_by_its_surfaces(session: &Path) {
    let before = std::fs::read(session).expect("a session");
    let mut export = calot();
    export.arg("export").arg(session).arg("--overwrite");
    let refused = finish(export.arg("--surfaces").arg(session));
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
    assert!(
        said(&refused).contains("never replaced"),
        "{}",
        said(&refused)
    );
    assert!(std::fs::read(session).expect("a session") == before);
}

fn what_is_stored_follows_its_schemas(store: &Path, folder: &Path) {
    let ask = |words: &[&str]| {
        let mut command = calot();
        command.args(["store", "--store"]).arg(store).args(words);
        command
    };
    follows(&json(&mut ask(&["list", "--json"])), "urn:calot:trainee:1");
    let sessions = json(&mut ask(&["list", "Ada", "--json"]));
    follows(&sessions, "urn:calot:session:1");
    let progress = json(&mut ask(&["progress", "Ada", "--json"]));
    follows(&progress, "urn:calot:progress:1");
    assert_eq!(progress["next"]["task"], "basics", "{progress:#}");
    let built_in = finish(&mut ask(&["curriculum"]));
    assert!(said(&built_in).is_empty() && !built_in.stdout.is_empty());
    let id = sessions[0]["id"].as_str().expect("a name");
    let enrol = ["trainee", "Ada", "--cohort", "novices"];
    follows(&json(&mut ask(&enrol)), "urn:calot:trainee:1");
    follows(&json(&mut ask(&["sheet", "--json"])), "urn:calot:form:1");
    let points = ["3", "3", "4", "4", "5"];
    let sheet = [&["sheet", id, "--rater", "Grace"], &points[..]].concat();
    let filled = finish(&mut ask(&sheet));
    assert!(filled.status.success(), "{}", said(&filled));
    let again = said(&finish(&mut ask(&sheet)));
    assert!(again.contains("--replace") && again.contains(id), "{again}");
    let again = finish(&mut ask(&[&sheet[..], &["--replace"]].concat()));
    assert!(
        said(&again).contains("replaced the sheet"),
        "{}",
        said(&again)
    );
    follows(
        &json(&mut ask(&["sheet", id, "--json"])),
        "urn:calot:sheet:1",
    );
    follows(
        &json(&mut ask(&["answers", "--json"])),
        "urn:calot:answers:1",
    );
    follows(&json(&mut ask(&["export"])), "urn:calot:store:1");

    let centre = folder.join("centre.sqlite");
    let mut merge = calot();
    merge.args(["store", "--store"]).arg(&centre);
    merge.args(["merge", "--json"]).arg(store);
    follows(&json(&mut merge), "urn:calot:merged:1");
}

#[test]
fn the_controller_and_the_preparation_follow_their_schemas() {
    let mut rt = calot();
    rt.args(["rt", "--no-realtime", "--json", "--seconds", "1"])
        .args(["--station", &station_name("controller"), "--scene"])
        .arg(compiled("built-in", None));
    let output = finish(&mut rt);
    let text = String::from_utf8_lossy(&output.stdout);
    let last = text.lines().last().unwrap_or_default();
    let controller = serde_json::from_str(last).unwrap_or_else(|error| panic!("{error}: {text}"));
    follows(&controller, "urn:calot:controller:1");

    let mut prepare = calot();
    prepare.args(["prepare", "built-in", "--spheres", "300", "--levels", "2"]);
    follows(
        &json(prepare.args(["--json", "-"])),
        "urn:calot:preparation:1",
    );
}

#[test]
fn every_schema_is_listed_and_a_wrong_document_is_refused() {
    let list = finish(calot().arg("schema"));
    let text = String::from_utf8_lossy(&list.stdout);
    let names: Vec<&str> = text.lines().filter_map(|it| it.split(' ').next()).collect();
    assert!(names.contains(&"summary") && names.len() > 20, "{names:?}");
    for name in names {
        let schema = json(calot().args(["schema", name]));
        let validator = jsonschema::validator_for(&schema).expect("a schema of draft 2020-12");
        let id = format!("urn:calot:{name}:1");
        assert!(!validator.is_valid(&serde_json::json!({ "schema": id, "unheard": {} })));
    }
}
