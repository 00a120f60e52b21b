//! Numbers in the format of the user's language.

use super::{Language, Words};

impl Words {
    /// A number with this many decimals.
    #[must_use]
    pub fn number(&self, value: f64, digits: usize) -> String {
        self.localised(format!("{value:.digits$}"))
    }

    /// A number with its unit. The unit `1` stands for a share, which is shown in per cent, `n` for
    /// a count, and `deg` for degrees.
    #[must_use]
    pub fn amount(&self, value: f64, unit: &str) -> String {
        match unit {
            "1" => format!("{:.0} %", 100.0 * value),
            "n" => format!("{value:.0}"),
            "deg" => format!("{value:.0}°"),
            // A short way is no "0.0 m".
            "m" if value.abs() < 1.0 => self.amount(100.0 * value, "cm"),
            _ if value.abs() >= 100.0 => format!("{value:.0} {unit}"),
            _ => format!("{} {unit}", self.number(value, 1)),
        }
    }

    /// A number with its unit, precise enough to tell a limit from values just beyond it.
    pub(super) fn exact(&self, value: f64, unit: &str) -> String {
        let (value, unit) = match unit {
            "1" => (100.0 * value, " %".to_owned()),
            "n" => (value, String::new()),
            "deg" => (value, "°".to_owned()),
            _ => (value, format!(" {unit}")),
        };
        // Three decimals distinguish all values of rules and metrics. Trailing zeros are left out.
        let text = format!("{value:.3}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        self.localised(format!("{text}{unit}"))
    }

    /// A number with its unit, with as few decimals as tell it from a limit.
    pub(super) fn apart(&self, value: f64, limit: f64, unit: &str) -> String {
        let scale = if unit == "1" { 100.0 } else { 1.0 };
        let round = |value: f64, digits: i32| {
            let tenths = 10f64.powi(digits);
            (value * scale * tenths).round() / (scale * tenths)
        };
        let fewest = if value.abs() * scale < 10.0 { 1 } else { 0 };
        let limit = self.exact(limit, unit);
        let texts = (fewest..3).map(|digits| self.exact(round(value, digits), unit));
        let mut told = texts.filter(|text| *text != limit);
        told.next().unwrap_or_else(|| self.exact(value, unit))
    }

    /// Text of a number in the format of this language.
    pub(crate) fn localised(&self, text: String) -> String {
        match self.language {
            Language::English => text,
            Language::German => text.replace('.', ","),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_units_and_their_language_s_point() {
        let (english, german) = (Words::default(), Words::new(Language::German));
        for (value, unit, text) in [
            (0.456, "1", "46 %"),
            (3.0, "n", "3"),
            (12.34, "s", "12.3 s"),
            (754.2, "s", "754 s"),
            (29.6, "deg", "30°"),
            (0.043, "m", "4.3 cm"),
            (4.24, "m", "4.2 m"),
        ] {
            assert_eq!(english.amount(value, unit), text);
            assert_eq!(german.amount(value, unit), text.replace('.', ","));
        }
        assert_eq!(german.number(-0.25, 2), "-0,25");
        for (value, unit, text) in [
            (0.8996, "1", "89,96 %"),
            (0.9, "1", "90 %"),
            (69.75, "n", "69,75"),
            (70.0, "n", "70"),
            (600.02, "s", "600,02 s"),
            (20.0, "deg", "20°"),
        ] {
            assert_eq!(german.exact(value, unit), text);
        }
        for (value, limit, unit, text) in [
            (35.459, 70.0, "n", "35"),
            (69.96, 70.0, "n", "69.96"),
            (69.9996, 70.0, "n", "70"),
            (9.0, 0.0, "n", "9"),
            (2.471, 3.0, "mm", "2.5 mm"),
            (0.1523, 0.95, "1", "15 %"),
            (0.9497, 0.95, "1", "94.97 %"),
        ] {
            assert_eq!(english.apart(value, limit, unit), text);
        }
    }
}
