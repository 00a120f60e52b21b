//! Sessions that wait for a centre, and people whom a centre has to forget.

use super::*;

const CENTRE: &str = "postgres://centre.example:5432/calot";

fn waiting(store: &Store, destination: i64) -> Vec<String> {
    let all = store.outgoing(destination).unwrap();
    all.into_iter().map(|it| it.session.id).collect()
}

#[test]
fn a_session_waits_for_each_centre_until_it_has_arrived_there() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let (one, two) = (session(100, "cut", 1.0), session(200, "cut", 2.0));
    store.add_session("Ada", &one).unwrap();
    store.add_session("Ada", &two).unwrap();
    store
        .enrol("Ada", Some("novice"), Some(Consent::No), 5)
        .unwrap();
    let centre = store.destination(CENTRE).unwrap();
    let other = store.destination("https://lrs.example/xapi").unwrap();
    assert_eq!(store.destination(CENTRE).unwrap(), centre);
    assert_ne!(centre, other);
    let found = store.outgoing(centre).unwrap();
    assert_eq!(found[0].person, person_id(" Ada"));
    assert_eq!(
        (found[0].told.cohort.as_str(), found[0].told.consent),
        ("novice", Consent::No)
    );
    assert_eq!(found[0].session, one);
    assert_eq!(waiting(&store, centre), [one.id.clone(), two.id.clone()]);
    let ended = [
        Delivery::There,
        Delivery::Differs,
        Delivery::Forgotten,
        Delivery::LeftOut,
    ];
    for state in ended {
        let lost = store
            .note_deliveries(centre, &[(&found[0], state)])
            .unwrap();
        assert!(lost.is_empty());
        assert_eq!(waiting(&store, centre), [two.id.as_str()], "{state:?}");
    }
    assert_eq!(waiting(&store, other).len(), 2);
    // A session that is kept anew has to be sent anew.
    store.add_session("Ada", &one).unwrap();
    assert_eq!(waiting(&store, centre).len(), 2);
}

#[test]
fn a_session_whose_sheets_or_person_changed_waits_again() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(100, "cut", 1.0);
    store.add_session("Ada", &it).unwrap();
    let centre = store.destination(CENTRE).unwrap();
    let goals = Sheet::named("goals").unwrap();
    let mut change = |change: &dyn Fn(&mut Store)| {
        for sent in store.outgoing(centre).unwrap() {
            let notes = [(&sent, Delivery::There)];
            store.note_deliveries(centre, &notes).unwrap();
        }
        change(&mut store);
        store.outgoing(centre).unwrap()
    };
    let rated = change(&|store| {
        store.rate(&it.id, &goals, ("Bo", true), &[3; 5]).unwrap();
    });
    assert_eq!(rated[0].ratings[0].sum(), 15);
    let again = change(&|store| {
        let again = store.rate_again(&it.id, &goals, ("Bo", true), &[4; 5]);
        again.map(drop).unwrap();
    });
    assert_eq!(again[0].ratings[0].sum(), 20);
    let enrolled = change(&|store| store.enrol("Ada", None, Some(Consent::No), 5).unwrap());
    assert_eq!(enrolled[0].told.consent, Consent::No);
    let same = change(&|store| store.enrol("Ada", None, Some(Consent::No), 5).unwrap());
    assert!(same.is_empty());
    // A repeated statement may be new to a centre that received another one in between.
    let later = change(&|store| store.enrol("Ada", None, Some(Consent::No), 6).unwrap());
    assert_eq!(later[0].told.consent_unix_s, Some(6));
}

#[test]
fn a_session_that_changed_while_it_was_sent_waits_again() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(100, "cut", 1.0);
    store.add_session("Ada", &it).unwrap();
    let centre = store.destination(CENTRE).unwrap();
    let goals = Sheet::named("goals").unwrap();
    let changes: [&dyn Fn(&mut Store); 3] = [
        &|store| store.enrol("Ada", Some("expert"), None, 5).unwrap(),
        &|store| store.enrol("Ada", None, Some(Consent::No), 5).unwrap(),
        &|store| {
            store.rate(&it.id, &goals, ("Bo", true), &[3; 5]).unwrap();
        },
    ];
    for change in changes {
        let old = store.outgoing(centre).unwrap().remove(0);
        change(&mut store);
        let new = store.outgoing(centre).unwrap().remove(0);
        for noted in [&old, &new, &old] {
            let notes = [(noted, Delivery::There)];
            assert!(store.note_deliveries(centre, &notes).unwrap().is_empty());
            let waits = usize::from(*noted == old);
            assert_eq!(waiting(&store, centre).len(), waits, "{noted:?}");
        }
    }
}

#[test]
fn a_forgotten_person_leaves_an_errand_without_a_name_for_each_centre() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let (one, two) = (session(100, "cut", 1.0), session(500, "cut", 2.0));
    store.add_session("Zaphod", &one).unwrap();
    let centre = store.destination(CENTRE).unwrap();
    let other = store.destination("https://lrs.example/xapi").unwrap();
    assert!(store.owed().unwrap().is_empty());
    store.forget("Zaphod", 300).unwrap();
    assert!(waiting(&store, centre).is_empty());
    assert_eq!(store.owed().unwrap(), ["https://lrs.example/xapi", CENTRE]);
    let first = store.withdrawals(centre).unwrap();
    let expected = Withdrawal {
        person: person_id("Zaphod"),
        at_unix_s: 300,
        sessions: vec![one.id.clone()],
    };
    assert_eq!(first, [expected]);
    let bytes = std::fs::read(&path).unwrap();
    assert!(!bytes.windows(6).any(|it| it == b"Zaphod"));
    // The person comes back and is forgotten again before the centre was reached.
    store.add_session("Zaphod", &two).unwrap();
    store.forget("Zaphod", 600).unwrap();
    store.note_withdrawn(centre, &first[0]).unwrap();
    let joined = store.withdrawals(centre).unwrap();
    assert_eq!((joined.len(), joined[0].at_unix_s), (1, 600));
    assert_eq!(joined[0].sessions.len(), 2);
    store.note_withdrawn(centre, &joined[0]).unwrap();
    assert!(store.withdrawals(centre).unwrap().is_empty());
    assert_eq!(store.withdrawals(other).unwrap().len(), 1);
}

#[test]
fn a_centre_that_is_named_later_has_to_forget_as_well() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store
        .add_session("Zaphod", &session(100, "cut", 1.0))
        .unwrap();
    store.forget("Zaphod", 300).unwrap();
    assert!(store.owed().unwrap().is_empty(), "no centre is known");
    let centre = store.destination(CENTRE).unwrap();
    let owed = store.withdrawals(centre).unwrap();
    let expected = Withdrawal {
        person: person_id("Zaphod"),
        at_unix_s: 300,
        sessions: Vec::new(),
    };
    assert_eq!(owed, std::slice::from_ref(&expected));
    assert_eq!(store.owed().unwrap(), [CENTRE]);
    store.note_withdrawn(centre, &owed[0]).unwrap();
    assert_eq!(store.destination(CENTRE).unwrap(), centre);
    assert!(store.withdrawals(centre).unwrap().is_empty(), "told once");
    let other = store.destination("https://lrs.example/xapi").unwrap();
    assert_eq!(store.withdrawals(other).unwrap(), [expected]);
}

#[test]
fn a_session_that_was_sent_while_its_person_was_forgotten_is_withdrawn() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(100, "cut", 1.0);
    store.add_session("Ada", &it).unwrap();
    let centre = store.destination(CENTRE).unwrap();
    let sent = store.outgoing(centre).unwrap().remove(0);
    store.forget("Ada", 300).unwrap();
    let told = store.withdrawals(centre).unwrap().remove(0);
    store.note_withdrawn(centre, &told).unwrap();
    let notes = [(&sent, Delivery::There)];
    assert_eq!(
        store.note_deliveries(centre, &notes).unwrap(),
        [it.id.as_str()]
    );
    store.withdraw(centre, &sent.person, &it.id, 100).unwrap();
    let again = store.withdrawals(centre).unwrap();
    assert_eq!(again[0].sessions, [it.id]);
}

#[test]
fn a_withdrawal_that_makes_no_sense_is_damage() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let centre = store.destination(CENTRE).unwrap();
    let write = |person: &str, sessions: &str| {
        let other = Connection::open(&path).unwrap();
        let row = "INSERT OR REPLACE INTO withdrawal VALUES (?1, ?2, 5, ?3)";
        other
            .execute(row, rusqlite::params![centre, person, sessions])
            .unwrap();
    };
    write("x\u{1b}", "[]");
    let said = store.withdrawals(centre).unwrap_err().to_string();
    assert!(
        said.contains("a withdrawal of 'x\\u{1b}' makes no sense"),
        "{said}"
    );
    let other = Connection::open(&path).unwrap();
    other.execute("DELETE FROM withdrawal", []).unwrap();
    drop(other);
    write(&person_id("Ada"), "[\"../x\"]");
    assert!(store.withdrawals(centre).is_err());
}

#[test]
fn another_spelling_of_an_address_takes_over_notes_and_errands() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let (kept, gone) = (session(100, "cut", 1.0), session(200, "cut", 2.0));
    store.add_session("Ada", &kept).unwrap();
    store.add_session("Bo", &gone).unwrap();
    let (from, to) = ("https://LRS.example:443/xapi", "https://lrs.example/xapi");
    let old = store.destination(from).unwrap();
    for sent in store.outgoing(old).unwrap() {
        store
            .note_deliveries(old, &[(&sent, Delivery::There)])
            .unwrap();
    }
    store.forget("Bo", 500).unwrap();
    let owed = store.withdrawals(old).unwrap();
    store.respell(from, to).unwrap();
    store.respell(from, to).unwrap();
    let new = store.destination(to).unwrap();
    assert!(waiting(&store, new).is_empty());
    assert_eq!(store.withdrawals(new).unwrap(), owed);
    assert_eq!(store.owed().unwrap(), [to]);
}
