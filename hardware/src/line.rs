//! A serial line for the tick: opened with `serialport`, then read and written without
//! allocating, and without waiting where the kernel allows that (see [`Line::read`]).
//!
//! `serialport`'s own reads box an error whenever there is nothing to read, so after opening,
//! the descriptor is non-blocking and used directly.
#![allow(unsafe_code)] // One descriptor changes hands between two crates' types.

use std::io;
use std::os::fd::{FromRawFd, IntoRawFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::OFlags;
use rustix::io::Errno;
use serialport::{ErrorKind, SerialPort, TTYPort};

use crate::HardwareError;

/// An open line. Dropping it closes it.
#[derive(Debug)]
pub(crate) struct Line {
    /// None once the line is lost.
    port: Option<OwnedFd>,
    path: PathBuf,
}

/// What a read brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Read {
    /// So many bytes.
    Bytes(usize),
    /// Nothing now.
    Empty,
    /// The line is gone.
    Lost,
}

/// What became of a write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Written {
    /// The line took everything.
    All,
    /// It took less than everything; the rest is dropped.
    Part,
    /// It took nothing.
    Nothing,
}

impl Line {
    /// Opens `path` for this program alone: raw, 8N1, RTS low where the line has one (high
    /// resets an Ascension tracker). Not for the tick.
    pub(crate) fn open(path: &Path, baud: u32) -> Result<Self, HardwareError> {
        let mut port = open_port(path, baud)?;
        // Ptys and some USB adapters have no modem lines (ENOTTY): nothing to clear there.
        let _ = port.write_request_to_send(false);
        let _ = port.clear(serialport::ClearBuffer::Input);

        // SAFETY: `into_raw_fd` gives up the port's only descriptor, which is open; from here
        // `OwnedFd` alone owns and closes it. The lock on it lives as long as the descriptor.
        let fd = unsafe { OwnedFd::from_raw_fd(port.into_raw_fd()) };
        rustix::fs::fcntl_setfl(&fd, OFlags::NONBLOCK).map_err(|errno| HardwareError::Line {
            path: path.to_path_buf(),
            doing: "switching to non-blocking",
            what: errno.to_string(),
        })?;
        Ok(Self {
            port: Some(fd),
            path: path.to_path_buf(),
        })
    }

    /// The path that was opened.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the line has gone.
    pub(crate) fn is_lost(&self) -> bool {
        self.port.is_none()
    }

    /// Reads what is there, at most `buffer`. Never allocates.
    ///
    /// A read of a tty without input waits, non-blocking or not, until a kernel worker of ordinary
    /// priority has flushed the line's buffer: on a busy machine tens of milliseconds. So the line is
    /// asked how much it holds, which flushes nothing, and read no further than that. A line that was
    /// hung up refuses the question.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> Read {
        let Some(port) = &self.port else {
            return Read::Lost;
        };
        let Ok(waiting) = rustix::io::ioctl_fionread(port) else {
            return self.lose();
        };
        let length = usize::try_from(waiting).map_or(0, |waiting| waiting.min(buffer.len()));
        let Some(buffer) = buffer.get_mut(..length).filter(|some| !some.is_empty()) else {
            return Read::Empty;
        };
        match rustix::io::read(port, buffer) {
            // A non-blocking tty in raw mode says EAGAIN when it is idle; 0 means hung up.
            Ok(0) => self.lose(),
            Ok(count) => Read::Bytes(count),
            Err(Errno::AGAIN | Errno::INTR) => Read::Empty,
            Err(_) => self.lose(),
        }
    }

    /// Writes what the line takes now; does not wait for room. Never allocates.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Written {
        let Some(port) = &self.port else {
            return Written::Nothing;
        };
        match rustix::io::write(port, bytes) {
            Ok(count) if count == bytes.len() => Written::All,
            Ok(0) | Err(Errno::AGAIN | Errno::INTR) => Written::Nothing,
            Ok(_) => Written::Part,
            Err(_) => {
                self.lose();
                Written::Nothing
            }
        }
    }

    fn lose(&mut self) -> Read {
        // Closing a dead descriptor is a short system call, once per unplugging.
        self.port = None;
        Read::Lost
    }
}

/// Opens `path` for this program alone, raw, 8N1.
pub(crate) fn open_port(path: &Path, baud: u32) -> Result<TTYPort, HardwareError> {
    serialport::new(path.to_string_lossy(), baud)
        .timeout(Duration::from_millis(100))
        .open_native()
        .map_err(|error| open_error(path, &error))
}

fn open_error(path: &Path, error: &serialport::Error) -> HardwareError {
    let path = path.to_path_buf();
    // `serialport` reports a taken line and a vanished one alike (`NoDevice`), and what is no
    // terminal as unknown; the file system tells them apart.
    let exists = std::fs::metadata(&path);
    match (error.kind(), exists) {
        (ErrorKind::Io(io::ErrorKind::PermissionDenied), _) => HardwareError::Permission { path },
        (_, Err(missing)) if missing.kind() == io::ErrorKind::NotFound => {
            HardwareError::Missing { path }
        }
        (ErrorKind::NoDevice, Ok(_)) => HardwareError::Busy { path },
        (_, Ok(_)) => HardwareError::NotSerial {
            path,
            what: error.description.clone(),
        },
        (_, Err(_)) => HardwareError::Line {
            path,
            doing: "opening",
            what: error.description.clone(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// The far end and a line on a pty.
    fn pair() -> (TTYPort, Line) {
        let (far, near) = TTYPort::pair().unwrap();
        let path = PathBuf::from(near.name().unwrap());
        drop(near);
        let line = Line::open(&path, 115_200).unwrap();
        (far, line)
    }

    #[test]
    fn reads_no_more_than_the_buffer_and_loses_nothing() {
        let (mut far, mut line) = pair();
        far.write_all(b"0123456789").unwrap();
        let mut heard = Vec::new();
        let mut buffer = [0; 4];
        for _ in 0..1000 {
            match line.read(&mut buffer) {
                Read::Bytes(count) => heard.extend_from_slice(&buffer[..count]),
                Read::Empty => std::thread::sleep(Duration::from_millis(1)),
                Read::Lost => panic!("lost"),
            }
            if heard.len() == 10 {
                break;
            }
        }
        assert_eq!(heard, b"0123456789");
    }

    #[test]
    fn a_silent_line_stays_and_an_unplugged_one_is_noticed() {
        let (far, mut line) = pair();
        let mut buffer = [0; 4];
        for _ in 0..50 {
            assert_eq!(line.read(&mut buffer), Read::Empty);
        }
        drop(far);
        assert_eq!(line.read(&mut buffer), Read::Lost);
        assert!(line.is_lost());
    }
}
