//! One thing that `calot check` looked at.

use serde::Serialize;

/// How a finding stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// As it should be.
    Good,
    /// Could be better: jitter grows.
    Better,
    /// Not realtime as long as it stays.
    Bad,
    /// Cannot be read here.
    Unknown,
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding {
    /// What.
    pub(crate) name: &'static str,
    pub(crate) verdict: Verdict,
    /// What is.
    pub(crate) is: String,
    /// What should be, and why.
    pub(crate) should: &'static str,
    /// The command that mends it; none where it is good or no command can.
    pub(crate) mend: Option<String>,
}
