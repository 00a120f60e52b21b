//! What comes in on a line, read by a thread of its own.
//!
//! Any system call on a terminal may wait for a kernel worker of ordinary priority: a read without
//! input flushes the line's buffer, a question for how much there is takes the lock that the worker
//! holds while it fills it. On a busy machine that takes tens of milliseconds. So a thread waits
//! here, notes when bytes arrived, and the tick takes them from memory.

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rt_core::time::TimeNs;
use rustix::event::{EventfdFlags, PollFd, PollFlags, eventfd, poll};
use rustix::io::Errno;
use rustix::time::{ClockId, clock_gettime};

use super::Read;

/// Room for bytes that nobody has taken yet: a second of a 1 kHz rig.
const ROOM: usize = 1 << 16;
/// Most bytes of one read.
const CHUNK: usize = 4096;
/// More bytes than this were left while nobody polled: they are history.
const BACKLOG: u64 = 2048;
/// What of a backlog is still taken: its newest.
const BACKLOG_KEPT: u64 = 512;
/// Between two reads of a line that brings more than any device sends.
const FLOODED: Duration = Duration::from_millis(1);

/// The bytes between the reading thread and the tick: one writes, the other takes.
#[derive(Debug)]
pub(crate) struct Bytes {
    ring: Box<[AtomicU8]>,
    written: AtomicU64,
    taken: AtomicU64,
    /// When the last of them arrived.
    arrived_ns: AtomicU64,
    is_lost: AtomicBool,
}

impl Bytes {
    pub(crate) fn new() -> Self {
        Self {
            ring: (0..ROOM).map(|_| AtomicU8::new(0)).collect(),
            written: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            arrived_ns: AtomicU64::new(0),
            is_lost: AtomicBool::new(false),
        }
    }

    fn places(&self, from: u64) -> impl Iterator<Item = &AtomicU8> {
        let start = (from % ROOM as u64) as usize;
        self.ring.iter().cycle().skip(start)
    }

    /// Takes in what arrived. What finds no room is dropped: nobody has polled for a second.
    pub(crate) fn put(&self, chunk: &[u8], at_ns: TimeNs) {
        let written = self.written.load(Ordering::Relaxed);
        let used = written - self.taken.load(Ordering::Acquire);
        let room = ROOM.saturating_sub(used as usize);
        let mut count = 0;
        for (place, &byte) in self.places(written).zip(chunk.iter().take(room)) {
            place.store(byte, Ordering::Relaxed);
            count += 1;
        }
        self.arrived_ns.store(at_ns, Ordering::Relaxed);
        self.written.store(written + count, Ordering::Release);
    }

    /// Gives what is there, at most `buffer`; of a backlog the newest.
    fn take(&self, buffer: &mut [u8]) -> (usize, TimeNs) {
        let written = self.written.load(Ordering::Acquire);
        let mut taken = self.taken.load(Ordering::Relaxed);
        if written - taken > BACKLOG {
            taken = written - BACKLOG_KEPT;
        }
        let waiting = (written - taken) as usize;
        let mut count = 0;
        for (to, place) in buffer.iter_mut().zip(self.places(taken).take(waiting)) {
            *to = place.load(Ordering::Relaxed);
            count += 1;
        }
        self.taken.store(taken + count as u64, Ordering::Release);
        (count, self.arrived_ns.load(Ordering::Relaxed))
    }

    /// What is there, at most `buffer`, and when the last of it arrived; what came before a loss is
    /// still given. Neither waits nor allocates.
    pub(crate) fn read(&self, buffer: &mut [u8]) -> Read {
        // Asked first: what arrived before the loss is then there.
        let is_lost = self.is_lost();
        match self.take(buffer) {
            (0, _) if is_lost => Read::Lost,
            (0, _) => Read::Empty,
            (count, at_ns) => Read::Bytes(count, at_ns),
        }
    }

    /// Whether nothing will come any more.
    pub(crate) fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Acquire)
    }

    /// Nothing will come any more.
    pub(crate) fn lose(&self) {
        self.is_lost.store(true, Ordering::Release);
    }
}

/// The reading thread and what it has read. Dropping it ends the thread.
#[derive(Debug)]
pub(super) struct Inlet {
    bytes: Arc<Bytes>,
    /// Written to when the thread shall end.
    end: OwnedFd,
    thread: Option<JoinHandle<()>>,
}

impl Inlet {
    /// Starts the thread, with the caller's cores and priority.
    pub(super) fn open(port: &Arc<OwnedFd>) -> io::Result<Self> {
        let end = eventfd(0, EventfdFlags::CLOEXEC)?;
        let asked_to_end = end.try_clone()?;
        let bytes = Arc::new(Bytes::new());
        let (port, into) = (Arc::clone(port), Arc::clone(&bytes));
        let thread = thread::Builder::new()
            .name("calot-line".to_owned())
            .stack_size(128 << 10)
            .spawn(move || {
                let _ = read_all(&port, &asked_to_end, &into);
                into.lose();
            })?;
        Ok(Self {
            bytes,
            end,
            thread: Some(thread),
        })
    }

    /// See [`Bytes::read`].
    pub(super) fn read(&self, buffer: &mut [u8]) -> Read {
        self.bytes.read(buffer)
    }

    /// Whether nothing will come any more.
    pub(super) fn is_lost(&self) -> bool {
        self.bytes.is_lost()
    }

    /// Nothing shall be read any more.
    pub(super) fn lose(&self) {
        self.bytes.lose();
    }
}

impl Drop for Inlet {
    fn drop(&mut self) {
        let _ = rustix::io::write(&self.end, &1u64.to_ne_bytes());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Reads until the line is lost or the thread is asked to end.
fn read_all(port: &OwnedFd, end: &OwnedFd, into: &Bytes) -> Result<(), Errno> {
    let mut chunk = [0; CHUNK];
    loop {
        let mut watched = [
            PollFd::new(port, PollFlags::IN),
            PollFd::new(end, PollFlags::IN),
        ];
        match poll(&mut watched, None) {
            Ok(_) if !watched[1].revents().is_empty() => return Ok(()),
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error),
        }
        match rustix::io::read(port, &mut chunk) {
            // A non-blocking tty in raw mode says EAGAIN when it is idle; 0 means hung up.
            Ok(0) => return Ok(()),
            Ok(count) => {
                into.put(chunk.get(..count).unwrap_or(&[]), now_ns());
                if count == CHUNK {
                    thread::sleep(FLOODED);
                }
            }
            Err(Errno::AGAIN | Errno::INTR) => {}
            Err(error) => return Err(error),
        }
    }
}

/// Host time.
pub(crate) fn now_ns() -> TimeNs {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// As long as it is polled often enough every byte comes out, once and in order.
        #[test]
        fn what_is_put_in_comes_out(
            chunks in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 0..1200),
            room in 1usize..1024,
        ) {
            let bytes = Bytes::new();
            let mut heard = Vec::new();
            let mut buffer = vec![0; room];
            for (i, chunk) in chunks.iter().enumerate() {
                bytes.put(chunk, i as u64);
                loop {
                    let (count, at_ns) = bytes.take(&mut buffer);
                    heard.extend_from_slice(&buffer[..count]);
                    prop_assert_eq!(at_ns, i as u64);
                    if count == 0 {
                        break;
                    }
                }
            }
            prop_assert_eq!(heard, chunks.concat());
        }
    }

    #[test]
    fn of_a_backlog_the_newest_bytes_come_and_a_flood_is_no_danger() {
        let bytes = Bytes::new();
        let mut buffer = [0; 1024];
        for i in 0..40u64 {
            bytes.put(&[i as u8; 100], i);
        }
        let (count, at_ns) = bytes.take(&mut buffer);
        assert_eq!((count, at_ns), (BACKLOG_KEPT as usize, 39));
        assert_eq!(buffer[..12], [34; 12]);
        assert_eq!(buffer[500..512], [39; 12]);
        for i in 0..1000 {
            bytes.put(&[i as u8; CHUNK], i);
        }
        let used = bytes.written.load(Ordering::Relaxed) - bytes.taken.load(Ordering::Relaxed);
        assert_eq!(used, ROOM as u64, "what finds no room is dropped");
        assert_eq!(bytes.take(&mut buffer).0, BACKLOG_KEPT as usize);
        assert_eq!(bytes.take(&mut buffer).0, 0);
        bytes.put(b"on", 7);
        assert_eq!(bytes.take(&mut buffer), (2, 7));
    }
}
