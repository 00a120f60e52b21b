//! Fifty stations and five viewers. Run by hand: `cargo test --release --test centre -- --ignored
//! --nocapture crowd`. `CALOT_SECONDS` sets its length, `CALOT_RECORDING` names a recording of
//! `calot tell`.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use super::*;

const STATIONS: usize = 50;
const VIEWERS: usize = 5;

#[test]
#[ignore = "a measurement of minutes"]
fn a_crowd_of_stations_and_viewers() {
    let variable = |name: &str| std::env::var(name).ok();
    let seconds = variable("CALOT_SECONDS").map_or(60, |it| it.parse().expect("seconds"));
    let names: Vec<String> = (1..=STATIONS).map(|it| format!("s-{it}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let house = House::open(&names, &names);
    let file = variable("CALOT_RECORDING").map_or_else(
        || {
            let file = house.file("recording");
            recording(&file);
            file
        },
        PathBuf::from,
    );
    let told = std::fs::File::create(house.file("told")).expect("a file");
    let mut stations = house.rehearse(&file, &names);
    let stations = Killed(stations.stdout(told).spawn().expect("a rehearsal"));
    let over = AtomicBool::new(false);
    let seen: Vec<BTreeMap<(char, String), u32>> = std::thread::scope(|threads| {
        let viewers: Vec<_> = (0..VIEWERS)
            .map(|viewer| {
                let (house, names, over) = (&house, &names, &over);
                threads.spawn(move || {
                    let mut page = house.page();
                    page.ask(&json!({"enlarge": names[viewer]}));
                    wait("all stations", || {
                        page.look();
                        (page.present() == STATIONS).then_some(())
                    });
                    page.pictures.clear();
                    while !over.load(Relaxed) {
                        page.look();
                    }
                    page.pictures
                })
            })
            .collect();
        let start = Instant::now();
        let before = used(house.centre.id());
        std::thread::sleep(Duration::from_secs(seconds));
        let after = used(house.centre.id());
        over.store(true, Relaxed);
        println!(
            "centre: {:.0} % of a core, {} MB; stations in one process: {} MB",
            100.0 * (after.0 - before.0) / start.elapsed().as_secs_f64(),
            after.1,
            used(stations.0.id()).1
        );
        viewers
            .into_iter()
            .map(|it| it.join().expect("a viewer"))
            .collect()
    });
    for pictures in &seen {
        let count = |wanted: char| {
            let of_kind = pictures.iter().filter(|((kind, _), _)| *kind == wanted);
            of_kind.map(|(_, count)| u64::from(*count)).sum::<u64>() as f64 / seconds as f64
        };
        println!(
            "viewer: {:.1} tiles/s, {:.1} large pictures/s",
            count('t'),
            count('v')
        );
    }
    std::thread::sleep(Duration::from_secs(2));
    drop(stations);
    let mut sent = sent(&house.file("told"));
    let last = sent.values().max().copied().unwrap_or(0);
    sent.retain(|_, at| *at + 500 < last);
    let heard = house.centre.logged("alarm");
    let heard: BTreeMap<_, u64> = { heard.iter() }
        .map(|it| {
            (
                of(it, &it["detail"]),
                it["at_unix_ms"].as_u64().expect("a time"),
            )
        })
        .collect();
    let late = sent
        .iter()
        .map(|(it, at)| heard.get(it).map(|heard| heard.saturating_sub(*at)));
    let mut late: Vec<Option<u64>> = late.collect();
    late.sort_unstable();
    let lost = late.iter().filter(|it| it.is_none()).count();
    let (median, most) = (late[late.len() / 2], late.last().copied().flatten());
    println!(
        "alarms: {} sent, {lost} lost, median {median:?} ms, latest {most:?} ms",
        sent.len()
    );
    assert_eq!(lost, 0);
}

/// Processor time of a process, s, and its memory, MB.
fn used(process: u32) -> (f64, u64) {
    let read = |file: &str| std::fs::read_to_string(format!("/proc/{process}/{file}"));
    let stat = read("stat").expect("it runs");
    let fields: Vec<&str> = stat
        .rsplit(") ")
        .next()
        .expect("fields")
        .split(' ')
        .collect();
    let ticks = |at: usize| fields[at].parse::<f64>().expect("ticks");
    let status = read("status").expect("it runs");
    let memory = status
        .lines()
        .find_map(|it| it.strip_prefix("VmRSS:"))
        .expect("memory");
    let memory = memory
        .trim()
        .trim_end_matches(" kB")
        .parse::<u64>()
        .expect("kB");
    // The kernel counts in hundredths of a second.
    ((ticks(11) + ticks(12)) / 100.0, memory / 1000)
}
