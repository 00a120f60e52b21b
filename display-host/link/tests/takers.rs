//! Watchers that ask but read slowly or not at all.

mod support;

use std::io::{ErrorKind, Read as _, Write};
use std::net::TcpStream;
use std::time::Duration;

use support::{
    Display, Proven, beside, beside_a_station, full_state, port, question, scene, tls, wait_until,
    watched,
};

/// Asks without reading until the other side disconnects.
fn ask_until_cut(mut line: impl Write) -> bool {
    let questions = question().repeat(100);
    let mut cut = false;
    wait_until("it is cut off", || {
        match line.write(&questions) {
            Ok(_) => {}
            Err(error) => {
                cut = !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
            }
        }
        cut
    });
    cut
}

#[test]
fn peer_that_takes_nothing_is_cut_off_and_others_go_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let Proven {
        theatre,
        desk: ours,
        listen,
        address,
    } = Proven::in_folder(folder.path());
    let there = (listen.as_str(), Some(theatre));
    let copy = folder.path().join("copy.calot");
    let watched = beside_a_station("slow", there, folder.path(), |_| {
        watched("beside", &address, copy, |here, _| {
            let mut display = Display::of(here);
            display.see(10);
            std::thread::scope(|scope| {
                let taker = scope.spawn(|| {
                    let mut line = tls(&listen, &ours);
                    line.write_all(&question()).expect("it is let in");
                    let patience = Some(Duration::from_millis(50));
                    line.sock.set_write_timeout(patience).expect("set");
                    ask_until_cut(line)
                });
                while !taker.is_finished() {
                    display.see(1);
                }
                assert!(taker.join().expect("no panic"));
            });
            display.see(10);
            let events = &display.events;
            assert!(events.windows(2).all(|it| it[1] == it[0] + 1), "{events:?}");
        })
    });
    assert_eq!((watched.connections, watched.events_lost), (1, 0));
}

/// True if the bytes end inside a message.
fn breaks_off(mut bytes: &[u8]) -> bool {
    while let Some((head, rest)) = bytes.split_first_chunk::<4>() {
        let length = u32::from_le_bytes(*head) as usize + 1;
        let Some(rest) = rest.get(length..) else {
            return true;
        };
        bytes = rest;
    }
    !bytes.is_empty()
}

/// The end of `serve` does not wait until slow watchers have their answers.
#[test]
fn server_that_ends_sends_nobody_the_rest() {
    const TAKERS: usize = 4;
    let folder = tempfile::tempdir().expect("a folder");
    let listen = format!("127.0.0.1:{}", port());
    let there = (listen.as_str(), None);
    std::thread::scope(|scope| {
        let (tell, told) = std::sync::mpsc::channel::<()>();
        let takers = beside(
            "rest",
            there,
            folder.path(),
            (&scene(), full_state),
            |ticks| {
                wait_until("it moves", || {
                    ticks.load(std::sync::atomic::Ordering::Relaxed) > 10
                });
                let takers: Vec<_> = (0..TAKERS)
                    .map(|_| {
                        let (tell, listen) = (tell.clone(), listen.clone());
                        scope.spawn(move || {
                            let mut line = TcpStream::connect(&listen).expect("it listens");
                            // All questions reach the station before it answers the first.
                            line.write_all(&question().repeat(250)).expect("sent");
                            let (mut taken, mut part) = (Vec::new(), vec![0; 64 << 10]);
                            let mut tell = Some(tell);
                            while let Ok(count @ 1..) = line.read(&mut part) {
                                taken.extend_from_slice(&part[..count]);
                                if taken.len() > 2 << 20 {
                                    tell = None;
                                }
                                std::thread::sleep(Duration::from_millis(10));
                            }
                            drop(tell);
                            taken
                        })
                    })
                    .collect();
                drop(tell);
                // Each watcher has read 2 MB. The rest of the answers exceeds the system's buffers.
                let _ = told.recv();
                takers
            },
        );
        let taken = takers.into_iter().map(|it| it.join().expect("no panic"));
        let broken_off = taken.filter(|it| breaks_off(it)).count();
        assert!(broken_off > 0, "all have whole answers");
    });
}
