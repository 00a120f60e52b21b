//! Load by authorised and unauthorised peers. This test has a program of its own, because it
//! measures that program's memory.

mod support;

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use link::Keys;
use support::{
    AtEnd, Display, Proven, beside_a_station, message, question, tls, wait_until, watched,
};

/// Answers before the first measurement of memory.
const BEFORE: u64 = 1_000;
/// Answers between the two measurements of memory. Each has about 10 kB, so that a leak of every
/// answer would show.
const MANY: u64 = 15_000;
/// Longest wait of a peer without a certificate before it disconnects.
const SHORT: Duration = Duration::from_millis(30);
/// Largest growth of memory that other causes than a leak explain, bytes.
const GROWN_MAX_BYTES: u64 = 64 << 20;

/// Resident memory of this program, bytes.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("it is there");
    let line = text.lines().find_map(|it| it.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|it| it.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.expect("a number") << 10
}

/// Asks and reads answers as fast as possible.
fn flood(listen: &str, keys: &Keys, over: &AtomicBool, answers: &AtomicU64) {
    let mut line = tls(listen, keys);
    while !over.load(Relaxed) {
        line.write_all(&question()).expect("it is taken");
        message(&mut line).expect("it is answered");
        answers.fetch_add(1, Relaxed);
    }
}

/// Sends questions without end, reads no answer, and reconnects when it is cut off.
fn pile_up(listen: &str, keys: &Keys, over: &AtomicBool) {
    while !over.load(Relaxed) {
        let mut line = tls(listen, keys);
        if line.write_all(&question()).is_err() {
            continue;
        }
        let patience = Some(Duration::from_millis(50));
        line.sock.set_write_timeout(patience).expect("set");
        while !over.load(Relaxed) {
            match line.write(&question().repeat(50)) {
                Err(error) if error.kind() != std::io::ErrorKind::WouldBlock => break,
                _ => {}
            }
        }
    }
}

/// Connects without a certificate: with noise, half a greeting, or nothing.
fn knock(listen: &str, over: &AtomicBool, first: &[u8], stays: Duration) {
    while !over.load(Relaxed) {
        let Ok(mut line) = TcpStream::connect(listen) else {
            continue;
        };
        let _ = line.write_all(first);
        let _ = line.set_read_timeout(Some(stays));
        let _ = line.read(&mut [0; 1024]);
    }
}

#[test]
fn flood_of_questions_and_knocks_keeps_nobody_waiting_and_no_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let Proven {
        theatre,
        desk: ours,
        listen,
        address,
    } = Proven::in_folder(folder.path());
    let there = (listen.as_str(), Some(theatre));
    let (over, answers) = (AtomicBool::new(false), AtomicU64::new(0));
    let noise: Vec<u8> = (0..4000u32).map(|i| (i * 7 % 251) as u8).collect();
    let half_a_greeting = [0x16, 3, 1, 2, 0, 1, 0, 1];
    let copy = folder.path().join("copy.calot");
    let watched = beside_a_station("flood", there, folder.path(), |_| {
        std::thread::scope(|scope| {
            let _end = AtEnd(&over);
            for _ in 0..3 {
                scope.spawn(|| flood(&listen, &ours, &over, &answers));
                scope.spawn(|| knock(&listen, &over, &half_a_greeting, Duration::from_secs(2)));
            }
            scope.spawn(|| pile_up(&listen, &ours, &over));
            scope.spawn(|| knock(&listen, &over, &noise, SHORT));
            scope.spawn(|| knock(&listen, &over, &[], SHORT));
            // The watcher connects while all these peers are active.
            wait_until("they are answered", || answers.load(Relaxed) > BEFORE);
            watched("calm", &address, copy, |here, _| {
                let mut display = Display::of(here);
                display.see(20);
                let before = resident();
                let until = answers.load(Relaxed) + MANY;
                wait_until("many are answered", || {
                    display.see(1);
                    answers.load(Relaxed) > until
                });
                let grown = resident().saturating_sub(before);
                assert!(grown < GROWN_MAX_BYTES, "{grown} bytes");
                let events = &display.events;
                assert!(events.windows(2).all(|it| it[1] == it[0] + 1), "{events:?}");
            })
        })
    });
    assert_eq!((watched.connections, watched.events_lost), (1, 0));
}
