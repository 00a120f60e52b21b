//! Where a session's bytes go, and what becomes of them when they cannot.

use std::fs::{File, Permissions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::{FileExt, FileTypeExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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

/// A new or emptied file that nobody else can open: how somebody operates is theirs.
///
/// # Errors
/// As the system says. A file that is somebody else's is left as it is.
pub fn create_private(path: &Path) -> io::Result<File> {
    let file = open_private(path)?;
    make_own(&file)?;
    Ok(file)
}

/// The same for a recording: no other recorder can write over it until it is dropped.
pub(crate) fn create_recording(path: &Path) -> io::Result<File> {
    // A pipe takes nothing at a place, and to open it waits for who reads it.
    if std::fs::metadata(path).is_ok_and(|it| it.file_type().is_fifo()) {
        let words = "a recording needs a file, this is a pipe";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, words));
    }
    let file = open_private(path)?;
    if file.metadata()?.is_file() {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                let words = "another recorder is writing it";
                return Err(io::Error::new(io::ErrorKind::ResourceBusy, words));
            }
            // A file system without locks takes recordings all the same.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
    }
    make_own(&file)?;
    Ok(file)
}

/// Whether a recorder is writing this file.
#[must_use]
pub fn is_being_recorded(path: &Path) -> bool {
    let file = File::open(path);
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// As it is, or new.
fn open_private(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.write(true).create(true).truncate(false).mode(0o600);
    options.open(path)
}

/// Empties it. The mode given before is for a file that is new; one that is replaced keeps its own. A pipe or a
/// device may refuse both.
fn make_own(file: &File) -> io::Result<()> {
    if file.metadata()?.is_file() {
        file.set_permissions(Permissions::from_mode(0o600))?;
        file.set_len(0)?;
    }
    Ok(())
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
    /// Why it refused the last ones, which wait.
    pub(crate) refused: Option<String>,
    /// Why nothing more is written.
    pub(crate) given_up: Option<String>,
}

/// The MCAP writer's end.
#[derive(Debug, Clone, Default)]
pub(crate) struct Waiting(Arc<Mutex<Vec<u8>>>);

impl Write for Waiting {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        lock(self).extend_from_slice(bytes);
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
            refused: None,
            given_up: None,
        };
        (outbox, waiting)
    }

    /// Writes what waits; whether the disk has all of it. What it refuses goes on waiting, and the file
    /// ends where it was whole; when too much waits, it stays so.
    pub(crate) fn send(&mut self) -> bool {
        let mut waiting = lock(&self.waiting);
        if self.given_up.is_some() {
            waiting.clear();
            return false;
        }
        let start = Instant::now();
        let outcome = self.storage.put(self.written, &waiting);
        self.slowest = self.slowest.max(start.elapsed());
        if let Err(error) = outcome {
            self.failures += 1;
            let _ = self.storage.cut(self.written);
            if waiting.len() > WAITING_MAX_BYTES {
                self.given_up = Some(error.to_string());
                waiting.clear();
            }
            self.refused = Some(error.to_string());
            return false;
        }
        self.written += waiting.len() as u64;
        waiting.clear();
        self.refused = None;
        true
    }

    /// Bytes that wait for the disk.
    pub(crate) fn waits(&self) -> usize {
        lock(&self.waiting).len()
    }

    /// The last time: what the disk refuses now is lost.
    pub(crate) fn finish(&mut self) -> bool {
        let whole = self.send();
        if !whole && self.given_up.is_none() {
            self.given_up = self.refused.take();
        }
        whole
    }
}

fn lock(waiting: &Waiting) -> MutexGuard<'_, Vec<u8>> {
    waiting.0.lock().unwrap_or_else(PoisonError::into_inner)
}
