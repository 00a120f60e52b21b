//! One property of the machine that `calot check` examined.

use rt_process::refusal::{Cause, Refusal};
use serde::Serialize;

/// Verdict on a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// As required.
    Good,
    /// Could be better: the present state adds jitter.
    Better,
    /// Prevents realtime.
    Bad,
    /// Cannot be read here.
    Unknown,
}

/// A property that was examined.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding {
    pub(crate) name: &'static str,
    pub(crate) verdict: Verdict,
    /// Current state.
    pub(crate) is: String,
    /// Required state, and the reason.
    pub(crate) should: &'static str,
    /// Command that fixes the property. `None` if the property is good or no command helps.
    pub(crate) mend: Option<String>,
    /// Rule of Linux that refused the call, if a call was tried and refused.
    pub(crate) cause: Option<Cause>,
}

/// Finding with these values. A good property needs no remedy, so `mend` is then left out.
pub(super) fn finding(
    name: &'static str,
    verdict: Verdict,
    is: impl Into<String>,
    should: &'static str,
    mend: impl Into<String>,
) -> Finding {
    let mend = Some(mend.into()).filter(|m| verdict != Verdict::Good && !m.is_empty());
    Finding {
        name,
        verdict,
        is: is.into(),
        should,
        mend,
        cause: None,
    }
}

/// Finding about a call that was tried. A refused call brings its cause and remedy.
pub(super) fn tried(
    name: &'static str,
    outcome: &Result<(), Refusal>,
    granted: impl Into<String>,
    should: &'static str,
) -> Finding {
    match outcome {
        Ok(()) => finding(name, Verdict::Good, granted, should, ""),
        Err(refusal) => Finding {
            cause: Some(refusal.cause),
            ..finding(
                name,
                Verdict::Bad,
                format!("refused: {}", refusal.why),
                should,
                refusal.mend.clone(),
            )
        },
    }
}
