//! Deliveries to a real server of PostgreSQL, and to a record store that checks every rule.

mod database;
mod forgotten;
mod records;
mod silent;
mod unusual;

use std::path::{Path, PathBuf};
use std::process::Command;

use deliver::{Destination, Pushed, push};
use store::{Circumstances, Hand, SessionRecord, Store, new_id};
use system_tests::lrs::Lrs;
use system_tests::postgres::{OWNER, PASSWORD, Postgres};

/// A store in a folder that is deleted with it.
struct Station {
    _folder: tempfile::TempDir,
    path: PathBuf,
    store: Store,
}

impl Station {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        let store = Store::open(&path).expect("a store");
        Self {
            _folder: folder,
            path,
            store,
        }
    }

    /// Keeps a session of a trainee and returns its id.
    fn keep(&mut self, name: &str, session: &SessionRecord) -> String {
        self.store.add_session(name, session).expect("kept");
        session.id.clone()
    }

    /// Keeps a number of sessions of Ada.
    fn keep_many(&mut self, count: i64) {
        for number in 0..count {
            self.keep("Ada", &session(1000 + number));
        }
    }

    fn push(&mut self, to: &Destination) -> Pushed {
        push(&mut self.store, to).expect("the store works")
    }

    /// A push that has to succeed.
    fn push_all(&mut self, to: &Destination) -> Pushed {
        let pushed = self.push(to);
        assert_eq!((&pushed.problem, pushed.waiting), (&None, 0), "{pushed:?}");
        pushed
    }

    /// Loses every note, as if the program had died after each delivery.
    fn lose_notes(&self) {
        let other = rusqlite::Connection::open(&self.path).expect("a file");
        let lost = "DELETE FROM delivery";
        other.execute(lost, []).expect("notes are lost");
    }
}

fn session(began_unix_s: i64) -> SessionRecord {
    SessionRecord {
        id: new_id(),
        began_unix_s,
        task: "clamp".to_owned(),
        difficulty: "exam".to_owned(),
        outcome: "passed".to_owned(),
        score: 81.5,
        alarms: 2,
        metrics_version: 3,
        metrics: [("time_s".to_owned(), 13.591_027_285_000_017)].into(),
        scene: "triangle".to_owned(),
        program: "a test".to_owned(),
        file: Some("/home/ada/session.mcap".to_owned()),
        hand: Hand::Person,
        circumstances: Circumstances {
            realtime: Some(true),
            site: "theatre-1".to_owned(),
            ..Circumstances::default()
        },
    }
}

fn none(_: &str) -> Option<String> {
    None
}

fn password(name: &str) -> Option<String> {
    (name == "PGPASSWORD").then(|| PASSWORD.to_owned())
}

fn key(name: &str) -> Option<String> {
    match name {
        "CALOT_LRS_USER" => Some("station".to_owned()),
        _ => Some("s3cret".to_owned()),
    }
}

/// The database as its owner sees it.
fn owners(server: &Postgres) -> Destination {
    Destination::shown(&server.address(OWNER), None, &password).expect("an address")
}

/// A record store without encryption, and its address.
fn records() -> (Lrs, Destination) {
    let lrs = Lrs::start(Some);
    let address = format!("http://127.0.0.1:{}/xapi", lrs.port());
    let to = Destination::shown(&address, None, &key).expect("an address");
    (lrs, to)
}

/// An authority, and a certificate of this computer that it signed: `ca.pem`, `server.pem` and
/// `server.key` in the folder.
fn make_keys(folder: &Path) {
    let script = "set -e
        openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout ca.key -out ca.pem -days 2 \
            -subj /CN=authority -addext basicConstraints=critical,CA:TRUE
        openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout server.key -out server.csr -subj /CN=centre
        echo 'subjectAltName=IP:127.0.0.1' > extensions
        openssl x509 -req -in server.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out server.pem -days 2 \
            -extfile extensions";
    let made = Command::new("sh")
        .args(["-c", script])
        .current_dir(folder)
        .output();
    let made = made.expect("a shell");
    let said = String::from_utf8_lossy(&made.stderr);
    assert!(made.status.success(), "{said}");
}
