//! Strangers, impostors, and mistakes of the user.

use std::collections::BTreeSet;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::json;

use crate::house::{House, recording};
use crate::page::{login, request};
use crate::support::{Killed, PASSWORD, centre_program, make_keys, wait, write_list};

#[test]
fn strangers_are_refused_with_and_without_certificates_and_passwords() {
    let house = House::open(&["s-1", "stranger"], &["s-1"]);
    let file = house.file("recording");
    recording(&file);
    // A certificate of the authority that is not on the list connects, and has no rights.
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
    // A certificate of another authority does not connect at all.
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
    // The page speaks TLS only.
    let mut plain = TcpStream::connect(&house.centre.page).expect("the page is there");
    plain
        .write_all(b"GET /login HTTP/1.0\r\n\r\n")
        .expect("sent");
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(
        !String::from_utf8_lossy(&answer).contains("HTTP"),
        "{answer:?}"
    );
    // Without a login the page shows nothing. After some tries, a wrong password has to wait.
    let authority = house.file("ca.pem");
    let ask = |head: &str| request(&house.centre, &authority, head, "");
    assert!(ask("GET /api/people HTTP/1.1").starts_with("HTTP/1.1 401"));
    assert!(ask("GET / HTTP/1.1").contains("location: /login"));
    assert!(ask("GET /live HTTP/1.1").starts_with("HTTP/1.1 401"));
    let foreign = "POST /logout HTTP/1.1\r\nOrigin: https://evil.example";
    assert!(ask(foreign).starts_with("HTTP/1.1 403"));
    let mut wrong = 0;
    loop {
        let (cookie, answer) = login(&house.centre, &authority, "wrong horse");
        assert!(cookie.is_none(), "{answer}");
        if answer.contains("/login?wait") {
            break;
        }
        assert!(answer.contains("/login?wrong"), "{answer}");
        wrong += 1;
    }
    assert!(wrong >= 5, "{wrong} tries");
    let (cookie, _) = login(&house.centre, &authority, PASSWORD);
    assert!(cookie.is_none(), "it has to wait, too");
    assert_eq!(house.centre.logged("refused").len(), wrong);
    let log = std::fs::read_to_string(house.file("log")).expect("a log");
    assert!(!log.contains("horse"));
}

#[test]
fn a_station_is_neither_heard_nor_told_beyond_its_own_name() {
    let house = House::open(&["s-1", "s-2"], &["s-1", "s-2"]);
    let file = house.file("recording");
    recording(&file);
    let said = house.file("impostor");
    let mut impostor = Command::new(example("impostor"));
    impostor
        .arg(&house.centre.stations)
        .arg(house.file("keys/s-2"))
        .arg("s-1");
    let told = std::fs::File::create(&said).expect("a file");
    let _impostor = Killed(impostor.stdout(told).spawn().expect("an impostor"));
    let spoke = |times: usize| {
        wait("it spoke", || {
            let said = std::fs::read_to_string(&said).expect("its output");
            (said.matches("spoke").count() >= times).then_some(said)
        })
    };
    spoke(2);
    let mut page = house.page();
    wait("its own name is heard", || {
        page.look();
        let own = page.stations.get("s-2")?;
        (own["state"]["trainee"] == "impostor").then_some(())
    });
    let other = &page.stations["s-1"];
    assert!(
        other["state"].is_null() && other["present"] == false,
        "{other}"
    );
    // Nor does it receive messages of the other station, or requests to the other station.
    let mut station = house.rehearse(&file, &["s-1"]);
    let _station = Killed(station.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    page.ask(&json!({"enlarge": "s-1"}));
    wait("pictures of the other one", || {
        page.look();
        let large = ('v', "s-1".to_owned());
        page.pictures
            .get(&large)
            .is_some_and(|it| *it > 3)
            .then_some(())
    });
    let before = spoke(0).matches("spoke").count();
    let said = spoke(before + 2);
    let heard: BTreeSet<&str> = said.lines().filter(|it| it.contains("heard")).collect();
    let is_own = |it: &&str| it.starts_with("heard calot/s-2/");
    assert!(!heard.is_empty() && heard.iter().all(is_own), "{heard:?}");
    assert_eq!(page.stations["s-1"]["state"]["trainee"], "trainee 0");
}

/// Program of `examples`, which cargo builds for the tests.
fn example(name: &str) -> PathBuf {
    let own = Path::new(env!("CARGO_BIN_EXE_calot-centre"));
    let program = own.with_file_name("examples").join(name);
    assert!(
        program.is_file(),
        "build {} first: cargo build --examples",
        program.display()
    );
    program
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
