//! Acts of an instructor during the session.

use shared_mem::message::ActMsg;
use shared_mem::words::ActKind;

/// An act of an instructor.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Act {
    /// Counted time since the task began, s. Pauses and gaps do not count.
    pub at_s: f64,
    /// Time since the recording began, s, at which a replay shows the act.
    pub session_s: f64,
    /// Kind of the act: `point`, `pause`, `resume`, `remark`, `fog`, `bleeding` or `slipped_clip`.
    pub kind: String,
    /// The remark; `null` for other acts.
    pub remark: Option<String>,
}

impl Act {
    /// An act that a session recorded; `None` if this program does not know its kind.
    pub(crate) fn of(at_s: f64, session_s: f64, act: &ActMsg) -> Option<Self> {
        let kind = act.kind().ok()?;
        let remark = act.text().filter(|_| kind == ActKind::Remark);
        Some(Self {
            at_s,
            session_s,
            kind: kind.name().to_owned(),
            remark: remark.map(str::to_owned),
        })
    }

    /// True for an act that makes the task harder: fog, bleeding, a slipped clip.
    pub(crate) fn complicates(&self) -> bool {
        [ActKind::Fog, ActKind::Bleeding, ActKind::SlippedClip]
            .iter()
            .any(|kind| kind.name() == self.kind)
    }

    /// Id of the message that names the act to a reader.
    #[must_use]
    pub fn message(&self) -> String {
        format!("act-{}", self.kind.replace('_', "-"))
    }
}
