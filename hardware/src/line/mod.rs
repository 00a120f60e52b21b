//! A serial line for the tick. The crate `serialport` opens the line, a separate thread reads it
//! ([`reader`]), and the tick writes to the descriptor directly. So the tick neither waits nor
//! allocates.
//!
//! A read through `serialport` allocates an error whenever there is no input. So after opening,
//! this module uses the non-blocking descriptor directly.
#![allow(unsafe_code)] // A descriptor passes from a type of `serialport` to `OwnedFd`.

mod holder;
mod reader;

use core::fmt;
use std::io;
use std::os::fd::{FromRawFd, IntoRawFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rt_core::time::TimeNs;
use rustix::fs::OFlags;
use rustix::io::Errno;
use serialport::{ErrorKind, SerialPort, TTYPort};

use crate::HardwareError;
pub use holder::{Holder, holders, socket_holders};
use reader::LineReader;
pub(crate) use reader::{InputRing, now_ns};

/// An open line. Dropping a `Line` closes it and waits for the reading thread, so the tick must
/// never drop one.
#[derive(Debug)]
pub(crate) struct Line {
    connection: Connection,
    path: PathBuf,
}

/// Connection of a line: a terminal or memory.
#[derive(Debug)]
enum Connection {
    /// A terminal.
    Tty {
        // The order of the fields matters: the reader is dropped before the port. The reader's
        // thread also holds the port, which closes with its last holder.
        reader: LineReader,
        port: Arc<OwnedFd>,
    },
    /// A device in memory, which receives the host's bytes at once.
    Memory {
        input: Arc<InputRing>,
        device: Arc<dyn MemoryDevice>,
    },
}

/// A device in memory, without a terminal, a thread or a clock of its own. Tests and simulations
/// use it.
pub(crate) trait MemoryDevice: fmt::Debug + Send + Sync {
    /// Receives the host's bytes.
    fn receive(&self, bytes: &[u8]);
}

/// Result of a read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Read {
    /// Number of bytes, and the arrival time of the last.
    Bytes(usize, TimeNs),
    /// No input now.
    Empty,
    /// The line is lost.
    Lost,
}

/// Result of a write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Written {
    /// The line took everything.
    All,
    /// The line took this many bytes, and the rest is dropped.
    Part(usize),
    /// The line took nothing.
    Nothing,
}

impl Line {
    /// Opens `path` exclusively, in raw mode with 8N1. Sets RTS low if the line has that wire,
    /// because a high RTS resets an Ascension tracker. May wait, so the tick must not call it.
    pub(crate) fn open(path: &Path, baud: u32) -> Result<Self, HardwareError> {
        let mut port = open_port(path, baud)?;
        // Ptys and some USB adapters have no RTS (ENOTTY), so there the error is ignored.
        let _ = port.write_request_to_send(false);
        let _ = port.clear(serialport::ClearBuffer::Input);

        // SAFETY: `into_raw_fd` gives up the port's only descriptor, which is open; from here
        // `OwnedFd` alone owns and closes it. The exclusive lock lives as long as the descriptor.
        let fd = unsafe { OwnedFd::from_raw_fd(port.into_raw_fd()) };
        let line_error = |doing, what: String| HardwareError::Line {
            path: path.to_path_buf(),
            doing,
            what,
        };
        rustix::fs::fcntl_setfl(&fd, OFlags::NONBLOCK)
            .map_err(|errno| line_error("switching to non-blocking", errno.to_string()))?;
        let port = Arc::new(fd);
        let reader = LineReader::open(&port)
            .map_err(|error| line_error("starting its reading thread", error.to_string()))?;
        Ok(Self {
            connection: Connection::Tty { reader, port },
            path: path.to_path_buf(),
        })
    }

    /// A line to a device in memory. Bytes put into `input` are its input.
    pub(crate) fn in_memory(input: Arc<InputRing>, device: Arc<dyn MemoryDevice>) -> Self {
        Self {
            connection: Connection::Memory { input, device },
            path: PathBuf::from("played"),
        }
    }

    /// Path of the line.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// True if the line is lost.
    pub(crate) fn is_lost(&self) -> bool {
        match &self.connection {
            Connection::Tty { reader, .. } => reader.is_lost(),
            Connection::Memory { input, .. } => input.is_lost(),
        }
    }

    /// Reads the available bytes, at most as many as `buffer` holds. Of more than 2 KiB, it keeps
    /// only the newest 512 bytes. Bytes that arrived before the line was lost are still returned.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> Read {
        match &self.connection {
            Connection::Tty { reader, .. } => reader.read(buffer),
            Connection::Memory { input, .. } => input.read(buffer),
        }
    }

    /// Number of bytes dropped so far because nobody read them in time.
    pub(crate) fn discarded(&self) -> u64 {
        match &self.connection {
            Connection::Tty { reader, .. } => reader.discarded(),
            Connection::Memory { input, .. } => input.discarded(),
        }
    }

    /// Writes the bytes that the line takes now, without waiting for room. Never allocates.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Written {
        if self.is_lost() {
            return Written::Nothing;
        }
        let (reader, port) = match &self.connection {
            Connection::Tty { reader, port } => (reader, port),
            Connection::Memory { device, .. } => {
                device.receive(bytes);
                return Written::All;
            }
        };
        match rustix::io::write(&**port, bytes) {
            Ok(count) if count == bytes.len() => Written::All,
            Ok(0) | Err(Errno::AGAIN | Errno::INTR) => Written::Nothing,
            Ok(count) => Written::Part(count),
            Err(_) => {
                reader.mark_lost();
                Written::Nothing
            }
        }
    }
}

/// Opens `path` exclusively: raw, 8N1.
pub(crate) fn open_port(path: &Path, baud: u32) -> Result<TTYPort, HardwareError> {
    serialport::new(path.to_string_lossy(), baud)
        .timeout(Duration::from_millis(100))
        .open_native()
        .map_err(|error| open_error(path, &error))
}

fn open_error(path: &Path, error: &serialport::Error) -> HardwareError {
    let path = path.to_path_buf();
    // `serialport` reports a busy and a missing line alike (`NoDevice`), and a path that is no
    // terminal as unknown. The file system tells them apart.
    let exists = std::fs::metadata(&path);
    match (error.kind(), exists) {
        (ErrorKind::Io(io::ErrorKind::PermissionDenied), _) => HardwareError::Permission { path },
        (_, Err(missing)) if missing.kind() == io::ErrorKind::NotFound => {
            HardwareError::Missing { path }
        }
        (ErrorKind::NoDevice, Ok(_)) => {
            let by: Vec<String> = holders(&path).iter().map(Holder::to_string).collect();
            match by.is_empty() {
                true => HardwareError::Busy { path },
                false => HardwareError::Held {
                    path,
                    by: by.join(", "),
                },
            }
        }
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

    /// A pty: its far end, and a line opened on its near end.
    fn pair() -> (TTYPort, Line) {
        let (far, near) = TTYPort::pair().unwrap();
        let path = PathBuf::from(near.name().unwrap());
        drop(near);
        let line = Line::open(&path, 115_200).unwrap();
        (far, line)
    }

    #[test]
    fn the_error_for_missing_permission_names_the_group() {
        let kind = ErrorKind::Io(io::ErrorKind::PermissionDenied);
        let said = open_error(Path::new("/dev/tty"), &serialport::Error::new(kind, ""));
        let words = "permission denied. Add yourself to the group";
        assert!(said.to_string().contains(words), "{said}");
    }

    #[test]
    fn a_read_takes_no_more_than_the_buffer_holds_and_loses_nothing() {
        let (mut far, mut line) = pair();
        far.write_all(b"0123456789").unwrap();
        let mut heard = Vec::new();
        let mut buffer = [0; 4];
        for _ in 0..30_000 {
            match line.read(&mut buffer) {
                Read::Bytes(count, _) => heard.extend_from_slice(&buffer[..count]),
                Read::Empty => std::thread::sleep(Duration::from_millis(1)),
                Read::Lost => panic!("lost"),
            }
            if heard.len() == 10 {
                break;
            }
        }
        assert_eq!(heard, b"0123456789");
    }

    /// First result other than `Empty`. On a busy machine it may take a while.
    fn first_result(line: &mut Line) -> Read {
        let mut buffer = [0; 4];
        for _ in 0..30_000 {
            match line.read(&mut buffer) {
                Read::Empty => std::thread::sleep(Duration::from_millis(1)),
                heard => return heard,
            }
        }
        Read::Empty
    }

    #[test]
    fn a_silent_line_stays_open_and_an_unplugged_one_is_noticed() {
        let (mut far, mut line) = pair();
        let mut buffer = [0; 4];
        for _ in 0..50 {
            assert_eq!(line.read(&mut buffer), Read::Empty);
        }
        far.write_all(b"end").unwrap();
        assert!(matches!(first_result(&mut line), Read::Bytes(3, _)));
        drop(far);
        assert_eq!(first_result(&mut line), Read::Lost);
        assert!(line.is_lost());
        assert_eq!(line.write(b"?"), Written::Nothing);
    }

    #[test]
    fn a_closed_line_can_be_opened_again_at_once() {
        let (far, line) = pair();
        let path = line.path().to_path_buf();
        drop(line);
        let mut again = Line::open(&path, 115_200).unwrap();
        drop(far);
        assert_eq!(first_result(&mut again), Read::Lost);
    }
}
