//! State and result of a recording.

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Longest silence of the writing thread, which reports once a second. After it, the disk counts as
/// hanging.
const SILENT_MAX: Duration = Duration::from_secs(5);

/// State of a running recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Health {
    /// Response of the disk to the recording.
    pub standing: Standing,
    /// Bytes on disk.
    pub bytes: u64,
    /// Bytes waiting for the disk.
    pub waiting: u64,
    /// Ticks that ran and are not recorded.
    pub missing: u64,
    /// Events that happened and are not recorded.
    pub missing_events: u64,
    /// Time of the writing thread's last report. `None`: silence does not count as hanging.
    pub reported: Option<Instant>,
}

impl Health {
    /// State at `now`. If the writing thread was silent for too long, the disk counts as hanging.
    #[must_use]
    pub fn at(mut self, now: Instant) -> Self {
        let silent = self.reported.map_or(Duration::ZERO, |reported| {
            now.saturating_duration_since(reported)
        });
        if silent > SILENT_MAX && self.standing == Standing::Recording {
            self.standing = Standing::Hanging;
        }
        self
    }

    /// True if the disk no longer takes the recording, and did before.
    #[must_use]
    pub fn begins_to_fail(&self, before: Option<Standing>) -> bool {
        self.standing != Standing::Recording && before == Some(Standing::Recording)
    }
}

/// Response of the disk to a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Standing {
    /// The disk takes the data.
    #[default]
    Recording,
    /// The disk refuses the data.
    Refused,
    /// The disk neither takes nor refuses the data.
    Hanging,
    /// Nothing more is written: the disk refused too much, or the recording is over.
    Ended,
}

/// Result of a recording; part of `summary.json`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Recorded {
    /// Path of the file.
    pub file: PathBuf,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Recorded ticks.
    pub ticks: u64,
    /// Ticks that ran and are not recorded; a replay stops at the first.
    pub missing: u64,
    /// Events that happened and are not recorded; no assessment includes them.
    pub missing_events: u64,
    /// Messages lost because the writing thread was too slow; ticks and events among them are
    /// counted as missing too.
    pub overflowed: u64,
    /// Number of refused writes.
    pub write_failures: u64,
    /// Longest duration of a write, ms. Usually a write holds one second of the session.
    pub slowest_write_ms: u64,
    /// Reason why the recording ends early, if it does.
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

    /// Warning for the user, if anything is missing.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let file = self.file.display();
        if let Some(why) = &self.problem {
            return Some(format!(
                "the recording {file} ends early ({why}); the recorded part can be replayed. Make room, or \
                 record elsewhere with --record"
            ));
        }
        let ticks = (self.missing > 0)
            .then(|| format!("{} ticks; a replay ends at the first of them", self.missing));
        let events = (self.missing_events > 0).then(|| {
            format!(
                "{} events, which no assessment of the recording includes",
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
    fn a_silent_disk_hangs_unless_it_has_refused_the_data() {
        let reported = Instant::now();
        let health = |standing| Health {
            standing,
            reported: Some(reported),
            ..Health::default()
        };
        let later = reported + SILENT_MAX * 2;
        let recording = health(Standing::Recording);
        assert_eq!(recording.at(reported).standing, Standing::Recording);
        assert_eq!(recording.at(later).standing, Standing::Hanging);
        assert_eq!(
            health(Standing::Refused).at(later).standing,
            Standing::Refused
        );
        assert_eq!(health(Standing::Ended).at(later).standing, Standing::Ended);
        let failing = health(Standing::Refused);
        assert!(failing.begins_to_fail(Some(Standing::Recording)));
        assert!(!failing.begins_to_fail(Some(Standing::Refused)) && !failing.begins_to_fail(None));
        assert!(!recording.begins_to_fail(Some(Standing::Recording)));
    }
}
