//! The firmware's side of the text protocol. The emulator uses it.

use super::wire::{Currents, Encoders, MAX_LINE, Model};

/// Time without a command after which the motors are switched off, µs.
const WATCHDOG_US: u32 = 100_000;
/// Error code: a byte other than a line end follows the command.
const TRAILING: i32 = 8;
/// Error code: the buffer is full before a command ends.
const TOO_LONG: i32 = 128;
/// Error code: the command has no `[`.
const NO_START: i32 = 256;
/// Error code: the command has a wrong number of commas.
const WRONG_LENGTH: i32 = 512;
/// Error code: the text between the brackets is no list of numbers.
const NO_LIST: i32 = 1024;
/// Number of commas in a command.
const COMMAS: usize = 2;

/// Firmware of one Teensy.
#[derive(Debug, Clone, Default)]
pub struct Firmware {
    buffer: CommandBuffer,
    command: Option<(Currents, u32)>,
    /// Encoders at the last good command. An answer with an error repeats them.
    counts: [i32; 6],
}

impl Firmware {
    /// Takes the received bytes and answers every command. A good command is answered with
    /// `counts`. Like the real firmware, it loses a command if the next command has already been
    /// received.
    pub fn receive(
        &mut self,
        mut waiting: &[u8],
        counts: [i32; 6],
        now_us: u32,
        mut answer: impl FnMut(&[u8]),
    ) {
        while let Some((&byte, rest)) = waiting.split_first() {
            waiting = rest;
            let Some(read) = self.buffer.push(byte) else {
                continue;
            };
            let read = read.and_then(|currents| {
                end_of_line(&mut waiting)?;
                currents.ok_or(NO_LIST)
            });
            if let Ok(currents) = read {
                self.command = Some((currents, now_us));
                self.counts = counts;
            }
            let encoders = Encoders {
                model: Model::Woody,
                counts: self.counts,
                error: read.err().unwrap_or(0),
            };
            answer(encoders.line().as_bytes());
        }
    }

    /// Motor currents now, mA. A current above the limit becomes zero. After 100 ms without a
    /// command all currents become zero.
    pub fn currents_ma(&mut self, now_us: u32) -> [i32; 3] {
        let Some((Currents(currents), at_us)) = self.command else {
            return [0; 3];
        };
        if now_us.wrapping_sub(at_us) > WATCHDOG_US {
            self.command = None;
            return [0; 3];
        }
        currents.map(|current| {
            if current.abs() <= Currents::LIMIT_MA {
                current
            } else {
                0
            }
        })
    }

    /// True from a command until the watchdog acts.
    #[must_use]
    pub const fn is_commanded(&self) -> bool {
        self.command.is_some()
    }
}

/// Skips the end of a line. If another byte follows, that byte and the command are lost.
fn end_of_line(waiting: &mut &[u8]) -> Result<(), i32> {
    while let Some((byte, rest)) = waiting.split_first() {
        *waiting = rest;
        if !b"\n\r\0".contains(byte) {
            return Err(TRAILING);
        }
    }
    Ok(())
}

/// Bytes since the last command, at most as many as the firmware's buffer holds.
#[derive(Debug, Clone)]
struct CommandBuffer {
    bytes: [u8; MAX_LINE],
    len: usize,
    /// Index after the last `[`.
    start: Option<usize>,
    /// Commas, those before the `[` included.
    commas: usize,
}

impl Default for CommandBuffer {
    fn default() -> Self {
        Self {
            bytes: [0; MAX_LINE],
            len: 0,
            start: None,
            commas: 0,
        }
    }
}

impl CommandBuffer {
    /// Takes one byte. At the end of a command it returns the currents, `None` if they are no
    /// numbers, or an error code.
    fn push(&mut self, byte: u8) -> Option<Result<Option<Currents>, i32>> {
        if byte == b']' {
            let ended = std::mem::take(self);
            return Some(ended.command());
        }
        if let Some(slot) = self.bytes.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
        match byte {
            b'[' => self.start = Some(self.len),
            b',' => self.commas += 1,
            _ => {}
        }
        (self.len == MAX_LINE).then(|| {
            *self = Self::default();
            Err(TOO_LONG)
        })
    }

    fn command(&self) -> Result<Option<Currents>, i32> {
        let start = self.start.ok_or(NO_START)?;
        if self.commas != COMMAS {
            return Err(WRONG_LENGTH);
        }
        Ok(self.bytes.get(start..self.len).and_then(Currents::parse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn say(firmware: &mut Firmware, text: &[u8], now_us: u32) -> String {
        let mut answers = String::new();
        firmware.receive(text, [1, 2, 3, 0, 0, 0], now_us, |answer| {
            answers.push_str(std::str::from_utf8(answer).unwrap());
        });
        answers
    }

    #[test]
    fn device_gives_one_answer_per_command() {
        let mut firmware = Firmware::default();
        assert_eq!(say(&mut firmware, b"[0,0,", 0), "");
        assert_eq!(say(&mut firmware, b"0]\n", 0), "[3,1,2,3,0,0,0,0]\n");
        assert_eq!(
            say(&mut firmware, b"\r\n[0,0,7]\r\n\0", 0),
            "[3,1,2,3,0,0,0,0]\n"
        );
    }

    #[test]
    fn every_wrong_command_has_its_code() {
        let too_long = [b'1'; MAX_LINE];
        let mistakes: [(&[u8], i32); 9] = [
            (b"[0,0]\n", WRONG_LENGTH),
            (b"[0,0,0,0]\n", WRONG_LENGTH),
            (b",[0,0,0]\n", WRONG_LENGTH),
            (b"0,0,0]\n", NO_START),
            (b"]\n", NO_START),
            (b"[0,x,0]\n", NO_LIST),
            (b"[0,[0,0]\n", NO_LIST),
            (b"[0,0,0]x", TRAILING),
            (&too_long, TOO_LONG),
        ];
        for (text, code) in mistakes {
            let shown = String::from_utf8_lossy(text);
            let mut firmware = Firmware::default();
            let answer = say(&mut firmware, text, 0);
            assert_eq!(answer, format!("[3,0,0,0,0,0,0,{code}]\n"), "{shown}");
            assert!(!firmware.is_commanded(), "{shown}");
            let answer = say(&mut firmware, b"[0,0,0]\n", 0);
            assert_eq!(answer, "[3,1,2,3,0,0,0,0]\n", "after {shown}");
        }
    }

    #[test]
    fn two_waiting_commands_are_both_lost() {
        let mut firmware = Firmware::default();
        assert_eq!(
            say(&mut firmware, b"[1,1,1]\n[2,2,2]\n", 0),
            "[3,0,0,0,0,0,0,8]\n[3,0,0,0,0,0,0,256]\n"
        );
        assert_eq!(firmware.currents_ma(0), [0; 3]);
    }

    #[test]
    fn an_answer_with_an_error_repeats_the_last_encoders() {
        let mut firmware = Firmware::default();
        say(&mut firmware, b"[0,0,0]\n", 0);
        let mut answers = String::new();
        firmware.receive(b"[0,0]\n", [9; 6], 0, |answer| {
            answers.push_str(std::str::from_utf8(answer).unwrap());
        });
        assert_eq!(answers, "[3,1,2,3,0,0,0,512]\n");
    }

    #[test]
    fn too_large_a_current_becomes_zero_and_silence_ends_the_current() {
        let mut firmware = Firmware::default();
        say(&mut firmware, b"[6000,-6001,5]\n", 0);
        assert_eq!(firmware.currents_ma(100_000), [6000, 0, 5]);
        assert_eq!(firmware.currents_ma(100_001), [0; 3]);
        assert_eq!(firmware.currents_ma(0), [0; 3], "whatever the clock does");
    }
}
