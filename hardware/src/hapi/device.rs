//! The board's side of the protocol. The emulator uses it. It reproduces two flaws of the firmware:
//! the last torque stays, and missing bytes are misread.

use std::collections::VecDeque;

use super::wire::command;

/// Number of ports of the board.
const PORTS: usize = 4;
/// Torque limit of the firmware, N m.
const TORQUE_MAX_NM: f32 = 0.123;
/// Time after which an incomplete command is executed, µs.
const READ_TIMEOUT_US: u32 = 1_000_000;
/// Size of the receive buffer, bytes; more bytes are dropped.
const BUFFER_BYTES: usize = 512;

/// One board. It holds every torque until it receives another or loses its power.
#[derive(Debug, Clone, Default)]
pub struct Board {
    unread: VecDeque<u8>,
    motors: [Motor; PORTS],
    encoders: [Encoder; PORTS],
    waiting: Option<PendingCommand>,
    /// True if the board was set up since power-up.
    was_set_up: bool,
}

#[derive(Debug, Clone, Copy, Default)]
struct Motor {
    /// Id of the host that set the motor up; 0: none.
    host: u8,
    torque_nm: f32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Encoder {
    host: u8,
    counts_per_turn: f32,
    /// Angle of the arm that the host stated at the set-up.
    stated_deg: f32,
    /// True angle of the arm at the set-up.
    true_deg: f32,
}

/// A command whose floats are incomplete.
#[derive(Debug, Clone, Copy)]
struct PendingCommand {
    host: u8,
    floats: usize,
    what: Floats,
    since_us: u32,
}

#[derive(Debug, Clone, Copy)]
enum Floats {
    Torques,
    Encoders { mask: u8, motors: u8 },
}

impl Board {
    /// Takes the host's bytes and answers every torque command. `angles_deg` are the arms' angles,
    /// by port.
    ///
    /// Like the firmware, it waits for floats but not for single bytes. A missing byte reads as FF.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        angles_deg: [f32; PORTS],
        now_us: u32,
        mut answer: impl FnMut(&[u8]),
    ) {
        let room = BUFFER_BYTES.saturating_sub(self.unread.len());
        self.unread.extend(bytes.iter().take(room));
        loop {
            if let Some(waiting) = self.waiting {
                let late = now_us.wrapping_sub(waiting.since_us) > READ_TIMEOUT_US;
                if self.unread.len() < 4 * waiting.floats && !late {
                    return;
                }
                self.waiting = None;
                self.floats(waiting, angles_deg);
                if matches!(waiting.what, Floats::Torques) {
                    answer(&self.angles(waiting.host, angles_deg));
                }
                continue;
            }
            let Some(first) = self.unread.pop_front() else {
                return;
            };
            match first {
                command::RESET => {
                    self.byte();
                    self.reset();
                }
                command::SET_UP => self.set_up(now_us),
                command::TORQUES => {
                    let host = self.byte();
                    let floats = self.motors.iter().filter(|m| m.host == host).count();
                    self.waiting = Some(PendingCommand {
                        host,
                        floats,
                        what: Floats::Torques,
                        since_us: now_us,
                    });
                }
                _ => {}
            }
        }
    }

    /// Torques of the motors, by port, N m.
    #[must_use]
    pub fn torques_nm(&self) -> [f32; PORTS] {
        self.motors.map(|motor| motor.torque_nm)
    }

    /// True if a host has stated the arms' angles since power-up, right or wrong.
    #[must_use]
    pub const fn was_set_up(&self) -> bool {
        self.was_set_up
    }

    fn byte(&mut self) -> u8 {
        self.unread.pop_front().unwrap_or(0xFF)
    }

    fn float(&mut self) -> f32 {
        // For missing bytes the firmware uses the contents of its stack; here zeros.
        f32::from_le_bytes(std::array::from_fn(|_| {
            self.unread.pop_front().unwrap_or(0)
        }))
    }

    /// The motors lose their host but keep their torque.
    fn reset(&mut self) {
        for motor in &mut self.motors {
            motor.host = 0;
        }
        for encoder in &mut self.encoders {
            encoder.host = 0;
        }
    }

    fn set_up(&mut self, now_us: u32) {
        self.reset();
        let host = self.byte();
        let motors = self.byte() & 0x0F;
        for _ in 0..motors.count_ones() {
            self.byte();
        }
        let mask = self.byte() & 0x0F;
        for _ in 0..mask.count_ones() {
            self.byte();
        }
        for _ in 0..2 {
            for _ in 0..self.byte() {
                self.byte();
            }
        }
        self.waiting = Some(PendingCommand {
            host,
            floats: 2 * mask.count_ones() as usize,
            what: Floats::Encoders { mask, motors },
            since_us: now_us,
        });
    }

    fn floats(&mut self, waiting: PendingCommand, angles_deg: [f32; PORTS]) {
        let host = waiting.host;
        match waiting.what {
            Floats::Torques => {
                for port in 0..PORTS {
                    if self.motors[port].host == host {
                        // As in the firmware: a NaN passes its clamp, and the conversion to a duty
                        // cycle turns it into zero.
                        let torque = self.float();
                        self.motors[port].torque_nm = if torque.is_nan() {
                            0.0
                        } else {
                            torque.clamp(-TORQUE_MAX_NM, TORQUE_MAX_NM)
                        };
                    }
                }
            }
            Floats::Encoders { mask, motors } => {
                for (port, true_deg) in angles_deg.into_iter().enumerate() {
                    if mask & 1 << port != 0 {
                        let stated_deg = self.float();
                        let counts_per_turn = self.float();
                        self.encoders[port] = Encoder {
                            host,
                            counts_per_turn,
                            stated_deg,
                            true_deg,
                        };
                        self.was_set_up = true;
                    }
                    if motors & 1 << port != 0 {
                        self.motors[port].host = host;
                    }
                }
            }
        }
    }

    fn angles(&self, host: u8, angles_deg: [f32; PORTS]) -> Vec<u8> {
        let mut bytes = vec![host];
        for (encoder, angle_deg) in self.encoders.iter().zip(angles_deg) {
            if encoder.host == host {
                let step_deg = 360.0 / encoder.counts_per_turn;
                let turned_deg = angle_deg - encoder.true_deg;
                let read = encoder.stated_deg + (turned_deg / step_deg).round() * step_deg;
                bytes.extend_from_slice(&read.to_le_bytes());
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::super::pantograph::Pantograph;
    use super::super::wire::{ID, set_up, torques};
    use super::*;

    const ANGLES: [f32; PORTS] = [10.0, 170.0, 0.0, 0.0];

    fn say(board: &mut Board, bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        board.receive(bytes, ANGLES, 0, |bytes| answers.extend_from_slice(bytes));
        answers
    }

    fn ready() -> Board {
        let mut board = Board::default();
        let ports = Pantograph::GEN3.ports([170.0, 10.0]);
        assert_eq!(say(&mut board, &set_up(&ports)), b"");
        board
    }

    #[test]
    fn a_fresh_board_answers_its_name_and_takes_zeros_as_resets() {
        let mut board = Board::default();
        assert_eq!(say(&mut board, &torques([0.0; 2])), [ID]);
    }

    #[test]
    fn after_the_setup_the_board_answers_angles_and_applies_the_torque() {
        let mut board = ready();
        let answer = say(&mut board, &torques([0.0625, -1.0]));
        assert_eq!(answer.len(), 9);
        let second = f32::from_le_bytes(answer[5..].try_into().unwrap());
        assert!((second - 170.0).abs() < 0.04, "{second}");
        assert_eq!(board.torques_nm()[..2], [0.0625, -0.123]);
        board.receive(&[], ANGLES, 3_000_000, |_| {});
        assert_eq!(board.torques_nm()[..2], [0.0625, -0.123], "torques last");
        say(&mut board, &[0, 0]);
        assert_eq!(
            board.torques_nm()[..2],
            [0.0625, -0.123],
            "after a reset, too"
        );
    }

    #[test]
    fn angles_are_the_given_start_plus_the_rotation_since() {
        let mut board = Board::default();
        say(&mut board, &set_up(&Pantograph::GEN3.ports([100.0, 30.0])));
        let mut answer = Vec::new();
        let turned = [15.0, 168.0, 0.0, 0.0];
        board.receive(&torques([0.0; 2]), turned, 0, |bytes| {
            answer.extend_from_slice(bytes);
        });
        let [first, second] =
            [1, 5].map(|at| f32::from_le_bytes(answer[at..at + 4].try_into().unwrap()));
        assert!((first - 35.0).abs() < 0.04 && (second - 98.0).abs() < 0.04);
    }

    #[test]
    fn a_command_may_come_in_pieces() {
        let mut board = ready();
        let command = torques([0.0625, 0.0]);
        assert_eq!(say(&mut board, &command[..5]), b"");
        assert_eq!(say(&mut board, &command[5..]).len(), 9);
        assert!((board.torques_nm()[0] - 0.0625).abs() < 1e-9);
    }
}
