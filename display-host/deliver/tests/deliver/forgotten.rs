//! A person who was forgotten at a station is forgotten at the centre.

use rustix::process::Signal;
use store::{Consent, person_id};
use system_tests::lrs::Fault;
use system_tests::postgres::Postgres;

use super::*;

#[test]
fn a_database_that_was_away_forgets_when_it_is_back_and_keeps_old_sessions_out() {
    let Some(mut server) = Postgres::start() else {
        return;
    };
    let (mut here, mut there) = (Station::new(), Station::new());
    here.keep("Zaphod", &session(100));
    here.keep("Bo", &session(110));
    here.push_all(&owners(&server));
    there.keep("Zaphod", &session(120));
    there.push_all(&owners(&server));
    there.keep("Zaphod", &session(130));
    server.stop(Signal::INT);
    here.store.forget("Zaphod", 500).expect("forgotten");
    let away = here.push(&owners(&server));
    assert_eq!((away.withdrawn, away.waiting), (0, 1));
    assert!(away.problem.is_some());
    server.resume();
    let back = here.push_all(&owners(&server));
    assert_eq!(back.withdrawn, 1);
    // The other station's results are gone as well, and those that it has not sent yet stay out.
    let names = "SELECT name FROM calot.session JOIN calot.trainee USING (person)";
    assert_eq!(server.rows(names), ["Bo"]);
    assert_eq!(server.rows("SELECT name FROM calot.trainee"), ["Bo"]);
    let late = there.push_all(&owners(&server));
    assert_eq!(late.sent, 0);
    assert!(late.forgotten_there.contains("Zaphod"), "{late:?}");
    assert_eq!(server.rows(names), ["Bo"]);
    // A person who comes back by choice counts.
    here.keep("Zaphod", &session(600));
    assert_eq!(here.push_all(&owners(&server)).sent, 1);
    assert_eq!(
        server.rows(&format!("{names} ORDER BY name")),
        ["Bo", "Zaphod"]
    );
    // Forgotten again, the person is gone again.
    here.store.forget("Zaphod", 700).expect("forgotten");
    assert_eq!(here.push_all(&owners(&server)).withdrawn, 1);
    assert_eq!(server.rows(names), ["Bo"]);
    let marks = server.rows("SELECT person, at_unix_s FROM calot.forgotten");
    assert_eq!(marks, [format!("{}|700", person_id("Zaphod"))]);
}

#[test]
fn a_person_who_was_forgotten_before_the_first_push_is_forgotten_there() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let (mut here, mut there) = (Station::new(), Station::new());
    there.keep("Zaphod", &session(120));
    there.push_all(&owners(&server));
    here.keep("Zaphod", &session(100));
    here.store.forget("Zaphod", 500).expect("forgotten");
    assert_eq!(here.push_all(&owners(&server)).withdrawn, 1);
    let people = "SELECT count(*) FROM calot.trainee";
    assert_eq!(server.rows(people), ["0"]);
}

#[test]
fn a_late_withdrawal_leaves_what_was_told_after_the_forgetting() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let told = "SELECT cohort, consent FROM calot.trainee";
    let mut here = Station::new();
    here.keep("Zaphod", &session(100));
    let enrolled = here
        .store
        .enrol("Zaphod", Some("novice"), Some(Consent::Yes), 150);
    enrolled.expect("a trainee");
    here.push_all(&owners(&server));
    here.store.forget("Zaphod", 500).expect("forgotten");
    // Another station is faster: its person came back and refuses.
    let mut there = Station::new();
    there.keep("Zaphod", &session(600));
    let refused = there.store.enrol("Zaphod", None, Some(Consent::No), 600);
    refused.expect("a trainee");
    there.push_all(&owners(&server));
    assert_eq!(server.rows(told), ["novice|no"]);
    assert_eq!(here.push_all(&owners(&server)).withdrawn, 1);
    assert_eq!(server.rows(told), ["|no"], "the cohort was told before");
}

#[test]
fn a_consent_from_before_the_forgetting_goes_though_its_person_came_back() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut here = Station::new();
    here.keep("Zaphod", &session(100));
    let enrolled = here.store.enrol("Zaphod", None, Some(Consent::Yes), 150);
    enrolled.expect("a trainee");
    here.push_all(&owners(&server));
    here.store.forget("Zaphod", 500).expect("forgotten");
    let mut there = Station::new();
    there.keep("Zaphod", &session(600));
    let enrolled = there.store.enrol("Zaphod", Some("expert"), None, 600);
    enrolled.expect("a trainee");
    there.push_all(&owners(&server));
    here.push_all(&owners(&server));
    let told = "SELECT cohort, consent FROM calot.trainee";
    assert_eq!(server.rows(told), ["expert|unknown"]);
}

#[test]
fn a_clock_that_is_ahead_keeps_nobody_out_for_years() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let now = i64::try_from(now.expect("a clock").as_secs()).expect("a time");
    let (mut here, mut there) = (Station::new(), Station::new());
    let ten_years = 315_360_000;
    // The session of a station with such a clock is gone all the same.
    here.keep("Zaphod", &session(now + ten_years - 60));
    here.push_all(&owners(&server));
    here.store
        .forget("Zaphod", now + ten_years)
        .expect("forgotten");
    assert_eq!(here.push_all(&owners(&server)).withdrawn, 1);
    assert_eq!(server.rows("SELECT count(*) FROM calot.session"), ["0"]);
    there.keep("Zaphod", &session(now - 60));
    assert_eq!(there.push_all(&owners(&server)).sent, 0, "it began before");
    there.keep("Zaphod", &session(now + 3600));
    assert_eq!(there.push_all(&owners(&server)).sent, 1, "it began later");
}

#[test]
fn a_push_names_other_addresses_that_still_owe_a_forgetting() {
    let (lrs, to) = records();
    let address = format!("http://localhost:{}/xapi", lrs.port());
    let other = Destination::shown(&address, None, &key).expect("an address");
    let mut station = Station::new();
    station.keep("Zaphod", &session(100));
    assert!(station.push_all(&to).owed_elsewhere.is_empty());
    station.store.forget("Zaphod", 500).expect("forgotten");
    assert_eq!(station.push_all(&other).owed_elsewhere, [to.name()]);
    assert!(station.push_all(&to).owed_elsewhere.is_empty());
}

#[test]
fn a_session_that_arrived_without_a_note_is_withdrawn_too() {
    let (lrs, to) = records();
    let mut station = Station::new();
    station.keep("Zaphod", &session(100));
    lrs.kept().faults.push_back(Fault::CutAfter);
    let cut = station.push(&to);
    assert_eq!((cut.sent, cut.waiting), (0, 1));
    assert_eq!(lrs.standing().len(), 1, "it arrived all the same");
    station.store.forget("Zaphod", 500).expect("forgotten");
    let pushed = station.push_all(&to);
    assert_eq!((pushed.withdrawn, lrs.standing().len()), (1, 0));
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn a_record_store_voids_the_statements_of_every_station() {
    let (lrs, to) = records();
    let (mut here, mut there) = (Station::new(), Station::new());
    here.keep("Zaphod", &session(100));
    here.keep("Bo", &session(110));
    here.push_all(&to);
    // More than fit on a page of the list.
    for began in [120, 130, 140, 150, 900] {
        there.keep("Zaphod", &session(began));
    }
    there.push_all(&to);
    lrs.kept().faults.push_back(Fault::Busy);
    here.store.forget("Zaphod", 500).expect("forgotten");
    let busy = here.push(&to);
    assert_eq!((busy.withdrawn, busy.waiting), (0, 1));
    lrs.kept().faults.push_back(Fault::Refuse);
    let refused = here.push(&to).problem.expect("refused");
    assert!(
        refused.contains("refuses a result: status 400: not today"),
        "{refused}"
    );
    assert_eq!(here.push_all(&to).withdrawn, 1);
    let left: Vec<String> = { lrs.standing().into_iter() }
        .map(|it| it["timestamp"].to_string())
        .collect();
    let expected = ["\"1970-01-01T00:01:50Z\"", "\"1970-01-01T00:15:00Z\""];
    assert!(
        left.len() == 2 && expected.iter().all(|it| left.contains(&(*it).to_owned())),
        "{left:?}"
    );
    assert_eq!(lrs.kept().voided.len(), 5);
    // No statement ever held the name.
    let all = format!("{:?}", lrs.kept().statements);
    assert!(!all.contains("Zaphod") && all.contains(&person_id("Zaphod")));
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn a_station_that_may_not_look_withdraws_what_it_sent() {
    let (lrs, to) = records();
    let (mut here, mut there) = (Station::new(), Station::new());
    here.keep("Zaphod", &session(100));
    there.keep("Zaphod", &session(110));
    here.push_all(&to);
    there.push_all(&to);
    lrs.kept().is_write_only = true;
    here.store.forget("Zaphod", 500).expect("forgotten");
    assert_eq!(here.push_all(&to).withdrawn, 1);
    assert_eq!(lrs.standing().len(), 1);
    there.store.forget("Zaphod", 500).expect("forgotten");
    there.push_all(&to);
    assert!(lrs.standing().is_empty());
}
