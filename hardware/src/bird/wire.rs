//! Commands and records of the bird protocol.
//!
//! A record is a row of 16-bit words. Only the upper 14 bits of a word are sent, in two bytes of
//! seven bits each, the lower seven bits first. Bit 7 is set only in the first byte of a record, so
//! a reader that lost a byte finds the start of the next record. A record has no checksum, so the
//! driver holds back implausible records. Source: laserBIRD manual, drivers of VRPN and IGSTK.

use nalgebra::{Quaternion, UnitQuaternion};

/// Commands from host to bird: one byte each, some with arguments.
pub mod command {
    /// Requests one record. While a stream is on, ends the stream instead.
    pub const POINT: u8 = b'B';
    /// Streams records until `POINT`.
    pub const STREAM: u8 = b'@';
    /// Selects records of position and quaternion, seven words.
    pub const POSITION_QUATERNION: u8 = b']';
    /// Selects the hemisphere of the sensor; two bytes follow.
    pub const HEMISPHERE: u8 = b'L';
    /// Requests a parameter; its number follows.
    pub const EXAMINE: u8 = b'O';
    /// Sets a parameter; its number and its bytes follow.
    pub const CHANGE: u8 = b'P';
    /// Upper four bits of the prefix byte that addresses a bird. The lower four bits are the
    /// address of the bird that gets the next command.
    pub const TO_BIRD: u8 = 0xF0;
    /// Wakes the bird.
    pub const RUN: u8 = b'F';
    /// Puts the bird to sleep.
    pub const SLEEP: u8 = b'G';
}

/// Parameter numbers.
pub mod parameter {
    /// Status word, two bytes.
    pub const STATUS: u8 = 0;
    /// Full scale of positions, two bytes: 0 is 36 in, 1 is 72 in.
    pub const SCALING: u8 = 3;
    /// Last error, one byte; reading clears it.
    pub const ERROR: u8 = 10;
    /// Model, ten characters.
    pub const MODEL: u8 = 15;
    /// Group mode, one byte: the records of all birds follow each other, each with its bird's
    /// address.
    pub const GROUP_MODE: u8 = 35;
    /// Number of birds to take into the group, one byte; needs 600 ms of silence before and after.
    pub const AUTO_CONFIGURE: u8 = 50;
}

/// Bits of the status word.
pub mod status {
    /// An error waits to be read.
    pub const ERROR: u16 = 1 << 13;
    /// The bird is running.
    pub const RUNNING: u16 = 1 << 12;
    /// Records are streamed.
    pub const STREAMING: u16 = 1;
}

/// Half of the room around the transmitter in which the sensor stays. The magnetic fields in the
/// two halves differ in sign only, so the host must state the half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hemisphere {
    /// x > 0.
    Forward,
    /// x < 0.
    Aft,
    /// y > 0.
    Right,
    /// y < 0.
    Left,
    /// z > 0.
    Lower,
    /// z < 0.
    Upper,
}

impl Hemisphere {
    /// All hemispheres.
    pub const ALL: [Self; 6] = [
        Self::Forward,
        Self::Aft,
        Self::Right,
        Self::Left,
        Self::Lower,
        Self::Upper,
    ];

    /// Argument bytes of the command `HEMISPHERE`.
    #[must_use]
    pub const fn bytes(self) -> [u8; 2] {
        match self {
            Self::Forward => [0x00, 0x00],
            Self::Aft => [0x00, 0x01],
            Self::Right => [0x06, 0x00],
            Self::Left => [0x06, 0x01],
            Self::Lower => [0x0C, 0x00],
            Self::Upper => [0x0C, 0x01],
        }
    }

    /// Hemisphere with these argument bytes of the command `HEMISPHERE`.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 2]) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|hemisphere| hemisphere.bytes() == bytes)
    }

    /// Distance of a position from the plane between the halves, in the position's unit. Negative
    /// outside this half.
    #[must_use]
    pub fn depth(self, position: [f32; 3]) -> f32 {
        let [x, y, z] = position;
        match self {
            Self::Forward => x,
            Self::Aft => -x,
            Self::Right => y,
            Self::Left => -y,
            Self::Lower => z,
            Self::Upper => -z,
        }
    }
}

/// Range of positions. A larger range has larger steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// ±0.914 m in steps of 0.11 mm.
    #[default]
    Inches36,
    /// ±1.829 m in steps of 0.22 mm.
    Inches72,
}

impl Scale {
    /// Position at full scale, m.
    #[must_use]
    pub const fn full_m(self) -> f32 {
        match self {
            Self::Inches36 => 36.0 * 0.0254,
            Self::Inches72 => 72.0 * 0.0254,
        }
    }

    /// The two bytes of the parameter `SCALING`.
    #[must_use]
    pub const fn bytes(self) -> [u8; 2] {
        match self {
            Self::Inches36 => [0, 0],
            Self::Inches72 => [1, 0],
        }
    }

    /// Scale with these bytes of the parameter `SCALING`.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 2]) -> Option<Self> {
        [Self::Inches36, Self::Inches72]
            .into_iter()
            .find(|scale| scale.bytes() == bytes)
    }
}

/// Words of a position-and-quaternion record.
const WORDS: usize = 7;
/// Bytes of a position-and-quaternion record.
pub const RECORD_BYTES: usize = 2 * WORDS;
/// Bit that marks the first byte of a record.
const PHASE: u8 = 0x80;

/// A parsed record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Position of the sensor in the transmitter's frame, m.
    pub position_m: [f32; 3],
    /// Rotation of the sensor. On the wire its quaternion has steps of 1/8192.
    pub rotation: UnitQuaternion<f32>,
}

impl Record {
    /// Parses the words of a record. `None` when the length of the quaternion differs from 1 by
    /// more than 1 %. A record shows no other sign of damage.
    #[must_use]
    pub fn parse(bytes: &[u8; RECORD_BYTES], scale: Scale) -> Option<Self> {
        let words = words(bytes);
        let [x, y, z, q0, q1, q2, q3] = words.map(|word| f32::from(word) / 32768.0);
        let quaternion = Quaternion::new(q0, q1, q2, q3);
        if !(0.98..=1.02).contains(&quaternion.norm_squared()) {
            return None;
        }
        Some(Self {
            position_m: [x, y, z].map(|part| part * scale.full_m()),
            rotation: UnitQuaternion::new_normalize(quaternion),
        })
    }

    /// Bytes of the record. Positions out of range saturate.
    #[must_use]
    pub fn bytes(&self, scale: Scale) -> [u8; RECORD_BYTES] {
        let [x, y, z] = self.position_m.map(|part| part / scale.full_m());
        let q = self.rotation.quaternion();
        // `as` saturates.
        let words = [x, y, z, q.w, q.i, q.j, q.k].map(|part| (part * 32768.0).round() as i16);
        pack(&words)
    }
}

fn pack(words: &[i16; WORDS]) -> [u8; RECORD_BYTES] {
    let mut bytes = [0; RECORD_BYTES];
    for (pair, &word) in bytes.chunks_exact_mut(2).zip(words) {
        let upper = word as u16 >> 2;
        pair[0] = (upper & 0x7F) as u8;
        pair[1] = (upper >> 7) as u8;
    }
    bytes[0] |= PHASE;
    bytes
}

fn words(bytes: &[u8; RECORD_BYTES]) -> [i16; WORDS] {
    let mut words = [0; WORDS];
    for (word, pair) in words.iter_mut().zip(bytes.chunks_exact(2)) {
        let upper = u16::from(pair[0] & 0x7F) | u16::from(pair[1] & 0x7F) << 7;
        *word = (upper << 2) as i16;
    }
    words
}

/// Finds records in a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct RecordReader {
    bytes: [u8; RECORD_BYTES],
    len: usize,
    /// True if each record ends with its bird's address.
    is_group: bool,
    /// True while bytes are dropped because no record has started. A run of such bytes counts as
    /// one error.
    lost: bool,
}

impl RecordReader {
    /// Reader for the records of a group, each of which ends with its bird's address.
    #[must_use]
    pub fn of_group() -> Self {
        Self {
            is_group: true,
            ..Self::default()
        }
    }

    /// Takes one byte. Returns `Some(Ok)` with the bird's address (0 without a group) when a record
    /// is complete, and `Some(Err)` when a record broke off or a byte came outside a record.
    pub fn push(&mut self, byte: u8) -> Option<Result<(&[u8; RECORD_BYTES], u8), PhaseError>> {
        if byte & PHASE != 0 {
            let broken = self.len != 0;
            self.bytes[0] = byte;
            self.len = 1;
            self.lost = false;
            return broken.then_some(Err(PhaseError));
        }
        if self.len == 0 {
            let first = !std::mem::replace(&mut self.lost, true);
            return first.then_some(Err(PhaseError));
        }
        let address = match self.bytes.get_mut(self.len) {
            Some(slot) => {
                *slot = byte;
                self.len += 1;
                if self.is_group || self.len < RECORD_BYTES {
                    return None;
                }
                0
            }
            None => byte,
        };
        self.len = 0;
        Some(Ok((&self.bytes, address)))
    }
}

/// A record broke off, or bytes came outside a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhaseError;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn words_have_the_bytes_of_the_laserbird_manual() {
        let bytes = pack(&[0x1122, 0x3344, 0x5566, 0, 0, 0, 0]);
        assert_eq!(bytes[..6], [0xC8, 0x08, 0x51, 0x19, 0x59, 0x2A]);
        assert_eq!(words(&bytes)[..3], [0x1120, 0x3344, 0x5564]);
    }

    #[test]
    fn a_position_in_inches_has_its_known_record() {
        let bytes = [
            0xE3, 0x11, 0x0E, 0x77, 0x39, 0x04, 0x7F, 0x3F, 0, 0, 0, 0, 0, 0,
        ];
        assert_eq!(words(&bytes), [9100, -4552, 2276, 32764, 0, 0, 0]);
        let record = Record::parse(&bytes, Scale::Inches36).unwrap();
        for (read_m, inches) in record.position_m.iter().zip([10.0, -5.0, 2.5]) {
            assert!((read_m - inches * 0.0254).abs() < 2e-4, "{read_m} {inches}");
        }
        assert!(record.rotation.angle() < 1e-3);
    }

    #[test]
    fn hemispheres_have_their_documented_bytes() {
        for hemisphere in Hemisphere::ALL {
            assert_eq!(Hemisphere::from_bytes(hemisphere.bytes()), Some(hemisphere));
        }
        assert_eq!(Hemisphere::from_bytes([1, 1]), None);
        assert!(Hemisphere::Upper.depth([0.0, 0.0, -0.2]) > 0.0);
    }

    #[test]
    fn a_lost_byte_costs_one_record() {
        let record = pack(&[100, 200, 300, 32764, 0, 0, 0]);
        let mut stream = record.to_vec();
        stream.remove(5);
        stream.extend_from_slice(&record);
        stream.extend_from_slice(&record);
        let mut reader = RecordReader::default();
        let read: Vec<_> = stream
            .iter()
            .filter_map(|&byte| reader.push(byte).map(|r| r.is_ok()))
            .collect();
        assert_eq!(read, [false, true, true]);
    }

    #[test]
    fn records_of_a_group_carry_their_birds_address() {
        let record = pack(&[100, 200, 300, 32764, 0, 0, 0]);
        let mut stream = Vec::new();
        for address in [1, 2, 1] {
            stream.extend_from_slice(&record);
            stream.push(address);
        }
        stream.remove(20);
        let mut reader = RecordReader::of_group();
        let read: Vec<_> = stream
            .iter()
            .filter_map(|&byte| {
                reader
                    .push(byte)
                    .map(|r| r.map(|(_, address)| address).ok())
            })
            .collect();
        assert_eq!(read, [Some(1), None, Some(1)]);
    }

    proptest! {
        #[test]
        fn records_are_read_as_sent_within_a_step(
            position_m in prop::array::uniform3(-0.9..0.9f32),
            turn in prop::array::uniform3(-3.0..3.0f32),
            scale in prop::sample::select(vec![Scale::Inches36, Scale::Inches72]),
        ) {
            let sent = Record {
                position_m,
                rotation: UnitQuaternion::from_scaled_axis(turn.into()),
            };
            let read = Record::parse(&sent.bytes(scale), scale).unwrap();
            for (read, sent) in read.position_m.iter().zip(position_m) {
                prop_assert!((read - sent).abs() < 2.3e-4);
            }
            prop_assert!(read.rotation.angle_to(&sent.rotation) < 1e-3);
        }

        #[test]
        fn arbitrary_bytes_give_finite_records_in_range_or_none(
            bytes in prop::collection::vec(any::<u8>(), 0..4096),
            is_group in any::<bool>(),
        ) {
            let mut reader = RecordReader { is_group, ..RecordReader::default() };
            for byte in bytes {
                let Some(Ok((record, _))) = reader.push(byte) else { continue };
                if let Some(record) = Record::parse(record, Scale::Inches72) {
                    let full_m = Scale::Inches72.full_m();
                    prop_assert!(record.position_m.iter().all(|x| x.abs() <= full_m));
                    prop_assert!((record.rotation.norm() - 1.0).abs() < 1e-4);
                }
            }
        }
    }
}
