//! Fifty stations and five viewers, with stations killed, cut off and returning. A measurement of
//! minutes, which `cargo xtask crowd SECONDS` runs. `CALOT_RECORDING` names another recording of
//! `calot tell` than the one that is made here.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::cut::Cable;
use crate::house::{House, Sent, heard, recording, sent};
use crate::support::{Killed, wait};

/// Numbers of stations that play all the time, that are cut off, and that are killed.
const STEADY: usize = 40;
const CUT: usize = 5;
const KILLED: usize = 5;
const VIEWERS: usize = 5;
/// Interval between two disturbances.
const DISTURBED_EVERY: Duration = Duration::from_secs(10);
/// Longest delay of an alarm of a station that nobody disturbs, ms.
const LATE_MAX_MS: u64 = 1000;

#[test]
#[ignore = "a measurement of minutes"]
fn a_crowd_of_stations_and_viewers_loses_no_alarm() {
    let variable = |name: &str| std::env::var(name).ok();
    let seconds = variable("CALOT_SECONDS").map_or(60, |it| it.parse().expect("seconds"));
    let names: Vec<String> = { 1..=STEADY + CUT + KILLED }
        .map(|it| format!("s-{it}"))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let house = House::open(&names, &names);
    let file = variable("CALOT_RECORDING").map_or_else(
        || {
            recording(&house.file("recording"));
            house.file("recording")
        },
        PathBuf::from,
    );
    let play = |address: &str, names: &[&str], told: &str| {
        let mut command = house.rehearse_at(address, &file, names);
        let told = File::create(house.file(told)).expect("a file");
        Killed(
            command
                .stdout(told)
                .stderr(Stdio::null())
                .spawn()
                .expect("a rehearsal"),
        )
    };
    let cable = Cable::to(&house.centre.stations);
    let (steady, others) = names.split_at(STEADY);
    let (cut, killed) = others.split_at(CUT);
    let stations = play(&house.centre.stations, steady, "told");
    let _cut = play(&cable.address, cut, "told-cut");
    let mut victims = play(&house.centre.stations, killed, "told-killed");
    let over = AtomicBool::new(false);
    std::thread::scope(|threads| {
        let viewers: Vec<_> = { 0..VIEWERS }
            .map(|viewer| {
                let (house, names, over) = (&house, &names, &over);
                threads.spawn(move || view(house, names[viewer], names.len(), over))
            })
            .collect();
        // All viewers see all stations before the disturbances begin.
        let mut page = house.page();
        wait("all stations", || {
            page.look();
            (page.present() == names.len()).then_some(())
        });
        drop(page);
        let (start, before) = (Instant::now(), used(house.centre.id()));
        let mut turn = 0;
        while start.elapsed() < Duration::from_secs(seconds) {
            std::thread::sleep(DISTURBED_EVERY / 2);
            match turn % 2 {
                0 => cable.cut(),
                _ => victims = play(&house.centre.stations, killed, "told-killed"),
            }
            std::thread::sleep(DISTURBED_EVERY / 2);
            cable.mend();
            turn += 1;
        }
        let after = used(house.centre.id());
        over.store(true, Relaxed);
        println!(
            "centre: {:.0} % of a core, {} MB; {STEADY} stations in one process: {} MB",
            100.0 * (after.0 - before.0) / start.elapsed().as_secs_f64(),
            after.1,
            used(stations.0.id()).1
        );
        for it in viewers {
            let (seconds, pictures) = it.join().expect("a viewer");
            let rate = |wanted: char| {
                let of_kind = pictures.iter().filter(|((kind, _), _)| *kind == wanted);
                of_kind.map(|(_, count)| f64::from(*count)).sum::<f64>() / seconds
            };
            println!(
                "viewer: {:.1} tiles/s, {:.1} large pictures/s",
                rate('t'),
                rate('v')
            );
        }
    });
    drop(victims);
    judge(&house, &house.file("told"));
    println!("went: {} times", house.centre.logged("went").len());
}

/// Looks at all stations and enlarges one, until it is over.
fn view(
    house: &House,
    large: &str,
    stations: usize,
    over: &AtomicBool,
) -> (f64, BTreeMap<(char, String), u32>) {
    let mut page = house.page();
    page.ask(&json!({"enlarge": large}));
    wait("all stations", || {
        page.look();
        (page.present() == stations).then_some(())
    });
    page.pictures.clear();
    let start = Instant::now();
    while !over.load(Relaxed) {
        page.look();
    }
    assert!(!page.is_over, "the centre ended a viewer's line");
    (start.elapsed().as_secs_f64(), page.pictures)
}

/// Alarms of the stations that nobody disturbed: none is lost, and none is late.
fn judge(house: &House, told: &Path) {
    let sent = sent(told);
    let missing =
        |heard: &BTreeMap<Sent, u64>| sent.keys().filter(|it| !heard.contains_key(*it)).count();
    // Alarms on their way now arrive.
    std::thread::sleep(Duration::from_secs(2));
    let heard = heard(&house.centre);
    let lost = missing(&heard);
    let late = sent
        .iter()
        .filter_map(|(it, at)| Some(heard.get(it)?.saturating_sub(*at)));
    let mut late: Vec<u64> = late.collect();
    late.sort_unstable();
    let [median, most] = [late.len() / 2, late.len() - 1].map(|it| late[it]);
    println!(
        "alarms: {} sent, {lost} lost, median {median} ms, latest {most} ms",
        sent.len()
    );
    assert_eq!(lost, 0);
    assert!(most <= LATE_MAX_MS, "the latest took {most} ms");
}

/// Processor time of a process, s, and its memory, MB.
fn used(process: u32) -> (f64, u64) {
    let read = |file: &str| std::fs::read_to_string(format!("/proc/{process}/{file}"));
    let stat = read("stat").expect("it runs");
    let fields = stat.rsplit(") ").next().expect("fields");
    let fields: Vec<&str> = fields.split(' ').collect();
    let ticks = |at: usize| fields[at].parse::<f64>().expect("ticks");
    let status = read("status").expect("it runs");
    let memory = { status.lines() }.find_map(|it| it.strip_prefix("VmRSS:"));
    let memory = memory.expect("memory").trim().trim_end_matches(" kB");
    // The kernel counts in hundredths of a second.
    let seconds = (ticks(11) + ticks(12)) / 100.0;
    (seconds, memory.parse::<u64>().expect("kB") / 1000)
}
