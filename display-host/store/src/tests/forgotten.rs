//! A forgotten person stays forgotten, and may come back.

use super::*;

/// Makes a station's store with two sessions of Zaphod and one of Bo. Returns the ids of Zaphod's
/// sessions.
fn shared(path: &Path) -> [String; 2] {
    let mut store = Store::open(path).unwrap();
    let own = [session(100, "cut", 1.0), session(200, "cut", 2.0)];
    for it in &own {
        store.add_session("Zaphod", it).unwrap();
    }
    store.add_session("Bo", &session(150, "cut", 3.0)).unwrap();
    let answers = Questionnaire::default();
    store.answer("Zaphod", &answers, &[3; 14], 250).unwrap();
    own.map(|it| it.id)
}

fn names(store: &Store) -> Vec<String> {
    let all = store.trainees().unwrap();
    all.into_iter().map(|it| it.name).collect()
}

#[test]
fn a_forgotten_trainee_stays_out_of_every_store_that_knows_of_it() {
    let (folder, station) = folder();
    let ids = shared(&station);
    // The centre knows the first session only. It keeps the second out because it marked the name.
    let centre = folder.path().join("centre.sqlite");
    let mut store = Store::open(&centre).unwrap();
    store
        .add_session(
            "Zaphod",
            &SessionRecord {
                id: ids[0].clone(),
                ..session(100, "cut", 1.0)
            },
        )
        .unwrap();
    store.forget("Zaphod", 300).unwrap();
    let merged = store.merge(&station).unwrap();
    assert_eq!((merged.sessions, merged.left_out_sessions), (1, 2));
    assert_eq!((merged.left_out_trainees, merged.left_out_answers), (1, 14));
    assert_eq!(names(&store), ["Bo"]);
    // The marks travel: a third store that merges the centre keeps Zaphod out, too.
    let third = folder.path().join("third.sqlite");
    let mut third = Store::open(&third).unwrap();
    third.merge(&centre).unwrap();
    let merged = third.merge(&station).unwrap();
    assert_eq!((merged.left_out_sessions, merged.known), (2, 1));
    assert_eq!(names(&third), ["Bo"]);
    // The station still has Zaphod, and the merge reports that the centre forgot Zaphod.
    let mut station = Store::open(&station).unwrap();
    let merged = station.merge(&centre).unwrap();
    assert_eq!(merged.forgotten_there, ["Zaphod"]);
    assert_eq!(names(&station), ["Bo", "Zaphod"]);
    // Neither name nor ids are in the file that forgot.
    let bytes = std::fs::read(&centre).unwrap();
    for text in ["Zaphod", &ids[0], &ids[1]] {
        let is_there = bytes.windows(text.len()).any(|it| it == text.as_bytes());
        assert!(!is_there, "{text}");
    }
}

#[test]
fn sessions_of_a_forgotten_trainee_are_known_under_any_name() {
    let (folder, station) = folder();
    let ids = shared(&station);
    let other = folder.path().join("other.sqlite");
    let mut other = Store::open(&other).unwrap();
    let same = SessionRecord {
        id: ids[1].clone(),
        ..session(200, "cut", 2.0)
    };
    other.add_session("Z. B.", &same).unwrap();
    let path = other.path().to_owned();
    drop(other);
    let mut store = Store::open(&station).unwrap();
    store.forget("Zaphod", 300).unwrap();
    assert_eq!(store.merge(&path).unwrap().left_out_sessions, 1);
    // Nor can the session be added from its recording.
    let error = store.add_recorded("Anybody", &same).unwrap_err();
    assert!(matches!(error, StoreError::Forgotten { .. }), "{error}");
    assert!(
        error.to_string().contains("A new session of the same"),
        "{error}"
    );
}

#[test]
fn who_comes_back_begins_anew() {
    let (folder, station) = folder();
    shared(&station);
    let mut store = Store::open(&station).unwrap();
    store.forget("Zaphod", 300).unwrap();
    let late = session(300, "cut", 5.0);
    assert!(store.add_session("Zaphod", &late).is_err(), "began before");
    let new = session(400, "cut", 5.0);
    store.add_session("Zaphod", &new).unwrap();
    assert_eq!(
        store.sessions("Zaphod", None).unwrap(),
        std::slice::from_ref(&new)
    );
    // The centre takes the new session and leaves the old ones out.
    let old = folder.path().join("old.sqlite");
    shared(&old);
    let mut centre = Store::open(&folder.path().join("centre.sqlite")).unwrap();
    centre.merge(&station).unwrap();
    assert_eq!(centre.merge(&old).unwrap().left_out_sessions, 2);
    assert_eq!(centre.sessions("Zaphod", None).unwrap(), [new]);
    // If Zaphod is forgotten again, the newest time counts.
    store.forget("Zaphod", 500).unwrap();
    let between = session(450, "cut", 5.0);
    assert!(store.add_session("Zaphod", &between).is_err());
}

#[test]
fn a_person_is_forgotten_though_the_file_cannot_be_compacted() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store
        .add_session("Zaphod", &session(100, "cut", 1.0))
        .unwrap();
    // Compacting needs a place for one more database.
    for number in 0..10 {
        let full = format!("ATTACH ':memory:' AS other{number}");
        store.connection.execute_batch(&full).unwrap();
    }
    let gone = store.forget("Zaphod", 300).unwrap();
    let loose = gone.loose.expect("no place").to_string();
    assert!(loose.contains("too many attached databases"), "{loose}");
    assert_eq!(gone.files, ["monday/session.mcap"]);
    assert!(store.trainees().unwrap().is_empty());
    let bytes = std::fs::read(&path).unwrap();
    assert!(!bytes.windows(6).any(|it| it == b"Zaphod"));
}
