//! One conformance suite for every device, emulated or real, to be run on the bench.
//!
//! [`haptic()`], [`woody()`], [`hapi()`], [`inverse3()`], [`touch()`], [`force_dimension()`],
//! [`tracker()`] and [`pedal()`] open a line, watch the device and check the watchdog, silence
//! after closing, a second opening, and an unplugged cable. They command zero force only, so the
//! device may stand free on a table.

mod force_dimension;
mod hapi;
mod haptic;
mod inverse3;
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
pub use pedal::{pedal, pedal_by};
pub use touch::touch;
pub use tracker::{tracker, tracker_by, trakstar};
pub use woody::woody;

/// Options of a conformance run.
pub struct Options<'a> {
    /// Time for which samples are watched.
    pub watch: Duration,
    /// Unplugs the device, or asks a person to; without it the check is skipped.
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
pub enum Outcome {
    /// The requirement holds.
    Pass,
    /// The requirement is violated.
    Fail,
    /// The check was not made.
    Skipped,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// Short, stable name: programs may read it.
    pub name: &'static str,
    /// Outcome of the check.
    pub outcome: Outcome,
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
    fn new(device: &str) -> Self {
        Self {
            device: device.to_owned(),
            checks: Vec::new(),
        }
    }

    /// True if no check failed.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.checks
            .iter()
            .all(|check| check.outcome != Outcome::Fail)
    }

    /// The check with this name.
    #[must_use]
    pub fn check(&self, name: &str) -> Option<&Check> {
        self.checks.iter().find(|check| check.name == name)
    }

    fn judge(&mut self, name: &'static str, good: bool, detail: String) {
        let outcome = if good { Outcome::Pass } else { Outcome::Fail };
        self.checks.push(Check {
            name,
            outcome,
            detail,
        });
    }

    /// Judges a check that depends on time, unless this computer itself was late.
    fn judge_time(&mut self, name: &'static str, good: bool, detail: String, host: watch::Host) {
        match host.excuse() {
            Some(excuse) if !good => self.skip(name, &format!("{detail}; {excuse}")),
            _ => self.judge(name, good, detail),
        }
    }

    fn skip(&mut self, name: &'static str, why: &str) {
        self.checks.push(Check {
            name,
            outcome: Outcome::Skipped,
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
                Outcome::Pass => "ok  ",
                Outcome::Fail => "FAIL",
                Outcome::Skipped => "skip",
            };
            writeln!(f, "  {mark}  {name:<14} {detail}")?;
        }
        Ok(())
    }
}
