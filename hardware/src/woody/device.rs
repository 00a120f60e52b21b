//! The firmware's side of the text protocol, for the emulator.

use super::wire::{Currents, Encoders, ListReader, Model};

/// Time without a command after which the motors are switched off, µs.
const WATCHDOG_US: u32 = 100_000;
/// Error codes of the firmware.
const TOO_LONG: i32 = 128;
const NO_LIST: i32 = 1024;

/// Firmware of one Teensy.
#[derive(Debug, Clone, Default)]
pub struct Firmware {
    reader: ListReader,
    command: Option<(Currents, u32)>,
}

impl Firmware {
    /// Takes the host's bytes and answers every command with the encoder counts.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        counts: [i32; 6],
        now_us: u32,
        mut answer: impl FnMut(&[u8]),
    ) {
        for &byte in bytes {
            let Some(read) = self.reader.push(byte) else {
                continue;
            };
            let error = match read.map(Currents::parse) {
                Ok(Some(currents)) => {
                    self.command = Some((currents, now_us));
                    0
                }
                Ok(None) => NO_LIST,
                Err(_) => TOO_LONG,
            };
            answer(
                Encoders {
                    model: Model::Woody,
                    counts,
                    error,
                }
                .line()
                .as_bytes(),
            );
        }
    }

    /// Motor currents now, mA. A current above the limit becomes zero; 100 ms without a command
    /// turn all of them to zero.
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

    /// True if commands arrive.
    #[must_use]
    pub const fn is_commanded(&self) -> bool {
        self.command.is_some()
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
        assert_eq!(say(&mut firmware, b"[0,0]\n", 0), "[3,1,2,3,0,0,0,1024]\n");
    }

    #[test]
    fn too_much_current_becomes_none_and_silence_ends_it() {
        let mut firmware = Firmware::default();
        say(&mut firmware, b"[6000,-6001,5]\n", 0);
        assert_eq!(firmware.currents_ma(100_000), [6000, 0, 5]);
        assert_eq!(firmware.currents_ma(100_001), [0; 3]);
        assert_eq!(firmware.currents_ma(0), [0; 3], "whatever the clock does");
    }
}
