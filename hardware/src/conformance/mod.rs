//! One suite for every device, emulated or real: what a rig builder runs on the bench.
//!
//! [`haptic()`], [`woody()`], [`hapi()`], [`inverse3()`], [`tracker()`] and [`pedal()`] open a
//! line, watch the device and try what must hold whatever happens: the watchdog, silence after
//! closing, a clean second opening, a plug pulled out. No force is asked for but zero: the device
//! may stand free on a table.

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

pub use hapi::hapi;
pub use haptic::haptic;
pub use inverse3::inverse3;
pub use pedal::{pedal, pedal_by};
pub use touch::touch;
pub use tracker::{tracker, tracker_by, trakstar};
pub use woody::woody;

/// How a device is tested.
pub struct Options<'a> {
    /// How long its samples are watched.
    pub watch: Duration,
    /// Pulls the plug, or asks a person to; without it that check is skipped.
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

/// How a check ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// As it must be.
    Pass,
    /// Not as it must be.
    Fail,
    /// Not tried.
    Skipped,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// Short name, stable: programs may read it.
    pub name: &'static str,
    /// How it ended.
    pub outcome: Outcome,
    /// What was seen, with figures and units; for a failure also what is allowed.
    pub detail: String,
}

/// What was found about one device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// What the device is and says of itself.
    pub device: String,
    /// Every check, in the order that they were made.
    pub checks: Vec<Check>,
}

impl Report {
    fn new(device: &str) -> Self {
        Self {
            device: device.to_owned(),
            checks: Vec::new(),
        }
    }

    /// Whether nothing failed.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.checks
            .iter()
            .all(|check| check.outcome != Outcome::Fail)
    }

    /// The check of that name.
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

    /// Judges what depends on time, unless this computer itself was late.
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
