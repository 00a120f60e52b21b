//! A limit for a vendor's library that hangs while it opens its device.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use super::hd;
use crate::HardwareError;

/// Longest time that the library may take. A Touch is ready in about 1 s. Calibration and ten
/// attempts at a device in use take 3 s.
pub(super) const LIMIT: Duration = Duration::from_secs(10);

/// The library has one scheduler, so only one driver may exist.
static IN_USE: AtomicBool = AtomicBool::new(false);
/// True while an attempt runs that nobody waits for any more.
static HANGS: AtomicBool = AtomicBool::new(false);

/// Frees the library for the next driver.
pub(super) fn release() {
    HANGS.store(false, Ordering::Release);
    IN_USE.store(false, Ordering::Release);
}

/// Calls `open` on a thread of its own and waits for at most `limit`. A library that takes longer
/// keeps that thread, and nothing else. No second attempt begins before it returns, and its late
/// result is dropped.
pub(super) fn within<D: Send + 'static>(
    limit: Duration,
    path: &Path,
    library: &Path,
    open: impl FnOnce() -> Result<D, HardwareError> + Send + 'static,
) -> Result<D, HardwareError> {
    let path = path.to_path_buf();
    let hangs = |path| HardwareError::Hangs {
        path,
        library: library.to_path_buf(),
        waited_s: limit.as_secs(),
    };
    if IN_USE.swap(true, Ordering::AcqRel) {
        return Err(match HANGS.load(Ordering::Acquire) {
            true => hangs(path),
            false => HardwareError::Busy { path },
        });
    }
    HANGS.store(false, Ordering::Release);
    let (tell, told) = sync_channel(1);
    let named = library.display().to_string();
    let spawned = thread::Builder::new().name("touch".into()).spawn(move || {
        let opened = hd::guarded(&named, open);
        if opened.is_err() {
            release();
        }
        // If nobody waits any more, the device is dropped, which releases the library.
        let _ = tell.send(opened);
    });
    if let Err(error) = spawned {
        release();
        return Err(HardwareError::Line {
            path,
            doing: "starting a thread",
            what: error.to_string(),
        });
    }
    match told.recv_timeout(limit) {
        Ok(opened) => opened,
        Err(RecvTimeoutError::Timeout) => {
            HANGS.store(true, Ordering::Release);
            // The library may have returned just now.
            if let Ok(opened) = told.try_recv() {
                HANGS.store(false, Ordering::Release);
                return opened;
            }
            Err(hangs(path))
        }
        Err(RecvTimeoutError::Disconnected) => {
            release();
            Err(hangs(path))
        }
    }
}
