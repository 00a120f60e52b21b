//! Header of a message, in both of the protocol's header versions; all numbers big-endian.
//! Source: the OpenIGTLink protocol documents.

use crc::{CRC_64_ECMA_182, Crc};

/// Bytes of a header.
pub const HEADER_BYTES: usize = 58;
/// Longest name of a type of message, bytes.
pub const KIND_BYTES: usize = 12;
/// Longest name of a device, bytes.
pub const NAME_BYTES: usize = 20;
/// Length of the extended header, with which the body begins in [`Version::Two`], bytes.
const EXTENDED_BYTES: usize = 12;
/// Bytes after the content in [`Version::Two`]: the count of metadata, which is zero.
const NO_METADATA: [u8; 2] = [0; 2];

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_ECMA_182);

/// Checksum of a body.
#[must_use]
pub fn checksum(body: &[u8]) -> u64 {
    CRC.checksum(body)
}

/// Version of the header. It differs from the version of the protocol: versions 1 and 2 of the
/// protocol use the first header, version 3 uses the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Version {
    /// The body is the content. Every client reads it.
    #[default]
    One,
    /// The body has an extended header before the content, and metadata after it.
    Two {
        /// Number of the message. An answer repeats the number of its request.
        message_id: u32,
    },
}

/// A header that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Number of the header's version: 1 and 2 are known, 3 is read like 2.
    pub version: u16,
    /// Type of message.
    pub kind: String,
    /// Name of the device.
    pub name: String,
    /// Bytes of the body.
    pub body_bytes: u64,
    /// Checksum of the body.
    pub checksum: u64,
}

impl Header {
    /// Reads a header. `None` if its version is unknown or a name is not ASCII. The rest of the
    /// stream then cannot be parsed.
    #[must_use]
    pub fn read(bytes: &[u8; HEADER_BYTES]) -> Option<Self> {
        let (version, rest) = bytes.split_first_chunk::<2>()?;
        let (kind, rest) = rest.split_first_chunk::<KIND_BYTES>()?;
        let (name, rest) = rest.split_first_chunk::<NAME_BYTES>()?;
        let (_time, rest) = rest.split_first_chunk::<8>()?;
        let (body_bytes, rest) = rest.split_first_chunk::<8>()?;
        let (checksum, _) = rest.split_first_chunk::<8>()?;
        let version = u16::from_be_bytes(*version);
        if !(1..=3).contains(&version) {
            return None;
        }
        Some(Self {
            version,
            kind: text(kind).filter(|kind| !kind.is_empty())?,
            name: text(name)?,
            body_bytes: u64::from_be_bytes(*body_bytes),
            checksum: u64::from_be_bytes(*checksum),
        })
    }

    /// Splits a body. Returns the version for the answer, and the content. `None` if the extended
    /// header contradicts the body's length.
    #[must_use]
    pub fn open<'a>(&self, body: &'a [u8]) -> Option<(Version, &'a [u8])> {
        if self.version == 1 {
            return Some((Version::One, body));
        }
        let half = |at: usize| Some(u16::from_be_bytes(*body.get(at..)?.first_chunk::<2>()?));
        let word = |at: usize| Some(u32::from_be_bytes(*body.get(at..)?.first_chunk::<4>()?));
        let (start, tail) = (usize::from(half(0)?), u32::from(half(2)?));
        let tail = usize::try_from(tail.checked_add(word(4)?)?).ok()?;
        let message_id = word(8)?;
        let end = body.len().checked_sub(tail)?;
        let content = body.get(start..end)?;
        (start >= EXTENDED_BYTES).then_some((Version::Two { message_id }, content))
    }
}

/// Text of a field that is padded with zeros; `None` if it is not ASCII.
fn text(field: &[u8]) -> Option<String> {
    let end = field.iter().position(|byte| *byte == 0);
    let text = field.get(..end.unwrap_or(field.len()))?;
    let is_plain = text.iter().all(|byte| (b' '..=b'~').contains(byte));
    is_plain.then(|| text.iter().map(|byte| char::from(*byte)).collect())
}

/// Fills a field of `N` bytes with text, cut after `N` bytes.
#[must_use]
pub fn field<const N: usize>(text: &str) -> [u8; N] {
    let mut field = [0; N];
    for (slot, byte) in field.iter_mut().zip(text.bytes()) {
        *slot = byte;
    }
    field
}

/// A message with header, checksum and content.
#[must_use]
pub fn pack(version: Version, kind: &str, name: &str, unix_ns: u64, content: &[u8]) -> Vec<u8> {
    let mut body = Vec::with_capacity(content.len() + EXTENDED_BYTES + NO_METADATA.len());
    let number: u16 = match version {
        Version::One => 1,
        Version::Two { message_id } => {
            body.extend([0, 12, 0, 2, 0, 0, 0, 0]);
            body.extend(message_id.to_be_bytes());
            2
        }
    };
    body.extend(content);
    if number > 1 {
        body.extend(NO_METADATA);
    }
    let mut bytes = Vec::with_capacity(HEADER_BYTES + body.len());
    bytes.extend(number.to_be_bytes());
    bytes.extend(field::<KIND_BYTES>(kind));
    bytes.extend(field::<NAME_BYTES>(name));
    bytes.extend(time(unix_ns).to_be_bytes());
    bytes.extend((body.len() as u64).to_be_bytes());
    bytes.extend(checksum(&body).to_be_bytes());
    bytes.extend(body);
    bytes
}

/// Converts Unix time to seconds in the upper half and units of 2⁻³² s in the lower half.
fn time(unix_ns: u64) -> u64 {
    let (seconds, ns) = (unix_ns / 1_000_000_000, unix_ns % 1_000_000_000);
    (seconds << 32) | ((ns << 32) / 1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_checksum_is_the_documented_one() {
        assert_eq!(checksum(b"123456789"), 0x6C40_DF5F_0B49_7347);
        assert_eq!(checksum(b""), 0);
    }

    #[test]
    fn the_header_is_laid_out_as_documented() {
        let bytes = pack(
            Version::One,
            "TRANSFORM",
            "ToolToReference",
            1_500_000_000,
            b"123456789",
        );
        assert_eq!(bytes.len(), HEADER_BYTES + 9);
        assert_eq!(&bytes[..2], [0, 1]);
        assert_eq!(&bytes[2..14], b"TRANSFORM\0\0\0");
        assert_eq!(&bytes[14..34], b"ToolToReference\0\0\0\0\0");
        assert_eq!(&bytes[34..42], [0, 0, 0, 1, 0x80, 0, 0, 0]);
        assert_eq!(&bytes[42..50], [0, 0, 0, 0, 0, 0, 0, 9]);
        assert_eq!(&bytes[50..58], 0x6C40_DF5F_0B49_7347u64.to_be_bytes());
        assert_eq!(&bytes[58..], b"123456789");
    }

    #[test]
    fn the_second_version_has_an_extended_header_and_no_metadata() {
        let version = Version::Two { message_id: 77 };
        let bytes = pack(version, "STATUS", "Calot", 0, b"xy");
        assert_eq!(&bytes[..2], [0, 2]);
        let body = &bytes[HEADER_BYTES..];
        assert_eq!(
            body,
            [0, 12, 0, 2, 0, 0, 0, 0, 0, 0, 0, 77, b'x', b'y', 0, 0]
        );
        assert_eq!(&bytes[50..58], checksum(body).to_be_bytes());
    }

    #[test]
    fn a_long_name_is_cut() {
        let name = "ANameThatIsLongerThanTwentyBytes";
        let bytes = pack(Version::One, "STRING", name, 0, b"");
        assert_eq!(&bytes[14..34], &name.as_bytes()[..20]);
    }

    #[test]
    fn a_header_with_an_unknown_version_or_a_name_that_is_not_ascii_is_refused() {
        for (at, byte) in [(1, 0), (1, 4), (0, 1), (3, 0xFF), (14, 7), (2, 0)] {
            let mut bytes = *pack(Version::One, "STATUS", "x", 0, b"")
                .first_chunk::<HEADER_BYTES>()
                .unwrap();
            assert!(Header::read(&bytes).is_some());
            bytes[at] = byte;
            assert_eq!(Header::read(&bytes), None, "byte {at}");
        }
    }

    proptest! {
        #[test]
        fn messages_are_read_as_packed(
            kind in "[A-Z_]{1,12}", name in "[ -~]{0,20}", content in any::<Vec<u8>>(),
            message_id in any::<Option<u32>>(),
        ) {
            let version = message_id.map_or(Version::One, |message_id| Version::Two { message_id });
            let bytes = pack(version, &kind, &name, 0, &content);
            let (head, body) = bytes.split_first_chunk::<HEADER_BYTES>().unwrap();
            let header = Header::read(head).unwrap();
            prop_assert_eq!((&header.kind, &header.name), (&kind, &name));
            prop_assert_eq!(header.body_bytes, body.len() as u64);
            prop_assert_eq!(header.checksum, checksum(body));
            prop_assert_eq!(header.open(body), Some((version, &content[..])));
        }

        #[test]
        fn any_bytes_are_read_or_refused(
            bytes in any::<[u8; HEADER_BYTES]>(), version in 1u16..4, body in any::<Vec<u8>>(),
        ) {
            let mut header = Header {
                version, kind: String::new(), name: String::new(), body_bytes: 0, checksum: 0,
            };
            if let Some(read) = Header::read(&bytes) {
                header = read;
            }
            if let Some((_, content)) = header.open(&body) {
                prop_assert!(content.len() <= body.len());
            }
        }
    }
}
