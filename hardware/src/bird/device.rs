//! The bird's side of the protocol, as the emulator plays it.

use super::wire::{Hemisphere, Record, command, parameter, status};

/// State of one bird: takes command bytes, gives answers and records.
#[derive(Debug, Clone)]
pub struct Bird {
    model: [u8; 10],
    running: bool,
    streaming: bool,
    hemisphere: Hemisphere,
    error: u8,
    command: Partial,
    pose: Record,
}

/// A command whose arguments are still coming.
#[derive(Debug, Clone, Copy, Default)]
struct Partial {
    code: u8,
    arguments: [u8; 3],
    have: usize,
    need: usize,
}

/// Error 6: the command is not known.
const INVALID_COMMAND: u8 = 6;

impl Bird {
    /// A bird after power-up: running, silent, in the forward hemisphere.
    #[must_use]
    pub fn new(pose: Record) -> Self {
        Self {
            model: *b"6DFOB     ",
            running: true,
            streaming: false,
            hemisphere: Hemisphere::Forward,
            error: 0,
            command: Partial::default(),
            pose,
        }
    }

    /// Where the sensor really is.
    pub fn set_pose(&mut self, pose: Record) {
        self.pose = pose;
    }

    /// Whether records flow by themselves.
    #[must_use]
    pub const fn is_streaming(&self) -> bool {
        self.streaming && self.running
    }

    /// Takes the bytes that the host sent; hands what it answers to `answer`.
    pub fn receive(&mut self, bytes: &[u8], mut answer: impl FnMut(&[u8])) {
        for &byte in bytes {
            let command = &mut self.command;
            if command.have < command.need {
                command.arguments[command.have] = byte;
                command.have += 1;
                if command.code == command::CHANGE && command.have == 1 {
                    // Every parameter that this bird lets change has two bytes.
                    command.need = 3;
                }
            } else {
                let need = match byte {
                    command::HEMISPHERE => 2,
                    command::EXAMINE | command::CHANGE => 1,
                    _ => 0,
                };
                *command = Partial {
                    code: byte,
                    need,
                    ..Partial::default()
                };
            }
            if self.command.have == self.command.need {
                self.obey(&mut answer);
                self.command = Partial::default();
            }
        }
    }

    fn obey(&mut self, answer: &mut impl FnMut(&[u8])) {
        let Partial {
            code,
            arguments: [first, second, third],
            ..
        } = self.command;
        match code {
            command::POINT if self.streaming => self.streaming = false,
            command::POINT if self.running => answer(&self.record()),
            command::POINT => {}
            command::STREAM => self.streaming = true,
            command::POSITION_QUATERNION => {}
            command::RUN => self.running = true,
            command::SLEEP => self.running = false,
            command::HEMISPHERE => match Hemisphere::from_bytes([first, second]) {
                Some(hemisphere) => self.hemisphere = hemisphere,
                None => self.error = INVALID_COMMAND,
            },
            command::EXAMINE => self.examine(first, answer),
            // Only the 36-inch scale is played.
            command::CHANGE if first == parameter::SCALING && [second, third] == [0, 0] => {}
            _ => self.error = INVALID_COMMAND,
        }
    }

    fn examine(&mut self, parameter: u8, answer: &mut impl FnMut(&[u8])) {
        match parameter {
            parameter::STATUS => {
                let mut word = 0;
                if self.running {
                    word |= status::RUNNING;
                }
                if self.streaming {
                    word |= status::STREAMING;
                }
                if self.error != 0 {
                    word |= status::ERROR;
                }
                answer(&word.to_le_bytes());
            }
            parameter::SCALING => answer(&[0, 0]),
            parameter::ERROR => answer(&[std::mem::take(&mut self.error)]),
            parameter::MODEL => answer(&self.model),
            _ => self.error = INVALID_COMMAND,
        }
    }

    /// The record of the present pose. In the wrong hemisphere the position comes out mirrored
    /// through the transmitter, as it does from the real one.
    #[must_use]
    pub fn record(&self) -> [u8; super::wire::RECORD_BYTES] {
        let mut record = self.pose;
        if self.hemisphere.depth(record.position_m) < 0.0 {
            record.position_m = record.position_m.map(|part| -part);
        }
        record.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn bird() -> Bird {
        let position_m = [0.1, 0.0, -0.2];
        Bird::new(Record {
            position_m,
            rotation: UnitQuaternion::identity(),
        })
    }

    fn answers(bird: &mut Bird, bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        bird.receive(bytes, |answer| answers.extend_from_slice(answer));
        answers
    }

    #[test]
    fn answers_who_it_is_and_how_it_is() {
        let mut bird = bird();
        assert_eq!(answers(&mut bird, b"O\x0F"), b"6DFOB     ");
        assert_eq!(answers(&mut bird, b"O\x00"), status::RUNNING.to_le_bytes());
        assert_eq!(answers(&mut bird, b"O\x03"), [0, 0]);
    }

    #[test]
    fn an_unknown_command_raises_an_error_that_reading_clears() {
        let mut bird = bird();
        assert_eq!(answers(&mut bird, b"?O\x0A"), [INVALID_COMMAND]);
        assert_eq!(answers(&mut bird, b"O\x0A"), [0]);
    }

    #[test]
    fn point_ends_a_stream_and_else_asks_for_a_record() {
        let mut bird = bird();
        assert_eq!(answers(&mut bird, b"@"), b"");
        assert!(bird.is_streaming());
        assert_eq!(answers(&mut bird, b"B"), b"");
        assert!(!bird.is_streaming());
        assert_eq!(answers(&mut bird, b"B").len(), 14);
    }

    #[test]
    fn the_wrong_hemisphere_mirrors() {
        let mut bird = bird();
        answers(&mut bird, b"L\x0C\x00"); // lower, but z is negative
        let mirrored = Record::parse(&bird.record()).unwrap();
        assert!((mirrored.position_m[2] - 0.2).abs() < 1e-3);
        answers(&mut bird, b"L\x0C\x01");
        let right = Record::parse(&bird.record()).unwrap();
        assert!((right.position_m[2] + 0.2).abs() < 1e-3);
    }
}
