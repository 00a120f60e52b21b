//! Stores the bytes of a session. Bytes that the disk refuses wait in memory.

use std::fs::{File, Permissions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::{FileExt, FileTypeExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Largest number of bytes that wait for a full or slow disk: more than a minute of a session.
const WAITING_MAX_BYTES: usize = 16 << 20;

/// A sink that takes bytes at an offset and can be truncated.
pub trait Storage: Send {
    /// Writes all of `bytes` at `offset`.
    ///
    /// # Errors
    /// The error of the operating system; part of the bytes may have been written.
    fn put(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()>;
    /// Truncates the storage to `length` bytes.
    ///
    /// # Errors
    /// The error of the operating system.
    fn cut(&mut self, length: u64) -> io::Result<()>;
    /// Hands all bytes to the disk itself, so that they survive a loss of power.
    ///
    /// # Errors
    /// The error of the operating system: the disk fails.
    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Storage for File {
    fn put(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.write_all_at(bytes, offset)
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }

    fn sync(&mut self) -> io::Result<()> {
        match self.sync_data() {
            // Pipes and devices have nothing to keep.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            outcome => outcome,
        }
    }
}

/// Creates or empties a file that no other user can open: a trainee's performance is private.
///
/// # Errors
/// The error of the operating system. Another user's file is left untouched.
pub fn create_private(path: &Path) -> io::Result<File> {
    let file = open_private(path)?;
    make_own(&file)?;
    Ok(file)
}

/// Checks that a recording can be written to `path`, and changes nothing there.
pub(crate) fn check_recording(path: &Path) -> io::Result<()> {
    let is_new = !path.exists();
    refuse_pipe(path)?;
    let file = open_private(path)?;
    let free = lock_file(&file);
    if is_new {
        std::fs::remove_file(path)?;
    }
    free
}

/// Creates or empties a recording. No other recorder can write to it until the file is closed.
pub(crate) fn create_recording(path: &Path) -> io::Result<File> {
    refuse_pipe(path)?;
    let file = open_private(path)?;
    lock_file(&file)?;
    make_own(&file)?;
    Ok(file)
}

/// A pipe has no offsets, and opening it waits for a reader.
fn refuse_pipe(path: &Path) -> io::Result<()> {
    if std::fs::metadata(path).is_ok_and(|it| it.file_type().is_fifo()) {
        let words = "a recording needs a file, and this is a pipe";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, words));
    }
    Ok(())
}

/// Locks a recording until the file is closed.
fn lock_file(file: &File) -> io::Result<()> {
    if !file.metadata()?.is_file() {
        return Ok(());
    }
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let words = "another recorder is writing to it";
            Err(io::Error::new(io::ErrorKind::ResourceBusy, words))
        }
        // Recordings are allowed on a file system without locks, too.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// True if a recorder is writing this file.
#[must_use]
pub fn is_being_recorded(path: &Path) -> bool {
    let file = File::open(path);
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// Opens an existing file unchanged, or a new one.
fn open_private(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.write(true).create(true).truncate(false).mode(0o600);
    options.open(path)
}

/// Empties the file and makes it private. The mode given at opening applies to a new file only; an
/// existing one keeps its mode. Devices are left as they are, because they may refuse both.
fn make_own(file: &File) -> io::Result<()> {
    if file.metadata()?.is_file() {
        file.set_permissions(Permissions::from_mode(0o600))?;
        file.set_len(0)?;
    }
    Ok(())
}

/// Bytes in transit: finished output of the MCAP writer waits here until the disk has it.
pub(crate) struct Outbox {
    storage: Box<dyn Storage>,
    waiting: Waiting,
    /// Bytes on disk.
    pub(crate) written: u64,
    /// Number of refused writes.
    pub(crate) failures: u64,
    pub(crate) slowest: Duration,
    /// Reason for the last refusal, while bytes wait.
    pub(crate) refused: Option<String>,
    /// Reason why nothing more is written.
    pub(crate) given_up: Option<String>,
}

/// The end of the outbox into which the MCAP writer writes.
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

    /// Writes the waiting bytes. Returns true if the disk has all of them. Refused bytes go on
    /// waiting, and the file is cut back to its last complete state. If too many bytes wait, the
    /// file keeps that state for good.
    pub(crate) fn send(&mut self) -> bool {
        let mut waiting = lock(&self.waiting);
        if self.given_up.is_some() {
            waiting.clear();
            return false;
        }
        let start = Instant::now();
        let put = self.storage.put(self.written, &waiting);
        let outcome = put.and_then(|()| self.storage.sync());
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

    /// Bytes waiting for the disk.
    pub(crate) fn waits(&self) -> usize {
        lock(&self.waiting).len()
    }

    /// Writes for the last time: bytes refused now are lost.
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
