//! Results arrive in PostgreSQL, each once.

use std::sync::Barrier;
use std::time::Duration;

use rustix::process::Signal;
use store::{Consent, Sheet, Store, person_id};
use system_tests::postgres::Postgres;

use super::*;

#[test]
fn a_result_arrives_whole_and_once() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    let one = station.keep("Ada", &session(100));
    let scripted = SessionRecord {
        hand: Hand::Scripted,
        ..session(200)
    };
    station.keep("Ada", &scripted);
    station.keep("Bo's", &session(300));
    let enrolled = station
        .store
        .enrol("Ada", Some("novice"), Some(Consent::Yes), 50);
    enrolled.expect("a trainee");
    let pushed = station.push_all(&owners(&server));
    assert_eq!((pushed.sent, pushed.known), (3, 0));
    let row = format!(
        "SELECT id, name, cohort, consent, task, score, metrics ->> 'time_s', hand, realtime, missed_ticks, site \
         FROM calot.session JOIN calot.trainee USING (person) WHERE id = '{one}'"
    );
    let whole = format!("{one}|Ada|novice|yes|clamp|81.5|13.591027285000017|person|t||theatre-1");
    assert_eq!(server.rows(&row), [whole]);
    let people = server.rows("SELECT person, name FROM calot.trainee ORDER BY name");
    let expected = ["Ada", "Bo's"].map(|it| format!("{}|{it}", person_id(it)));
    assert_eq!(people, expected);
    // Nothing is left to do.
    let again = station.push_all(&owners(&server));
    assert_eq!((again.sent, again.known), (0, 0));
    // A program that died between delivery and note delivers again, and nothing is doubled.
    station.lose_notes();
    let again = station.push_all(&owners(&server));
    assert_eq!((again.sent, again.known), (0, 3));
    assert_eq!(server.rows("SELECT count(*) FROM calot.session"), ["3"]);
    // The path of a recording names a user of the station, and stays there.
    let dump = server.rows("SELECT session::text FROM calot.session");
    assert!(dump.iter().all(|it| !it.contains("/home")), "{dump:?}");
}

#[test]
fn sheets_and_consent_that_come_later_arrive_and_replace_older_ones() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    let id = station.keep("Ada", &session(100));
    station.push_all(&owners(&server));
    let goals = Sheet::named("goals").expect("a sheet");
    let sums =
        "SELECT rater, blinded, sum(value) FROM calot.point GROUP BY rater, blinded ORDER BY rater";
    for (points, expected) in [([2; 5], "Bo|t|10"), ([4; 5], "Bo|t|20")] {
        let rated = station.store.rate_again(&id, &goals, ("Bo", true), &points);
        rated.expect("rated");
        station.push_all(&owners(&server));
        assert_eq!(server.rows(sums), [expected]);
    }
    let rated = station.store.rate(&id, &goals, ("Cy", false), &[1; 5]);
    rated.expect("rated");
    let refused = station.store.enrol("Ada", None, Some(Consent::No), 150);
    refused.expect("a trainee");
    station.push_all(&owners(&server));
    assert_eq!(server.rows(sums), ["Bo|t|20", "Cy|f|5"]);
    assert_eq!(server.rows("SELECT consent FROM calot.trainee"), ["no"]);
    assert_eq!(
        station.push_all(&owners(&server)).known,
        0,
        "nothing is left to do"
    );
    station.store.forget("Ada", 500).expect("forgotten");
    station.push_all(&owners(&server));
    assert_eq!(server.rows("SELECT count(*) FROM calot.point"), ["0"]);
}

#[test]
fn the_later_telling_arrives_whatever_was_told_before_and_by_whom() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let told = || {
        server
            .rows("SELECT cohort, consent FROM calot.trainee")
            .remove(0)
    };
    let (mut here, mut there) = (Station::new(), Station::new());
    here.keep("Ada", &session(100));
    there.keep("Ada", &session(200));
    let mut tell = |is_here: bool, cohort: Option<&str>, consent, at| {
        let station = if is_here { &mut here } else { &mut there };
        let enrolled = station.store.enrol("Ada", cohort, consent, at);
        enrolled.expect("a trainee");
        station.push_all(&owners(&server));
        told()
    };
    assert_eq!(
        tell(true, Some("novice"), Some(Consent::No), 10),
        "novice|no"
    );
    assert_eq!(tell(true, None, Some(Consent::Yes), 20), "novice|yes");
    assert_eq!(tell(true, Some(""), None, 30), "|yes");
    // Another station delivers an older statement, then a newer refusal.
    assert_eq!(tell(false, Some("expert"), Some(Consent::No), 15), "|yes");
    assert_eq!(tell(false, None, Some(Consent::No), 40), "|no");
    assert_eq!(tell(true, None, Some(Consent::Unknown), 50), "|unknown");
}

#[test]
fn a_site_that_is_named_later_or_elsewhere_makes_no_other_session() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let (lrs, to) = records();
    let mut station = Station::new();
    let mut bare = session(100);
    bare.circumstances.site = String::new();
    station.keep("Ada", &bare);
    station.push_all(&owners(&server));
    station.push_all(&to);
    station.store.set_site("theatre-1").expect("a site");
    let mut centre = Station::new();
    centre.store.merge(&station.path).expect("merged");
    for to in [&owners(&server), &to] {
        let pushed = centre.push_all(to);
        assert_eq!((pushed.known, pushed.differing.len()), (1, 0), "{pushed:?}");
    }
    assert_eq!(server.rows("SELECT site FROM calot.session"), ["theatre-1"]);
    station.store.set_site("theatre-2").expect("a site");
    station.lose_notes();
    let pushed = station.push_all(&owners(&server));
    assert_eq!((pushed.known, pushed.differing.len()), (1, 0), "{pushed:?}");
    assert_eq!(server.rows("SELECT site FROM calot.session"), ["theatre-1"]);
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn two_programs_at_once_deliver_each_result_once() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    station.keep_many(60);
    let start = Barrier::new(2);
    let push = || {
        let mut store = Store::open(&station.path).expect("a store");
        start.wait();
        super::push(&mut store, &owners(&server)).expect("a store")
    };
    let pushed = std::thread::scope(|threads| {
        let both = [threads.spawn(push), threads.spawn(push)];
        both.map(|it| it.join().expect("it works"))
    });
    assert!(pushed.iter().all(|it| it.problem.is_none()), "{pushed:?}");
    assert_eq!(pushed[0].sent + pushed[1].sent, 60, "{pushed:?}");
    let count = "SELECT count(*), count(DISTINCT id) FROM calot.session";
    assert_eq!(server.rows(count), ["60|60"]);
}

#[test]
fn a_server_that_dies_in_the_middle_gets_the_rest_later() {
    let Some(mut server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    station.keep("Ada", &session(1));
    station.push_all(&owners(&server));
    station.keep_many(1500);
    let to = owners(&server);
    let path = station.path.clone();
    let pushing = std::thread::spawn(move || {
        let mut store = Store::open(&path).expect("a store");
        super::push(&mut store, &to).expect("a store")
    });
    while server.rows("SELECT count(*) > 40 FROM calot.session") == ["f"] {
        std::thread::sleep(Duration::from_millis(2));
    }
    server.stop(Signal::QUIT);
    let cut = pushing.join().expect("it ends");
    let problem = cut.problem.expect("it was cut off");
    assert!(problem.contains("does not work at the moment"), "{problem}");
    assert!(
        cut.sent >= 40 && cut.waiting > 0,
        "{} {}",
        cut.sent,
        cut.waiting
    );
    assert_eq!(cut.sent + cut.waiting, 1500);
    // It is still away.
    assert_eq!(station.push(&owners(&server)).waiting, cut.waiting);
    server.resume();
    let rest = station.push_all(&owners(&server));
    assert!(
        rest.sent + rest.known == cut.waiting && rest.known <= 1,
        "{rest:?}"
    );
    let count = "SELECT count(*), count(DISTINCT id) FROM calot.session";
    assert_eq!(server.rows(count), ["1501|1501"]);
}
