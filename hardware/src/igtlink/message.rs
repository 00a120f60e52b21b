//! Messages that Calot sends. Source: the OpenIGTLink protocol documents; the bytes in the tests
//! were compared with those of the reference library (libOpenIGTLink 1.11).

use nalgebra::Isometry3;

use super::wire::{self, Version};

/// Longest name of a status, bytes.
const STATUS_NAME_BYTES: usize = 20;
/// Type of instrument in tracking data: position and orientation (6 degrees of freedom).
const SIX_DEGREES: u8 = 2;
/// IANA's number of US-ASCII.
const ASCII: u16 = 3;

/// Code of a `STATUS`; the protocol's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// All is well.
    Ok = 1,
    /// There is nothing of this name.
    NotFound = 4,
    /// No room for another client.
    Busy = 6,
    /// The source is silent.
    TimeOut = 7,
    /// The checksum of a request is wrong.
    Checksum = 9,
    /// The request contradicts the configuration.
    Config = 10,
    /// The request is not supported.
    UnknownInstruction = 12,
    /// There is no such message now.
    NotReady = 13,
    /// The source has not appeared yet.
    NotPresent = 16,
    /// The version of the header is unknown.
    UnknownVersion = 17,
    /// The source has ended.
    ShutDown = 19,
}

/// Unit of a `SENSOR`, packed as the protocol defines, from the highest bit down: a prefix (4
/// bits), then six pairs of a unit's number (6 bits) and its exponent (4 bits).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Unit {
    /// A plain number.
    One = 0,
    /// Newton: unit 0x0B to the power of one.
    Newton = 0x02C4_0000_0000_0000,
}

/// A message before it is packed for a client's version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Type of message, e.g. `TRANSFORM`.
    pub kind: &'static str,
    /// Name of the device; ASCII, cut after [`wire::NAME_BYTES`].
    pub name: String,
    /// Unix time, ns.
    pub unix_ns: u64,
    /// Content without the header.
    pub content: Vec<u8>,
}

impl Message {
    fn new(kind: &'static str, name: &str, unix_ns: u64, content: Vec<u8>) -> Self {
        Self {
            kind,
            name: name.to_owned(),
            unix_ns,
            content,
        }
    }

    /// `TRANSFORM`: a pose, m; in mm on the wire. `None` if a number is not finite.
    #[must_use]
    pub fn transform(name: &str, pose: &Isometry3<f32>, unix_ns: u64) -> Option<Self> {
        let mut content = Vec::with_capacity(48);
        push_pose(&mut content, pose)?;
        Some(Self::new("TRANSFORM", name, unix_ns, content))
    }

    /// `TDATA`: named poses, m, at one time. `None` if a number is not finite.
    #[must_use]
    pub fn tracking(name: &str, poses: &[(&str, Isometry3<f32>)], unix_ns: u64) -> Option<Self> {
        let mut content = Vec::with_capacity(70 * poses.len());
        for (tool, pose) in poses {
            content.extend(wire::field::<{ wire::NAME_BYTES }>(tool));
            content.extend([SIX_DEGREES, 0]);
            push_pose(&mut content, pose)?;
        }
        Some(Self::new("TDATA", name, unix_ns, content))
    }

    /// `QTDATA`: like [`Message::tracking`], with the rotations as quaternions. `None` if a number
    /// is not finite.
    #[must_use]
    pub fn quaternions(name: &str, poses: &[(&str, Isometry3<f32>)], unix_ns: u64) -> Option<Self> {
        let mut content = Vec::with_capacity(50 * poses.len());
        for (tool, pose) in poses {
            content.extend(wire::field::<{ wire::NAME_BYTES }>(tool));
            content.extend([SIX_DEGREES, 0]);
            let position_mm = pose.translation.vector * 1e3;
            // The real part comes last, as nalgebra stores it.
            for number in position_mm.iter().chain(pose.rotation.coords.iter()) {
                number.is_finite().then_some(())?;
                content.extend(number.to_be_bytes());
            }
        }
        Some(Self::new("QTDATA", name, unix_ns, content))
    }

    /// `SENSOR`: at most 255 values. `None` if there are more, or if one is not finite.
    #[must_use]
    pub fn sensor(name: &str, values: &[f32], unit: Unit, unix_ns: u64) -> Option<Self> {
        let count = u8::try_from(values.len()).ok()?;
        let mut content = vec![count, 0];
        content.extend((unit as u64).to_be_bytes());
        for value in values {
            value.is_finite().then_some(())?;
            content.extend(f64::from(*value).to_be_bytes());
        }
        Some(Self::new("SENSOR", name, unix_ns, content))
    }

    /// `STRING`: a text. Characters outside of ASCII become question marks. A text is cut at 64
    /// KiB.
    #[must_use]
    pub fn string(name: &str, text: &str, unix_ns: u64) -> Self {
        let text: Vec<u8> = ascii(text).take(usize::from(u16::MAX)).collect();
        let length = u16::try_from(text.len()).unwrap_or(u16::MAX);
        let mut content = Vec::with_capacity(4 + text.len());
        content.extend(ASCII.to_be_bytes());
        content.extend(length.to_be_bytes());
        content.extend(text);
        Self::new("STRING", name, unix_ns, content)
    }

    /// `POLYDATA`: a surface of triangles. Points are in m here and in mm on the wire: the protocol
    /// defines no unit, and receivers expect mm. Indices count from 0.
    #[must_use]
    pub fn polydata(
        name: &str,
        points_m: &[[f32; 3]],
        triangles: &[[u32; 3]],
        unix_ns: u64,
    ) -> Self {
        /// A triangle on the wire: the number of corners, then the corners.
        const TRIANGLE_BYTES: usize = 16;
        let bytes = TRIANGLE_BYTES * triangles.len();
        let count = |of: usize| u32::try_from(of).unwrap_or(u32::MAX);
        // Counts and sizes in bytes of points, vertices, lines, polygons, strips and attributes.
        let [points, polygons, size] = [points_m.len(), triangles.len(), bytes].map(count);
        let head = [points, 0, 0, 0, 0, polygons, size, 0, 0, 0];
        let mut content = Vec::with_capacity(4 * head.len() + 12 * points_m.len() + bytes);
        content.extend(head.iter().flat_map(|it| it.to_be_bytes()));
        let numbers = points_m.as_flattened().iter();
        content.extend(numbers.flat_map(|x| (x * 1e3).to_be_bytes()));
        for corners in triangles {
            content.extend(3u32.to_be_bytes());
            content.extend(corners.iter().flat_map(|it| it.to_be_bytes()));
        }
        Self::new("POLYDATA", name, unix_ns, content)
    }

    /// `STATUS`: a code, a short name for programs, and words for people.
    #[must_use]
    pub fn status(name: &str, code: Code, short: &str, words: &str, unix_ns: u64) -> Self {
        let mut content = Vec::with_capacity(31 + words.len());
        content.extend((code as u16).to_be_bytes());
        content.extend(0i64.to_be_bytes());
        content.extend(wire::field::<STATUS_NAME_BYTES>(short));
        content.extend(ascii(words));
        content.push(0);
        Self::new("STATUS", name, unix_ns, content)
    }

    /// `CAPABILITY`: types of messages that are sent and understood.
    #[must_use]
    pub fn capability(name: &str, kinds: &[&str], unix_ns: u64) -> Self {
        let mut content = Vec::with_capacity(wire::KIND_BYTES * kinds.len());
        for kind in kinds {
            content.extend(wire::field::<{ wire::KIND_BYTES }>(kind));
        }
        Self::new("CAPABILITY", name, unix_ns, content)
    }

    /// `RTS_TDATA` or `RTS_QTDATA`: the answer to a request to start or to stop tracking data.
    #[must_use]
    pub fn tracking_reply(kind: &'static str, name: &str, is_done: bool, unix_ns: u64) -> Self {
        Self::new(kind, name, unix_ns, vec![u8::from(!is_done)])
    }

    /// The bytes on the wire.
    #[must_use]
    pub fn bytes(&self, version: Version) -> Vec<u8> {
        wire::pack(version, self.kind, &self.name, self.unix_ns, &self.content)
    }
}

fn ascii(text: &str) -> impl Iterator<Item = u8> {
    let plain = |letter: char| u8::try_from(letter).ok().filter(u8::is_ascii);
    text.chars()
        .map(move |letter| plain(letter).unwrap_or(b'?'))
}

/// Appends the rotation's columns, then the position in mm, as twelve f32.
fn push_pose(content: &mut Vec<u8>, pose: &Isometry3<f32>) -> Option<()> {
    let rotation = pose.rotation.to_rotation_matrix();
    let position_mm = pose.translation.vector * 1e3;
    for number in rotation.matrix().iter().chain(position_mm.iter()) {
        number.is_finite().then_some(())?;
        content.extend(number.to_be_bytes());
    }
    Some(())
}

#[cfg(test)]
mod tests;
