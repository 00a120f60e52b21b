//! `calot store push`: results of a station go to a centre, each once, whatever happens.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use rustix::process::Signal;
use serde_json::Value;
use store::{Circumstances, Hand, SessionRecord, Store, new_id};
use system_tests::lrs::Lrs;
use system_tests::postgres::{OWNER, PASSWORD, Postgres};
use system_tests::{calot, documents, finish, said, station_name};

/// A store with sessions of Ada and, at last, one of Zaphod.
fn store(folder: &Path, sessions: i64) -> PathBuf {
    let path = folder.join("store.sqlite");
    let mut store = Store::open(&path).expect("a store");
    for number in 0..sessions {
        let name = if number + 1 < sessions {
            "Ada"
        } else {
            "Zaphod"
        };
        let session = SessionRecord {
            id: new_id(),
            began_unix_s: 1_790_000_000 + number,
            task: "cut".to_owned(),
            difficulty: "exam".to_owned(),
            outcome: "failed".to_owned(),
            score: 40.25,
            alarms: 0,
            metrics_version: 1,
            metrics: [("time_s".to_owned(), 61.0)].into(),
            scene: "triangle".to_owned(),
            program: "a test".to_owned(),
            file: None,
            hand: Hand::Person,
            circumstances: Circumstances::default(),
        };
        store.add_session(name, &session).expect("kept");
    }
    path
}

fn push(store: &Path, address: &str) -> Command {
    let mut command = calot();
    command.args(["store", "push", "--json", "--to", address, "--store"]);
    command.arg(store).env("PGPASSWORD", PASSWORD);
    command
        .env("CALOT_LRS_USER", "station")
        .env("CALOT_LRS_PASSWORD", "s3cret");
    command
}

fn told(output: &Output) -> Value {
    let told = serde_json::from_slice(&output.stdout);
    let told: Value = told.unwrap_or_else(|error| panic!("{error}: {}", said(output)));
    documents::check(&told);
    told
}

/// Each session takes the server 20 ms, so that all of them take 40 s.
const SLOW: &str = "CREATE FUNCTION calot.slow() RETURNS trigger LANGUAGE plpgsql \
     AS 'BEGIN PERFORM pg_sleep(0.02); RETURN NEW; END'; \
     CREATE TRIGGER slow BEFORE INSERT ON calot.session FOR EACH ROW EXECUTE FUNCTION calot.slow()";

#[test]
fn a_push_that_is_killed_is_finished_by_two_at_once() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let store = store(folder.path(), 2000);
    let address = server.address(OWNER);
    // The tables are there before the count begins.
    let none = folder.path().join("none.sqlite");
    drop(Store::open(&none).expect("a store"));
    assert!(finish(&mut push(&none, &address)).status.success());
    // A slow server, so that the push cannot end before it is killed, however late this test runs.
    server.sql("calot", SLOW);
    let mut first = push(&store, &address)
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts");
    while server.rows("SELECT count(*) > 50 FROM calot.session") == ["f"] {
        assert_eq!(
            first.try_wait().expect("a child"),
            None,
            "it ended too soon"
        );
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    first.kill().expect("killed");
    first.wait().expect("it ends");
    let half = server.rows("SELECT count(*) FROM calot.session");
    let half: i64 = half[0].parse().expect("a number");
    assert!((50..2000).contains(&half), "{half}");
    server.sql("calot", "DROP TRIGGER slow ON calot.session");
    let start = || {
        let mut command = push(&store, &address);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("it starts")
    };
    let both = [start(), start()].map(|it| it.wait_with_output().expect("it ends"));
    let sent: i64 = both
        .iter()
        .map(|it| told(it)["sent"].as_i64().expect("a number"))
        .sum();
    assert!(
        both.iter().all(|it| it.status.success()),
        "{}",
        said(&both[0])
    );
    assert!(sent <= 2000 - half, "{sent} after {half}");
    let count = "SELECT count(*), count(DISTINCT id) FROM calot.session";
    assert_eq!(server.rows(count), ["2000|2000"]);
}

#[test]
fn who_is_forgotten_while_the_centres_are_away_is_forgotten_there_later() {
    let Some(mut server) = Postgres::start() else {
        return;
    };
    let lrs = Lrs::start(Some);
    let folder = tempfile::tempdir().expect("a folder");
    let store = store(folder.path(), 3);
    let (database, records) = (
        server.address(OWNER),
        format!("http://127.0.0.1:{}/xapi", lrs.port()),
    );
    for address in [&database, &records] {
        let output = finish(&mut push(&store, address));
        assert!(output.status.success(), "{}", said(&output));
        assert_eq!(told(&output)["sent"], 3);
    }
    server.stop(Signal::INT);
    let mut forget = calot();
    let output = finish(
        forget
            .args(["store", "forget", "Zaphod", "--store"])
            .arg(&store),
    );
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("still has to forget; `calot store push` tells it"),
        "{text}"
    );
    let output = finish(&mut push(&store, &database));
    assert_eq!(output.status.code(), Some(1));
    assert!(
        said(&output).contains("does not work at the moment"),
        "{}",
        said(&output)
    );
    assert_eq!(told(&output)["waiting"], 1);
    server.resume();
    for address in [&database, &records] {
        let output = finish(&mut push(&store, address));
        assert!(output.status.success(), "{}", said(&output));
        assert_eq!(told(&output)["withdrawn"], 1);
    }
    let left = "SELECT DISTINCT name FROM calot.trainee LEFT JOIN calot.session USING (person)";
    assert_eq!(server.rows(left), ["Ada"]);
    assert_eq!(lrs.standing().len(), 2);
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn a_push_that_cannot_begin_says_why_and_changes_nothing() {
    let lrs = Lrs::start(Some);
    let address = format!("http://127.0.0.1:{}/xapi", lrs.port());
    let folder = tempfile::tempdir().expect("a folder");
    let none = folder.path().join("none/store.sqlite");
    let fails = |command: &mut Command, why: &str| {
        let output = finish(command);
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let text = said(&output);
        assert!(text.contains(why), "{text}");
        assert!(
            !text.contains("s3cret") && !text.contains(PASSWORD),
            "{text}"
        );
    };
    fails(&mut push(&none, &address), "there is no store");
    assert!(!none.parent().expect("a folder").exists());
    let store = store(folder.path(), 40);
    fails(
        &mut push(&store, "https://a:s3cret@lrs.example/xapi"),
        "in --to, which every user",
    );
    let mut wrong = push(&store, &address);
    fails(
        wrong.env("CALOT_LRS_PASSWORD", "wr0ng"),
        "refuses this user or password",
    );
    // A page in the middle of the file is overwritten.
    let mut bytes = std::fs::read(&store).expect("a file");
    let middle = bytes.len() / 2 / 4096 * 4096;
    bytes[middle..middle + 4096].fill(0x5a);
    std::fs::write(&store, &bytes).expect("written");
    fails(&mut push(&store, &address), "is damaged");
    assert_eq!(std::fs::read(&store).expect("a file"), bytes);
    assert_eq!(lrs.kept().writes, 0);
}

#[test]
fn recordings_of_a_centre_are_scored_again_as_a_report_scores_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let (out, store) = (
        folder.path().join("all/one"),
        folder.path().join("store.sqlite"),
    );
    let mut run = calot();
    run.args([
        "run",
        "--headless",
        "--frames",
        "0",
        "--seconds",
        "4",
        "--task",
        "scope",
    ]);
    run.args([
        "--trainee",
        "Ada",
        "--new-trainee",
        "--station",
        &station_name("rescore"),
    ]);
    let ran = finish(run.arg("--out").arg(&out).arg("--store").arg(&store));
    assert!(ran.status.success(), "{}", said(&ran));
    let recording = out.join("session.mcap");
    for number in 0..5 {
        let copy = folder.path().join(format!("all/copy-{number}.mcap"));
        std::fs::copy(&recording, copy).expect("copied");
    }
    std::fs::write(folder.path().join("all/broken.mcap"), "x").expect("written");
    // Other rules: each lost point counts.
    let rules = finish(calot().args(["report", "--rules-file"]));
    let rules = String::from_utf8(rules.stdout).expect("a text");
    let file = folder.path().join("strict.toml");
    std::fs::write(&file, rules).expect("written");
    let rescore = |jobs: &str| {
        let mut command = calot();
        command
            .args(["store", "rescore", "--jobs", jobs, "--rules"])
            .arg(&file);
        command
            .arg(folder.path().join("all"))
            .arg("--store")
            .arg(&store);
        let output = finish(&mut command);
        assert_eq!(
            output.status.code(),
            Some(1),
            "one is broken: {}",
            said(&output)
        );
        assert!(
            said(&output).contains("7 recordings in"),
            "{}",
            said(&output)
        );
        String::from_utf8(output.stdout).expect("a text")
    };
    let (one, many) = (rescore("1"), rescore("3"));
    assert_eq!(one, many, "the number of threads changes nothing");
    let mut rows = many.lines().map(|it| it.split(',').collect::<Vec<_>>());
    let head = rows.next().expect("a head");
    let rows: Vec<_> = rows.collect();
    assert_eq!(rows.len(), 7);
    let at = |name: &str| head.iter().position(|it| *it == name).expect("a column");
    let mut report = calot();
    report
        .args(["report", "--json", "--rules"])
        .arg(&file)
        .arg(&recording);
    let report = finish(&mut report);
    let report: Value = serde_json::from_slice(&report.stdout).expect("JSON");
    let expected = &report[0];
    for row in rows
        .iter()
        .filter(|it| !it[at("file")].ends_with("broken.mcap"))
    {
        assert_eq!(row[at("trainee")], "Ada");
        assert_eq!(
            row[at("outcome")],
            expected["outcome"].as_str().expect("a text")
        );
        assert_eq!(
            row[at("score")].parse::<f64>().ok(),
            expected["score"].as_f64()
        );
        let path = expected["metrics"]["scope_path_m"].as_f64();
        assert_eq!(row[at("scope_path_m")].parse::<f64>().ok(), path);
        assert_eq!(row[at("outcome_before")], row[at("outcome")]);
    }
}
