//! Commands and answers of the board.
//!
//! ```text
//! 00 id                                         forget all motors and encoders (torque stays!)
//! 01 id motors dir.. encoders dir.. 0 0 f32..   set up: masks of ports, a direction for each port,
//!                                               no sensors, no pins, offset and counts per encoder
//! 02 id f32..                                   a torque per motor, N m; only this is answered:
//! id f32..                                      an angle per encoder, degrees
//! ```
//!
//! Floats are little-endian. A board that this `id` has not set up takes no torques and answers
//! with the `id` only. It reads the rest of the command as new commands: two zeros are a reset.

/// Calot's id on the board. If a byte is lost, the id may become the upper byte of a float. The
/// torque is then negligible (1e-22 N m). The id also distinguishes our set-up from that of other
/// programs (Haply's examples use 5).
pub const ID: u8 = 0x1C;
/// Motors and encoders in use.
pub const ARMS: usize = 2;
/// Length of a set-up.
pub const SET_UP_BYTES: usize = 10 + 8 * ARMS;
/// Length of a torque command.
pub const TORQUES_BYTES: usize = 2 + 4 * ARMS;
/// Length of the answer.
pub const ANSWER_BYTES: usize = 1 + 4 * ARMS;
/// Mask of the motors and encoders at ports 1 and 2.
const PORTS: u8 = 0b11;
/// Largest plausible angle of an arm, degrees.
const ANGLE_LIMIT_DEG: f32 = 720.0;

/// First bytes of commands.
pub mod command {
    /// Forgets every motor and encoder.
    pub const RESET: u8 = 0;
    /// Sets up motors and encoders.
    pub const SET_UP: u8 = 1;
    /// Sets torques and requests the angles.
    pub const TORQUES: u8 = 2;
}

/// Set-up of the motor and the encoder at one port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Port {
    /// True if the motor turns the other way.
    pub motor_reversed: bool,
    /// True if the encoder counts the other way.
    pub encoder_reversed: bool,
    /// Present angle of the arm, degrees.
    pub angle_deg: f32,
    /// Encoder counts per turn of the arm.
    pub counts_per_turn: f32,
}

/// Set-up command for ports 1 and 2.
#[must_use]
pub fn set_up(ports: &[Port; ARMS]) -> [u8; SET_UP_BYTES] {
    let [a, b] = ports;
    let mut bytes = [0; SET_UP_BYTES];
    let head = [
        command::SET_UP,
        ID,
        PORTS,
        a.motor_reversed.into(),
        b.motor_reversed.into(),
        PORTS,
        a.encoder_reversed.into(),
        b.encoder_reversed.into(),
        0,
        0,
    ];
    let floats = ports
        .iter()
        .flat_map(|port| [port.angle_deg, port.counts_per_turn]);
    let bytes_of_floats = floats.flat_map(f32::to_le_bytes);
    for (slot, byte) in bytes
        .iter_mut()
        .zip(head.into_iter().chain(bytes_of_floats))
    {
        *slot = byte;
    }
    bytes
}

/// Torque command for ports 1 and 2, N m.
#[must_use]
pub fn torques(torque_nm: [f32; ARMS]) -> [u8; TORQUES_BYTES] {
    let [a, b] = torque_nm.map(|torque| truncate_mantissa(torque).to_le_bytes());
    let [[a0, a1, a2, a3], [b0, b1, b2, b3]] = [a, b];
    [command::TORQUES, ID, a0, a1, a2, a3, b0, b1, b2, b3]
}

/// Rounds the torque towards zero in steps of less than 1 %, so that its two lower bytes are zero.
/// If one or two bytes are lost on the way, zeros shift into the float's upper bytes, and the
/// torque is nearly zero.
fn truncate_mantissa(torque_nm: f32) -> f32 {
    if torque_nm.is_finite() {
        f32::from_bits(torque_nm.to_bits() & 0xFFFF_0000)
    } else {
        0.0
    }
}

/// Finds answers in a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct AnswerReader {
    bytes: [u8; ANSWER_BYTES],
    len: usize,
}

/// Bytes that are not an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadAnswer;

impl AnswerReader {
    /// Takes one byte. Returns `Some(Ok)` with the angles of ports 1 and 2, degrees, when an answer
    /// is complete. Returns `Some(Err)` for a broken answer and for a byte outside of an answer.
    pub fn push(&mut self, byte: u8) -> Option<Result<[f32; ARMS], BadAnswer>> {
        if self.len == 0 && byte != ID {
            return Some(Err(BadAnswer));
        }
        if let Some(slot) = self.bytes.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
        if self.len < ANSWER_BYTES {
            return None;
        }
        let [_, a0, a1, a2, a3, b0, b1, b2, b3] = self.bytes;
        let angles_deg = [[a0, a1, a2, a3], [b0, b1, b2, b3]].map(f32::from_le_bytes);
        // NaN also fails this comparison.
        if angles_deg.iter().all(|deg| deg.abs() <= ANGLE_LIMIT_DEG) {
            self.len = 0;
            Some(Ok(angles_deg))
        } else {
            self.resynchronise(self.bytes);
            Some(Err(BadAnswer))
        }
    }

    /// Rejects the last answer. The true answer may begin anywhere behind its first byte.
    pub fn reject(&mut self) {
        if self.len == 0 {
            self.resynchronise(self.bytes);
        }
    }

    /// Searches the bytes of a rejected answer for the next beginning.
    fn resynchronise(&mut self, [_, rest @ ..]: [u8; ANSWER_BYTES]) {
        let skipped = rest.iter().take_while(|&&byte| byte != ID).count();
        self.len = 0;
        for (slot, &byte) in self.bytes.iter_mut().zip(rest.iter().skip(skipped)) {
            *slot = byte;
            self.len += 1;
        }
    }

    /// Number of bytes of the incomplete answer.
    #[must_use]
    pub const fn waiting(&self) -> usize {
        self.len
    }

    /// Drops an incomplete answer.
    pub fn clear(&mut self) {
        self.len = 0;
    }
}

/// Answer of a board that is set up.
#[must_use]
pub fn answer(angles_deg: [f32; ARMS]) -> [u8; ANSWER_BYTES] {
    let [[a0, a1, a2, a3], [b0, b1, b2, b3]] = angles_deg.map(f32::to_le_bytes);
    [ID, a0, a1, a2, a3, b0, b1, b2, b3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn port(angle_deg: f32) -> Port {
        Port {
            motor_reversed: true,
            encoder_reversed: false,
            angle_deg,
            counts_per_turn: 4880.0,
        }
    }

    #[test]
    fn commands_are_as_the_firmware_reads_them() {
        let mut expected = vec![1, ID, 3, 1, 1, 3, 0, 0, 0, 0];
        for float in [180.0f32, 4880.0, 0.0, 4880.0] {
            expected.extend_from_slice(&float.to_le_bytes());
        }
        assert_eq!(set_up(&[port(180.0), port(0.0)]).to_vec(), expected);
        // 0.5 and −0.25 have one bit of mantissa.
        assert_eq!(
            torques([0.5, -0.25]),
            [2, ID, 0, 0, 0, 0x3F, 0, 0, 0x80, 0xBE]
        );
        assert_eq!(torques([f32::NAN, f32::INFINITY])[2..], [0; 8]);
    }

    fn read(stream: &[u8]) -> (Vec<[f32; ARMS]>, usize) {
        let mut reader = AnswerReader::default();
        let (mut good, mut bad) = (Vec::new(), 0);
        for &byte in stream {
            match reader.push(byte) {
                Some(Ok(angles)) => good.push(angles),
                Some(Err(BadAnswer)) => bad += 1,
                None => {}
            }
        }
        (good, bad)
    }

    #[test]
    fn answers_are_found_after_noise() {
        let mut stream = vec![7, 9];
        stream.extend_from_slice(&answer([181.5, -3.25]));
        stream.extend_from_slice(&answer([181.75, -3.0]));
        assert_eq!(read(&stream), (vec![[181.5, -3.25], [181.75, -3.0]], 2));
    }

    #[test]
    fn the_next_answer_may_begin_inside_a_refused_one() {
        let mut reader = AnswerReader::default();
        // Three bytes of noise that look like the start of an answer.
        for byte in [ID, 0, 0] {
            assert_eq!(reader.push(byte), None);
        }
        let mut found = Vec::new();
        for &byte in &answer([1.0, 2.0]) {
            if let Some(Ok(angles)) = reader.push(byte) {
                found.push(angles);
                if angles[0] < 0.5 {
                    reader.reject();
                }
            }
        }
        assert_eq!(found.len(), 2);
        assert_eq!(found.last(), Some(&[1.0, 2.0]));
    }

    proptest! {
        #[test]
        fn angles_are_read_as_sent(angles in prop::array::uniform2(-720.0..720.0f32)) {
            prop_assert_eq!(read(&answer(angles)), (vec![angles], 0));
        }

        #[test]
        fn arbitrary_bytes_give_angles_in_range_or_none(
            bytes in prop::collection::vec(prop_oneof![Just(ID), any::<u8>()], 0..4096),
        ) {
            for angles in read(&bytes).0 {
                prop_assert!(angles.iter().all(|deg| deg.abs() <= ANGLE_LIMIT_DEG));
            }
        }

        /// Torques that the board reads when one or two bytes of a command are lost.
        #[test]
        fn command_without_one_or_two_bytes_gives_no_torque(
            sent in prop::array::uniform2(-0.123..0.123f32),
            next in prop::array::uniform2(-0.123..0.123f32),
            lost in 1usize..=2,
        ) {
            let stream = [torques(sent), torques(next)].concat();
            let after = &stream[2 + lost..2 + lost + 8];
            for float in after.chunks(4) {
                let torque = f32::from_le_bytes(float.try_into().unwrap());
                prop_assert!(torque.abs() < 1e-18, "{torque}");
            }
        }

        #[test]
        fn torques_are_sent_to_one_percent_and_never_more(sent in -0.123..0.123f32) {
            let read = truncate_mantissa(sent);
            prop_assert!(read.abs() <= sent.abs() && (read - sent).abs() <= 0.01 * sent.abs());
        }
    }
}
