//! Results on their way to the centre.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;

use serde_json::{Value, json};
use store::Store;

use crate::house::House;
use crate::page::Page;
use crate::support::{Centre, Killed, centre_program, wait};

#[test]
fn results_wait_for_the_centre_arrive_once_and_are_forgotten_with_their_person() {
    let mut house = House::open(&["s-1"], &["s-1"]);
    let own = house.file("station.sqlite");
    keep_results(&own);
    let copy = house.file("copy.sqlite");
    std::fs::copy(&own, &copy).expect("copied");
    // The centre is away when the station starts.
    let (stations, page) = (house.centre.stations.clone(), house.centre.page.clone());
    house.centre.kill();
    let first = join(&house);
    house.centre = wait("the centre starts at its old addresses", || {
        Centre::start_at(house.folder.path(), &stations, &page)
    });
    let page = house.page();
    let sessions = |page: &Page| -> Value {
        let people = page.get(&house.centre, &house.file("ca.pem"), "/api/people");
        people[0]["sessions"].clone()
    };
    wait("both results", || (sessions(&page) == 2).then_some(()));
    wait("both are noted", || {
        (waiting(&own) == Some(0)).then_some(())
    });
    assert!(house.centre.logged("result").len() >= 2);
    drop(first);
    // A store that was restored from a copy sends the results again, and two new ones.
    std::fs::copy(&copy, &own).expect("copied");
    keep_results(&own);
    let second = join(&house);
    wait("four results", || (sessions(&page) == 4).then_some(()));
    wait("all are noted", || (waiting(&own) == Some(0)).then_some(()));
    let fates = house.centre.logged("result");
    assert!(
        fates.iter().all(|it| it["detail"]["fate"] == "there"),
        "{fates:?}"
    );
    assert_eq!(sessions(&page), 4);
    drop(second);
    let now_s = i64::try_from(centre::log::now_ms() / 1000).expect("a time");
    let store = Store::open(&own).and_then(|mut it| it.forget("Kim", now_s));
    store.expect("Kim is forgotten");
    let _third = join(&house);
    wait("nobody is known", || {
        let people = page.get(&house.centre, &house.file("ca.pem"), "/api/people");
        (people == json!([])).then_some(())
    });
}

/// Starts the end of a station that has a store, and no operation.
fn join(house: &House) -> Killed {
    let mut command = centre_program();
    command.args(["join", "--connect", &house.centre.stations]);
    command.arg("--keys").arg(house.file("keys/s-1"));
    command.arg("--store").arg(house.file("station.sqlite"));
    command.args(["--station", &format!("test-{}-none", std::process::id())]);
    Killed(command.stdout(Stdio::null()).spawn().expect("an end"))
}

/// Number of sessions that the centre still lacks. `None`: the store is being written.
fn waiting(store: &Path) -> Option<usize> {
    let mut store = Store::open(store).ok()?;
    let centre = store.destination("calot-centre/s-1").ok()?;
    Some(store.outgoing(centre).ok()?.len())
}

/// Two sessions of Kim in the store of a centre.
pub(crate) fn keep_results(path: &Path) {
    let mut store = store::Store::open(path).expect("a store");
    for (began_unix_s, score) in [(1_790_000_000, 55.0), (1_790_100_000, 81.5)] {
        let session = store::SessionRecord {
            id: store::new_id(),
            began_unix_s,
            task: "clamp".to_owned(),
            difficulty: "exam".to_owned(),
            outcome: if score > 70.0 { "passed" } else { "failed" }.to_owned(),
            score,
            alarms: 1,
            metrics_version: 1,
            metrics: BTreeMap::new(),
            scene: "triangle".to_owned(),
            program: "a test".to_owned(),
            file: None,
            hand: store::Hand::Person,
            circumstances: store::Circumstances::default(),
        };
        store.add_session("Kim", &session).expect("kept");
    }
}
