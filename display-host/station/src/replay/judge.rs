//! Finds the first tick in which a replay differs from its session.

use rt_process::replay::{Difference, Replayed};
use serde::Serialize;
use session::printable;

/// Number of ticks in which a differing organ is searched after a tick in which only the tools
/// differ.
const LOOKED_ON: u64 = 1000;

/// The first tick in which the runs differ.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Different {
    pub(crate) tick: u64,
    /// Time of the tick in the session, s.
    pub(crate) at_s: f64,
    /// `tools` or `organ`.
    pub(crate) what: &'static str,
    /// Organ that differs in this tick, or the first one that differs after the tools.
    pub(crate) organ: Option<String>,
    /// Tick in which the organ differs.
    pub(crate) organ_tick: Option<u64>,
}

/// Finds the first tick that differs.
#[derive(Debug, Default)]
pub(crate) struct Judge {
    pub(crate) first: Option<Different>,
    pub(crate) is_done: bool,
}

impl Judge {
    /// Compares a tick. Returns false when nothing more can be found: the organ that differs is
    /// known, or no organ differs within `LOOKED_ON` ticks.
    pub(crate) fn look(&mut self, replayed: &Replayed<'_>, at_s: f64, organs: &[String]) -> bool {
        if self.is_done {
            return false;
        }
        let tick = replayed.record.tick;
        match (&mut self.first, replayed.differs()) {
            (None, None) => {}
            (None, Some(difference)) => {
                let organ = organ(difference, organs);
                self.is_done = organ.is_some();
                let what = match difference {
                    Difference::Organ(_) => "organ",
                    Difference::Tools => "tools",
                };
                self.first = Some(Different {
                    tick,
                    at_s,
                    what,
                    organ_tick: organ.is_some().then_some(tick),
                    organ,
                });
            }
            (Some(first), found) => {
                first.organ = found.and_then(|it| organ(it, organs));
                first.organ_tick = first.organ.is_some().then_some(tick);
                self.is_done =
                    first.organ.is_some() || tick >= first.tick.saturating_add(LOOKED_ON);
            }
        }
        !self.is_done
    }
}

impl Different {
    pub(crate) fn in_words(&self) -> String {
        let organ = self.organ.as_deref().map(printable);
        let what = match (self.what, organ, self.organ_tick) {
            ("tools", Some(organ), Some(tick)) => {
                format!("tools or force differ, and in tick {tick} {organ}")
            }
            ("tools", ..) => "tools or force differ, and no organ soon after".to_owned(),
            (_, Some(organ), _) => format!("{organ} differs"),
            (_, None, _) => "an organ differs".to_owned(),
        };
        format!("tick {} ({:.3} s): {what}", self.tick, self.at_s)
    }
}

fn organ(difference: Difference, organs: &[String]) -> Option<String> {
    match difference {
        Difference::Organ(organ) => organs.get(organ?).cloned(),
        Difference::Tools => None,
    }
}
