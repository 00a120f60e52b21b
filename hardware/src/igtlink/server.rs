//! A server that sends the same messages to all clients and answers their requests. It never waits
//! for a client.

mod answer;
#[cfg(test)]
mod tests;

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::time::Instant;

use super::client::{Client, Form};
use super::message::{Code, Message};

/// Types of messages that hold the present state. They are forgotten when the source falls silent.
const PRESENT_STATE_KINDS: [&str; 5] = ["TRANSFORM", "TDATA", "QTDATA", "SENSOR", "POLYDATA"];

/// A listening server.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    /// Name of the device in the server's own answers.
    name: String,
    /// Name of the frame of all poses, in capitals.
    frame: String,
    clients: Vec<Client>,
    /// Newest message of each type and name, for requests.
    newest: Vec<Message>,
    /// Newest messages for clients that connect later.
    announcements: Vec<Message>,
    skipped: u64,
    turned_away: u64,
}

impl Server {
    /// Default port of 3D Slicer.
    pub const PORT: u16 = 18944;
    /// Largest number of clients at once; more are turned away with a `STATUS`.
    pub const CLIENTS_MAX: usize = 8;

    /// Starts listening. Use a loopback address unless others on the network may see the poses: the
    /// protocol has no login. `name` is the name of the device in the server's own answers. `frame`
    /// is the frame of the poses.
    ///
    /// # Errors
    ///
    /// The system's error, e.g. if the port is taken.
    pub fn bind(address: impl ToSocketAddrs, name: &str, frame: &str) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            name: name.to_owned(),
            frame: frame.to_uppercase(),
            clients: Vec::new(),
            newest: Vec::new(),
            announcements: Vec::new(),
            skipped: 0,
            turned_away: 0,
        })
    }

    /// Address of the server.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Number of connected clients.
    #[must_use]
    pub fn client_count(&self) -> usize {
        self.clients.len()
    }

    /// Number of messages that slow clients missed.
    #[must_use]
    pub const fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Number of clients that were turned away.
    #[must_use]
    pub const fn turned_away(&self) -> u64 {
        self.turned_away
    }

    /// Accepts new clients, answers requests, and removes clients that have gone. `unix_ns` is the
    /// time in the server's own answers. Never blocks.
    pub fn attend(&mut self, unix_ns: u64) {
        self.accept(unix_ns);
        let mut clients = std::mem::take(&mut self.clients);
        clients.retain_mut(|client| self.answer(client, unix_ns).is_ok() && self.greet(client));
        self.clients = clients;
    }

    /// Sends the newest announcements to a client that now begins to get messages without a
    /// request. Returns false if the client has gone.
    fn greet(&self, client: &mut Client) -> bool {
        !client.begins_to_get_all(Instant::now())
            || self.announcements.iter().all(|it| client.send(it).is_ok())
    }

    /// Sends messages to all clients that get messages without a request. `TDATA` and `QTDATA` go
    /// only to clients that requested them. Never blocks: a client that does not read misses
    /// messages. A client that has gone is removed.
    pub fn send(&mut self, messages: &[Message]) {
        let now = Instant::now();
        let mut skipped = 0;
        self.clients.retain_mut(|client| {
            messages.iter().all(|message| {
                let is_due = match Form::of(message.kind) {
                    Some(form) => client.is_tracking_due(form, now),
                    None => client.gets_all(),
                };
                if !is_due {
                    return true;
                }
                let sent = client.send(message);
                skipped += u64::from(matches!(sent, Ok(false)));
                sent.is_ok()
            })
        });
        self.skipped += skipped;
        for message in messages {
            keep(&mut self.newest, message);
        }
    }

    /// Sends a message to all clients, and later to each that connects.
    pub fn announce(&mut self, message: &Message) {
        self.send(std::slice::from_ref(message));
        keep(&mut self.announcements, message);
    }

    /// Forgets the newest poses and values, so that no answer has old ones.
    pub fn forget_moment(&mut self) {
        self.newest
            .retain(|message| !PRESENT_STATE_KINDS.contains(&message.kind));
    }

    fn accept(&mut self, unix_ns: u64) {
        // Bounded, so that a flood of connections cannot hold the caller.
        for _ in 0..Self::CLIENTS_MAX {
            let Ok((stream, _)) = self.listener.accept() else {
                return;
            };
            if stream.set_nonblocking(true).is_err() {
                continue;
            }
            if self.clients.len() >= Self::CLIENTS_MAX {
                self.turn_away(stream, unix_ns);
                continue;
            }
            let _ = stream.set_nodelay(true);
            self.clients.push(Client::new(stream));
        }
    }

    /// Tells a client beyond the limit the reason, and closes its connection.
    fn turn_away(&mut self, stream: TcpStream, unix_ns: u64) {
        self.turned_away += 1;
        let words = format!(
            "{} clients are connected, and more are not served",
            Self::CLIENTS_MAX
        );
        let full = Message::status(&self.name, Code::Busy, "full", &words, unix_ns);
        let _ = Client::new(stream).send(&full);
    }
}

/// Stores a message. It replaces the last one of its type and name.
fn keep(messages: &mut Vec<Message>, message: &Message) {
    let is_same = |it: &&mut Message| it.kind == message.kind && it.name == message.name;
    match messages.iter_mut().find(is_same) {
        Some(place) => place.clone_from(message),
        None => messages.push(message.clone()),
    }
}
