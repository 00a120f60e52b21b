//! Questions that a person answers at a terminal.

use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use assess::{Difficulty, Task};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use store::{Circumstances, Hand, SessionRecord, Store};
use system_tests::{Program, calot, said};

/// A store with one session.
fn store(path: &Path) -> String {
    let session = SessionRecord {
        id: store::new_id(),
        began_unix_s: 1_790_000_000,
        task: Task::Cut.name().to_owned(),
        difficulty: Difficulty::Exam.name().to_owned(),
        outcome: "passed".to_owned(),
        score: 80.0,
        alarms: 0,
        metrics_version: 1,
        metrics: [("time_s".to_owned(), 60.0)].into_iter().collect(),
        scene: "triangle".to_owned(),
        program: "a test".to_owned(),
        file: None,
        hand: Hand::Person,
        circumstances: Circumstances::default(),
    };
    let mut store = Store::open(path).expect("a store");
    store.add_session("Ada", &session).expect("it is added");
    session.id
}

/// Fills a sheet. `typed` is what the person types; without it there is no terminal.
fn fill(store: &Path, id: &str, rater: &str, typed: Option<&str>) -> Output {
    let mut command = calot();
    command.args(["store", "--store"]).arg(store);
    command.args(["sheet", id, "--rater", rater, "3", "3", "4", "4", "5"]);
    let Some(typed) = typed else {
        return Program::start(command.stdin(Stdio::null())).finish();
    };
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&terminal).expect("granted");
    unlockpt(&terminal).expect("unlocked");
    let name = ptsname(&terminal, Vec::new()).expect("a name");
    let name = name.to_str().expect("a path");
    let mut options = std::fs::File::options();
    let keyboard = options.read(true).write(true).open(name);
    command.stdin(Stdio::from(keyboard.expect("it opens")));
    let program = Program::start(&mut command);
    // The terminal keeps what is typed before it is read.
    let mut hand = std::fs::File::from(terminal);
    hand.write_all(typed.as_bytes()).expect("typed");
    let output = program.finish();
    drop(hand);
    output
}

fn raters(path: &Path, id: &str) -> Vec<String> {
    let store = Store::read(path).expect("the store");
    let sheets = store.ratings(id).expect("its sheets");
    sheets.into_iter().map(|it| it.rater).collect()
}

#[test]
fn a_rater_whose_name_looks_like_anothers_is_questioned_at_a_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("store.sqlite");
    let id = store(&path);
    let first = fill(&path, &id, "Grace", None);
    assert!(first.status.success(), "{}", said(&first));
    let question = "the rater 'grace' looks like the rater 'Grace' of the store";
    // Refused: by the answer, by none, by the end of the input (Ctrl-D), and without a terminal.
    for (typed, is_asked) in [
        (Some("n\n"), true),
        (Some("\n"), true),
        (Some("\u{4}"), true),
        (None, false),
    ] {
        let refused = fill(&path, &id, "grace", typed);
        let words = said(&refused);
        assert_eq!(refused.status.code(), Some(1), "{typed:?}: {words}");
        let asked = format!("{question}. Is it another person? [y/N]");
        assert_eq!(words.contains(&asked), is_asked, "{typed:?}: {words}");
        let refusal = format!("{question}. Use that name, or add --new-rater");
        assert!(words.contains(&refusal), "{typed:?}: {words}");
        assert_eq!(raters(&path, &id), ["Grace"]);
    }
    let other = fill(&path, &id, "grace", Some("y\n"));
    assert!(other.status.success(), "{}", said(&other));
    assert_eq!(raters(&path, &id), ["Grace", "grace"]);
    // A known name is not questioned.
    let known = said(&fill(&path, &id, "Grace", Some("n\n")));
    assert!(!known.contains("another person"), "{known}");
}
