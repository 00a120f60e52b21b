//! Where a session's bytes go, and what becomes of them when they cannot.

use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What may wait for a disk that is full or slow: more than a minute of a session.
const WAITING_MAX_BYTES: usize = 16 << 20;

/// Something that takes bytes at a place, and can be cut off there.
pub trait Storage: Send {
    /// Writes all of `bytes` at `offset`.
    ///
    /// # Errors
    /// As the system says; part of them may have been written.
    fn put(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()>;
    /// Makes it end at `length`.
    ///
    /// # Errors
    /// As the system says.
    fn cut(&mut self, length: u64) -> io::Result<()>;
}

impl Storage for File {
    fn put(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.write_all_at(bytes, offset)
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }
}

/// Bytes on their way: what the MCAP writer has finished waits here until the disk has it.
pub(crate) struct Outbox {
    storage: Box<dyn Storage>,
    waiting: Waiting,
    /// Bytes that the disk has.
    pub(crate) written: u64,
    /// Times that it refused some.
    pub(crate) failures: u64,
    pub(crate) slowest: Duration,
    /// Why nothing more is written.
    pub(crate) given_up: Option<String>,
}

/// The MCAP writer's end.
#[derive(Debug, Clone, Default)]
pub(crate) struct Waiting(Arc<Mutex<Vec<u8>>>);

impl Write for Waiting {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Outbox {
    pub(crate) fn new(storage: Box<dyn Storage>) -> (Self, Waiting) {
        let waiting = Waiting::default();
        let outbox = Self {
            storage,
            waiting: waiting.clone(),
            written: 0,
            failures: 0,
            slowest: Duration::ZERO,
            given_up: None,
        };
        (outbox, waiting)
    }

    /// Writes what waits. What the disk refuses goes on waiting, and the file ends where it was
    /// whole; when too much waits, it stays so.
    pub(crate) fn send(&mut self) {
        let mut waiting = self
            .waiting
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if self.given_up.is_some() {
            waiting.clear();
            return;
        }
        if waiting.is_empty() {
            return;
        }
        let start = Instant::now();
        let outcome = self.storage.put(self.written, &waiting);
        self.slowest = self.slowest.max(start.elapsed());
        match outcome {
            Ok(()) => {
                self.written += waiting.len() as u64;
                waiting.clear();
            }
            Err(error) => {
                self.failures += 1;
                let _ = self.storage.cut(self.written);
                if waiting.len() > WAITING_MAX_BYTES {
                    self.given_up = Some(error.to_string());
                    waiting.clear();
                }
            }
        }
    }

    /// The last time: what the disk refuses now is lost.
    pub(crate) fn finish(&mut self) {
        self.send();
        let waiting = self
            .waiting
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if !waiting.is_empty() && self.given_up.is_none() {
            self.given_up = Some("the disk did not take the last of it".to_owned());
        }
    }
}
