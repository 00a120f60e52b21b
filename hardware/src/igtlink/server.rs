//! A server that sends the same messages to all clients and waits for none.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};

use super::wire::Transform;

/// Largest number of clients at once; more are turned away.
const CLIENTS_MAX: usize = 8;
/// Largest number of bytes from a client that one call reads and discards.
const DROP_BYTES: usize = 4096;

/// A listening server.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    clients: Vec<Client>,
    skipped: u64,
}

#[derive(Debug)]
struct Client {
    stream: TcpStream,
    /// Rest of a message that the socket did not take whole.
    rest: Vec<u8>,
}

impl Server {
    /// Default port of 3D Slicer.
    pub const PORT: u16 = 18944;

    /// Starts listening. Use a loopback address unless others on the network may see the poses: the
    /// protocol has no login.
    pub fn bind(address: impl ToSocketAddrs) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            clients: Vec::new(),
            skipped: 0,
        })
    }

    /// Address of the server.
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

    /// Accepts new clients and sends these poses to all. Never blocks: a client that does not read
    /// misses messages, and one that is gone is removed.
    pub fn publish(&mut self, transforms: &[Transform<'_>]) {
        self.accept();
        let mut skipped = 0;
        self.clients.retain_mut(|client| {
            if !client.discard_requests() {
                return false;
            }
            for message in transforms.iter().filter_map(Transform::bytes) {
                match client.send(&message) {
                    Ok(true) => {}
                    Ok(false) => skipped += 1,
                    Err(_) => return false,
                }
            }
            true
        });
        self.skipped += skipped;
    }

    fn accept(&mut self) {
        // Bounded, so that a flood of connections cannot hold the caller.
        for _ in 0..CLIENTS_MAX {
            let Ok((stream, _)) = self.listener.accept() else {
                return;
            };
            // A client beyond the limit is closed at once.
            if self.clients.len() < CLIENTS_MAX && stream.set_nonblocking(true).is_ok() {
                let _ = stream.set_nodelay(true);
                self.clients.push(Client {
                    stream,
                    rest: Vec::new(),
                });
            }
        }
    }
}

impl Client {
    /// Reads and discards the client's requests, which are not served. Returns true if the client
    /// is still connected.
    fn discard_requests(&mut self) -> bool {
        match self.stream.read(&mut [0; DROP_BYTES]) {
            Ok(count) => count > 0,
            Err(error) => error.kind() == ErrorKind::WouldBlock,
        }
    }

    /// Returns true if the socket took the message, or the first part of it.
    fn send(&mut self, message: &[u8]) -> io::Result<bool> {
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
        self.rest.extend_from_slice(&message[sent..]);
        Ok(true)
    }

    fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        match (&self.stream).write(bytes) {
            Ok(0) => Err(ErrorKind::WriteZero.into()),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::wire::MESSAGE_BYTES;
    use super::*;
    use nalgebra::Isometry3;
    use std::time::{Duration, Instant};

    fn tool() -> Transform<'static> {
        Transform {
            name: "ToolToReference",
            pose: Isometry3::identity(),
            unix_ns: 0,
        }
    }

    /// Publishes until `done` returns true, for at most a minute.
    fn until(server: &mut Server, mut done: impl FnMut(&Server) -> bool) {
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(60) {
            server.publish(&[tool()]);
            if done(server) {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("it does not happen");
    }

    #[test]
    fn every_client_gets_every_message_and_one_that_leaves_is_forgotten() {
        let mut server = Server::bind("127.0.0.1:0").unwrap();
        let mut first = TcpStream::connect(server.address().unwrap()).unwrap();
        let mut second = TcpStream::connect(server.address().unwrap()).unwrap();
        until(&mut server, |server| server.client_count() == 2);
        for client in [&mut first, &mut second] {
            let mut message = [0; MESSAGE_BYTES];
            client.read_exact(&mut message).unwrap();
            assert_eq!(message, tool().bytes().unwrap());
        }
        drop(first);
        until(&mut server, |server| server.client_count() == 1);
    }

    #[test]
    fn a_client_that_does_not_read_misses_whole_messages_only() {
        let mut server = Server::bind("127.0.0.1:0").unwrap();
        let mut client = TcpStream::connect(server.address().unwrap()).unwrap();
        until(&mut server, |server| server.client_count() == 1);
        for _ in 0..200_000 {
            server.publish(&[tool()]);
            if server.skipped() > 10 {
                break;
            }
        }
        assert!(server.skipped() > 10, "the client's buffers never fill");
        // The client resumes: it reads whole messages and gets new ones again.
        let reader = std::thread::spawn(move || {
            let expected = tool().bytes().unwrap();
            let mut message = [0; MESSAGE_BYTES];
            let mut count = 0u64;
            while client.read_exact(&mut message).is_ok() {
                assert_eq!(message, expected, "message {count}");
                count += 1;
            }
            count
        });
        let mut before = server.skipped();
        until(&mut server, |server| {
            let is_read = server.skipped() == before;
            before = server.skipped();
            is_read
        });
        drop(server);
        assert!(reader.join().unwrap() > 100);
    }

    #[test]
    fn one_client_too_many_is_turned_away() {
        let mut server = Server::bind("127.0.0.1:0").unwrap();
        let address = server.address().unwrap();
        let clients: Vec<TcpStream> = (0..12)
            .map(|_| TcpStream::connect(address).unwrap())
            .collect();
        until(&mut server, |server| server.client_count() == CLIENTS_MAX);
        for _ in 0..50 {
            server.publish(&[tool()]);
            assert_eq!(server.client_count(), CLIENTS_MAX);
        }
        drop(clients);
    }
}
