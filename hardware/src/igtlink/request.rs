//! Splits a client's stream of bytes into requests.

use super::wire::{self, HEADER_BYTES, Header, Version};

/// Largest body that is kept, bytes. The content of a larger one is skipped.
const KEPT_BYTES: usize = 4096;
/// Largest body that a header may announce, bytes. A header that announces more counts as noise.
const BODY_MAX: u64 = 1 << 32;

/// Next thing in a client's stream.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Incoming {
    /// A whole message.
    Request(Request),
    /// A message whose checksum or extended header is wrong.
    Damaged {
        /// Its type.
        kind: String,
    },
    /// Bytes that are no header. The rest of the stream cannot be parsed.
    Noise,
}

/// A message from a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Request {
    /// Version for the answer.
    pub(super) version: Version,
    /// Type of message.
    pub(super) kind: String,
    /// Name of the requested device; may be empty.
    pub(super) name: String,
    /// Content; empty if the body was larger than [`KEPT_BYTES`].
    pub(super) content: Vec<u8>,
}

/// Bytes of a client that are not parsed yet.
#[derive(Debug, Default)]
pub(super) struct Inbox {
    bytes: Vec<u8>,
    /// Bytes of a large body that are still to be skipped.
    bytes_to_skip: u64,
    is_noise: bool,
}

impl Inbox {
    /// Adds bytes that were read. After noise, all are dropped.
    pub(super) fn add(&mut self, bytes: &[u8]) {
        if self.is_noise {
            return;
        }
        let passed =
            usize::try_from(self.bytes_to_skip).map_or(bytes.len(), |it| it.min(bytes.len()));
        self.bytes_to_skip -= passed as u64;
        self.bytes.extend(bytes.iter().skip(passed));
    }

    /// False if so many bytes wait that no more should be read.
    pub(super) fn has_room(&self) -> bool {
        self.bytes.len() < HEADER_BYTES + KEPT_BYTES
    }

    /// The next message, if it has arrived completely.
    pub(super) fn next(&mut self) -> Option<Incoming> {
        let (head, rest) = self.bytes.split_first_chunk::<HEADER_BYTES>()?;
        let header = Header::read(head).filter(|header| header.body_bytes <= BODY_MAX);
        let Some(header) = header else {
            self.is_noise = true;
            self.bytes = Vec::new();
            return Some(Incoming::Noise);
        };
        let length = usize::try_from(header.body_bytes).unwrap_or(usize::MAX);
        if length > KEPT_BYTES {
            let here = length.min(rest.len());
            self.bytes_to_skip = header.body_bytes - here as u64;
            self.bytes.drain(..HEADER_BYTES + here);
            let version = match header.version {
                1 => Version::One,
                _ => Version::Two { message_id: 0 },
            };
            return Some(Incoming::Request(Request {
                version,
                kind: header.kind,
                name: header.name,
                content: Vec::new(),
            }));
        }
        let body = rest.get(..length)?;
        let opened = header
            .open(body)
            .filter(|_| wire::checksum(body) == header.checksum)
            .map(|(version, content)| (version, content.to_vec()));
        self.bytes.drain(..HEADER_BYTES + length);
        Some(match opened {
            None => Incoming::Damaged { kind: header.kind },
            Some((version, content)) => Incoming::Request(Request {
                version,
                kind: header.kind,
                name: header.name,
                content,
            }),
        })
    }
}

/// Content of `STT_TDATA`: a client asks for tracking data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct StartTracking {
    /// Shortest time between two messages, ms; 0: all messages.
    pub(super) resolution_ms: i32,
    /// Name of the frame, in capitals.
    pub(super) frame: String,
}

impl StartTracking {
    /// Reads the content; `None` if it is too short.
    pub(super) fn read(content: &[u8]) -> Option<Self> {
        let (resolution, name) = content.split_first_chunk::<4>()?;
        let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
        Some(Self {
            resolution_ms: i32::from_be_bytes(*resolution),
            frame: String::from_utf8_lossy(name).trim().to_uppercase(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn packed(version: Version, kind: &str, content: &[u8]) -> Vec<u8> {
        wire::pack(version, kind, "Calot", 0, content)
    }

    fn request(version: Version, kind: &str, content: &[u8]) -> Incoming {
        Incoming::Request(Request {
            version,
            kind: kind.into(),
            name: "Calot".into(),
            content: content.into(),
        })
    }

    #[test]
    fn a_request_of_the_reference_library_is_read() {
        // STT_TDATA, 50 ms, "Patient", as libOpenIGTLink 1.11 packs it.
        let mut content = vec![0, 0, 0, 50];
        content.extend(wire::field::<32>("Patient"));
        let bytes = packed(Version::One, "STT_TDATA", &content);
        assert_eq!(bytes[50..58], 0xFEFB_AFE8_91CE_20DB_u64.to_be_bytes());
        let start = StartTracking::read(&content).unwrap();
        assert_eq!((start.resolution_ms, start.frame.as_str()), (50, "PATIENT"));
        assert_eq!(StartTracking::read(&[0, 0]), None);
    }

    #[test]
    fn a_large_body_is_skipped_and_the_next_request_is_read() {
        let mut inbox = Inbox::default();
        let mut bytes = packed(Version::One, "IMAGE", &[7; 10_000]);
        bytes.extend(packed(Version::One, "GET_STATUS", b""));
        let mut heard = Vec::new();
        for part in bytes.chunks(300) {
            inbox.add(part);
            heard.extend(std::iter::from_fn(|| inbox.next()));
        }
        let expected = ["IMAGE", "GET_STATUS"].map(|kind| request(Version::One, kind, b""));
        assert_eq!(heard, expected);
    }

    #[test]
    fn a_damaged_request_is_named_and_noise_ends_the_stream() {
        let mut inbox = Inbox::default();
        let mut bytes = packed(Version::One, "GET_TDATA", b"abc");
        *bytes.last_mut().unwrap() ^= 1;
        bytes.extend(packed(Version::Two { message_id: 1 }, "STATUS", b"x"));
        // The extended header claims more metadata than there is.
        let start = bytes.len() - 15;
        bytes[start + 3] = 200;
        bytes.extend([0; 4 * HEADER_BYTES]);
        inbox.add(&bytes);
        let kinds = ["GET_TDATA", "STATUS"];
        for kind in kinds {
            assert_eq!(inbox.next(), Some(Incoming::Damaged { kind: kind.into() }));
        }
        assert_eq!(inbox.next(), Some(Incoming::Noise));
        inbox.add(&packed(Version::One, "GET_STATUS", b""));
        assert_eq!(inbox.next(), None);
    }

    proptest! {
        #[test]
        fn requests_are_read_however_the_stream_is_cut(
            cut in 1usize..200, message_id in any::<Option<u32>>(), content in any::<Vec<u8>>(),
        ) {
            let version = message_id.map_or(Version::One, |message_id| Version::Two { message_id });
            let mut inbox = Inbox::default();
            let mut heard = Vec::new();
            let bytes = [packed(version, "A", &content), packed(version, "B", b"")].concat();
            for part in bytes.chunks(cut) {
                inbox.add(part);
                heard.extend(std::iter::from_fn(|| inbox.next()));
            }
            let expected = [request(version, "A", &content), request(version, "B", b"")];
            prop_assert_eq!(heard, expected);
        }

        #[test]
        fn arbitrary_bytes_are_harmless(bytes in any::<Vec<u8>>()) {
            let mut inbox = Inbox::default();
            inbox.add(&bytes);
            while inbox.next().is_some() {}
        }
    }
}
