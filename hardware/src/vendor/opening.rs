//! Time limit for a vendor's library that hangs while it opens its device.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use super::ended::guarded;
use crate::HardwareError;

/// Longest time that a library may take to open a device. A Touch is ready in about 1 s.
/// Calibration and ten attempts at a device in use take 3 s.
const LIMIT: Duration = Duration::from_secs(10);

/// Access to one vendor's library, which serves one driver at a time.
#[derive(Debug)]
pub(crate) struct LibraryAccess {
    /// Name of the thread that opens a device.
    name: &'static str,
    in_use: AtomicBool,
    /// True while a call into the library has not returned although its time limit is over.
    hangs: AtomicBool,
}

impl LibraryAccess {
    pub(crate) const fn new(name: &'static str) -> Self {
        Self {
            name,
            in_use: AtomicBool::new(false),
            hangs: AtomicBool::new(false),
        }
    }

    /// Frees the library for the next driver.
    pub(crate) fn release(&self) {
        self.hangs.store(false, Ordering::Release);
        self.in_use.store(false, Ordering::Release);
    }

    /// Notes that the library blocks a thread that should have ended. If that thread ends after
    /// all, it frees the library.
    pub(crate) fn mark_hung(&self) {
        self.hangs.store(true, Ordering::Release);
    }

    /// Calls `open` on a thread of its own and waits for at most 10 s. A library that takes longer
    /// blocks only that thread. No second attempt begins before the library returns, and its late
    /// result is dropped.
    pub(crate) fn open<D: Send + 'static>(
        &'static self,
        path: &Path,
        library: &Path,
        open: impl FnOnce() -> Result<D, HardwareError> + Send + 'static,
    ) -> Result<D, HardwareError> {
        let path = path.to_path_buf();
        let hangs = |path| HardwareError::Hangs {
            path,
            library: library.to_path_buf(),
            waited_s: LIMIT.as_secs(),
        };
        if self.in_use.swap(true, Ordering::AcqRel) {
            return Err(match self.hangs.load(Ordering::Acquire) {
                true => hangs(path),
                false => HardwareError::Busy { path },
            });
        }
        self.hangs.store(false, Ordering::Release);
        let (sender, receiver) = sync_channel(1);
        let named = library.display().to_string();
        let spawned = thread::Builder::new()
            .name(self.name.into())
            .spawn(move || {
                let opened = guarded(&named, open);
                if opened.is_err() {
                    self.release();
                }
                // If nobody waits any more, the device is dropped, which releases the library.
                let _ = sender.send(opened);
            });
        if let Err(error) = spawned {
            self.release();
            return Err(HardwareError::Line {
                path,
                doing: "starting a thread",
                what: error.to_string(),
            });
        }
        match receiver.recv_timeout(LIMIT) {
            Ok(opened) => opened,
            Err(RecvTimeoutError::Timeout) => {
                self.hangs.store(true, Ordering::Release);
                // The library may have returned just now.
                if let Ok(opened) = receiver.try_recv() {
                    self.hangs.store(false, Ordering::Release);
                    return opened;
                }
                Err(hangs(path))
            }
            Err(RecvTimeoutError::Disconnected) => {
                self.release();
                Err(HardwareError::Line {
                    path,
                    doing: "opening the vendor's library",
                    what: "Calot's driver panicked; please report this".to_owned(),
                })
            }
        }
    }
}
