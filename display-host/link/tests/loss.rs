//! Lines that break.

mod support;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use link::wire::{SCENE, SceneAsk};
use link::{WatchConfig, watch};
use shared_mem::scene::SceneFile;
use support::{
    AtEnd, Display, beside, halfway, port, scene, scene_of, state, station, wait_until, watched,
    way,
};

fn count(seen: &Mutex<Vec<String>>, what: &str) -> usize {
    let seen = seen.lock().expect("no panic");
    seen.iter().filter(|it| it.starts_with(what)).count()
}

#[test]
fn line_lost_again_and_again_is_told_and_found_each_time() {
    const LOSSES: usize = 4;
    let folder = tempfile::tempdir().expect("a folder");
    let listen = format!("127.0.0.1:{}", port());
    let (between, address) = halfway();
    let (over, breaks) = (AtomicBool::new(false), AtomicBool::new(false));
    let there = (listen.as_str(), None);
    let result = beside("lost", there, folder.path(), (&scene(), state), |_| {
        std::thread::scope(|scope| {
            scope.spawn(|| {
                way(&between, &listen, &over, |_, _, _| {
                    !breaks.swap(false, Relaxed)
                });
            });
            let _end = AtEnd(&over);
            let copy = folder.path().join("copy.calot");
            watched("found", &address, copy, |here, seen| {
                let mut display = Display::of(here);
                for loss in 0..=LOSSES {
                    wait_until("it is found", || count(seen, "Connected") == loss + 1);
                    display.see(10);
                    if loss < LOSSES {
                        breaks.store(true, Relaxed);
                        wait_until("it is told", || count(seen, "Lost") == loss + 1);
                    }
                }
                let events = &display.events;
                assert!(events.windows(2).all(|it| it[1] == it[0] + 1), "{events:?}");
                let seen = seen.lock().expect("no panic");
                let of_line = |it: &&String| it.starts_with("Connected") || it.starts_with("Lost");
                let told: Vec<_> = seen
                    .iter()
                    .filter(of_line)
                    .map(|it| it == "Connected")
                    .collect();
                assert!(
                    told.windows(2).all(|it| it[0] != it[1]),
                    "in turns: {seen:?}"
                );
            })
        })
    });
    assert_eq!(
        (result.connections, result.events_lost),
        (LOSSES as u64 + 1, 0)
    );
}

#[test]
fn a_scene_goes_on_where_it_stood_when_the_line_was_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_of(6000);
    let listen = format!("127.0.0.1:{}", port());
    let (between, address) = halfway();
    let (over, asked) = (AtomicBool::new(false), Mutex::new(Vec::new()));
    // The first two connections break at their second question for a part.
    let passes = |connection: usize, kind: u8, content: &[u8]| {
        if kind != SCENE {
            return true;
        }
        let offset = bytemuck::pod_read_unaligned::<SceneAsk>(content).offset;
        let mut asked = asked.lock().expect("no panic");
        asked.push((connection, offset));
        connection > 1 || asked.iter().filter(|it| it.0 == connection).count() < 2
    };
    let copy = folder.path().join("copy.calot");
    let there = (listen.as_str(), None);
    beside("parts", there, folder.path(), (&scene, state), |_| {
        std::thread::scope(|scope| {
            scope.spawn(|| way(&between, &listen, &over, passes));
            let _end = AtEnd(&over);
            watched("whole", &address, copy.clone(), |_, seen| {
                wait_until("the scene is there", || count(seen, "Scene") == 1);
            });
        });
    });
    let asked = asked.into_inner().expect("no panic");
    let offsets = |connection: usize| -> Vec<u64> {
        let of = asked.iter().filter(|it| it.0 == connection);
        of.map(|it| it.1).collect()
    };
    let [first, second, third] = [0, 1, 2].map(offsets);
    assert_eq!(
        (first[0], first.len(), second.len()),
        (0, 2, 2),
        "{asked:?}"
    );
    // A question that was open when the line broke is asked again. No other question is.
    assert_eq!([second[0], third[0]], [first[1], second[1]], "{asked:?}");
    let rises = |it: &[u64]| it.is_sorted_by(|a, b| a < b);
    assert!(
        rises(&first) && rises(&second) && rises(&third),
        "{asked:?}"
    );
    let copied = SceneFile::open(&copy).expect("the scene came");
    assert_eq!(copied.id(), scene.id());
}

#[test]
fn a_rate_that_is_none_is_a_slow_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_silent, address) = halfway();
    for rate_hz in [0.0, -1.0, f64::NAN, 1e-300] {
        let config = WatchConfig {
            station: station("rate"),
            address: address.clone(),
            rate_hz,
            scene: folder.path().join("copy.calot"),
            seconds: Some(0.2),
        };
        let watched = watch(&config, &AtomicBool::new(false), |_| ());
        assert_eq!(watched.expect("it watched").states, 0);
    }
}
