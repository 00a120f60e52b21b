//! One connection of a client.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::message::Message;
use super::request::{Inbox, Incoming};
use super::wire::Version;

/// Largest number of bytes from a client that one call reads.
const READ_BYTES: usize = 4096;
/// Largest number of messages of a client that one call answers.
pub(super) const ANSWERS_MAX: usize = 16;

/// Time in which a new client may send a first request. Until then it gets no message without a
/// request.
const FIRST_REQUEST_TIME: Duration = Duration::from_millis(200);
/// A client that began with a request gets answers only. It gets all messages once it has sent no
/// request for this time.
const ANSWERS_ONLY_TIME: Duration = Duration::from_secs(5);

/// A connected client.
#[derive(Debug)]
pub(super) struct Client {
    stream: TcpStream,
    inbox: Inbox,
    /// Unsent rest of the last message.
    unsent: Vec<u8>,
    /// True if the client has closed its sending side. It may still read.
    is_done_sending: bool,
    /// Version of the client's last message. All messages to this client have this version.
    version: Version,
    mode: Mode,
    /// Tracking data that the client requested, with rotations as matrices and as quaternions.
    tracking: [Option<Tracking>; 2],
    /// True once the client was told that the server ignores its data.
    pub(super) is_told_of_data: bool,
}

/// State of a client that decides whether it gets messages without a request.
#[derive(Debug, Clone, Copy)]
enum Mode {
    /// It is new, and may begin with a request until this time.
    AwaitingRequest(Instant),
    /// It sends requests, and takes the next message as the answer. The state ends at this time.
    AnswersOnly(Instant),
    /// It gets all messages.
    AllMessages,
}

/// Form of tracking data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// `TDATA`
    Matrix,
    /// `QTDATA`
    Quaternion,
}

impl Form {
    /// The form of messages of this type; `None` if they are no tracking data.
    pub(super) fn of(kind: &str) -> Option<Self> {
        match kind {
            "TDATA" => Some(Self::Matrix),
            "QTDATA" => Some(Self::Quaternion),
            _ => None,
        }
    }
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
            unsent: Vec::new(),
            is_done_sending: false,
            version: Version::One,
            mode: Mode::AwaitingRequest(Instant::now() + FIRST_REQUEST_TIME),
            tracking: [None; 2],
            is_told_of_data: false,
        }
    }

    /// Reads what the client sent, and returns its complete messages. Each call reads and returns a
    /// bounded amount.
    ///
    /// # Errors
    ///
    /// The socket's error: the client is gone.
    pub(super) fn receive(&mut self) -> io::Result<Vec<Incoming>> {
        if !self.is_done_sending && self.inbox.has_room() {
            let mut bytes = [0; READ_BYTES];
            match self.stream.read(&mut bytes) {
                Ok(0) => self.is_done_sending = true,
                Ok(count) => self.inbox.add(bytes.get(..count).unwrap_or_default()),
                Err(error) if is_temporary(&error) => {}
                Err(error) => return Err(error),
            }
        }
        let heard = std::iter::from_fn(|| self.inbox.next());
        Ok(heard.take(ANSWERS_MAX).collect())
    }

    /// Uses the version of the client's message for all later messages.
    pub(super) fn use_version(&mut self, version: Version) {
        self.version = match version {
            Version::One => Version::One,
            Version::Two { .. } => Version::Two { message_id: 0 },
        };
    }

    /// Notes a request for data. The client takes the next message as the answer.
    pub(super) fn note_request(&mut self) {
        if !matches!(self.mode, Mode::AllMessages) {
            self.mode = Mode::AnswersOnly(Instant::now() + ANSWERS_ONLY_TIME);
        }
    }

    /// True if the client gets messages without a request.
    pub(super) const fn gets_all(&self) -> bool {
        matches!(self.mode, Mode::AllMessages)
    }

    /// Returns true once, when the client begins to get messages without a request: its time for a
    /// request is over, or it has closed its sending side.
    pub(super) fn begins_to_get_all(&mut self, now: Instant) -> bool {
        let (Mode::AwaitingRequest(end) | Mode::AnswersOnly(end)) = self.mode else {
            return false;
        };
        let begins = now >= end || self.is_done_sending;
        if begins {
            self.mode = Mode::AllMessages;
        }
        begins
    }

    /// Begins to send tracking data of a form, at most one message in each `every`.
    pub(super) fn start_tracking(&mut self, form: Form, every: Duration) {
        let due = Instant::now();
        *self.tracking_in(form) = Some(Tracking { every, due });
    }

    /// Stops sending tracking data of a form.
    pub(super) fn stop_tracking(&mut self, form: Form) {
        *self.tracking_in(form) = None;
    }

    const fn tracking_in(&mut self, form: Form) -> &mut Option<Tracking> {
        let [matrix, quaternion] = &mut self.tracking;
        match form {
            Form::Matrix => matrix,
            Form::Quaternion => quaternion,
        }
    }

    /// True if the client requested tracking data of this form and the next message is due. The
    /// message after it is then scheduled.
    pub(super) fn is_tracking_due(&mut self, form: Form, now: Instant) -> bool {
        let Some(tracking) = self.tracking_in(form) else {
            return false;
        };
        let is_due = now >= tracking.due;
        if is_due {
            // The mean rate is kept, but a pause is not caught up.
            let next = tracking.due + tracking.every;
            tracking.due = if next < now {
                now + tracking.every
            } else {
                next
            };
        }
        is_due
    }

    /// Sends a message in the client's version. Returns true if the socket took all or a first part
    /// of it. Returns false if the client does not read fast enough and misses the message.
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
        if !self.unsent.is_empty() {
            let sent = self.write(&self.unsent)?;
            self.unsent.drain(..sent);
            if !self.unsent.is_empty() {
                return Ok(false);
            }
        }
        let sent = self.write(message)?;
        if sent == 0 {
            return Ok(false);
        }
        self.unsent.extend(message.iter().skip(sent));
        Ok(true)
    }

    fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        match (&self.stream).write(bytes) {
            Ok(0) => Err(ErrorKind::WriteZero.into()),
            Err(error) if is_temporary(&error) => Ok(0),
            other => other,
        }
    }
}

fn is_temporary(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
