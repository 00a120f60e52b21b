//! A browser's part of the conversation: login, requests, and the live line.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use serde_json::Value;
use tungstenite::{Error, Message, WebSocket};

use crate::support::{Centre, PASSWORD};

/// Longest look.
const LOOK: Duration = Duration::from_millis(100);

type Tls = StreamOwned<ClientConnection, TcpStream>;

fn connect(centre: &Centre, authority: &Path) -> Tls {
    let mut roots = RootCertStore::empty();
    let certificate = CertificateDer::from_pem_file(authority).expect("a certificate");
    roots.add(certificate).expect("an authority");
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let builder = ClientConfig::builder_with_provider(provider);
    let builder = builder.with_safe_default_protocol_versions().expect("TLS");
    let config = builder.with_root_certificates(roots).with_no_client_auth();
    let name = ServerName::try_from("127.0.0.1").expect("a name");
    let client = ClientConnection::new(Arc::new(config), name).expect("a client");
    let stream = TcpStream::connect(&centre.page).expect("the page is there");
    StreamOwned::new(client, stream)
}

/// Sends a request and returns the whole answer.
pub(crate) fn request(centre: &Centre, authority: &Path, head: &str, body: &str) -> String {
    let mut line = connect(centre, authority);
    let length = body.len();
    let text = format!(
        "{head}\r\nHost: {}\r\nConnection: close\r\nContent-Length: {length}\r\n\
         Content-Type: application/x-www-form-urlencoded\r\n\r\n{body}",
        centre.page
    );
    line.write_all(text.as_bytes()).expect("sent");
    let mut answer = Vec::new();
    // A server may close the connection without TLS's closing message.
    let _ = line.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// A page of an instructor who is logged in.
pub(crate) struct Page {
    cookie: String,
    line: WebSocket<Tls>,
    /// The last state of each station.
    pub(crate) stations: BTreeMap<String, Value>,
    /// Number of pictures by kind and station.
    pub(crate) pictures: BTreeMap<(char, String), u32>,
    /// Answer to the last remark.
    pub(crate) remark: Option<String>,
    /// The centre closed the connection.
    pub(crate) is_over: bool,
}

/// Logs in, and returns the cookie and the answer.
pub(crate) fn login(centre: &Centre, authority: &Path, password: &str) -> (Option<String>, String) {
    let body = format!("name=bo&password={}", password.replace(' ', "+"));
    let answer = request(centre, authority, "POST /login HTTP/1.1", &body);
    let cookie = answer
        .lines()
        .find_map(|it| it.strip_prefix("set-cookie: "));
    let cookie = cookie.and_then(|it| it.split(';').next());
    (cookie.map(str::to_owned), answer)
}

impl Page {
    pub(crate) fn open(centre: &Centre, authority: &Path) -> Self {
        let (cookie, answer) = login(centre, authority, PASSWORD);
        let cookie = cookie.unwrap_or_else(|| panic!("no cookie: {answer}"));
        let request = tungstenite::http::Request::builder()
            .uri(format!("wss://{}/live", centre.page))
            .header("Host", &centre.page)
            .header("Origin", format!("https://{}", centre.page))
            .header("Cookie", &cookie)
            .header("Connection", "Upgrade")
            .header("Upgrade", "websocket")
            .header("Sec-WebSocket-Version", "13")
            .header(
                "Sec-WebSocket-Key",
                tungstenite::handshake::client::generate_key(),
            )
            .body(())
            .expect("a request");
        let led = tungstenite::client(request, connect(centre, authority));
        let (line, _) = led.unwrap_or_else(|error| panic!("the live line: {error}"));
        let patience = Some(LOOK);
        line.get_ref()
            .sock
            .set_read_timeout(patience)
            .expect("a limit");
        Self {
            cookie,
            line,
            stations: BTreeMap::new(),
            pictures: BTreeMap::new(),
            remark: None,
            is_over: false,
        }
    }

    pub(crate) fn ask(&mut self, asked: &Value) {
        let sent = self.line.send(Message::text(asked.to_string()));
        sent.expect("the page is connected");
    }

    /// Takes everything that has come, and waits a tenth of a second for more at most.
    pub(crate) fn look(&mut self) {
        let start = Instant::now();
        while !self.is_over && start.elapsed() < LOOK {
            match self.line.read() {
                Ok(message) => self.take(message),
                Err(Error::Io(error))
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    return;
                }
                Err(_) => self.is_over = true,
            }
        }
    }

    fn take(&mut self, message: Message) {
        match message {
            Message::Text(text) => {
                let told: Value = serde_json::from_str(&text).expect("JSON");
                if let Some(outcome) = told["remark"]["outcome"].as_str() {
                    self.remark = Some(outcome.to_owned());
                    return;
                }
                for name in told["gone"].as_array().into_iter().flatten() {
                    self.stations.remove(name.as_str().unwrap_or_default());
                }
                for it in told["states"].as_array().into_iter().flatten() {
                    let name = it["name"].as_str().expect("a name").to_owned();
                    self.stations.insert(name, it.clone());
                }
            }
            Message::Binary(bytes) => {
                let length = usize::from(bytes[1]);
                let name = String::from_utf8_lossy(&bytes[2..2 + length]).into_owned();
                assert!(bytes[2 + length..].starts_with(&[0xff, 0xd8]), "a picture");
                let kind = char::from(bytes[0]);
                *self.pictures.entry((kind, name)).or_default() += 1;
            }
            _ => {}
        }
    }

    pub(crate) fn present(&self) -> usize {
        let all = self.stations.values();
        all.filter(|it| it["present"] == true).count()
    }

    /// Answer to a request of this login.
    pub(crate) fn request(&self, centre: &Centre, authority: &Path, head: &str) -> String {
        let head = format!("{head}\r\nCookie: {}", self.cookie);
        request(centre, authority, &head, "")
    }

    /// Answer to a request for JSON.
    pub(crate) fn get(&self, centre: &Centre, authority: &Path, path: &str) -> Value {
        let answer = self.request(centre, authority, &format!("GET {path} HTTP/1.1"));
        let (_, body) = answer.split_once("\r\n\r\n").expect("an answer");
        serde_json::from_str(body).unwrap_or_else(|error| panic!("{path}: {error}: {answer}"))
    }
}
