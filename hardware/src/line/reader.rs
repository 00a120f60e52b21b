//! Input of a serial line, read by a separate thread.
//!
//! Any system call on a terminal may wait for a kernel worker of ordinary priority. A read without
//! input flushes the line's buffer, and a query of the input's length takes the lock that the
//! worker holds while it fills the buffer. On a busy machine such a wait lasts tens of
//! milliseconds. Therefore a thread waits for input and notes the arrival time, and the tick takes
//! the bytes from memory.

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

/// Capacity for unread bytes: more than one second of a rig that reports at 1 kHz.
const CAPACITY: usize = 1 << 16;
/// Largest number of bytes of one read.
const CHUNK: usize = 4096;
/// Number of unread bytes above which the old ones are discarded. So many bytes collect only if
/// nobody polls for a while.
const BACKLOG: u64 = 2048;
/// Number of newest bytes that are kept of such a backlog.
const BACKLOG_KEPT: u64 = 512;
/// Pause after a read that filled the whole chunk, so that a flooded line does not occupy a core.
const FLOOD_PAUSE: Duration = Duration::from_millis(1);

/// Ring buffer from the reading thread to the tick.
#[derive(Debug)]
pub(crate) struct InputRing {
    ring: Box<[AtomicU8]>,
    written: AtomicU64,
    taken: AtomicU64,
    /// Bytes that nobody read in time.
    discarded: AtomicU64,
    /// Arrival time of the newest byte.
    arrived_ns: AtomicU64,
    is_lost: AtomicBool,
}

impl InputRing {
    pub(crate) fn new() -> Self {
        Self {
            ring: (0..CAPACITY).map(|_| AtomicU8::new(0)).collect(),
            written: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            discarded: AtomicU64::new(0),
            arrived_ns: AtomicU64::new(0),
            is_lost: AtomicBool::new(false),
        }
    }

    fn places(&self, from: u64) -> impl Iterator<Item = &AtomicU8> {
        let start = (from % CAPACITY as u64) as usize;
        self.ring.iter().cycle().skip(start)
    }

    /// Stores a chunk. Bytes that find no room are dropped, which happens only when nobody has
    /// polled for a second.
    pub(crate) fn put(&self, chunk: &[u8], at_ns: TimeNs) {
        let written = self.written.load(Ordering::Relaxed);
        let used = written - self.taken.load(Ordering::Acquire);
        let room = CAPACITY.saturating_sub(used as usize);
        let mut count = 0;
        for (place, &byte) in self.places(written).zip(chunk.iter().take(room)) {
            place.store(byte, Ordering::Relaxed);
            count += 1;
        }
        self.discard(chunk.len() as u64 - count);
        self.arrived_ns.store(at_ns, Ordering::Relaxed);
        self.written.store(written + count, Ordering::Release);
    }

    /// Copies the available bytes into `buffer`. If more than `BACKLOG` bytes wait, it copies only
    /// the newest.
    fn take(&self, buffer: &mut [u8]) -> (usize, TimeNs) {
        let written = self.written.load(Ordering::Acquire);
        let mut taken = self.taken.load(Ordering::Relaxed);
        if written - taken > BACKLOG {
            self.discard(written - BACKLOG_KEPT - taken);
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

    fn discard(&self, count: u64) {
        if count > 0 {
            self.discarded.fetch_add(count, Ordering::Relaxed);
        }
    }

    /// Number of bytes so far that nobody read in time.
    pub(crate) fn discarded(&self) -> u64 {
        self.discarded.load(Ordering::Relaxed)
    }

    /// Copies the available bytes into `buffer` and returns the arrival time of the newest byte.
    /// Bytes that arrived before the line was lost are still returned. This method neither waits
    /// nor allocates.
    pub(crate) fn read(&self, buffer: &mut [u8]) -> Read {
        // The flag is read first. If it is set, `take` sees all bytes from before the loss.
        let is_lost = self.is_lost();
        match self.take(buffer) {
            (0, _) if is_lost => Read::Lost,
            (0, _) => Read::Empty,
            (count, at_ns) => Read::Bytes(count, at_ns),
        }
    }

    /// True if no more bytes will come.
    pub(crate) fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Acquire)
    }

    /// Marks the end of the input.
    pub(crate) fn mark_lost(&self) {
        self.is_lost.store(true, Ordering::Release);
    }
}

/// The reading thread and its buffer. Dropping a `LineReader` ends the thread.
#[derive(Debug)]
pub(super) struct LineReader {
    bytes: Arc<InputRing>,
    /// Event that ends the thread.
    end: OwnedFd,
    thread: Option<JoinHandle<()>>,
}

impl LineReader {
    /// Starts the thread with the caller's cores and priority.
    pub(super) fn open(port: &Arc<OwnedFd>) -> io::Result<Self> {
        let end = eventfd(0, EventfdFlags::CLOEXEC)?;
        let asked_to_end = end.try_clone()?;
        let bytes = Arc::new(InputRing::new());
        let (port, into) = (Arc::clone(port), Arc::clone(&bytes));
        let thread = thread::Builder::new()
            .name("calot-line".to_owned())
            .stack_size(128 << 10)
            .spawn(move || {
                let _ = read_all(&port, &asked_to_end, &into);
                into.mark_lost();
            })?;
        Ok(Self {
            bytes,
            end,
            thread: Some(thread),
        })
    }

    /// See [`InputRing::read`].
    pub(super) fn read(&self, buffer: &mut [u8]) -> Read {
        self.bytes.read(buffer)
    }

    /// See [`InputRing::discarded`].
    pub(super) fn discarded(&self) -> u64 {
        self.bytes.discarded()
    }

    /// True if no more bytes will come.
    pub(super) fn is_lost(&self) -> bool {
        self.bytes.is_lost()
    }

    /// Ends the input.
    pub(super) fn mark_lost(&self) {
        self.bytes.mark_lost();
    }
}

impl Drop for LineReader {
    fn drop(&mut self) {
        let _ = rustix::io::write(&self.end, &1u64.to_ne_bytes());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Reads until the line is lost or the thread must end.
fn read_all(port: &OwnedFd, end: &OwnedFd, into: &InputRing) -> Result<(), Errno> {
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
            // A non-blocking tty in raw mode returns EAGAIN when idle; 0 means that the far end
            // hung up.
            Ok(0) => return Ok(()),
            Ok(count) => {
                into.put(chunk.get(..count).unwrap_or(&[]), now_ns());
                if count == CHUNK {
                    thread::sleep(FLOOD_PAUSE);
                }
            }
            Err(Errno::AGAIN | Errno::INTR) => {}
            Err(error) => return Err(error),
        }
    }
}

/// `CLOCK_MONOTONIC`, ns.
pub(crate) fn now_ns() -> TimeNs {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// If the reader polls often enough, every byte comes out once and in order.
        #[test]
        fn bytes_are_read_as_written(
            chunks in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 0..1200),
            room in 1usize..1024,
        ) {
            let bytes = InputRing::new();
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
    fn a_backlog_gives_its_newest_bytes_and_a_flood_is_harmless() {
        let bytes = InputRing::new();
        let mut buffer = [0; 1024];
        for i in 0..40u64 {
            bytes.put(&[i as u8; 100], i);
        }
        let (count, at_ns) = bytes.take(&mut buffer);
        assert_eq!((count, at_ns), (BACKLOG_KEPT as usize, 39));
        assert_eq!(buffer[..12], [34; 12]);
        assert_eq!(buffer[500..512], [39; 12]);
        assert_eq!(bytes.discarded(), 4000 - BACKLOG_KEPT);
        for i in 0..1000 {
            bytes.put(&[i as u8; CHUNK], i);
        }
        let used = bytes.written.load(Ordering::Relaxed) - bytes.taken.load(Ordering::Relaxed);
        assert_eq!(used, CAPACITY as u64, "what finds no room is dropped");
        assert_eq!(bytes.take(&mut buffer).0, BACKLOG_KEPT as usize);
        assert_eq!(bytes.take(&mut buffer).0, 0);
        bytes.put(b"on", 7);
        assert_eq!(bytes.take(&mut buffer), (2, 7));
    }
}
