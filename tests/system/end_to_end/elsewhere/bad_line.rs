//! A bad line between two networks.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// Delay of the line in one direction.
const DELAY: Duration = Duration::from_millis(40);
/// Time that a lost packet holds up the line until it is sent again.
const LOST: Duration = Duration::from_millis(250);
/// One packet in this many is lost.
const LOSES_ONE_IN: u64 = 50;

/// A line that delays all data and loses some. TCP sends lost data again; until then the data that
/// follow wait.
pub(super) fn bad_line(from: &str, to: String, lost: Arc<AtomicU64>) {
    let listener = TcpListener::bind(from).expect("an address of ours");
    std::thread::spawn(move || {
        for near in listener.incoming().map_while(Result::ok) {
            let Ok(far) = TcpStream::connect(&to) else {
                continue;
            };
            let two = |it: &TcpStream| it.try_clone().expect("a socket");
            pass(two(&near), two(&far), lost.clone());
            pass(far, near, lost.clone());
        }
    });
}

fn pass(mut from: TcpStream, mut to: TcpStream, lost: Arc<AtomicU64>) {
    let (sender, chunks) = mpsc::sync_channel::<(Instant, Vec<u8>)>(256);
    std::thread::spawn(move || {
        let (mut bytes, mut count) = (vec![0; 16 << 10], 0u64);
        while let Ok(length @ 1..) = from.read(&mut bytes) {
            count += 1;
            let mut due = Instant::now() + DELAY;
            if count.is_multiple_of(LOSES_ONE_IN) {
                lost.fetch_add(1, Relaxed);
                due += LOST;
            }
            if sender.send((due, bytes[..length].to_vec())).is_err() {
                return;
            }
        }
    });
    std::thread::spawn(move || {
        for (due, chunk) in chunks {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            if to.write_all(&chunk).is_err() {
                break;
            }
        }
        let _ = to.shutdown(Shutdown::Both);
    });
}
