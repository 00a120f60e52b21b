//! Stores of older versions. Those of version 1 are made with the SQL of that version.

use rusqlite::{Connection, params};

use super::*;

/// Tables of version 1, as its program made them.
const FIRST: &str = "
CREATE TABLE trainee (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE) STRICT;
CREATE TABLE session (
    id TEXT PRIMARY KEY,
    trainee INTEGER NOT NULL REFERENCES trainee ON DELETE CASCADE,
    began_unix_s INTEGER NOT NULL,
    task TEXT NOT NULL,
    difficulty TEXT NOT NULL,
    outcome TEXT NOT NULL,
    score REAL NOT NULL,
    alarms INTEGER NOT NULL,
    metrics_version INTEGER NOT NULL,
    metrics TEXT NOT NULL,
    scene TEXT NOT NULL,
    program TEXT NOT NULL,
    file TEXT
) STRICT;
CREATE INDEX session_of ON session (trainee, began_unix_s);
CREATE TABLE answer (
    trainee INTEGER NOT NULL REFERENCES trainee ON DELETE CASCADE,
    questionnaire TEXT NOT NULL,
    item TEXT NOT NULL,
    value INTEGER NOT NULL CHECK (value BETWEEN 1 AND 5),
    at_unix_s INTEGER NOT NULL,
    PRIMARY KEY (trainee, questionnaire, item)
) STRICT;
CREATE TABLE sheet (
    session TEXT NOT NULL REFERENCES session ON DELETE CASCADE,
    item TEXT NOT NULL,
    value INTEGER NOT NULL CHECK (value BETWEEN 1 AND 5),
    PRIMARY KEY (session, item)
) STRICT;
PRAGMA application_id = 1130458223;
PRAGMA user_version = 1;
";

/// The table that came later in version 1.
const SCRIPTED: &str = "CREATE TABLE scripted (
    session TEXT PRIMARY KEY REFERENCES session ON DELETE CASCADE
) STRICT;";

/// Makes a store of version 1 with two sessions of 'Ame\u{301}lie', of which the second was
/// scripted if there is a table for that. Returns their ids.
fn first(path: &Path, has_scripted: bool) -> [String; 2] {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let made = Connection::open(path).unwrap();
    made.execute_batch(FIRST).unwrap();
    made.execute(
        "INSERT INTO trainee (id, name) VALUES (1, ?1), (2, 'Bo')",
        ["Ame\u{301}lie"],
    )
    .unwrap();
    let ids = [new_id(), new_id()];
    for (id, at) in ids.iter().zip([100, 200]) {
        made.execute(
            "INSERT INTO session VALUES (?1, 1, ?2, 'cut', 'exam', 'passed', 81.5, 2, 3, \
             '{\"time_s\":13.591027285000017}', 'triangle', 'old', '/there')",
            params![id, at],
        )
        .unwrap();
    }
    for (item, value) in [("depth", 4), ("hands", 2)] {
        made.execute(
            "INSERT INTO sheet VALUES (?1, ?2, ?3)",
            params![ids[0], item, value],
        )
        .unwrap();
    }
    made.execute("INSERT INTO answer VALUES (2, 'q', 'i', 3, 50)", [])
        .unwrap();
    if has_scripted {
        made.execute_batch(SCRIPTED).unwrap();
        made.execute("INSERT INTO scripted VALUES (?1)", [&ids[1]])
            .unwrap();
    }
    ids
}

/// Checks that everything of [`first`] is there.
fn check(store: &Store, ids: &[String; 2], has_scripted: bool) {
    let sessions = store.sessions("Am\u{e9}lie", None).unwrap();
    assert_eq!([&sessions[0].id, &sessions[1].id], [&ids[0], &ids[1]]);
    let it = &sessions[0];
    assert_eq!((it.score, it.alarms, it.metrics_version), (81.5, 2, 3));
    let time_s = it.metrics["time_s"];
    assert_eq!(time_s.to_bits(), 13.591_027_285_000_017_f64.to_bits());
    assert_eq!(it.file.as_deref(), Some("/there"));
    assert_eq!(it.circumstances, Circumstances::default(), "unknown");
    let hand = match has_scripted {
        true => Hand::Scripted,
        false => Hand::Person,
    };
    assert_eq!([it.hand, sessions[1].hand], [Hand::Person, hand]);
    let sheet = store.sheet(&ids[0]).unwrap();
    let named = |name: &str, value| (name.to_owned(), value);
    assert_eq!(
        sheet,
        [named("Depth perception", 4), named("Bimanual dexterity", 2)]
    );
    assert_eq!(store.answers_of("Bo").unwrap()[0].value, 3);
    assert_eq!(store.trainees().unwrap()[0].consent, Consent::Unknown);
}

fn tables(path: &Path) -> Vec<(String, String)> {
    let store = Store::open(path).unwrap();
    let columns = "SELECT m.name, group_concat(c.name || c.type || c.\"notnull\" || coalesce(c.dflt_value, '')) \
                   FROM sqlite_schema m, pragma_table_info(m.name) c WHERE m.type = 'table' GROUP BY m.name ORDER BY 1";
    let mut query = store.connection.prepare(columns).unwrap();
    let rows = query.query_map([], |row| Ok((row.get(0)?, row.get(1)?)));
    rows.unwrap().map(Result::unwrap).collect()
}

#[test]
fn a_store_of_version_1_becomes_one_of_this_version_and_loses_nothing() {
    for has_scripted in [true, false] {
        let (_folder, path) = folder();
        let ids = first(&path, has_scripted);
        let before = std::fs::read(&path).unwrap();
        // Reading shows the store as the migration will make it, and leaves the file as it is.
        check(&Store::read(&path).unwrap(), &ids, has_scripted);
        assert_eq!(std::fs::read(&path).unwrap(), before);
        // So does merging it.
        let centre = path.with_extension("centre");
        let mut whole = Store::open(&centre).unwrap();
        assert_eq!(whole.merge(&path).unwrap().sessions, 2);
        check(&whole, &ids, has_scripted);
        assert_eq!(std::fs::read(&path).unwrap(), before);
        // Opening it to write changes the file.
        check(&Store::open(&path).unwrap(), &ids, has_scripted);
        check(&Store::read(&path).unwrap(), &ids, has_scripted);
        assert_ne!(std::fs::read(&path).unwrap(), before);
        assert_eq!(tables(&path), tables(&centre), "as a new store");
    }
}

#[test]
fn two_spellings_of_a_name_stay_two_trainees() {
    let (_folder, path) = folder();
    first(&path, true);
    let made = Connection::open(&path).unwrap();
    let add = "INSERT INTO trainee (id, name) VALUES (3, ?1)";
    made.execute(add, ["Am\u{e9}lie"]).unwrap();
    drop(made);
    let store = Store::open(&path).unwrap();
    let sessions = |name| store.sessions(name, None).unwrap().len();
    assert_eq!((sessions("Ame\u{301}lie"), sessions("Am\u{e9}lie")), (2, 0));
}

#[test]
fn a_store_of_version_4_becomes_one_of_this_version_and_loses_nothing() {
    let (_folder, path) = folder();
    let ids = first(&path, true);
    let made = tables(&path);
    let old = Connection::open(&path).unwrap();
    old.execute_batch("DROP TABLE forgotten_person; PRAGMA user_version = 4;")
        .unwrap();
    drop(old);
    check(&Store::read(&path).unwrap(), &ids, true);
    check(&Store::open(&path).unwrap(), &ids, true);
    assert_eq!(tables(&path), made);
}

#[test]
fn a_store_of_version_3_becomes_one_of_this_version_and_loses_nothing() {
    let (_folder, path) = folder();
    let ids = first(&path, true);
    let made = tables(&path);
    let old = Connection::open(&path).unwrap();
    old.execute_batch(
        "DROP TABLE forgotten_person;
         DROP TRIGGER enrolled; ALTER TABLE trainee DROP COLUMN cohort_unix_s;
         ALTER TABLE trainee DROP COLUMN consent_unix_s;
         CREATE TRIGGER enrolled AFTER UPDATE OF cohort, consent ON trainee BEGIN
             DELETE FROM delivery WHERE state = 'there';
         END;
         PRAGMA user_version = 3;",
    )
    .unwrap();
    drop(old);
    check(&Store::read(&path).unwrap(), &ids, true);
    check(&Store::open(&path).unwrap(), &ids, true);
    assert_eq!(tables(&path), made);
}

#[test]
fn a_store_of_version_2_becomes_one_of_this_version_and_loses_nothing() {
    let (_folder, path) = folder();
    let ids = first(&path, true);
    let made = tables(&path);
    let old = Connection::open(&path).unwrap();
    old.execute_batch(
        "DROP TRIGGER rated; DROP TRIGGER enrolled; DROP TABLE withdrawal; DROP TABLE delivery; DROP TABLE destination; DROP TABLE forgotten_person; ALTER TABLE trainee DROP COLUMN cohort_unix_s; ALTER TABLE trainee DROP COLUMN consent_unix_s; PRAGMA user_version = 2;",
    )
    .unwrap();
    drop(old);
    let before = std::fs::read(&path).unwrap();
    check(&Store::read(&path).unwrap(), &ids, true);
    assert_eq!(std::fs::read(&path).unwrap(), before);
    check(&Store::open(&path).unwrap(), &ids, true);
    assert_eq!(tables(&path), made);
}
