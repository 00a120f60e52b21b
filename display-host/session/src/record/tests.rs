use std::sync::atomic::AtomicU64;
use std::sync::mpsc;

use bytemuck::Zeroable as _;
use shared_mem::message::EventMsg;
use shared_mem::service::{Station, Tap};

use super::queue::{Item, Items, QUEUE, queue};
use super::*;

#[test]
fn one_recorder_too_many_is_refused_in_the_station_s_words() {
    let station = Station::new(&format!("taps-{}", std::process::id())).expect("a plain name");
    let recorders = [(); 2].map(|()| Tap::open(&station).expect("room for two"));
    let refused = Listening::begin(&station, |_| {}, None).expect_err("both places are taken");
    assert!(matches!(refused, Error::Service(_)), "{refused:?}");
    let (name, count) = (station.name(), recorders.len());
    let whole = format!("station '{name}' has {count} recorders already; close one");
    assert_eq!(refused.to_string(), whole);
}

/// A listener whose messages are already queued; the station is gone.
fn heard(items: Items, overflowed: Arc<AtomicU64>) -> Listening {
    Listening {
        thread: std::thread::spawn(|| {}),
        stop: Arc::default(),
        overflowed,
        items,
        prepare: |_| {},
        tick_cpu: None,
    }
}

fn config(path: PathBuf) -> Config {
    Config {
        path,
        build: "a test".to_owned(),
        scene: crate::tests::scene(),
        assignment: None,
        sight: Sight::default(),
        acts: Acts::default(),
        course: None,
        hears: None,
    }
}

#[test]
fn events_that_a_full_queue_loses_are_counted_and_reported() {
    let overflowed = Arc::new(AtomicU64::new(0));
    let (queue, items) = queue(overflowed.clone());
    for sequence in 0..QUEUE as u64 + 3 {
        queue.send(Item::Event(EventMsg {
            sequence,
            ..EventMsg::zeroed()
        }));
    }
    drop(queue);
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path().join("session.mcap"));
    let recording = heard(items, overflowed).record(config).unwrap();
    let recorded = recording.end().unwrap();
    // No tick is missing, so only the count of events shows the loss.
    assert_eq!(
        (
            recorded.missing,
            recorded.missing_events,
            recorded.overflowed
        ),
        (0, 3, 3)
    );
    let warning = recorded.warning().unwrap();
    assert!(warning.contains("misses 3 events"), "{warning}");
}

#[test]
fn two_recorders_do_not_write_over_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.mcap");
    let begin = || {
        let overflowed = Arc::new(AtomicU64::new(0));
        let (queue, items) = queue(overflowed.clone());
        let recording = heard(items, overflowed).record(config(path.clone()));
        (queue, recording)
    };
    let (queue, first) = begin();
    let error = begin().1.unwrap_err().to_string();
    assert!(error.contains("another recorder"), "{error}");
    assert!(crate::is_being_recorded(&path));
    drop(queue);
    let recorded = first.unwrap().end().unwrap();
    assert_eq!(recorded.problem, None);
    assert_eq!(std::fs::metadata(&path).unwrap().len(), recorded.bytes);
    // After the end the file may be replaced.
    assert!(!crate::is_being_recorded(&path));
    let (queue, again) = begin();
    drop(queue);
    assert_eq!(again.unwrap().end().unwrap().problem, None);
}

#[test]
fn a_pipe_is_refused_instead_of_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe");
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    let fifo = rustix::fs::FileType::Fifo;
    rustix::fs::mknodat(rustix::fs::CWD, &path, fifo, mode, 0).unwrap();
    let (_queue, items) = queue(Arc::default());
    let refused = heard(items, Arc::default()).record(config(path));
    let error = refused.unwrap_err().to_string();
    assert!(error.contains("needs a file"), "{error}");
}

#[test]
fn the_end_does_not_wait_for_a_disk_that_hangs() {
    let (hold, held) = mpsc::channel::<()>();
    let recording = Recording {
        listener: std::thread::spawn(|| {}),
        stop: Arc::default(),
        writer: std::thread::spawn(move || {
            let _ = held.recv();
            Recorded::none_yet(PathBuf::new())
        }),
        health: Arc::new(Mutex::new(Health {
            bytes: 7,
            reported: Some(Instant::now()),
            ..Health::default()
        })),
        file: "session.mcap".into(),
    };
    let recorded = recording.end_within(Duration::from_millis(50)).unwrap();
    let problem = recorded.problem.clone().unwrap();
    assert!(problem.contains("has not answered"), "{problem}");
    assert_eq!(
        (recorded.bytes, recorded.file.to_str()),
        (7, Some("session.mcap"))
    );
    drop(hold);
}
