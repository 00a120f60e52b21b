//! One connection of a client.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::message::Message;
use super::request::{Heard, Inbox};
use super::wire::Version;

/// Largest number of bytes from a client that one call reads.
const READ_BYTES: usize = 4096;
/// Largest number of messages of a client that one call answers.
pub(super) const ANSWERS_MAX: usize = 16;

/// A connected client.
#[derive(Debug)]
pub(super) struct Client {
    stream: TcpStream,
    inbox: Inbox,
    /// Rest of a message that the socket did not take whole.
    rest: Vec<u8>,
    /// The client will send nothing more. It may still read.
    is_done_sending: bool,
    /// Version of the client's last message, in which it is sent everything.
    version: Version,
    tracking: Option<Tracking>,
    /// The client was told once that its data are not taken.
    pub(super) is_told_of_data: bool,
}

#[derive(Debug, Clone, Copy)]
struct Tracking {
    every: Duration,
    due: Instant,
}

impl Client {
    pub(super) fn new(stream: TcpStream) -> Self {
        Self {
            stream,
            inbox: Inbox::default(),
            rest: Vec::new(),
            is_done_sending: false,
            version: Version::One,
            tracking: None,
            is_told_of_data: false,
        }
    }

    /// Reads and returns what the client sent. Bounded in each call.
    ///
    /// # Errors
    ///
    /// The socket's error: the client is gone.
    pub(super) fn hear(&mut self) -> io::Result<Vec<Heard>> {
        if !self.is_done_sending && self.inbox.has_room() {
            let mut bytes = [0; READ_BYTES];
            match self.stream.read(&mut bytes) {
                Ok(0) => self.is_done_sending = true,
                Ok(count) => self.inbox.add(bytes.get(..count).unwrap_or_default()),
                Err(error) if is_for_later(&error) => {}
                Err(error) => return Err(error),
            }
        }
        let heard = std::iter::from_fn(|| self.inbox.next());
        Ok(heard.take(ANSWERS_MAX).collect())
    }

    /// Sends everything from now on in the version of the client's message.
    pub(super) fn speak(&mut self, version: Version) {
        self.version = match version {
            Version::One => Version::One,
            Version::Two { .. } => Version::Two { message_id: 0 },
        };
    }

    /// Begins to send tracking data, at most one in each `every`.
    pub(super) fn start_tracking(&mut self, every: Duration) {
        let due = Instant::now();
        self.tracking = Some(Tracking { every, due });
    }

    /// Ends sending tracking data.
    pub(super) fn stop_tracking(&mut self) {
        self.tracking = None;
    }

    /// True if the client asked for tracking data and its time has come; moves the time on.
    pub(super) fn is_tracking_due(&mut self, now: Instant) -> bool {
        let Some(tracking) = &mut self.tracking else {
            return false;
        };
        let is_due = now >= tracking.due;
        if is_due {
            // The rate holds on average, but a pause is not made up for.
            let next = tracking.due + tracking.every;
            tracking.due = if next < now {
                now + tracking.every
            } else {
                next
            };
        }
        is_due
    }

    /// Sends a message in the client's version. Returns true if the socket took it, or the first
    /// part of it; false if the client does not read fast enough and misses it.
    ///
    /// # Errors
    ///
    /// The socket's error: the client is gone.
    pub(super) fn send(&mut self, message: &Message) -> io::Result<bool> {
        self.send_bytes(&message.bytes(self.version))
    }

    /// Sends an answer in the version of its request.
    ///
    /// # Errors
    ///
    /// Like [`Client::send`].
    pub(super) fn answer(&mut self, message: &Message, version: Version) -> io::Result<bool> {
        self.send_bytes(&message.bytes(version))
    }

    fn send_bytes(&mut self, message: &[u8]) -> io::Result<bool> {
        if !self.rest.is_empty() {
            let sent = self.write(&self.rest)?;
            self.rest.drain(..sent);
            if !self.rest.is_empty() {
                return Ok(false);
            }
        }
        let sent = self.write(message)?;
        if sent == 0 {
            return Ok(false);
        }
        self.rest.extend(message.iter().skip(sent));
        Ok(true)
    }

    fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        match (&self.stream).write(bytes) {
            Ok(0) => Err(ErrorKind::WriteZero.into()),
            Err(error) if is_for_later(&error) => Ok(0),
            other => other,
        }
    }
}

fn is_for_later(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
