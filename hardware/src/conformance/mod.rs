//! Conformance tests of every device, emulated or real.
//!
//! [`haptic()`], [`woody()`], [`hapi()`], [`inverse3()`], [`touch()`], [`force_dimension()`],
//! [`tracker()`] and [`pedal()`] open a device and watch its samples. Where the device allows it,
//! they also check its watchdog, its silence after closing, a second opening, and an unplugged
//! cable. The tests command zero force only, so the device may stand free on a table.

mod answers;
mod force_dimension;
mod hapi;
mod haptic;
mod inverse3;
mod motion;
mod pedal;
mod samples;
mod touch;
mod tracker;
mod watch;
mod woody;

use std::fmt;
use std::time::Duration;

pub use force_dimension::force_dimension;
pub use hapi::hapi;
pub use haptic::haptic;
pub use inverse3::inverse3;
pub(crate) use motion::Motion;
pub use pedal::{pedal, pedal_by};
pub use touch::touch;
pub use tracker::{tracker, tracker_by, trakstar};
pub use woody::woody;

/// Options of a conformance run.
pub struct Options<'a> {
    /// Time for which samples are watched.
    pub watch: Duration,
    /// Unplugs the device, or asks a person to do so. If it is `None`, that check is skipped.
    pub unplug: Option<&'a mut dyn FnMut()>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            watch: Duration::from_secs(2),
            unplug: None,
        }
    }
}

impl fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("watch", &self.watch)
            .field("unplug", &self.unplug.is_some())
            .finish()
    }
}

/// Outcome of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CheckOutcome {
    /// The requirement holds.
    Pass,
    /// The requirement is violated.
    Fail,
    /// The check could not be made, or this computer was too late to judge it. It does not count as
    /// passed.
    NotJudged,
    /// The check does not apply to this device, or the options leave it out.
    Skipped,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// Short, stable name: programs may read it.
    pub name: &'static str,
    /// Outcome of the check.
    pub outcome: CheckOutcome,
    /// Observation with figures and units; for a failure also the allowed range.
    pub detail: String,
}

/// Results for one device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// Type and identity of the device.
    pub device: String,
    /// All checks in the order in which they were made.
    pub checks: Vec<Check>,
}

impl Report {
    pub(crate) fn new(device: &str) -> Self {
        Self {
            device: device.to_owned(),
            checks: Vec::new(),
        }
    }

    /// True if no check failed and none was left unjudged. Skipped checks do not count.
    #[must_use]
    pub fn passed(&self) -> bool {
        !self.has(CheckOutcome::Fail) && !self.has(CheckOutcome::NotJudged)
    }

    /// True if a check has this outcome.
    #[must_use]
    pub fn has(&self, outcome: CheckOutcome) -> bool {
        self.checks.iter().any(|check| check.outcome == outcome)
    }

    /// Names of the checks with this outcome.
    #[must_use]
    pub fn names(&self, outcome: CheckOutcome) -> Vec<&'static str> {
        let with = self.checks.iter().filter(|it| it.outcome == outcome);
        with.map(|check| check.name).collect()
    }

    /// The check with this name.
    #[must_use]
    pub fn check(&self, name: &str) -> Option<&Check> {
        self.checks.iter().find(|check| check.name == name)
    }

    pub(crate) fn judge(&mut self, name: &'static str, good: bool, detail: String) {
        let outcome = if good {
            CheckOutcome::Pass
        } else {
            CheckOutcome::Fail
        };
        self.checks.push(Check {
            name,
            outcome,
            detail,
        });
    }

    /// Judges a check that depends on time. A failure counts as not judged if this computer itself
    /// was late.
    fn judge_time(&mut self, name: &'static str, good: bool, detail: String, host: watch::Host) {
        match host.excuse() {
            Some(excuse) if !good => self.mark_not_judged(name, &format!("{detail}; {excuse}")),
            _ => self.judge(name, good, detail),
        }
    }

    /// Notes a check that applies but cannot be judged.
    pub(crate) fn mark_not_judged(&mut self, name: &'static str, why: &str) {
        self.checks.push(Check {
            name,
            outcome: CheckOutcome::NotJudged,
            detail: why.to_owned(),
        });
    }

    /// Appends `words` to the detail of a check.
    fn add_to(&mut self, name: &str, words: &str) {
        if let Some(check) = self.checks.iter_mut().find(|it| it.name == name) {
            check.detail += words;
        }
    }

    pub(crate) fn skip(&mut self, name: &'static str, why: &str) {
        self.checks.push(Check {
            name,
            outcome: CheckOutcome::Skipped,
            detail: why.to_owned(),
        });
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.device)?;
        for Check {
            name,
            outcome,
            detail,
        } in &self.checks
        {
            let mark = match outcome {
                CheckOutcome::Pass => "ok  ",
                CheckOutcome::Fail => "FAIL",
                CheckOutcome::NotJudged => "??  ",
                CheckOutcome::Skipped => "skip",
            };
            writeln!(f, "  {mark}  {name:<14} {detail}")?;
        }
        Ok(())
    }
}
