//! Way of pictures to the screen, in documents.

use serde::Serialize;

/// Way of the window's pictures to the screen.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct PresentationSummary {
    /// `x11_present`; `None` if nothing told when pictures were presented.
    pub source: Option<&'static str>,
    /// Reason for which nothing was told, or nothing more from some time on.
    pub missing: Option<String>,
    /// Pictures that the screen showed from their own memory: their time is that of the screen.
    pub flips: u64,
    /// Pictures that were copied into the window: a compositor may show them later.
    pub copies: u64,
    /// Pictures in whose place a later one was shown.
    pub skips: u64,
}

impl PresentationSummary {
    /// Sentence without a full stop.
    #[must_use]
    pub fn said(&self) -> String {
        let ways = format!(
            "presentation times of the X server (extension Present): {} pictures by a flip, {} by a \
             copy into the window, {} skipped",
            self.flips, self.copies, self.skips
        );
        match (&self.missing, self.source) {
            (Some(missing), None) => format!("no presentation times: {missing}"),
            (Some(missing), Some(_)) => format!("{ways}; later none: {missing}"),
            (None, _) => ways,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_have_either_the_ways_or_the_reason() {
        let mut told = PresentationSummary {
            source: Some("x11_present"),
            flips: 900,
            copies: 3,
            skips: 1,
            ..PresentationSummary::default()
        };
        assert!(told.said().contains("900 pictures by a flip, 3 by a copy"));
        told.missing = Some("it ended".to_owned());
        assert!(told.said().ends_with("1 skipped; later none: it ended"));
        told.source = None;
        told.missing = Some("no window was opened".to_owned());
        assert_eq!(told.said(), "no presentation times: no window was opened");
    }
}
