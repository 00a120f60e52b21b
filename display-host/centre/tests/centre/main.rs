//! A centre and its stations as real processes, seen by a page of an instructor.

mod browser;
mod crowd;
mod page;
mod support;

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use browser::Browser;
use page::{Page, login};
use serde_json::{Value, json};
use support::{Centre, Killed, PASSWORD, calot, centre_program, make_keys, wait, write_list};

/// Keys, a list and a running centre in a folder that goes with them.
struct House {
    folder: tempfile::TempDir,
    centre: Centre,
}

impl House {
    fn open(members: &[&str], listed: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let members: Vec<String> = members.iter().map(|it| (*it).to_owned()).collect();
        make_keys(folder.path(), "centre", &members);
        let centre = Centre::start(folder.path(), listed);
        Self { folder, centre }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn page(&self) -> Page {
        Page::open(&self.centre, &self.file("ca.pem"))
    }

    /// Plays a recording as these stations.
    fn rehearse(&self, recording: &Path, names: &[&str]) -> Command {
        let mut command = centre_program();
        command
            .arg("rehearse")
            .arg(recording)
            .args(["--connect", &self.centre.stations]);
        command.arg("--keys");
        names.iter().for_each(|it| {
            command.arg(self.file("keys").join(it));
        });
        command
    }
}

/// A frame as `calot tell` writes it.
fn frame(kind: u8, body: &[u8]) -> Vec<u8> {
    let length = u32::try_from(body.len()).expect("short");
    [&[kind], &length.to_le_bytes()[..], body].concat()
}

/// A recording of 6 s with an alarm a second, and a picture with each state.
fn recording(file: &Path) {
    let picture = include_bytes!("picture.jpg");
    let mut bytes = Vec::new();
    for half in 0..12_u64 {
        let alarms: Vec<Value> = (1..=half / 2)
            .map(|number| json!({"number": number, "at_s": 1.0, "text": {"en": "burnt: liver", "de": "verbrannt: Leber"}}))
            .collect();
        let said = |text: &str| json!({"en": text, "de": text});
        let state = json!({
            "operation": 1, "trainee": null, "running": true, "paused": false, "realtime": true,
            "ticks": 1000 + half * 500, "missed": 0, "late": 0, "device": "live",
            "task": {"name": "clamp", "difficulty": "exam", "title": said("Clip"), "time_s": 1.0, "score": 90.0,
                "step": said("clip the artery"), "steps_done": 1, "steps": 4, "passed": null, "end": null},
            "alarms": alarms.len(), "newest_alarms": alarms,
        });
        bytes.extend(frame(b's', state.to_string().as_bytes()));
        bytes.extend(frame(b't', picture));
        bytes.extend(frame(b'v', picture));
    }
    std::fs::write(file, bytes).expect("written");
}

/// Alarms that a rehearsal says it sent, as (station, operation, number), with their times, ms.
fn sent(output: &Path) -> BTreeMap<(String, u64, u64), u64> {
    let text = std::fs::read_to_string(output).expect("its output");
    let lines = text
        .lines()
        .filter_map(|it| serde_json::from_str::<Value>(it).ok());
    lines
        .map(|it| (of(&it, &it), it["sent_unix_ms"].as_u64().expect("a time")))
        .collect()
}

fn of(station: &Value, alarm: &Value) -> (String, u64, u64) {
    let number = |name: &str| alarm[name].as_u64().expect("a number");
    let station = station["station"].as_str().expect("a station").to_owned();
    (station, number("operation"), number("number"))
}

#[test]
fn stations_come_go_and_err_and_nothing_is_lost() {
    let names = ["s-1", "s-2", "s-3", "s-4"];
    let house = House::open(&["s-1", "s-2", "s-3", "s-4", "stranger"], &names);
    let file = house.file("recording");
    recording(&file);
    let told = std::fs::File::create(house.file("told")).expect("a file");
    let mut first = house.rehearse(&file, &names[..2]);
    let mut first = Killed(first.stdout(told).spawn().expect("a rehearsal"));
    let mut second = house.rehearse(&file, &names[2..]);
    let second = Killed(second.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    let mut page = house.page();
    page.ask(&json!({"enlarge": "s-3"}));
    let large = ('v', "s-3".to_owned());
    wait("four stations, tiles and a large picture", || {
        page.look();
        let tiles = names
            .iter()
            .all(|it| page.pictures.contains_key(&('t', (*it).to_owned())));
        let is_large = page.pictures.get(&large).is_some_and(|it| *it > 3);
        (page.present() == 4 && tiles && is_large).then_some(())
    });
    assert!(
        page.pictures
            .keys()
            .all(|(kind, name)| *kind == 't' || name == "s-3")
    );
    assert_eq!(page.stations["s-1"]["state"]["task"]["score"], 90.0);
    // A station that is killed goes, and comes back.
    drop(second);
    wait("two stations are gone", || {
        page.look();
        (page.present() == 2).then_some(())
    });
    let mut again = house.rehearse(&file, &names[2..]);
    let _again = Killed(again.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    wait("they are back", || {
        page.look();
        (page.present() == 4).then_some(())
    });
    // So far, every alarm that was sent arrived.
    let _ = first.0.kill();
    let _ = first.0.wait();
    let mut sent = sent(&house.file("told"));
    // What it sent while it was killed may have been on its way.
    let last = sent.values().max().copied().unwrap_or(0);
    sent.retain(|_, at| *at + 500 < last);
    assert!(sent.len() > 4, "{sent:?}");
    let late = wait("every alarm is in the log", || {
        let heard = house.centre.logged("alarm");
        let heard: BTreeMap<_, u64> = { heard.iter() }
            .map(|it| {
                (
                    of(it, &it["detail"]),
                    it["at_unix_ms"].as_u64().expect("a time"),
                )
            })
            .collect();
        let late = sent
            .iter()
            .map(|(alarm, at)| Some(heard.get(alarm)?.saturating_sub(*at)));
        late.collect::<Option<Vec<u64>>>()
    });
    println!(
        "{} alarms, the latest after {:?} ms",
        late.len(),
        late.iter().max()
    );
    // A name that is taken off the list is gone at once and comes no more.
    write_list(house.folder.path(), &["s-1", "s-2", "s-4"]);
    wait("it is off the list", || {
        page.look();
        (!page.stations.contains_key("s-3") && page.present() == 1).then_some(())
    });
    let watched = wait("the watching is logged", || {
        page.ask(&json!({"enlarge": null}));
        house.centre.logged("watched").pop()
    });
    assert_eq!(
        (&watched["who"], &watched["station"]),
        (&json!("bo"), &json!("s-3"))
    );
}

#[test]
fn strangers_are_refused_with_and_without_certificates_and_passwords() {
    let house = House::open(&["s-1", "stranger"], &["s-1"]);
    let file = house.file("recording");
    recording(&file);
    // A certificate of the authority that is not on the list comes in and may do nothing.
    let mut unlisted = house.rehearse(&file, &["stranger"]);
    let unlisted = Killed(unlisted.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    let mut listed = house.rehearse(&file, &["s-1"]);
    let _listed = Killed(listed.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    let mut page = house.page();
    wait("the station on the list is there", || {
        page.look();
        (page.present() == 1).then_some(())
    });
    assert_eq!(page.stations.len(), 1, "{:?}", page.stations.keys());
    drop(unlisted);
    // One of another authority does not come in at all.
    let other = tempfile::tempdir().expect("a folder");
    make_keys(other.path(), "evil", &["s-1".to_owned()]);
    let own = house.file("keys/s-1/ca.pem");
    std::fs::copy(own, other.path().join("keys/s-1/ca.pem")).expect("copied");
    let mut command = house.rehearse(&file, &[]);
    let refused = command
        .arg(other.path().join("keys/s-1"))
        .output()
        .expect("it ends");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        !refused.status.success() && said.contains("connecting to the centre failed"),
        "{said}"
    );
    // Without a login the page shows nothing; a wrong password waits after some tries.
    let authority = house.file("ca.pem");
    let ask = |head: &str| page::request(&house.centre, &authority, head, "");
    assert!(ask("GET /api/people HTTP/1.1").starts_with("HTTP/1.1 401"));
    assert!(ask("GET / HTTP/1.1").contains("location: /login"));
    assert!(ask("GET /live HTTP/1.1").starts_with("HTTP/1.1 401"));
    let foreign = "POST /logout HTTP/1.1\r\nOrigin: https://evil.example";
    assert!(ask(foreign).starts_with("HTTP/1.1 403"));
    for tries in 0..6 {
        let (cookie, answer) = login(&house.centre, &authority, "wrong horse");
        let place = if tries < 5 {
            "/login?wrong"
        } else {
            "/login?wait"
        };
        assert!(cookie.is_none() && answer.contains(place), "{answer}");
    }
    let (cookie, _) = login(&house.centre, &authority, PASSWORD);
    assert!(cookie.is_none(), "it has to wait, too");
    assert_eq!(house.centre.logged("refused").len(), 5);
    let log = std::fs::read_to_string(house.file("log")).expect("a log");
    assert!(!log.contains("horse"));
}

#[test]
fn a_page_shows_stations_alarms_and_results_in_a_browser() {
    let house = House::open(&["s-1", "s-2"], &["s-1", "s-2"]);
    let Some(mut browser) = Browser::start(&house.file("profile")) else {
        return;
    };
    let file = house.file("recording");
    recording(&file);
    keep_results(&house.file("centre.sqlite"));
    let mut stations = house.rehearse(&file, &["s-1", "s-2"]);
    let stations = Killed(stations.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    browser.open(&format!("https://{}/", house.centre.page));
    browser.until("location.pathname === '/login' && document.forms[0]");
    browser.value("document.getElementById('name').value = 'bo'");
    browser.value(&format!(
        "document.getElementById('password').value = '{PASSWORD}'"
    ));
    browser.value("document.forms[0].submit()");
    browser.until("document.querySelectorAll('.tile').length === 2");
    browser.until("[...document.querySelectorAll('.tile img')].every((it) => it.naturalWidth > 0)");
    browser.until("document.querySelector('.tile.flash') && document.querySelector('.tile .alarms').textContent");
    browser.value("document.querySelector('.tile').click()");
    browser.until("window.shownPictures > 3 && document.querySelector('#alarms li').textContent.includes('burnt')");
    browser.until("document.getElementById('large-facts').textContent.includes('trainee 0')");
    browser.picture(&house.file("stations.png"));
    browser.value("document.getElementById('show-results').click()");
    browser.until("document.querySelector('#people button')");
    browser.value("document.querySelector('#people button').click()");
    browser.until("document.querySelectorAll('circle').length === 2 && document.querySelectorAll('td').length === 12");
    browser.picture(&house.file("results.png"));
    drop(stations);
    browser.until("[...stations.values()].every((it) => !it.told.present)");
    browser.value("document.querySelector('header form').submit()");
    browser.until("location.pathname === '/login'");
    let pictures = std::env::var_os("CALOT_CENTRE_PICTURES").map(PathBuf::from);
    if let Some(folder) = pictures {
        for name in ["stations.png", "results.png"] {
            std::fs::copy(house.file(name), folder.join(name)).expect("copied");
        }
    }
}

/// Two sessions of Kim in the store of a centre.
fn keep_results(path: &Path) {
    let mut store = store::Store::open(path).expect("a store");
    for (began_unix_s, score) in [(1_790_000_000, 55.0), (1_790_100_000, 81.5)] {
        let session = store::SessionRecord {
            id: store::new_id(),
            began_unix_s,
            task: "clamp".to_owned(),
            difficulty: "exam".to_owned(),
            outcome: if score > 70.0 { "passed" } else { "failed" }.to_owned(),
            score,
            alarms: 1,
            metrics_version: 1,
            metrics: BTreeMap::new(),
            scene: "triangle".to_owned(),
            program: "a test".to_owned(),
            file: None,
            hand: store::Hand::Person,
            circumstances: store::Circumstances::default(),
        };
        store.add_session("Kim", &session).expect("kept");
    }
}

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
        (state["running"] == true && !state["task"].is_null()).then(|| state.clone())
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

#[test]
fn mistakes_of_the_user_are_told_with_the_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = |words: &[&str], input: &str| {
        let mut command = centre_program();
        command.args(words).current_dir(folder.path());
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().expect("a program");
        child
            .stdin
            .take()
            .expect("its input")
            .write_all(input.as_bytes())
            .expect("written");
        let output = child.wait_with_output().expect("it ends");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        (
            output.status.success(),
            text,
            String::from_utf8_lossy(&output.stdout).into_owned(),
        )
    };
    let (ok, text, _) = said(&["password"], "short\n");
    assert!(!ok && text.contains("needs 10 to 200"), "{text}");
    let (ok, _, hash) = said(&["password"], "long enough\n");
    assert!(ok && hash.starts_with("$argon2id$"));
    let (ok, text, _) = said(&["serve", "--list", "x", "--keys", "none"], "");
    assert!(!ok && text.contains("is no folder of keys"), "{text}");
    make_keys(folder.path(), "centre", &["s-1".to_owned()]);
    write_list(folder.path(), &["s-1"]);
    let listen = |stations: &str, page: &str| {
        let words = [
            "serve",
            "--list",
            "centre.toml",
            "--keys",
            "keys/centre",
            "--stations",
            stations,
            "--page",
            page,
        ];
        said(&words, "")
    };
    let (ok, text, _) = listen("192.0.2.1:7448", "127.0.0.1:0");
    assert!(
        !ok && text.contains("cannot listen at 192.0.2.1:7448"),
        "{text}"
    );
    let (ok, text, _) = listen("127.0.0.1:0", "192.0.2.1:8443");
    assert!(
        !ok && text.contains("cannot listen at 192.0.2.1:8443"),
        "{text}"
    );
}
