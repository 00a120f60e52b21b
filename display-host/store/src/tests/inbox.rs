//! Results that arrive from stations.

use super::*;

const CENTRE: &str = "centre";

/// Results that wait at a station for the centre.
fn sent(station: &mut Store) -> Vec<Outgoing> {
    let centre = station.destination(CENTRE).unwrap();
    station.outgoing(centre).unwrap()
}

#[test]
fn a_session_is_taken_once_with_what_is_known_of_it() {
    let (folder, path) = folder();
    let mut station = Store::open(&path).unwrap();
    let it = session(100, "cut", 1.0);
    station.add_session("Ada", &it).unwrap();
    station
        .enrol("Ada", Some("novice"), Some(Consent::Yes), 50)
        .unwrap();
    let goals = Sheet::named("goals").unwrap();
    station.rate(&it.id, &goals, ("Bo", true), &[3; 5]).unwrap();
    let mut centre = Store::open(&folder.path().join("centre")).unwrap();
    let first = sent(&mut station).remove(0);
    for _ in 0..2 {
        assert_eq!(centre.receive(&first).unwrap(), Delivery::There);
    }
    let ada = centre.trainees().unwrap().remove(0);
    assert_eq!(
        (ada.sessions, ada.cohort.as_str(), ada.consent),
        (1, "novice", Consent::Yes)
    );
    assert_eq!(centre.ratings(&it.id).unwrap()[0].sum(), 15);
    assert_eq!(centre.sessions("Ada", None).unwrap()[0].file, None);
    // A site that is named later is filled in; other contents are not taken.
    station.set_site("theatre").unwrap();
    assert_eq!(
        centre.receive(&sent(&mut station)[0]).unwrap(),
        Delivery::There
    );
    assert_eq!(
        centre.sessions("Ada", None).unwrap()[0].circumstances.site,
        "theatre"
    );
    let mut other = first.clone();
    other.session.score += 1.0;
    assert_eq!(centre.receive(&other).unwrap(), Delivery::Differs);
    other.person = person_id("Bo");
    let said = centre.receive(&other).unwrap_err().to_string();
    assert!(
        said.contains("allowed is the id that belongs to the name"),
        "{said}"
    );
    // Messages are JSON, and every bit of a number arrives.
    let text = serde_json::to_string(&first).unwrap();
    assert_eq!(serde_json::from_str::<Outgoing>(&text).unwrap(), first);
}

#[test]
fn who_was_forgotten_goes_from_the_centre_and_stays_out() {
    let (folder, path) = folder();
    let mut station = Store::open(&path).unwrap();
    for began in [100, 200] {
        station
            .add_session("Ada", &session(began, "cut", 1.0))
            .unwrap();
    }
    station.enrol("Ada", Some("novice"), None, 50).unwrap();
    let mut centre = Store::open(&folder.path().join("centre")).unwrap();
    let all = sent(&mut station);
    let late = {
        let mut other = Store::open(&folder.path().join("other")).unwrap();
        other.add_session("Ada", &session(900, "cut", 1.0)).unwrap();
        sent(&mut other).remove(0)
    };
    for it in all.iter().chain([&late]) {
        centre.receive(it).unwrap();
    }
    station.forget("Ada", 500).unwrap();
    let number = station.destination(CENTRE).unwrap();
    let errand = station.withdrawals(number).unwrap().remove(0);
    centre.forget_person(&errand, 1000).unwrap();
    let ada = centre.trainees().unwrap().remove(0);
    assert_eq!(
        (ada.sessions, ada.cohort.as_str()),
        (1, ""),
        "she came back"
    );
    assert_eq!(centre.receive(&all[0]).unwrap(), Delivery::Forgotten);
    // A clock that is ahead keeps nobody out for years.
    let ahead = Withdrawal {
        at_unix_s: 1_000_000,
        ..errand
    };
    centre.forget_person(&ahead, 1000).unwrap();
    assert!(centre.trainees().unwrap().is_empty());
    assert_eq!(centre.receive(&late).unwrap(), Delivery::Forgotten);
    let mut new = late;
    new.session.began_unix_s = 1001;
    new.session.id = new_id();
    assert_eq!(centre.receive(&new).unwrap(), Delivery::There);
}
