//! The bird's side of the protocol. The emulator uses it.

use super::wire::{Hemisphere, Record, Scale, command, parameter, status};

/// State of a bird or a group of birds: takes command bytes, returns answers and records.
#[derive(Debug, Clone)]
pub struct Bird {
    model: [u8; 10],
    running: bool,
    streaming: bool,
    scale: Scale,
    group: bool,
    /// Number of birds taken into the group.
    group_size: u8,
    error: u8,
    command: PartialCommand,
    /// Address of the bird that receives the next command.
    addressed: u8,
    birds: Vec<Sensor>,
}

/// One bird.
#[derive(Debug, Clone, Copy)]
struct Sensor {
    pose: Record,
    hemisphere: Hemisphere,
    /// True if the bird's records hold position and quaternion. Otherwise they hold position and
    /// angles.
    with_quaternion: bool,
}

/// A command whose arguments are incomplete.
#[derive(Debug, Clone, Copy, Default)]
struct PartialCommand {
    code: u8,
    arguments: [u8; 3],
    have: usize,
    need: usize,
}

/// Error 6: unknown command.
const INVALID_COMMAND: u8 = 6;
/// Length of a record of position and angles.
const ANGLES_BYTES: usize = 12;

impl Bird {
    /// A bird after power-up: it runs, sends nothing, and expects the forward hemisphere.
    #[must_use]
    pub fn new(pose: Record) -> Self {
        Self::flock(&[pose])
    }

    /// Makes the bird report the error `code` until the host reads it, as a bird with a broken part
    /// does after power-up.
    #[cfg(test)]
    pub(crate) const fn fail(&mut self, code: u8) {
        self.error = code;
    }

    /// Birds with these poses and the addresses 1, 2, ….
    #[must_use]
    pub fn flock(poses: &[Record]) -> Self {
        Self {
            model: *b"6DFOB     ",
            running: true,
            streaming: false,
            scale: Scale::default(),
            group: false,
            group_size: 1,
            error: 0,
            command: PartialCommand::default(),
            addressed: 1,
            birds: poses
                .iter()
                .map(|&pose| Sensor {
                    pose,
                    hemisphere: Hemisphere::Forward,
                    with_quaternion: false,
                })
                .collect(),
        }
    }

    /// Changes the ten-character model name.
    #[must_use]
    pub fn with_model(self, model: [u8; 10]) -> Self {
        Self { model, ..self }
    }

    /// Length of the first command in `bytes`, including its address.
    #[must_use]
    pub fn command_len(bytes: &[u8]) -> usize {
        let prefix = usize::from(bytes.first().is_some_and(|&byte| byte > command::TO_BIRD));
        let arguments = match (bytes.get(prefix), bytes.get(prefix + 1)) {
            (Some(&command::CHANGE), Some(&parameter)) => change_arguments(parameter),
            (Some(&command::HEMISPHERE), _) => 2,
            (Some(&command::EXAMINE | &command::CHANGE), _) => 1,
            _ => 0,
        };
        prefix + 1 + arguments
    }

    /// Sets the true pose of the first sensor.
    pub fn set_pose(&mut self, pose: Record) {
        if let Some(first) = self.birds.first_mut() {
            first.pose = pose;
        }
    }

    /// True if records flow without requests.
    #[must_use]
    pub const fn is_streaming(&self) -> bool {
        self.streaming && self.running
    }

    /// Takes bytes from the host and passes the answers to `answer`.
    pub fn receive(&mut self, bytes: &[u8], mut answer: impl FnMut(&[u8])) {
        for &byte in bytes {
            let command = &mut self.command;
            if command.have < command.need {
                command.arguments[command.have] = byte;
                command.have += 1;
                if command.code == command::CHANGE && command.have == 1 {
                    command.need = change_arguments(byte);
                }
            } else if byte > command::TO_BIRD {
                self.addressed = byte & 0x0F;
                continue;
            } else {
                let need = match byte {
                    command::HEMISPHERE => 2,
                    command::EXAMINE | command::CHANGE => 1,
                    _ => 0,
                };
                *command = PartialCommand {
                    code: byte,
                    need,
                    ..PartialCommand::default()
                };
            }
            if self.command.have == self.command.need {
                self.execute(&mut answer);
                self.command = PartialCommand::default();
                self.addressed = 1;
            }
        }
    }

    fn execute(&mut self, answer: &mut impl FnMut(&[u8])) {
        let PartialCommand {
            code,
            arguments: [first, second, third],
            ..
        } = self.command;
        match code {
            command::POINT if self.streaming => self.streaming = false,
            command::POINT if self.running => answer(&self.record_of(self.addressed)),
            command::POINT => {}
            command::STREAM => self.streaming = true,
            command::POSITION_QUATERNION => {
                if let Some(sensor) = self.sensor() {
                    sensor.with_quaternion = true;
                }
            }
            command::RUN => self.running = true,
            command::SLEEP => self.running = false,
            command::HEMISPHERE => match Hemisphere::from_bytes([first, second]) {
                Some(hemisphere) => {
                    if let Some(sensor) = self.sensor() {
                        sensor.hemisphere = hemisphere;
                    }
                }
                None => self.error = INVALID_COMMAND,
            },
            command::EXAMINE => self.examine(first, answer),
            command::CHANGE if first == parameter::SCALING => {
                match Scale::from_bytes([second, third]) {
                    Some(scale) => self.scale = scale,
                    None => self.error = INVALID_COMMAND,
                }
            }
            command::CHANGE if first == parameter::AUTO_CONFIGURE => self.group_size = second,
            command::CHANGE if first == parameter::GROUP_MODE => self.group = second == 1,
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
            parameter::SCALING => answer(&self.scale.bytes()),
            parameter::ERROR => answer(&[std::mem::take(&mut self.error)]),
            parameter::MODEL => answer(&self.model),
            _ => self.error = INVALID_COMMAND,
        }
    }

    fn sensor(&mut self) -> Option<&mut Sensor> {
        let place = usize::from(self.addressed).checked_sub(1)?;
        self.birds.get_mut(place)
    }

    /// Record of the first bird's present pose. In a group, the records of all birds taken into it,
    /// each with its bird's address.
    #[must_use]
    pub fn record(&self) -> Vec<u8> {
        self.record_of(1)
    }

    fn record_of(&self, address: u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (sensor, at) in self.birds.iter().zip(1..) {
            if self.group && at <= self.group_size {
                bytes.extend_from_slice(&sensor.record(self.scale));
                bytes.push(at);
            } else if !self.group && at == address {
                bytes.extend_from_slice(&sensor.record(self.scale));
            }
        }
        bytes
    }
}

/// Number of argument bytes of `CHANGE` for this parameter, the parameter's number included.
const fn change_arguments(parameter: u8) -> usize {
    match parameter {
        parameter::GROUP_MODE | parameter::AUTO_CONFIGURE => 2,
        _ => 3,
    }
}

impl Sensor {
    /// In the wrong hemisphere the position is mirrored through the transmitter, as with the real
    /// bird.
    fn record(&self, scale: Scale) -> Vec<u8> {
        let mut record = self.pose;
        if self.hemisphere.depth(record.position_m) < 0.0 {
            record.position_m = record.position_m.map(|part| -part);
        }
        let mut bytes = record.bytes(scale).to_vec();
        if !self.with_quaternion {
            // The host never reads the three angles, so these words just hold a part of the
            // quaternion.
            bytes.truncate(ANGLES_BYTES);
        }
        bytes
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
    fn the_bird_answers_its_name_and_its_status() {
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
    fn the_point_command_ends_a_stream_or_asks_for_a_record() {
        let mut bird = bird();
        assert_eq!(answers(&mut bird, b"@"), b"");
        assert!(bird.is_streaming());
        assert_eq!(answers(&mut bird, b"B"), b"");
        assert!(!bird.is_streaming());
        assert_eq!(answers(&mut bird, b"B").len(), 12);
        assert_eq!(answers(&mut bird, b"]B").len(), 14);
    }

    #[test]
    fn the_wrong_hemisphere_mirrors_positions() {
        let mut bird = bird();
        answers(&mut bird, b"]L\x0C\x00"); // selects the lower half, but z is negative
        let parse =
            |bytes: Vec<u8>| Record::parse(&bytes.try_into().unwrap(), Scale::Inches36).unwrap();
        let mirrored = parse(bird.record());
        assert!((mirrored.position_m[2] - 0.2).abs() < 1e-3);
        answers(&mut bird, b"L\x0C\x01");
        let right = parse(bird.record());
        assert!((right.position_m[2] + 0.2).abs() < 1e-3);
    }

    #[test]
    fn a_group_answers_with_a_record_and_the_address_of_every_bird() {
        let pose = |x| Record {
            position_m: [x, 0.0, 0.0],
            rotation: UnitQuaternion::identity(),
        };
        let mut flock = Bird::flock(&[pose(0.1), pose(0.2), pose(0.3)]);
        // Takes two birds into the group, lets both send quaternions and switches group mode on.
        answers(&mut flock, b"P\x32\x02\xF1]\xF2]P\x23\x01");
        let all = answers(&mut flock, b"B");
        assert_eq!((all.len(), all[14], all[29]), (30, 1, 2));
        answers(&mut flock, b"P\x23\x00");
        assert_eq!(answers(&mut flock, b"\xF2B").len(), 14);
        assert_eq!(
            answers(&mut flock, b"\xF3B").len(),
            12,
            "bird 3 still sends angles"
        );
    }
}
