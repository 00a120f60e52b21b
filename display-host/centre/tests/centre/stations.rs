//! Stations that join, leave and fail, and one that is taken off the list.

use std::process::Stdio;

use serde_json::json;

use crate::house::{House, heard, recording, sent};
use crate::support::{Killed, wait, write_list, write_text};

#[test]
fn stations_come_go_and_err_and_nothing_is_lost() {
    let names = ["s-1", "s-2", "s-3", "s-4"];
    let house = House::open(&["s-1", "s-2", "s-3", "s-4", "stranger"], &names);
    let file = house.file("recording");
    recording(&file);
    let told = std::fs::File::create(house.file("told")).expect("a file");
    let mut first = house.rehearse(&file, &names[..2]);
    let _first = Killed(first.stdout(told).spawn().expect("a rehearsal"));
    let mut second = house.rehearse(&file, &names[2..]);
    let second = Killed(second.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    let mut page = house.page();
    page.ask(&json!({"enlarge": "s-3"}));
    let large = ('v', "s-3".to_owned());
    wait("four stations, tiles and a large picture", || {
        page.look();
        let tiles = names
            .iter()
            .all(|it| page.pictures.contains_key(&('t', (*it).to_owned())));
        let is_large = page.pictures.get(&large).is_some_and(|it| *it > 3);
        (page.present() == 4 && tiles && is_large).then_some(())
    });
    assert!(
        page.pictures
            .keys()
            .all(|(kind, name)| *kind == 't' || name == "s-3")
    );
    assert_eq!(page.stations["s-1"]["state"]["task"]["score"], 90.0);
    // A station that is killed disappears, and comes back.
    drop(second);
    wait("two stations are gone", || {
        page.look();
        (page.present() == 2).then_some(())
    });
    let mut again = house.rehearse(&file, &names[2..]);
    let _again = Killed(again.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    wait("they are back", || {
        page.look();
        (page.present() == 4).then_some(())
    });
    // Every alarm that was sent so far arrives, and once.
    let sent = wait("some alarms", || {
        Some(sent(&house.file("told"))).filter(|it| it.len() > 4)
    });
    let late = wait("every alarm is in the log", || {
        page.look();
        let heard = heard(&house.centre);
        let late = { sent.iter() }.map(|(alarm, at)| Some(heard.get(alarm)?.saturating_sub(*at)));
        late.collect::<Option<Vec<u64>>>()
    });
    println!(
        "{} alarms, the latest after {:?} ms",
        late.len(),
        late.iter().max()
    );
    // A name that is taken off the list disappears at once and does not come back.
    write_list(house.folder.path(), &["s-1", "s-2", "s-4"]);
    wait("it is off the list", || {
        page.look();
        (!page.stations.contains_key("s-3") && page.present() == 3).then_some(())
    });
    // The log records who watched it. The end of a right ends the watching, as the end of the page
    // does.
    let watches = house.centre.logged("watches");
    assert_eq!(
        (&watches[0]["who"], &watches[0]["station"]),
        (&json!("bo"), &json!("s-3"))
    );
    page.ask(&json!({"enlarge": null}));
    let watched = wait("the end of the watching is logged", || {
        house.centre.logged("watched").pop()
    });
    assert_eq!(
        (&watched["who"], &watched["station"]),
        (&json!("bo"), &json!("s-3"))
    );
}

#[test]
fn a_login_that_ends_and_a_name_that_goes_end_the_live_line() {
    let house = House::open(&[], &[]);
    let (mut first, mut second) = (house.page(), house.page());
    first.look();
    assert!(!first.is_over && !second.is_over);
    let answer = first.request(
        &house.centre,
        &house.file("ca.pem"),
        "POST /logout HTTP/1.1",
    );
    assert!(answer.contains("location: /login"), "{answer}");
    wait("the line of the login that ended", || {
        first.look();
        first.is_over.then_some(())
    });
    second.look();
    assert!(!second.is_over, "the other login holds");
    write_text(house.folder.path(), "");
    wait("the line of the name that is gone", || {
        second.look();
        second.is_over.then_some(())
    });
    wait("both looks are in the log", || {
        (house.centre.logged("looked").len() == 2).then_some(())
    });
}
