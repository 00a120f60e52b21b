//! The service's socket with a time limit on every read and write. Without these limits, a message
//! that arrives one byte at a time could hold the thread for ever.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// A stream with one deadline for waiting and one for the whole exchange.
#[derive(Debug)]
pub(super) struct TimedStream {
    stream: TcpStream,
    wait_until: Instant,
    end: Instant,
    /// True once a read was tried after the deadline. One such read is allowed, because the thread
    /// itself may have been late.
    is_late: bool,
}

impl TimedStream {
    pub(super) fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        let now = Instant::now();
        Ok(Self {
            stream,
            wait_until: now,
            end: now,
            is_late: false,
        })
    }

    /// A second handle of the socket, with which another thread can close it.
    pub(super) fn try_clone(&self) -> io::Result<TcpStream> {
        self.stream.try_clone()
    }

    /// From now on a read waits for `wait` and a write for `end`. Each then returns `WouldBlock`.
    /// The second read after `end` returns `TimedOut`.
    pub(super) fn limit(&mut self, wait: Duration, end: Duration) {
        let now = Instant::now();
        self.wait_until = now + wait;
        self.end = now + end;
        self.is_late = false;
    }

    /// Closes the connection.
    pub(super) fn hang_up(&self) {
        let _ = self.stream.shutdown(Shutdown::Both);
    }

    /// Waits until the socket is ready, at most until `until`.
    fn wait(&self, flags: PollFlags, until: Instant) -> io::Result<()> {
        let Some(left) = until.checked_duration_since(Instant::now()) else {
            return Err(ErrorKind::WouldBlock.into());
        };
        let timeout = Timespec::try_from(left).map_err(|_| ErrorKind::InvalidInput)?;
        match poll(&mut [PollFd::new(&self.stream, flags)], Some(&timeout)) {
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

impl Read for TimedStream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if Instant::now() >= self.end && std::mem::replace(&mut self.is_late, true) {
                return Err(ErrorKind::TimedOut.into());
            }
            match self.stream.read(buffer) {
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    self.wait(PollFlags::IN, self.wait_until)?;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                done => return done,
            }
        }
    }
}

impl Write for TimedStream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        loop {
            match self.stream.write(bytes) {
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    self.wait(PollFlags::OUT, self.end)?;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                done => return done,
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}
