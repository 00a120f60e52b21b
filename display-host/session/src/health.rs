//! How a recording does, and what it came to.

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The writing thread tells its health as often as it writes: one that has not for so long hangs.
const SILENT_MAX: Duration = Duration::from_secs(5);

/// How a recording does while it goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Health {
    /// Whether the disk takes it.
    pub standing: Standing,
    /// Bytes that the disk has.
    pub bytes: u64,
    /// Bytes that wait for it.
    pub waiting: u64,
    /// Ticks that ran and are not in it.
    pub missing: u64,
    /// Events that happened and are not in it.
    pub missing_events: u64,
    /// When the writing thread said so; `None`: it is no matter how long ago.
    pub told: Option<Instant>,
}

impl Health {
    /// How it does at `now`: a writing thread that says nothing any more waits for a disk that hangs.
    #[must_use]
    pub fn at(mut self, now: Instant) -> Self {
        let silent = self
            .told
            .map_or(Duration::ZERO, |told| now.saturating_duration_since(told));
        if silent > SILENT_MAX && self.standing == Standing::Recording {
            self.standing = Standing::Hanging;
        }
        self
    }
}

/// Whether the disk takes a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Standing {
    /// It does.
    #[default]
    Recording,
    /// It refuses what waits.
    Refused,
    /// It neither takes nor refuses what waits.
    Hanging,
    /// It has refused too much, or the recording is over: nothing more is written.
    Ended,
}

/// What a recording came to; part of `summary.json`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Recorded {
    /// The file.
    pub file: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// Ticks in it.
    pub ticks: u64,
    /// Ticks that ran and are not in it; replay stops at the first.
    pub missing: u64,
    /// Events that happened and are not in it; an assessment of it knows nothing of them.
    pub missing_events: u64,
    /// Messages that the writing thread was too slow for; ticks and events among them are also missing.
    pub overflowed: u64,
    /// Times that the disk refused a write.
    pub write_failures: u64,
    /// Longest that the disk took for a second of it.
    pub slowest_write_ms: u64,
    /// Why it ends early, if it does.
    pub problem: Option<String>,
}

impl Recorded {
    pub(crate) const fn none_yet(file: PathBuf) -> Self {
        Self {
            file,
            bytes: 0,
            ticks: 0,
            missing: 0,
            missing_events: 0,
            overflowed: 0,
            write_failures: 0,
            slowest_write_ms: 0,
            problem: None,
        }
    }

    /// What the user should know, if anything.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let file = self.file.display();
        if let Some(why) = &self.problem {
            return Some(format!(
                "the recording {file} ends early ({why}); what is in it can be replayed. Make room, or record \
                 elsewhere with --record"
            ));
        }
        let ticks = (self.missing > 0)
            .then(|| format!("{} ticks; replay ends at the first of them", self.missing));
        let events = (self.missing_events > 0).then(|| {
            format!(
                "{} events, which its assessment knows nothing of",
                self.missing_events
            )
        });
        let missing: Vec<String> = ticks.into_iter().chain(events).collect();
        match missing.is_empty() {
            true => None,
            false => Some(format!(
                "the recording {file} misses {}",
                missing.join("; and ")
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_says_nothing_hangs_and_one_that_refuses_refuses() {
        let told = Instant::now();
        let health = |standing| Health {
            standing,
            told: Some(told),
            ..Health::default()
        };
        let later = told + SILENT_MAX * 2;
        let recording = health(Standing::Recording);
        assert_eq!(recording.at(told).standing, Standing::Recording);
        assert_eq!(recording.at(later).standing, Standing::Hanging);
        assert_eq!(
            health(Standing::Refused).at(later).standing,
            Standing::Refused
        );
        assert_eq!(health(Standing::Ended).at(later).standing, Standing::Ended);
    }
}
