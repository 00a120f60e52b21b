//! Presentation of a window's pictures on the screen, as JSON files and reports state it.

use serde::Serialize;

/// Presentation of a window's pictures on the screen.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct PresentationSummary {
    /// Interface that gave the presentation times: `x11_present` or `wp_presentation`; `None` if
    /// none gave them.
    pub source: Option<&'static str>,
    /// Reason for missing times. They are all missing if `source` is `None`, otherwise only the
    /// later ones.
    pub missing: Option<String>,
    /// Pictures that the screen showed from their own memory. Their time is the screen's.
    pub flips: u64,
    /// Pictures that were copied. On X11 they were copied into the window, and a compositor may
    /// show them later.
    pub copies: u64,
    /// Pictures that were never shown, because a later one took their place.
    pub skips: u64,
    /// Pictures whose time the screen's hardware gave; `None` on X11.
    pub by_hardware: Option<u64>,
    /// Time between two refreshes of the screen, ns, if a Wayland compositor gives it.
    pub refresh_ns: Option<u32>,
}

impl PresentationSummary {
    /// All of this in words: a sentence without a full stop.
    #[must_use]
    pub fn said(&self) -> String {
        let counts = match self.by_hardware {
            None => format!(
                "presentation times of the X server (extension Present): {} pictures by a flip, {} by \
                 a copy into the window, {} skipped",
                self.flips, self.copies, self.skips
            ),
            Some(by_hardware) => format!(
                "presentation times of the Wayland compositor (wp_presentation): {} pictures shown \
                 from their own memory, {} copied, {} skipped; {by_hardware} times by the screen's \
                 hardware, {}",
                self.flips,
                self.copies,
                self.skips,
                self.refresh_ns.map_or_else(
                    || "unknown rate".to_owned(),
                    |ns| format!("{:.2} Hz", 1e9 / f64::from(ns))
                )
            ),
        };
        match (&self.missing, self.source) {
            (Some(missing), None) => format!("no presentation times: {missing}"),
            (Some(missing), Some(_)) => format!("{counts}; later none: {missing}"),
            (None, _) => counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_has_the_counts_or_the_reason_for_missing_times() {
        let mut told = PresentationSummary {
            source: Some("x11_present"),
            flips: 900,
            copies: 3,
            skips: 1,
            ..PresentationSummary::default()
        };
        assert!(told.said().contains("900 pictures by a flip, 3 by a copy"));
        let wayland = PresentationSummary {
            source: Some("wp_presentation"),
            by_hardware: Some(7),
            refresh_ns: Some(20_000_000),
            ..told.clone()
        };
        let said = wayland.said();
        assert!(said.contains("(wp_presentation): 900 pictures shown from their own"));
        assert!(said.ends_with("1 skipped; 7 times by the screen's hardware, 50.00 Hz"));
        told.missing = Some("it ended".to_owned());
        assert!(told.said().ends_with("1 skipped; later none: it ended"));
        told.source = None;
        told.missing = Some("no window was opened".to_owned());
        assert_eq!(told.said(), "no presentation times: no window was opened");
    }
}
