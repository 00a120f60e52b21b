//! Sessions that a learning curve leaves out, by their reasons.

use assess::{Difficulty, Metric, Outcome};
use store::{Hand, SessionRecord};

use super::CUT_SHORT;

/// Reason why a curve leaves a session out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    Aborted,
    CutShort,
    Practice,
    Scripted,
    Complications,
    Difficulty,
    Version,
}

impl Reason {
    const ALL: [Self; 7] = [
        Self::Aborted,
        Self::CutShort,
        Self::Practice,
        Self::Scripted,
        Self::Complications,
        Self::Difficulty,
        Self::Version,
    ];

    fn in_words(self) -> &'static str {
        match self {
            Self::Aborted => "aborted",
            Self::CutShort => "cut short",
            Self::Practice => "of practice",
            Self::Scripted => "by a scripted hand",
            Self::Complications => "with complications by an instructor",
            Self::Difficulty => "of another difficulty (--difficulty)",
            Self::Version => {
                "of another version of the metrics (`calot store rescore` compares versions)"
            }
        }
    }
}

/// Reason why a session compares with no other one: nobody completed it, or not by oneself.
pub(super) fn incomplete(session: &SessionRecord) -> Option<Reason> {
    let complications = session.metrics.get(Metric::Complications.name());
    match session.outcome.as_str() {
        _ if session.hand == Hand::Scripted => Some(Reason::Scripted),
        CUT_SHORT => Some(Reason::CutShort),
        name if name == Outcome::Practised.name() => Some(Reason::Practice),
        name if name != Outcome::Passed.name() && name != Outcome::Failed.name() => {
            Some(Reason::Aborted)
        }
        _ if complications.is_some_and(|count| *count > 0.0) => Some(Reason::Complications),
        _ => None,
    }
}

/// Reason why a session does not belong to the curve of the newest session, which has this
/// difficulty and version of the metrics.
pub(super) fn reason(
    session: &SessionRecord,
    asked: Option<Difficulty>,
    newest: Option<&(String, u32)>,
) -> Option<Reason> {
    let difficulty = asked
        .map(Difficulty::name)
        .or_else(|| newest.map(|it| it.0.as_str()));
    let is_other = |of: &str| session.difficulty != of;
    incomplete(session)
        .or_else(|| {
            difficulty
                .is_some_and(is_other)
                .then_some(Reason::Difficulty)
        })
        .or_else(|| {
            newest
                .is_some_and(|it| it.1 != session.metrics_version)
                .then_some(Reason::Version)
        })
}

/// Numbers of sessions by reason.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct LeftOut(Vec<Reason>);

impl LeftOut {
    pub(super) fn add(&mut self, why: Reason) {
        self.0.push(why);
    }

    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// One sentence with the number of each reason. `None`: nothing is left out.
    pub(super) fn in_words(&self) -> Option<String> {
        let of = |why: Reason| self.0.iter().filter(|it| **it == why).count();
        let counts = Reason::ALL.map(|why| (of(why), why.in_words()));
        let parts: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, why)| format!("{count} {why}"))
            .collect();
        let head = match self.0.len() {
            0 => return None,
            1 => "1 session is".to_owned(),
            count => format!("{count} sessions are"),
        };
        Some(format!("{head} left out: {}", parts.join(", ")))
    }
}
