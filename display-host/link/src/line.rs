//! A line between two computers: messages over TLS, with certificates on both sides.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream, ToSocketAddrs as _};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustls::crypto::ring::default_provider;
use rustls::pki_types::ServerName;
use rustls::server::WebPkiClientVerifier;
use rustls::version::TLS13;
use rustls::{ClientConfig, ClientConnection, Connection, ServerConfig, ServerConnection};

use crate::address::Address;
use crate::error::LinkError;

/// Longest duration of a TLS handshake.
const HANDSHAKE: Duration = Duration::from_secs(10);
/// Longest wait for a TCP connection to a computer.
const REACH: Duration = Duration::from_secs(2);
/// A peer that takes no byte for this long is disconnected.
const WRITE_PATIENCE: Duration = Duration::from_secs(5);
/// A peer that needs longer than this for one message is disconnected.
const SEND_PATIENCE: Duration = Duration::from_secs(20);
/// Longest wait of one read. After it, the thread can do other work.
const READ_PATIENCE: Duration = Duration::from_millis(5);
/// Bytes before a message: four for the length of the content, one for the kind.
const HEAD: usize = 5;

/// An established connection.
pub(crate) struct Line {
    socket: TcpStream,
    tls: Option<Connection>,
    /// Bytes received of the incomplete message.
    coming: Vec<u8>,
    longest: usize,
    heard: Instant,
}

/// Error of the operating system or of TLS.
type Broken = std::io::Error;

impl Line {
    fn new(socket: TcpStream, tls: Option<Connection>, longest: usize) -> Self {
        Self {
            socket,
            tls,
            coming: Vec::new(),
            longest,
            heard: Instant::now(),
        }
    }

    /// Time of the last byte from the other side, even of an incomplete message.
    pub(crate) fn heard(&self) -> Instant {
        self.heard
    }

    /// Sends a message.
    pub(crate) fn send(&mut self, kind: u8, message: &[u8]) -> Result<(), Broken> {
        let length = u32::try_from(message.len()).map_err(|_| ErrorKind::InvalidInput)?;
        let mut bytes = Vec::with_capacity(HEAD + message.len());
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.push(kind);
        bytes.extend_from_slice(message);
        let (start, mut rest) = (Instant::now(), bytes.as_slice());
        while !rest.is_empty() {
            let count = match self.write(rest) {
                Err(error) if error.kind() == ErrorKind::Interrupted => 0,
                written => written?,
            };
            rest = rest.get(count..).unwrap_or_default();
            if start.elapsed() >= SEND_PATIENCE {
                return Err(ErrorKind::TimedOut.into());
            }
        }
        self.flush(start)
    }

    /// Sends some of `bytes`, or with TLS sends some of the queue and queues some of `bytes`.
    /// Returns the number of bytes taken.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Broken> {
        let Some(tls) = &mut self.tls else {
            return self.socket.write(bytes);
        };
        if tls.wants_write() {
            tls.write_tls(&mut self.socket)?;
        }
        tls.writer().write(bytes)
    }

    fn flush(&mut self, start: Instant) -> Result<(), Broken> {
        let Some(tls) = &mut self.tls else {
            return Ok(());
        };
        while tls.wants_write() {
            match tls.write_tls(&mut self.socket) {
                Err(error) if error.kind() != ErrorKind::Interrupted => return Err(error),
                _ if start.elapsed() >= SEND_PATIENCE => return Err(ErrorKind::TimedOut.into()),
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the next message and its kind, if it is complete within a few milliseconds. A peer
    /// that sends byte by byte therefore cannot block the thread. The buffer holds at most the
    /// longest message and one read.
    pub(crate) fn receive(&mut self) -> Result<Option<(u8, Vec<u8>)>, Broken> {
        let start = Instant::now();
        loop {
            if let Some(message) = self.whole()? {
                return Ok(Some(message));
            }
            if start.elapsed() >= READ_PATIENCE {
                return Ok(None);
            }
            let mut part = [0; 16 << 10];
            match self.read(&mut part) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self
                    .coming
                    .extend_from_slice(part.get(..count).unwrap_or(&[])),
                Err(error) if is_late(&error) || error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Reads the available bytes with one call to the socket. The `Stream` of rustls would wait
    /// until a record is complete.
    fn read(&mut self, part: &mut [u8]) -> Result<usize, Broken> {
        let Some(tls) = &mut self.tls else {
            let count = self.socket.read(part)?;
            self.heard = Instant::now();
            return Ok(count);
        };
        match tls.reader().read(part) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            came => return came,
        }
        if tls.read_tls(&mut self.socket)? == 0 {
            return Ok(0);
        }
        self.heard = Instant::now();
        take_in(tls, &mut self.socket)?;
        self.flush(Instant::now())?;
        match &mut self.tls {
            Some(tls) => tls.reader().read(part),
            None => Ok(0),
        }
    }

    fn whole(&mut self) -> Result<Option<(u8, Vec<u8>)>, Broken> {
        let Some((head, rest)) = self.coming.split_first_chunk::<HEAD>() else {
            return Ok(None);
        };
        let [a, b, c, d, kind] = *head;
        let length = u32::from_le_bytes([a, b, c, d]) as usize;
        if length > self.longest {
            let words = format!(
                "a message of {length} bytes; at most {} are allowed",
                self.longest
            );
            return Err(Broken::new(ErrorKind::InvalidData, words));
        }
        let Some(message) = rest.get(..length).map(<[u8]>::to_vec) else {
            return Ok(None);
        };
        self.coming.drain(..HEAD + length);
        Ok(Some((kind, message)))
    }
}

/// Decrypts the complete records.
fn take_in(tls: &mut Connection, socket: &mut TcpStream) -> Result<(), Broken> {
    let Err(error) = tls.process_new_packets() else {
        return Ok(());
    };
    // Send the other side the TLS alert with the reason.
    let _ = tls.write_tls(socket);
    Err(Broken::other(error))
}

fn is_late(error: &Broken) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

/// The station's listening end.
pub(crate) struct Door {
    listener: TcpListener,
    tls: Option<Arc<ServerConfig>>,
}

impl Door {
    pub(crate) fn open(address: &Address) -> Result<Self, LinkError> {
        let tls = match &address.keys {
            None => None,
            Some(keys) => {
                keys.check_station()?;
                let provider = Arc::new(default_provider());
                let roots = Arc::new(keys.authority()?);
                let watchers = WebPkiClientVerifier::builder_with_provider(roots, provider.clone())
                    .build()
                    .map_err(|error| keys.refused(&keys.authority, &error))?;
                let (chain, key) = keys.own()?;
                let config = ServerConfig::builder_with_provider(provider)
                    .with_protocol_versions(&[&TLS13])
                    .map(|it| it.with_client_cert_verifier(watchers))
                    .and_then(|it| it.with_single_cert(chain, key));
                Some(Arc::new(
                    config.map_err(|error| keys.refused(&keys.certificate, &error))?,
                ))
            }
        };
        let failed = |source| LinkError::Listen {
            address: address.text(),
            source,
        };
        let listener = TcpListener::bind(address.text()).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        Ok(Self { listener, tls })
    }

    /// A new connection, if there is one. Its peer is not authenticated yet.
    pub(crate) fn knock(&self) -> Option<TcpStream> {
        self.listener.accept().ok().map(|(stream, _)| stream)
    }

    /// A [`Porter`] that does the handshake on another thread.
    pub(crate) fn porter(&self) -> Porter {
        Porter(self.tls.clone())
    }
}

/// Admits peers. With TLS, a peer needs a certificate; without TLS, every peer is admitted.
#[derive(Clone)]
pub(crate) struct Porter(Option<Arc<ServerConfig>>);

impl Porter {
    pub(crate) fn let_in(
        &self,
        mut socket: TcpStream,
        longest: usize,
        is_over: &dyn Fn() -> bool,
    ) -> Result<Line, Broken> {
        socket.set_nonblocking(false)?;
        prepare(&socket)?;
        let Some(tls) = &self.0 else {
            return Ok(Line::new(socket, None, longest));
        };
        let tls = ServerConnection::new(tls.clone()).map_err(Broken::other)?;
        let tls = shake(tls.into(), &mut socket, is_over)?;
        Ok(Line::new(socket, Some(tls), longest))
    }
}

/// Connects a watcher. If it has keys, it verifies the station's certificate.
pub(crate) fn connect(
    address: &Address,
    longest: usize,
    is_over: &dyn Fn() -> bool,
) -> Result<Line, Broken> {
    let mut last = Broken::new(ErrorKind::NotFound, "no such host");
    for to in address.text().to_socket_addrs()? {
        match TcpStream::connect_timeout(&to, REACH) {
            Ok(socket) => return greet(address, socket, longest, is_over),
            Err(error) => last = error,
        }
        if is_over() {
            break;
        }
    }
    Err(last)
}

fn greet(
    address: &Address,
    mut socket: TcpStream,
    longest: usize,
    is_over: &dyn Fn() -> bool,
) -> Result<Line, Broken> {
    prepare(&socket)?;
    let Some(keys) = &address.keys else {
        return Ok(Line::new(socket, None, longest));
    };
    let roots = keys.authority().map_err(Broken::other)?;
    let (chain, key) = keys.own().map_err(Broken::other)?;
    let config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
        .with_protocol_versions(&[&TLS13])
        .map(|it| it.with_root_certificates(roots))
        .and_then(|it| it.with_client_auth_cert(chain, key))
        .map_err(Broken::other)?;
    let name = ServerName::try_from(address.host.clone()).map_err(Broken::other)?;
    let tls = ClientConnection::new(Arc::new(config), name).map_err(Broken::other)?;
    let tls = shake(tls.into(), &mut socket, is_over)?;
    Ok(Line::new(socket, Some(tls), longest))
}

fn prepare(stream: &TcpStream) -> Result<(), Broken> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(READ_PATIENCE))?;
    stream.set_write_timeout(Some(WRITE_PATIENCE))
}

/// Completes the handshake within its time limit, so that a slow peer cannot hold up the thread.
fn shake(
    mut tls: Connection,
    socket: &mut TcpStream,
    is_over: &dyn Fn() -> bool,
) -> Result<Connection, Broken> {
    let start = Instant::now();
    while start.elapsed() < HANDSHAKE && !is_over() {
        while tls.wants_write() {
            tls.write_tls(socket)?;
        }
        if !tls.is_handshaking() {
            return Ok(tls);
        }
        match tls.read_tls(socket) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(_) => take_in(&mut tls, socket)?,
            Err(error) if is_late(&error) || error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Err(ErrorKind::TimedOut.into())
}
