//! Answers to requests.

use std::io;
use std::time::Duration;

use super::Server;
use crate::igtlink::client::{Client, Form};
use crate::igtlink::message::{Code, Message};
use crate::igtlink::request::{Incoming, Request, StartTracking};
use crate::igtlink::wire::Version;

/// Types that the server sends, and requests that it answers.
const CAPABILITIES: [&str; 22] = [
    "TRANSFORM",
    "TDATA",
    "QTDATA",
    "SENSOR",
    "STRING",
    "POLYDATA",
    "STATUS",
    "CAPABILITY",
    "RTS_TDATA",
    "RTS_QTDATA",
    "GET_TRANS",
    "GET_TDATA",
    "GET_QTDATA",
    "GET_SENSOR",
    "GET_STRING",
    "GET_POLYDATA",
    "GET_STATUS",
    "GET_CAPABIL",
    "STT_TDATA",
    "STP_TDATA",
    "STT_QTDATA",
    "STP_QTDATA",
];
/// Name that the examples of the reference library send instead of the requested device's name. It
/// is the name of the example itself.
const EXAMPLE_NAME: &str = "Client";
/// Frames that a client may request by name. Other names have a meaning only for the client.
const FRAMES: [&str; 4] = ["RAS", "LPS", "LSA", "SCENE"];
/// Longest time between two messages of tracking data that a client may request, ms.
const RESOLUTION_MAX_MS: i32 = 60_000;

impl Server {
    /// Reads a client's requests and answers them.
    ///
    /// # Errors
    ///
    /// The socket's error: the client is gone.
    pub(super) fn answer(&mut self, client: &mut Client, unix_ns: u64) -> io::Result<()> {
        for heard in client.receive()? {
            let (version, answers) = match heard {
                Incoming::Request(request) => {
                    client.use_version(request.version);
                    (request.version, self.answers(client, &request, unix_ns))
                }
                Incoming::Damaged { kind } => {
                    let words = format!("the checksum or the extended header of {kind} is wrong");
                    let message = self.status(Code::Checksum, "damaged", &words, unix_ns);
                    (Version::One, vec![message])
                }
                Incoming::Noise => {
                    let words = "this is no OpenIGTLink header of version 1, 2 or 3; \
                                 nothing more is read on this connection";
                    let message = self.status(Code::UnknownVersion, "noise", words, unix_ns);
                    (Version::One, vec![message])
                }
            };
            for answer in answers {
                self.skipped += u64::from(!client.answer(&answer, version)?);
            }
        }
        Ok(())
    }

    fn answers(&self, client: &mut Client, request: &Request, unix_ns: u64) -> Vec<Message> {
        let name = match request.name.as_str() {
            EXAMPLE_NAME => "",
            name => name,
        };
        let kind = request.kind.as_str();
        let is_about_data = !["GET_STATUS", "GET_CAPABIL"].contains(&kind);
        if kind.starts_with("GET_") && is_about_data {
            client.note_request();
        }
        match kind {
            "GET_STATUS" => self.newest_of("STATUS", "", unix_ns),
            "GET_CAPABIL" => vec![Message::capability(&self.name, &CAPABILITIES, unix_ns)],
            "GET_TRANS" => self.newest_of("TRANSFORM", name, unix_ns),
            "GET_TDATA" => self.newest_of("TDATA", "", unix_ns),
            "GET_QTDATA" => self.newest_of("QTDATA", "", unix_ns),
            "GET_SENSOR" => self.newest_of("SENSOR", name, unix_ns),
            "GET_STRING" => self.newest_of("STRING", name, unix_ns),
            "GET_POLYDATA" => self.newest_of("POLYDATA", name, unix_ns),
            "STT_TDATA" => self.start_tracking(client, Form::Matrix, &request.content, unix_ns),
            "STT_QTDATA" => {
                self.start_tracking(client, Form::Quaternion, &request.content, unix_ns)
            }
            "STP_TDATA" => self.stop_tracking(client, Form::Matrix, unix_ns),
            "STP_QTDATA" => self.stop_tracking(client, Form::Quaternion, unix_ns),
            // An answer to an answer would never end.
            kind if kind == "STATUS" || kind.starts_with("RTS_") => Vec::new(),
            kind if is_request(kind) || !client.is_told_of_data => {
                client.is_told_of_data |= !is_request(kind);
                let words = format!("{kind} is not supported; GET_CAPABIL lists what is");
                vec![self.status(Code::UnknownInstruction, "unsupported", &words, unix_ns)]
            }
            _ => Vec::new(),
        }
    }

    /// The newest messages of a type: the one of this name, or all if the name is empty.
    fn newest_of(&self, kind: &str, name: &str, unix_ns: u64) -> Vec<Message> {
        let of_kind = || self.newest.iter().filter(|it| it.kind == kind);
        let found: Vec<Message> = of_kind()
            .filter(|it| name.is_empty() || it.name == name)
            .cloned()
            .collect();
        if !found.is_empty() {
            return found;
        }
        let names: Vec<&str> = of_kind().map(|it| it.name.as_str()).collect();
        let message = if names.is_empty() {
            let words = format!("there is no {kind} at present");
            self.status(Code::NotReady, "nothing yet", &words, unix_ns)
        } else {
            let words = format!("there is no {kind} '{name}', but {}", names.join(", "));
            self.status(Code::NotFound, "unknown name", &words, unix_ns)
        };
        vec![message]
    }

    fn stop_tracking(&self, client: &mut Client, form: Form, unix_ns: u64) -> Vec<Message> {
        client.stop_tracking(form);
        vec![Message::tracking_reply(
            reply(form),
            &self.name,
            true,
            unix_ns,
        )]
    }

    fn start_tracking(
        &self,
        client: &mut Client,
        form: Form,
        content: &[u8],
        unix_ns: u64,
    ) -> Vec<Message> {
        let answer = |is_done| Message::tracking_reply(reply(form), &self.name, is_done, unix_ns);
        let refused = |words: &str| {
            vec![
                answer(false),
                self.status(Code::Config, "no tracking", words, unix_ns),
            ]
        };
        let Some(start) = StartTracking::read(content) else {
            return refused("the request has no resolution");
        };
        let ms = start.resolution_ms;
        let Some(every_ms) = u64::try_from(ms).ok().filter(|_| ms <= RESOLUTION_MAX_MS) else {
            return refused(&format!(
                "the resolution {ms} ms is not in 0 to {RESOLUTION_MAX_MS} ms"
            ));
        };
        let frame = start.frame.as_str();
        let asked = if frame == "LSA" { "SCENE" } else { frame };
        if FRAMES.contains(&frame) && asked != self.frame {
            return refused(&format!(
                "poses are in the frame {}, not {frame}; start calot igtlink with --frame {}",
                self.frame,
                asked.to_lowercase()
            ));
        }
        client.start_tracking(form, Duration::from_millis(every_ms));
        vec![answer(true)]
    }

    fn status(&self, code: Code, short: &str, words: &str, unix_ns: u64) -> Message {
        Message::status(&self.name, code, short, words, unix_ns)
    }
}

/// Type of the answer to a request about tracking data.
const fn reply(form: Form) -> &'static str {
    match form {
        Form::Matrix => "RTS_TDATA",
        Form::Quaternion => "RTS_QTDATA",
    }
}

/// True for a request, to which the protocol expects an answer.
fn is_request(kind: &str) -> bool {
    ["GET_", "STT_", "STP_", "COMMAND"]
        .iter()
        .any(|start| kind.starts_with(start))
}
