//! Condition of the watched station. It follows from the frames that come from the station, and
//! from the claim on its name, which the processes of a running station hold.

use std::time::{Duration, Instant};

use hardware::igtlink::message::{Code, Message};

use super::messages::STATION;

/// The controller of a station that was seen counts as silent after this time without a frame.
const SILENT: Duration = Duration::from_millis(500);
/// A station that has not been seen yet counts as missing after this time without a frame.
const PATIENCE: Duration = Duration::from_secs(3);

/// Condition of a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Condition {
    /// No frame has come yet. The station may be loading its scene.
    Awaited,
    /// No frame has come, and no station of this name runs.
    Missing,
    /// Frames come.
    Running,
    /// Frames come, and the simulation is paused.
    Paused,
    /// No frame comes, but the station still runs.
    Silent,
    /// The station has ended.
    Ended,
}

impl Condition {
    /// Message `STATUS` for clients.
    pub(super) fn status(self, station: &str, unix_ns: u64) -> Message {
        let (code, short, words) = match self {
            Self::Awaited => (Code::NotReady, "awaited", "is awaited"),
            Self::Missing => (Code::NotPresent, "missing", "does not run"),
            Self::Running => (Code::Ok, "running", "runs"),
            Self::Paused => (Code::NotReady, "paused", "is paused"),
            Self::Silent => (Code::TimeOut, "silent", "has a silent controller"),
            Self::Ended => (Code::ShutDown, "ended", "has ended; data stop"),
        };
        let words = format!("station {station} {words}");
        Message::status(STATION, code, short, &words, unix_ns)
    }

    /// Line for the user about the change from `before`, if it needs one.
    pub(super) fn note(self, station: &str, before: Self) -> Option<String> {
        match self {
            Self::Missing => Some(format!(
                "no station '{station}' runs so far; start it with `calot run --station \
                 {station}`, or name another with --station. Waiting for it"
            )),
            Self::Silent => Some(format!(
                "the controller of station '{station}' is silent; data stop until it is back"
            )),
            Self::Ended => Some(format!(
                "station '{station}' has ended; data stop until it runs again"
            )),
            Self::Running | Self::Paused
                if matches!(before, Self::Missing | Self::Silent | Self::Ended) =>
            {
                Some(format!("station '{station}' runs; data go on"))
            }
            _ => None,
        }
    }
}

/// Follows a station's condition.
#[derive(Debug)]
pub(super) struct Watch {
    condition: Condition,
    /// Time of the last frame, or of the start before the first one.
    heard: Instant,
}

impl Watch {
    pub(super) fn new(now: Instant) -> Self {
        Self {
            condition: Condition::Awaited,
            heard: now,
        }
    }

    pub(super) const fn condition(&self) -> Condition {
        self.condition
    }

    /// Records that a frame came. Returns the condition before.
    pub(super) fn heard(&mut self, now: Instant, is_paused: bool) -> Condition {
        self.heard = now;
        let next = if is_paused {
            Condition::Paused
        } else {
            Condition::Running
        };
        std::mem::replace(&mut self.condition, next)
    }

    /// Records that no frame came. `is_claimed` returns true if a process holds the station's name.
    /// It is called only after a silence. Returns the condition before.
    pub(super) fn silence(&mut self, now: Instant, is_claimed: impl FnOnce() -> bool) -> Condition {
        let before = self.condition;
        let silence = now.saturating_duration_since(self.heard);
        let was_seen = !matches!(before, Condition::Awaited | Condition::Missing);
        if was_seen && silence > SILENT && before != Condition::Ended {
            self.condition = if is_claimed() {
                Condition::Silent
            } else {
                Condition::Ended
            };
        } else if before == Condition::Awaited && silence > PATIENCE && !is_claimed() {
            self.condition = Condition::Missing;
        }
        before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_station_that_never_ran_is_missing_after_seconds() {
        let start = Instant::now();
        let mut watch = Watch::new(start);
        watch.silence(start + Duration::from_secs(2), || false);
        assert_eq!(watch.condition(), Condition::Awaited);
        watch.silence(start + Duration::from_secs(4), || true);
        assert_eq!(
            watch.condition(),
            Condition::Awaited,
            "it is loading its scene"
        );
        let before = watch.silence(start + Duration::from_secs(4), || false);
        assert_eq!(watch.condition(), Condition::Missing);
        let note = watch.condition().note("nosuch", before).unwrap();
        assert!(note.contains("calot run --station nosuch"), "{note}");
    }

    #[test]
    fn silence_pause_end_and_return_are_distinguished() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut watch = Watch::new(start);
        assert_eq!(watch.heard(at(10), false), Condition::Awaited);
        watch.silence(at(300), || false);
        assert_eq!(watch.condition(), Condition::Running, "a short gap");
        watch.heard(at(400), true);
        assert_eq!(watch.condition(), Condition::Paused);
        watch.silence(at(1000), || true);
        assert_eq!(watch.condition(), Condition::Silent);
        watch.silence(at(1100), || false);
        assert_eq!(watch.condition(), Condition::Ended);
        watch.silence(at(1200), || true);
        let ended = watch.condition();
        assert_eq!(
            ended,
            Condition::Ended,
            "it stays ended until a frame comes"
        );
        assert!(
            ended
                .note("main", Condition::Silent)
                .unwrap()
                .contains("has ended")
        );
        let before = watch.heard(at(1300), false);
        let note = watch.condition().note("main", before).unwrap();
        assert!(note.contains("data go on"), "{note}");
        assert_eq!(watch.condition().note("main", Condition::Paused), None);
        let silent = Condition::Silent.note("main", Condition::Running).unwrap();
        assert!(silent.contains("is silent"), "{silent}");
    }

    #[test]
    fn every_condition_has_its_code() {
        for (condition, code, word) in [
            (Condition::Awaited, 13, "is awaited"),
            (Condition::Missing, 16, "does not run"),
            (Condition::Running, 1, "runs"),
            (Condition::Paused, 13, "is paused"),
            (Condition::Silent, 7, "has a silent controller"),
            (Condition::Ended, 19, "has ended"),
        ] {
            let content = condition.status("main", 0).content;
            assert_eq!(content[1], code);
            let words = String::from_utf8_lossy(&content[30..]).into_owned();
            assert!(words.contains(word), "{words}");
        }
    }
}
