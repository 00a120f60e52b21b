//! The two kinds of text line: currents to the device, and encoder counts from it. Source: the
//! firmware `woody_teensy_mini`.

/// Longest line, bytes; the firmware's own buffer is as long.
pub const MAX_LINE: usize = 127;
/// Largest plausible encoder count.
const COUNT_LIMIT: i32 = 10_000_000;
/// Numbers in the device's line.
const FIELDS: usize = 8;

/// Model that a device reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Polhem: another linkage.
    Polhem,
    /// Vintage Phantom with new electronics.
    Vintage,
    /// WoodenHaptics.
    Woody,
}

/// The device's line: `[model,e0,e1,e2,e3,e4,e5,error]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoders {
    /// Model of the device.
    pub model: Model,
    /// Counts of the three motors, then of the three joints of the handle.
    pub counts: [i32; 6],
    /// 0, or the reason for which the last command was refused: 1, 2, 4 for a joint's sensor; 8 and
    /// above for a command that was not understood.
    pub error: i32,
}

impl Encoders {
    /// Parses the text between the brackets.
    #[must_use]
    pub fn parse(text: &[u8]) -> Option<Self> {
        let mut numbers = [0; FIELDS];
        let mut fields = text.split(|&byte| byte == b',');
        for number in &mut numbers {
            *number = integer(fields.next()?)?;
        }
        if fields.next().is_some() {
            return None;
        }
        let [model, e0, e1, e2, e3, e4, e5, error] = numbers;
        let counts = [e0, e1, e2, e3, e4, e5];
        if counts.iter().any(|count| count.abs() > COUNT_LIMIT) {
            return None;
        }
        let model = match model {
            1 => Model::Polhem,
            2 => Model::Vintage,
            3 => Model::Woody,
            _ => return None,
        };
        Some(Self {
            model,
            counts,
            error,
        })
    }

    /// The line of text.
    #[must_use]
    pub fn line(&self) -> Text {
        let model = match self.model {
            Model::Polhem => 1,
            Model::Vintage => 2,
            Model::Woody => 3,
        };
        let [e0, e1, e2, e3, e4, e5] = self.counts;
        Text::list(&[model, e0, e1, e2, e3, e4, e5, self.error])
    }
}

/// The host's line: `[a,b,c]`, currents of the three motors, mA. The firmware turns a current above
/// 6 A into zero, so the driver must limit it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Currents(pub [i32; 3]);

impl Currents {
    /// Largest current that the firmware accepts, mA.
    pub const LIMIT_MA: i32 = 6000;

    /// Parses the text between the brackets.
    #[must_use]
    pub fn parse(text: &[u8]) -> Option<Self> {
        let mut fields = text.split(|&byte| byte == b',');
        let mut currents = [0; 3];
        for current in &mut currents {
            *current = integer(fields.next()?)?;
        }
        fields.next().is_none().then_some(Self(currents))
    }

    /// The line of text.
    #[must_use]
    pub fn line(&self) -> Text {
        Text::list(&self.0)
    }
}

/// An integer of at most nine digits, with or without a minus sign.
fn integer(text: &[u8]) -> Option<i32> {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        digits => (1, digits),
    };
    if digits.is_empty() || digits.len() > 9 {
        return None;
    }
    digits
        .iter()
        .try_fold(0i32, |value, digit| {
            digit
                .is_ascii_digit()
                .then(|| value * 10 + i32::from(digit - b'0'))
        })
        .map(|value| sign * value)
}

/// A line of text without allocation.
#[derive(Debug, Clone, Copy)]
pub struct Text {
    bytes: [u8; MAX_LINE],
    len: usize,
}

impl Text {
    /// `[a,b,…]` and a newline.
    fn list(numbers: &[i32]) -> Self {
        let mut text = Self {
            bytes: [0; MAX_LINE],
            len: 0,
        };
        text.push(b'[');
        for (position, &number) in numbers.iter().enumerate() {
            if position > 0 {
                text.push(b',');
            }
            text.number(number);
        }
        text.push(b']');
        text.push(b'\n');
        text
    }

    fn number(&mut self, number: i32) {
        if number < 0 {
            self.push(b'-');
        }
        let mut rest = number.unsigned_abs();
        let mut digits = [0u8; 10];
        let mut count = 0;
        for digit in &mut digits {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
            count += 1;
            if rest == 0 {
                break;
            }
        }
        for &digit in digits.iter().take(count).rev() {
            self.push(digit);
        }
    }

    fn push(&mut self, byte: u8) {
        if let Some(slot) = self.bytes.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
    }

    /// The bytes to send.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }
}

/// Finds bracketed lists in a stream of bytes.
#[derive(Debug, Clone)]
pub struct ListReader {
    bytes: [u8; MAX_LINE],
    /// `None` outside brackets.
    len: Option<usize>,
}

/// A list broke off or was too long, or a `]` came without its `[`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadList;

impl Default for ListReader {
    fn default() -> Self {
        Self {
            bytes: [0; MAX_LINE],
            len: None,
        }
    }
}

impl ListReader {
    /// Takes one byte. Returns `Some(Ok)` with the text between the brackets when they close.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], BadList>> {
        match (byte, self.len) {
            (b'[', before) => {
                self.len = Some(0);
                before.map(|_| Err(BadList))
            }
            (b']', Some(len)) => {
                self.len = None;
                Some(self.bytes.get(..len).ok_or(BadList))
            }
            (b']', None) => Some(Err(BadList)),
            (_, None) => None,
            (_, Some(len)) => match self.bytes.get_mut(len) {
                Some(slot) => {
                    *slot = byte;
                    self.len = Some(len + 1);
                    None
                }
                None => {
                    self.len = None;
                    Some(Err(BadList))
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn between(line: &[u8]) -> Vec<u8> {
        let mut reader = ListReader::default();
        line.iter()
            .find_map(|&byte| reader.push(byte).map(|r| r.unwrap().to_vec()))
            .unwrap()
    }

    #[test]
    fn lines_are_as_the_firmware_prints_and_scans_them() {
        assert_eq!(
            Currents([-120, 0, 6000]).line().as_bytes(),
            b"[-120,0,6000]\n"
        );
        let counts = [8312, -10366, 19768, 0, 30, 0];
        let line = Encoders {
            model: Model::Woody,
            counts,
            error: 0,
        }
        .line();
        assert_eq!(line.as_bytes(), b"[3,8312,-10366,19768,0,30,0,0]\n");
        assert_eq!(
            Encoders::parse(&between(line.as_bytes())).unwrap().counts,
            counts
        );
    }

    #[test]
    fn message_without_eight_numbers_is_refused() {
        for text in [
            &b"3,1,2,3,4,5,6"[..],
            b"3,1,2,3,4,5,6,0,0",
            b"3,1,2,3,4,5,6,",
            b"3,1,2,3,nan,5,6,0",
            b"9,1,2,3,4,5,6,0",
            b"3,99999999,2,3,4,5,6,0",
            b"3,9999999999999999,2,3,4,5,6,0",
            b"3,--1,2,3,4,5,6,0",
            b"",
        ] {
            assert_eq!(
                Encoders::parse(text),
                None,
                "{}",
                String::from_utf8_lossy(text)
            );
        }
    }

    proptest! {
        #[test]
        fn encoders_are_read_as_sent(counts in prop::array::uniform6(-COUNT_LIMIT..COUNT_LIMIT)) {
            let sent = Encoders { model: Model::Woody, counts, error: 8 };
            prop_assert_eq!(Encoders::parse(&between(sent.line().as_bytes())), Some(sent));
        }

        #[test]
        fn currents_are_read_as_sent(currents in prop::array::uniform3(-6000..=6000)) {
            let sent = Currents(currents);
            prop_assert_eq!(Currents::parse(&between(sent.line().as_bytes())), Some(sent));
        }

        #[test]
        fn arbitrary_text_is_harmless(bytes in prop::collection::vec(
            prop::sample::select(b"[],-0123456789\nx".to_vec()), 0..1000)) {
            let mut reader = ListReader::default();
            for byte in bytes {
                if let Some(Ok(text)) = reader.push(byte)
                    && let Some(encoders) = Encoders::parse(text)
                {
                    prop_assert!(encoders.counts.iter().all(|c| c.abs() <= COUNT_LIMIT));
                }
            }
        }
    }
}
