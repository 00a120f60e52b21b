//! `TRANSFORM` messages, protocol version 1, which every client reads. Source: the
//! OpenIGTLink protocol documents.

use crc::{CRC_64_ECMA_182, Crc};
use nalgebra::Isometry3;

/// Offsets of the header's fields; all big-endian.
mod field {
    pub(super) const VERSION: usize = 0;
    pub(super) const KIND: usize = 2;
    pub(super) const NAME: usize = 14;
    pub(super) const TIME: usize = 34;
    pub(super) const BODY_BYTES: usize = 42;
    pub(super) const CHECKSUM: usize = 50;
    pub(super) const BODY: usize = 58;
    pub(super) const END: usize = BODY + super::BODY_BYTES;
}

/// Twelve f32: the rotation's columns, then the translation.
const BODY_BYTES: usize = 48;
/// Bytes of a message.
pub const MESSAGE_BYTES: usize = field::END;
/// Longest name, bytes.
pub const NAME_BYTES: usize = field::TIME - field::NAME;

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_ECMA_182);

/// A named pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform<'a> {
    /// `ToolToReference` and the like, ASCII; cut after [`NAME_BYTES`].
    pub name: &'a str,
    /// The pose, m. The protocol counts in mm.
    pub pose: Isometry3<f32>,
    /// Unix time, ns.
    pub unix_ns: u64,
}

impl Transform<'_> {
    /// The message. `None` when the pose is not finite.
    #[must_use]
    pub fn bytes(&self) -> Option<[u8; MESSAGE_BYTES]> {
        let rotation = self.pose.rotation.to_rotation_matrix();
        let position_mm = self.pose.translation.vector * 1e3;
        // The numbers of the rotation and the position, column by column.
        let numbers = rotation.matrix().iter().chain(position_mm.iter());
        if !numbers.clone().all(|number| number.is_finite()) {
            return None;
        }
        let mut bytes = [0; MESSAGE_BYTES];
        let (header, body) = bytes.split_at_mut(field::BODY);
        for (slot, number) in body.chunks_exact_mut(4).zip(numbers) {
            slot.copy_from_slice(&number.to_be_bytes());
        }
        let mut put = |at: usize, value: &[u8]| {
            header[at..at + value.len()].copy_from_slice(value);
        };
        put(field::VERSION, &1u16.to_be_bytes());
        put(field::KIND, b"TRANSFORM");
        let name = self.name.as_bytes();
        put(field::NAME, &name[..name.len().min(NAME_BYTES)]);
        put(field::TIME, &time(self.unix_ns).to_be_bytes());
        put(field::BODY_BYTES, &(BODY_BYTES as u64).to_be_bytes());
        put(field::CHECKSUM, &CRC.checksum(body).to_be_bytes());
        Some(bytes)
    }
}

/// Converts Unix time to seconds in the upper half and units of 2⁻³² s in the lower half.
fn time(unix_ns: u64) -> u64 {
    let (seconds, ns) = (unix_ns / 1_000_000_000, unix_ns % 1_000_000_000);
    (seconds << 32) | ((ns << 32) / 1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    fn message(pose: Isometry3<f32>) -> [u8; MESSAGE_BYTES] {
        Transform {
            name: "ToolToReference",
            pose,
            unix_ns: 1_500_000_000,
        }
        .bytes()
        .unwrap()
    }

    fn number(bytes: &[u8; MESSAGE_BYTES], index: usize) -> f32 {
        let at = field::BODY + 4 * index;
        f32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    #[test]
    fn the_checksum_is_the_documented_one() {
        assert_eq!(CRC.checksum(b"123456789"), 0x6C40_DF5F_0B49_7347);
        let identity = message(Isometry3::identity());
        assert_eq!(
            identity[field::CHECKSUM..field::BODY],
            0xB5A2_25F8_F462_B3D7u64.to_be_bytes()
        );
    }

    #[test]
    fn the_header_is_laid_out_as_documented() {
        let bytes = message(Isometry3::identity());
        assert_eq!(bytes.len(), 106);
        assert_eq!(&bytes[..2], [0, 1]);
        assert_eq!(&bytes[2..14], b"TRANSFORM\0\0\0");
        assert_eq!(&bytes[14..34], b"ToolToReference\0\0\0\0\0");
        assert_eq!(&bytes[34..42], [0, 0, 0, 1, 0x80, 0, 0, 0]);
        assert_eq!(&bytes[42..50], [0, 0, 0, 0, 0, 0, 0, 48]);
    }

    #[test]
    fn the_body_is_columns_then_millimetres() {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.5);
        let bytes = message(Translation3::new(0.01, -0.02, 0.03) * turn);
        assert!((number(&bytes, 0) - 0.5f32.cos()).abs() < 1e-6, "R11");
        assert!(
            (number(&bytes, 1) - 0.5f32.sin()).abs() < 1e-6,
            "R21 follows R11"
        );
        for (index, mm) in [(9, 10.0), (10, -20.0), (11, 30.0)] {
            assert!((number(&bytes, index) - mm).abs() < 1e-5);
        }
    }

    #[test]
    fn a_long_name_is_cut_and_a_pose_that_is_no_number_is_not_sent() {
        let name = "ANameThatIsLongerThanTwentyBytes";
        let sent = Transform {
            name,
            pose: Isometry3::identity(),
            unix_ns: 0,
        };
        assert_eq!(&sent.bytes().unwrap()[14..34], &name.as_bytes()[..20]);
        let nowhere = Translation3::new(f32::NAN, 0.0, 0.0).into();
        assert!(
            Transform {
                pose: nowhere,
                ..sent
            }
            .bytes()
            .is_none()
        );
    }
}
