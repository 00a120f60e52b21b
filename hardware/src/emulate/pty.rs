//! A pty as a device's line. The emulator holds the master; a symbolic link leads the controller to
//! the other side.

use std::fs;
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, ioctl_tiocnxcl, tcgetattr, tcsetattr};

use crate::HardwareError;

/// A connected line. Dropping it hangs up and removes the link.
#[derive(Debug)]
pub(super) struct Pty {
    master: OwnedFd,
    /// Kept open, so that raw mode (no echo) remains after a controller has closed the line.
    slave: OwnedFd,
    link: PathBuf,
    target: PathBuf,
}

impl Pty {
    /// Makes a pty and lets `link` point to it atomically.
    pub(super) fn plug_in(link: &Path) -> Result<Self, HardwareError> {
        let failed = |doing: &'static str| {
            move |errno: Errno| HardwareError::Line {
                path: link.to_path_buf(),
                doing,
                what: errno.to_string(),
            }
        };
        let making = failed("making a pty");
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
            .map_err(&making)?;
        grantpt(&master).map_err(&making)?;
        unlockpt(&master).map_err(&making)?;
        let name = ptsname(&master, Vec::new()).map_err(&making)?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(&name, flags, rustix::fs::Mode::empty()).map_err(&making)?;
        let mut termios = tcgetattr(&slave).map_err(&making)?;
        termios.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &termios).map_err(&making)?;
        rustix::fs::fcntl_setfl(&master, OFlags::NONBLOCK).map_err(&making)?;

        let target = PathBuf::from(std::ffi::OsStr::from_bytes(name.as_bytes()));
        let temporary = link.with_extension("new");
        let linking = |error: std::io::Error| HardwareError::Line {
            path: link.to_path_buf(),
            doing: "making the link",
            what: error.to_string(),
        };
        let _ = fs::remove_file(&temporary);
        std::os::unix::fs::symlink(&target, &temporary).map_err(linking)?;
        fs::rename(&temporary, link).map_err(linking)?;
        Ok(Self {
            master,
            slave,
            link: link.to_path_buf(),
            target,
        })
    }

    /// Reads the controller's bytes and returns their number; 0 when it is silent or gone.
    pub(super) fn read(&mut self, buffer: &mut [u8]) -> usize {
        rustix::io::read(&self.master, buffer).unwrap_or(0)
    }

    /// Writes all that fits. A controller that does not read loses the rest, as on a real line.
    pub(super) fn write(&mut self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.master, bytes);
    }

    /// Ends the exclusive mode that a killed controller left on the line. A running controller
    /// keeps its file lock.
    pub(super) fn lift_exclusive_use(&self) {
        let _ = ioctl_tiocnxcl(&self.slave);
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // Remove only our own link: another emulator may have replaced it.
        if fs::read_link(&self.link).is_ok_and(|target| target == self.target) {
            let _ = fs::remove_file(&self.link);
        }
    }
}
