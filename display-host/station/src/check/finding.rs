//! One property of the machine that `calot check` examined.

use rt_process::refusal::Cause;
use serde::Serialize;

/// Verdict on a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// As required.
    Good,
    /// Could be better: it adds jitter.
    Better,
    /// Prevents realtime.
    Bad,
    /// Cannot be read here.
    Unknown,
}

/// A property that was examined.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding {
    /// Name of the property.
    pub(crate) name: &'static str,
    pub(crate) verdict: Verdict,
    /// Current state.
    pub(crate) is: String,
    /// Required state, and the reason.
    pub(crate) should: &'static str,
    /// Command that fixes it. `None` if it is good or no command can.
    pub(crate) mend: Option<String>,
    /// Rule of Linux that refused a call, if one was tried and refused.
    pub(crate) cause: Option<Cause>,
}
