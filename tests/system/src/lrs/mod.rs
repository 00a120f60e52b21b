//! A learning record store for tests. It keeps statements in memory and refuses whatever breaks a
//! rule of xAPI 2.0 (IEEE 9274.1.1). It can fail on demand.

mod valid;

use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead as _, BufReader, Read, Write};
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde_json::{Value, json};

pub use valid::check;

/// Header with user `station` and password `s3cret`.
const KEY: &str = "Basic c3RhdGlvbjpzM2NyZXQ=";
/// Statements in a page of a list.
const PAGE: usize = 2;

/// A failure of the next request that writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The line is cut before the statement is kept.
    CutBefore,
    /// The statement is kept, and the line is cut before the answer.
    CutAfter,
    /// The server is too busy.
    Busy,
    /// The server refuses the statement.
    Refuse,
}

/// Contents of a record store.
#[derive(Debug, Default)]
pub struct Kept {
    /// Statements by id, also those that were voided.
    pub statements: BTreeMap<String, Value>,
    /// Ids of the voided ones.
    pub voided: Vec<String>,
    /// Rules that requests broke.
    pub broken: Vec<String>,
    /// Failures to come.
    pub faults: VecDeque<Fault>,
    /// Number of requests that wrote.
    pub writes: usize,
    /// Versions that it says it speaks; empty: it says nothing.
    pub versions: Vec<&'static str>,
    /// True if nobody may list statements.
    pub is_write_only: bool,
    /// True if it answers 409 to a statement that it has, even if it is the same.
    pub is_picky: bool,
}

/// A record store that listens on this computer until the test program ends.
#[derive(Clone)]
pub struct Lrs {
    kept: Arc<Mutex<Kept>>,
    port: u16,
}

/// A request.
struct Request {
    method: String,
    path: String,
    query: BTreeMap<String, String>,
    headers: BTreeMap<String, String>,
    body: String,
}

impl Lrs {
    /// Starts a record store. `wrap` turns each plain connection into one that the store reads, or
    /// refuses it.
    ///
    /// # Panics
    ///
    /// If no port is free.
    #[must_use]
    pub fn start<S: Read + Write>(
        wrap: impl Fn(std::net::TcpStream) -> Option<S> + Clone + Send + 'static,
    ) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let lrs = Self {
            kept: Arc::new(Mutex::new(Kept {
                versions: vec!["1.0.3", "2.0.0"],
                ..Kept::default()
            })),
            port: listener.local_addr().expect("an address").port(),
        };
        let all = lrs.clone();
        std::thread::spawn(move || {
            for line in listener.incoming().flatten() {
                let (lrs, wrap) = (all.clone(), wrap.clone());
                std::thread::spawn(move || wrap(line).map(|line| lrs.attend(line)));
            }
        });
        lrs
    }

    /// Port at which it listens.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Its contents.
    pub fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Statements that are neither voided nor void others.
    #[must_use]
    pub fn standing(&self) -> Vec<Value> {
        let kept = self.kept();
        let stands = |(id, it): &(&String, &Value)| !kept.voided.contains(id) && !is_voiding(it);
        { kept.statements.iter() }
            .filter(stands)
            .map(|(_, it)| it.clone())
            .collect()
    }

    /// Answers the requests of one line. `None`: it ended.
    fn attend(&self, line: impl Read + Write) -> Option<()> {
        let mut line = BufReader::new(line);
        loop {
            let request = read(&mut line)?;
            let (status, body) = self.answer(&request)?;
            let body = match body {
                Value::Null => String::new(),
                Value::String(text) => text,
                other => other.to_string(),
            };
            let length = body.len();
            let head = format!(
                "HTTP/1.1 {status} x\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\
                 X-Experience-API-Version: 2.0.0\r\nETag: \"{length}\"\r\n\
                 X-Experience-API-Consistent-Through: 2026-11-29T00:00:00Z\r\n\r\n"
            );
            line.get_mut().write_all((head + &body).as_bytes()).ok()?;
            line.get_mut().flush().ok()?;
        }
    }

    /// Status and body. `None`: the line is cut.
    fn answer(&self, request: &Request) -> Option<(u16, Value)> {
        let mut kept = self.kept();
        let mut broken = |why: String| {
            kept.broken.push(why.clone());
            Some((400, json!(why)))
        };
        let header = |name: &str| request.headers.get(name).map(String::as_str);
        if header("x-experience-api-version") != Some("2.0.0") {
            return broken("the header of the version is absent or wrong".to_owned());
        }
        if request.path == "/xapi/about" {
            return Some(match kept.versions.as_slice() {
                [] => (404, Value::Null),
                versions => (200, json!({"version": versions})),
            });
        }
        if header("authorization") != Some(KEY) {
            return Some((401, json!("who are you?")));
        }
        if request.path != "/xapi/statements" {
            return Some((404, Value::Null));
        }
        match request.method.as_str() {
            "PUT" => put(&mut kept, request),
            "GET" => get(&mut kept, request),
            other => broken(format!("method {other}")),
        }
    }
}

fn is_voiding(statement: &Value) -> bool {
    statement["verb"]["id"] == "http://adlnet.gov/expapi/verbs/voided"
}

fn put(kept: &mut Kept, request: &Request) -> Option<(u16, Value)> {
    kept.writes += 1;
    let fault = kept.faults.pop_front();
    match fault {
        Some(Fault::CutBefore) => return None,
        Some(Fault::Busy) => return Some((503, json!("busy"))),
        Some(Fault::Refuse) => return Some((400, json!("not today"))),
        Some(Fault::CutAfter) | None => {}
    }
    let checked = valid::put(
        request.headers.get("content-type"),
        &request.query,
        &request.body,
    );
    let (id, statement) = match checked {
        Ok(found) => found,
        Err(why) => {
            kept.broken.push(why.clone());
            return Some((400, json!(why)));
        }
    };
    if let Some(known) = kept.statements.get(&id) {
        let is_other = *known != statement || kept.is_picky;
        return Some((if is_other { 409 } else { 204 }, Value::Null));
    }
    if is_voiding(&statement) {
        let target = statement["object"]["id"]
            .as_str()
            .unwrap_or_default()
            .to_owned();
        if !kept.statements.contains_key(&target) {
            return Some((404, json!("nothing to void")));
        }
        kept.voided.push(target);
    }
    kept.statements.insert(id, statement);
    match fault {
        Some(_) => None,
        None => Some((204, Value::Null)),
    }
}

fn get(kept: &mut Kept, request: &Request) -> Option<(u16, Value)> {
    let known = [
        "statementId",
        "voidedStatementId",
        "agent",
        "limit",
        "after",
    ];
    if let Some(other) = request
        .query
        .keys()
        .find(|it| !known.contains(&it.as_str()))
    {
        kept.broken.push(format!("parameter {other}"));
        return Some((400, Value::Null));
    }
    if let Some(id) = request.query.get("statementId") {
        let found = kept
            .statements
            .get(id)
            .filter(|_| !kept.voided.contains(id));
        return Some(found.map_or((404, Value::Null), |it| (200, it.clone())));
    }
    if kept.is_write_only {
        return Some((403, json!("only what you wrote")));
    }
    let agent: Value = match request
        .query
        .get("agent")
        .map(|it| serde_json::from_str(it))
    {
        Some(Ok(agent)) => agent,
        _ => {
            kept.broken.push("no agent in JSON".to_owned());
            return Some((400, Value::Null));
        }
    };
    let stands = |(id, it): &(&String, &Value)| {
        !kept.voided.contains(id) && it["actor"]["account"] == agent["account"]
    };
    let all: Vec<Value> = { kept.statements.iter() }
        .filter(stands)
        .map(|(_, it)| it.clone())
        .collect();
    let from = request
        .query
        .get("after")
        .and_then(|it| it.parse().ok())
        .unwrap_or(0_usize);
    let page: Vec<&Value> = all.iter().skip(from).take(PAGE).collect();
    let rest = all.len() > from + PAGE;
    let agent = request.query.get("agent")?;
    let encoded: String = agent.bytes().map(|it| format!("%{it:02X}")).collect();
    let more = match rest {
        true => format!("/xapi/statements?agent={encoded}&after={}", from + PAGE),
        false => String::new(),
    };
    Some((200, json!({"statements": page, "more": more})))
}

/// The next request on a line. `None`: it ended.
fn read(line: &mut BufReader<impl Read>) -> Option<Request> {
    let mut first = String::new();
    line.read_line(&mut first).ok().filter(|it| *it > 0)?;
    let mut words = first.split_whitespace();
    let (method, target) = (words.next()?.to_owned(), words.next()?);
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let pair = |it: &str| {
        let (name, value) = it.split_once('=')?;
        Some((name.to_owned(), decoded(value)))
    };
    let (path, query) = (path.to_owned(), query.split('&').filter_map(pair).collect());
    let mut headers = BTreeMap::new();
    loop {
        let mut text = String::new();
        line.read_line(&mut text).ok().filter(|it| *it > 0)?;
        match text.trim_end().split_once(':') {
            Some((name, value)) => headers.insert(name.to_lowercase(), value.trim().to_owned()),
            None => break,
        };
    }
    let length = headers
        .get("content-length")
        .and_then(|it| it.parse().ok())
        .unwrap_or(0_usize);
    let mut body = vec![0; length];
    line.read_exact(&mut body).ok()?;
    Some(Request {
        method,
        path,
        query,
        headers,
        body: String::from_utf8(body).ok()?,
    })
}

fn decoded(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let hex = text.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        match hex.and_then(|it| u8::from_str_radix(it, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                at += 3;
            }
            None => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}
