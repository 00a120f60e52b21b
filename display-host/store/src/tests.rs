//! Tests of the whole store.

mod forgotten;
mod inbox;
mod migration;
mod names;
mod outbox;
mod reading;
mod sheets;

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::time::Duration;

use proptest::prelude::*;
use rusqlite::Connection;

use crate::*;

fn folder() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("people/store.sqlite");
    (folder, path)
}

fn session(began_unix_s: i64, task: &str, score: f64) -> SessionRecord {
    SessionRecord {
        id: new_id(),
        began_unix_s,
        task: task.to_owned(),
        difficulty: "exam".to_owned(),
        outcome: "passed".to_owned(),
        score,
        alarms: 1,
        metrics_version: 1,
        metrics: [("time_s".to_owned(), 12.5)].into(),
        scene: "triangle".to_owned(),
        program: "a test".to_owned(),
        file: Some("monday/session.mcap".to_owned()),
        hand: Hand::Person,
        circumstances: Circumstances::default(),
    }
}

#[test]
fn the_last_trainee_is_that_of_the_newest_session() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store
        .answer("Zoe", &Questionnaire::default(), &[3; 14], 900)
        .unwrap();
    assert_eq!(store.last_trainee().unwrap(), None);
    for (name, began_unix_s) in [("Ada", 100), ("Bo", 300), ("Ada", 200)] {
        let session = session(began_unix_s, "cut", 40.0);
        store.add_session(name, &session).unwrap();
    }
    assert_eq!(store.last_trainee().unwrap().as_deref(), Some("Bo"));
}

#[test]
fn a_scripted_session_stays_marked_through_merge_and_export() {
    let (_folder, path) = folder();
    let (_other, other) = folder();
    let mut store = Store::open(&path).unwrap();
    let scripted = SessionRecord {
        hand: Hand::Scripted,
        ..session(100, "cut", 90.0)
    };
    store.add_session("Ada", &scripted).unwrap();
    store
        .add_session("Ada", &session(200, "cut", 40.0))
        .unwrap();
    let hands = |store: &Store| {
        let all = store.sessions("Ada", None).unwrap();
        all.iter().map(|it| it.hand).collect::<Vec<_>>()
    };
    assert_eq!(hands(&store), [Hand::Scripted, Hand::Person]);
    let csv = store.export_csv(None, &[]).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].contains("scene,hand,"));
    assert!(lines[1].contains("triangle,scripted,") && lines[2].contains("triangle,person,"));
    let mut other = Store::open(&other).unwrap();
    assert_eq!(other.merge(&path).unwrap().sessions, 2);
    assert_eq!(hands(&other), [Hand::Scripted, Hand::Person]);
    // A session that is added again as a person's counts as a person's.
    let again = SessionRecord {
        hand: Hand::Person,
        ..scripted
    };
    other.add_session("Ada", &again).unwrap();
    assert_eq!(hands(&other), [Hand::Person; 2]);
}

fn mode(path: &Path) -> u32 {
    std::fs::metadata(path).unwrap().permissions().mode() & 0o777
}

#[test]
fn a_recorded_session_is_added_once_and_is_nobody_elses_after() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let kept = session(100, "cut", 40.0);
    assert!(store.add_recorded(" Ada ", &kept).unwrap());
    store.set_sheet(&kept.id, "", [1, 2, 3, 4, 5]).unwrap();
    // Another recording claims the same id with a better score.
    let forged = SessionRecord {
        score: 100.0,
        ..kept.clone()
    };
    assert!(!store.add_recorded("Ada", &forged).unwrap());
    let error = store.add_recorded("Bo", &forged).unwrap_err();
    assert!(matches!(error, StoreError::Taken { .. }), "{error}");
    let found = store.sessions("Ada", None).unwrap();
    assert_eq!(found, std::slice::from_ref(&kept));
    assert!(!store.sheet(&kept.id).unwrap().is_empty());
    let mut bad = session(1, "cut", 1.0);
    bad.program = "\u{1b}[31mred".to_owned();
    assert!(store.add_recorded("Bo", &bad).is_err());
    let bad = SessionRecord {
        id: String::new(),
        ..kept
    };
    assert!(store.add_recorded("Bo", &bad).is_err());
    assert_eq!(store.trainees().unwrap().len(), 1, "Bo has no session");
}

#[test]
fn kept_sessions_come_back_in_order_and_only_their_user_reads_them() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let later = session(200, "cut", 60.0);
    let earlier = session(100, "cut", 40.0);
    let other = session(150, "clamp", 90.0);
    for it in [&later, &earlier, &other] {
        store.add_session("Ada", it).unwrap();
    }
    store.add_session("Bo", &session(1, "cut", 1.0)).unwrap();
    drop(store);
    assert_eq!((mode(&path), mode(path.parent().unwrap())), (0o600, 0o700));
    // A copied file that others can read becomes private.
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o644)).unwrap();
    let store = Store::open(&path).unwrap();
    assert_eq!(mode(&path), 0o600);
    assert_eq!(
        store.sessions("Ada", Some("cut")).unwrap(),
        [earlier, later]
    );
    assert_eq!(store.sessions("Ada", None).unwrap().len(), 3);
    let people = store.trainees().unwrap();
    let names: Vec<_> = people
        .iter()
        .map(|it| (it.name.as_str(), it.sessions))
        .collect();
    assert_eq!(names, [("Ada", 3), ("Bo", 1)]);
    let error = store.sessions("Cy", None).unwrap_err().to_string();
    assert!(
        error.contains("'Cy'") && error.contains("store list"),
        "{error}"
    );
}

#[test]
fn forgotten_trainee_leaves_no_trace_in_the_file() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let name = "Zaphod Beeblebrox";
    let it = session(1, "cut", 1.0);
    store.add_session(name, &it).unwrap();
    store.add_session("Ada", &session(2, "cut", 2.0)).unwrap();
    store.set_sheet(&it.id, "", [1, 2, 3, 4, 5]).unwrap();
    let questions = Questionnaire::default();
    store.answer(name, &questions, &[3; 14], 5).unwrap();
    let gone = store.forget(name, 1_000_000).unwrap();
    assert!(gone.loose.is_none());
    let files = gone.files;
    assert_eq!(files, ["monday/session.mcap"]);
    assert!(store.forget(name, 1_000_000).is_err());
    assert!(store.sheet(&it.id).unwrap().is_empty());
    assert_eq!(store.summarise(&questions).unwrap()[0].count, 0);
    drop(store);
    let bytes = std::fs::read(&path).unwrap();
    let there = |text: &str| bytes.windows(text.len()).any(|it| it == text.as_bytes());
    assert!(!there(name) && !there(&it.id) && there("Ada"));
    let beside = std::fs::read_dir(path.parent().unwrap()).unwrap().count();
    assert_eq!(beside, 1, "no journal is left");
}

#[test]
fn export_has_all_of_somebody_and_nothing_of_others() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(1, "cut", 1.0);
    store.add_session("=cmd, \"x\"", &it).unwrap();
    store.add_session("Bo", &session(2, "clamp", 2.0)).unwrap();
    store.set_sheet(&it.id, "", [1, 2, 3, 4, 5]).unwrap();
    store
        .answer("Bo", &Questionnaire::default(), &[4; 14], 5)
        .unwrap();
    let all = store.export_json(None).unwrap();
    assert_eq!(all["trainees"].as_array().unwrap().len(), 2);
    let sheet = &all["trainees"][0]["sessions"][0]["sheet"];
    assert_eq!(sheet["Autonomy"], 5, "{all:#}");
    let bo = store.export_json(Some("Bo")).unwrap().to_string();
    assert!(bo.contains("force-quality") && !bo.contains("cmd"), "{bo}");
    let csv = store.export_csv(None, &["time_s", "alarms"]).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 3);
    assert!(csv.ends_with('\n') && !csv.contains('\r'), "{csv:?}");
    assert!(
        lines[0].ends_with(",time_s,metric_alarms,other_metrics"),
        "{csv}"
    );
    assert!(lines[1].starts_with("\"'=cmd, \"\"x\"\"\","), "{csv}");
    assert!(!store.export_csv(Some("Bo"), &[]).unwrap().contains("cmd"));
    assert!(store.export_csv(Some("Cy"), &[]).is_err());
}

#[test]
fn the_sheet_takes_one_to_five_of_a_known_session() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(1, "cut", 1.0);
    store.add_session("Ada", &it).unwrap();
    assert!(store.sheet(&it.id).unwrap().is_empty());
    store.set_sheet(&it.id, "", [5, 4, 3, 2, 1]).unwrap();
    store.set_sheet(&it.id, "", [5, 4, 3, 2, 2]).unwrap();
    let sheet = store.sheet(&it.id).unwrap();
    assert_eq!(sheet.len(), 5);
    assert_eq!(sheet[4], ("Autonomy".to_owned(), 2));
    let error = store.set_sheet(&it.id, "", [0, 4, 3, 2, 1]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("Depth perception is 0; allowed is 1 to 5")
    );
    assert!(store.set_sheet("nothing", "", [1; 5]).is_err());
}

#[test]
fn answers_are_summarised_beside_the_papers() {
    let questions = Questionnaire::default();
    assert_eq!(questions.items.len(), 14);
    assert!(
        questions
            .items
            .iter()
            .all(|it| it.paper_mean.is_some() && it.paper_sd.is_some())
    );
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    assert_eq!(store.summarise(&questions).unwrap()[3].mean, None);
    store.answer("Ada", &questions, &[2; 14], 1).unwrap();
    assert_eq!(store.summarise(&questions).unwrap()[3].sd, None);
    store.answer("Bo", &questions, &[4; 14], 2).unwrap();
    // The newer answer counts.
    store.answer("Ada", &questions, &[3; 14], 3).unwrap();
    let summary = store.summarise(&questions).unwrap();
    assert_eq!((summary[7].count, summary[7].mean), (2, Some(3.5)));
    assert!((summary[7].sd.unwrap() - 0.5f64.sqrt()).abs() < 1e-12);
    assert_eq!(summary[7].paper, Some([2.3, 0.82]));
    assert!(store.answer("Bo", &questions, &[4; 13], 2).is_err());
    assert!(store.answer("Bo", &questions, &[6; 14], 2).is_err());
    // What does not apply has no answer, and takes an earlier one away.
    let mut answers = [4; 14];
    answers[7] = NOT_APPLICABLE;
    store.answer("Bo", &questions, &answers, 4).unwrap();
    let summary = store.summarise(&questions).unwrap();
    assert_eq!((summary[6].count, summary[7].count), (2, 1));
    assert_eq!(summary[7].mean, Some(3.0));
}

#[test]
fn questionnaires_are_checked() {
    let item = "[[item]]\nid = 'a'\ntext = 'b'\n";
    let good = format!("name = 'x'\ntitle = 'y'\n{item}");
    assert_eq!(Questionnaire::parse(&good).unwrap().items.len(), 1);
    for (bad, why) in [
        (format!("{good}{item}"), "two items"),
        ("name = 'x'\ntitle = 'y'\nitem = []".to_owned(), "0 items"),
        (format!("{good}paper_mean = nan"), "allowed is 0 to 5"),
        (good.replace("'b'", "''"), "0 characters"),
        (good.replace("title", "titel"), "titel"),
    ] {
        let error = Questionnaire::parse(&bad).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn foreign_files_other_versions_and_damage_are_refused_and_left_alone() {
    let (_folder, path) = folder();
    drop(Store::open(&path).unwrap());
    let refused = |what: &str| {
        let before = std::fs::read(&path).unwrap();
        let error = Store::open(&path).unwrap_err().to_string();
        assert!(
            error.contains(what) && error.contains("left as it is"),
            "{error}"
        );
        assert_eq!(std::fs::read(&path).unwrap(), before);
    };
    for version in [0, SCHEMA_VERSION + 1] {
        let connection = Connection::open(&path).unwrap();
        connection
            .pragma_update(None, "user_version", version)
            .unwrap();
        drop(connection);
        refused(&format!("version {version}"));
    }
    std::fs::remove_file(&path).unwrap();
    let connection = Connection::open(&path).unwrap();
    connection.execute_batch("CREATE TABLE theirs (x)").unwrap();
    drop(connection);
    refused("not a store of Calot");
    std::fs::write(&path, "a text").unwrap();
    refused("not a store of Calot");
}

#[test]
fn names_are_short_and_printable() {
    for good in ["Ada", "Ö", "a b", &"x".repeat(64)] {
        check_name(good).unwrap();
    }
    for bad in ["", " ", "a\nb", "\u{1b}[31m", &"x".repeat(65)] {
        assert!(check_name(bad).is_err(), "{bad:?}");
    }
}

#[test]
fn names_that_look_alike_are_one_or_refused_with_the_reason() {
    assert_eq!(check_name("  Ada\t").unwrap(), "Ada");
    for (bad, which) in [
        ("Ada\u{202e}", "U+202E"),
        ("A\u{200b}da", "U+200B"),
        ("\u{feff}Ada", "U+FEFF"),
    ] {
        let error = check_name(bad).unwrap_err().to_string();
        assert!(
            error.contains(which) && error.contains("look alike"),
            "{error}"
        );
    }
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store.add_session("Ada ", &session(1, "cut", 1.0)).unwrap();
    store.add_session(" Ada", &session(2, "cut", 1.0)).unwrap();
    assert_eq!(store.trainees().unwrap().len(), 1);
    assert_eq!(store.sessions("Ada", None).unwrap().len(), 2);
    store.forget(" Ada ", 1_000_000).unwrap();
    assert!(store.trainees().unwrap().is_empty());
}

#[test]
fn a_store_that_another_program_writes_is_busy_and_not_damaged() {
    let (_folder, path) = folder();
    drop(Store::open(&path).unwrap());
    let other = Connection::open(&path).unwrap();
    other.execute_batch("BEGIN EXCLUSIVE").unwrap();
    let error = Store::open_within(&path, Duration::from_millis(10)).unwrap_err();
    assert!(matches!(error, StoreError::Busy { .. }), "{error}");
    let error = error.to_string();
    assert!(
        error.contains("try again") || error.contains("Try again"),
        "{error}"
    );
    assert!(!error.contains("move"), "{error}");
    other.execute_batch("COMMIT").unwrap();
    Store::open(&path).unwrap();
}

#[test]
fn forgotten_trainee_is_in_no_log_beside_the_store() {
    let (_folder, path) = folder();
    drop(Store::open(&path).unwrap());
    let other = Connection::open(&path).unwrap();
    other
        .execute_batch(&format!(
            "PRAGMA journal_mode = WAL; PRAGMA user_version = {SCHEMA_VERSION}"
        ))
        .unwrap();
    let mut store = Store::open_within(&path, Duration::from_millis(10)).unwrap();
    let name = "Zaphod Beeblebrox";
    store.add_session(name, &session(1, "cut", 1.0)).unwrap();
    let error = store.forget(name, 1_000_000).unwrap_err();
    assert!(matches!(error, StoreError::Log { .. }), "{error}");
    assert!(
        error.to_string().contains("Nobody was forgotten"),
        "{error}"
    );
    assert_eq!(store.sessions(name, None).unwrap().len(), 1);
    drop(other);
    store.forget(name, 1_000_000).unwrap();
    let beside = std::fs::read_dir(path.parent().unwrap()).unwrap();
    for file in beside {
        let file = file.unwrap().path();
        let bytes = std::fs::read(&file).unwrap();
        let there = bytes.windows(name.len()).any(|it| it == name.as_bytes());
        assert!(!there, "{}", file.display());
    }
}

#[test]
fn columns_have_names_of_their_own() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let mut it = session(1, "cut", 1.0);
    it.metrics.insert("alarms".to_owned(), 1.0);
    store.add_session("Ada", &it).unwrap();
    let csv = store.export_csv(None, &["time_s", "alarms"]).unwrap();
    let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let names: std::collections::BTreeSet<_> = header.iter().collect();
    assert_eq!(names.len(), header.len(), "{csv}");
    assert!(header.contains(&"metric_alarms"), "{csv}");
}

#[test]
fn a_questionnaire_without_end_is_refused() {
    let error = Questionnaire::read(Path::new("/dev/zero")).unwrap_err();
    assert!(error.to_string().contains("65536 bytes"), "{error}");
    let error = Questionnaire::read(Path::new("/nowhere/a.toml")).unwrap_err();
    assert!(error.to_string().contains("/nowhere/a.toml"), "{error}");
}

#[test]
fn ids_differ_and_sort_by_time() {
    let ids: Vec<String> = (0..100).map(|_| new_id()).collect();
    let mut sorted = ids.clone();
    sorted.sort();
    sorted.dedup();
    assert_eq!(sorted, ids);
    assert!(
        ids.iter()
            .all(|id| id.len() == 36 && id.as_bytes()[14] == b'7')
    );
}

/// A store in which each of `people` has one session.
fn station(path: &Path, people: &[&str]) -> Store {
    let mut store = Store::open(path).unwrap();
    for (name, at) in people.iter().zip(100..) {
        let it = session(at, "cut", 50.0);
        store.add_session(name, &it).unwrap();
        store.set_sheet(&it.id, "", [1, 2, 3, 4, 5]).unwrap();
    }
    store
}

#[test]
fn stores_of_several_stations_become_one() {
    let (folder, centre) = folder();
    let other = |name: &str| folder.path().join(name);
    let mut first = station(&other("first.sqlite"), &["Ada", "Bo", "Ada"]);
    let mut second = station(&other("second.sqlite"), &["Ada", "Cy"]);
    let questions = Questionnaire::default();
    let (old, new) = (
        vec![2; questions.items.len()],
        vec![5; questions.items.len()],
    );
    first.answer("Ada", &questions, &old, 1000).unwrap();
    second.answer("Ada", &questions, &new, 2000).unwrap();
    drop((first, second));
    let before = std::fs::read(other("second.sqlite")).unwrap();

    let mut store = Store::open(&centre).unwrap();
    let merged = store.merge(&other("second.sqlite")).unwrap();
    assert_eq!(
        (merged.sessions, merged.trainees, merged.points),
        (2, 2, 10)
    );
    let merged = store.merge(&other("first.sqlite")).unwrap();
    assert_eq!(
        (merged.sessions, merged.trainees, merged.answers),
        (3, 1, 0)
    );
    let whole = store.export_json(None).unwrap();
    for name in ["first.sqlite", "second.sqlite"] {
        let merged = store.merge(&other(name)).unwrap();
        let nothing = Merged {
            known: merged.known,
            ..Merged::default()
        };
        assert!(merged == nothing && merged.known >= 2, "{merged:?}");
    }
    assert_eq!(store.export_json(None).unwrap(), whole, "a second merge");
    assert_eq!(store.sessions("Ada", None).unwrap().len(), 3);
    let answers = &whole["trainees"][0]["answers"];
    assert_eq!(answers[0]["value"], 5, "the newer answer is kept");
    assert_eq!(std::fs::read(other("second.sqlite")).unwrap(), before);

    // The example query of a training centre.
    let mut statement = store.connection.prepare(EXAMPLE_SQL).unwrap();
    let rows = statement.query_map([], |row| {
        Ok((row.get(0)?, row.get(2)?, row.get(3)?, row.get(4)?))
    });
    let rows: Vec<(String, i64, f64, f64)> = rows.unwrap().map(Result::unwrap).collect();
    let row = |name: &str, count| (name.to_owned(), count, 50.0, 12.5);
    assert_eq!(rows, [row("Ada", 3), row("Bo", 1), row("Cy", 1)]);
}

#[test]
fn a_session_that_differs_stays_as_it_is_here() {
    let (folder, centre) = folder();
    let other = folder.path().join("other.sqlite");
    let mut theirs = Store::open(&other).unwrap();
    let mut it = session(1, "cut", 10.0);
    theirs.add_session("Ada", &it).unwrap();
    it.score = 99.0;
    let mut store = Store::open(&centre).unwrap();
    store.add_session("Ada", &it).unwrap();
    let merged = store.merge(&other).unwrap();
    assert_eq!((merged.sessions, merged.known, merged.differing), (0, 1, 1));
    assert_eq!(store.sessions("Ada", None).unwrap(), [it]);
}

#[test]
fn sheets_of_a_session_with_another_owner_stay_out() {
    let (folder, centre) = folder();
    let other = folder.path().join("other.sqlite");
    let (shared, own) = (session(1, "cut", 10.0), session(2, "cut", 10.0));
    let mut theirs = Store::open(&other).unwrap();
    for it in [&shared, &own] {
        theirs.add_session("Bo", it).unwrap();
        theirs.set_sheet(&it.id, "", [1; 5]).unwrap();
    }
    let mut store = Store::open(&centre).unwrap();
    store.add_session("Ada", &shared).unwrap();
    let merged = store.merge(&other).unwrap();
    assert_eq!((merged.known, merged.differing, merged.points), (1, 1, 5));
    let owner = OtherOwner {
        session: shared.id.clone(),
        here: "Ada".to_owned(),
        there: "Bo".to_owned(),
    };
    assert_eq!(merged.other_owners, [owner]);
    assert!(store.ratings(&shared.id).unwrap().is_empty());
    assert_eq!(store.ratings(&own.id).unwrap().len(), 1);
    assert_eq!(store.sessions("Ada", None).unwrap(), [shared]);
}

#[test]
fn a_store_is_not_merged_into_itself() {
    let (folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let link = folder.path().join("link.sqlite");
    std::os::unix::fs::symlink(&path, &link).unwrap();
    for other in [&path, &link] {
        let merged = store.merge(other).unwrap_err();
        assert!(matches!(merged, StoreError::SameFile { .. }), "{merged}");
        let refused = Store::can_merge(&path, other).unwrap_err().to_string();
        assert!(refused.contains("the same file"), "{refused}");
        assert!(refused.contains(other.to_str().unwrap()), "{refused}");
    }
}

#[test]
fn store_that_cannot_be_merged_changes_nothing() {
    let (folder, centre) = folder();
    let mut store = Store::open(&centre).unwrap();
    let path = folder.path().join("other.sqlite");
    assert!(matches!(
        store.merge(&path),
        Err(StoreError::Missing { .. })
    ));
    std::fs::write(&path, "no database").unwrap();
    assert!(store.merge(&path).is_err());
    let broken = [
        "UPDATE session SET id = 'mine' WHERE rowid = 2",
        "UPDATE session SET metrics = '{\"a\":\"b\"}' WHERE rowid = 2",
        "UPDATE trainee SET name = 'A' || char(8238) WHERE id = 2",
        "PRAGMA user_version = 99",
        "DROP TABLE answer",
    ];
    for change in broken {
        std::fs::remove_file(&path).unwrap();
        let other = station(&path, &["Ada", "Bo", "Cy"]);
        let off = "PRAGMA foreign_keys = OFF;";
        other.connection.execute_batch(off).unwrap();
        other.connection.execute_batch(change).unwrap();
        drop(other);
        assert!(store.merge(&path).is_err(), "{change}");
        assert!(store.trainees().unwrap().is_empty(), "{change}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Any damage: the store is read or refused without a panic. A refused merge adds nothing.
    #[test]
    fn a_damaged_store_is_read_or_refused(
        flips in prop::collection::vec((0.0f64..1.0, any::<u8>()), 1..40), cut in 0.0f64..2.0,
    ) {
        let (_folder, path) = folder();
        let mut store = Store::open(&path).unwrap();
        for number in 0..6 {
            store.add_session("Ada", &session(number, "cut", 1.0)).unwrap();
        }
        drop(store);
        let mut bytes = std::fs::read(&path).unwrap();
        for (share, value) in flips {
            let at = (share * bytes.len() as f64) as usize;
            bytes[at] = value;
        }
        if cut < 1.0 {
            bytes.truncate((cut * bytes.len() as f64) as usize);
        }
        std::fs::write(&path, &bytes).unwrap();
        let mut whole = Store::open(&path.with_extension("whole")).unwrap();
        if whole.merge(&path).is_err() {
            prop_assert!(whole.trainees().unwrap().is_empty());
        }
        if let Ok(store) = Store::open(&path) {
            let _ = store.trainees();
            let _ = store.export_json(None);
            let _ = store.export_csv(None, &["time_s", "alarms"]);
        }
    }

    #[test]
    fn any_name_is_kept_as_it_is_or_refused(name in "\\PC{0,70}") {
        let (_folder, path) = folder();
        let mut store = Store::open(&path).unwrap();
        let added = store.add_session(&name, &session(1, "cut", 1.0));
        prop_assert_eq!(added.is_ok(), check_name(&name).is_ok());
        if added.is_ok() {
            prop_assert_eq!(store.sessions(&name, None).unwrap().len(), 1);
        }
    }
}
