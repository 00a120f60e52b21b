//! Records of sessions for the store, from a run, or from a recording and the summary next to it.

use std::path::Path;

use assess::{Assessed, Metric};
use display_host::report::Summary;
use serde_json::Value;
use store::{Circumstances, Hand, SessionRecord};

/// Longest summary that is read, bytes.
const SUMMARY_MAX_BYTES: u64 = 64 << 20;

/// Origin of a session.
pub(crate) struct Made<'a> {
    /// The session's name in the store.
    pub(crate) id: &'a str,
    pub(crate) began_unix_s: i64,
    pub(crate) scene: &'a str,
    /// Program that recorded it.
    pub(crate) program: &'a str,
    /// Its recording.
    pub(crate) file: Option<&'a Path>,
    pub(crate) hand: Hand,
    pub(crate) circumstances: Circumstances,
}

/// Record of a session for the store.
pub(crate) fn record(assessed: &Assessed, made: Made<'_>) -> SessionRecord {
    let values = Metric::ALL.map(|metric| (metric.name().to_owned(), assessed.metrics.get(metric)));
    let metrics = values.into_iter().filter(|(_, value)| value.is_finite());
    SessionRecord {
        id: made.id.to_owned(),
        began_unix_s: made.began_unix_s,
        task: assessed.task.name().to_owned(),
        difficulty: assessed.difficulty.name().to_owned(),
        outcome: assessed.outcome.name().to_owned(),
        score: assessed.score,
        alarms: assessed.alarms.len() as i64,
        metrics_version: assessed.version,
        metrics: metrics.collect(),
        scene: made.scene.to_owned(),
        program: made.program.to_owned(),
        file: made.file.map(|file| {
            let whole = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
            whole.display().to_string()
        }),
        hand: made.hand,
        circumstances: made.circumstances,
    }
}

/// Circumstances of a run that has ended.
pub(crate) fn circumstances_of(run: &Summary) -> Circumstances {
    let haptic = run.devices.iter().find(|it| it.kind == "haptic");
    Circumstances {
        // Without a record of a tick, nothing is known.
        realtime: (run.timing_records > 0).then_some(run.realtime),
        missed_ticks: i64::try_from(run.missed_periods).ok(),
        device: haptic.map_or_else(String::new, |it| session::printable(&it.name)),
        driver: haptic.map_or_else(String::new, |it| session::printable(&it.driver)),
        site: String::new(),
    }
}

/// Circumstances from the summary next to a recording. They are unknown if that is not the summary
/// of this session.
pub(super) fn circumstances_beside(recording: &Path, id: &str) -> Circumstances {
    let summary = recording.with_file_name("summary.json");
    let is_short = summary
        .metadata()
        .is_ok_and(|it| it.is_file() && it.len() <= SUMMARY_MAX_BYTES);
    let text = is_short.then(|| std::fs::read(&summary).ok()).flatten();
    let read = text.and_then(|it| serde_json::from_slice(&it).ok());
    circumstances_from(&read.unwrap_or_default(), id)
}

fn circumstances_from(summary: &Value, id: &str) -> Circumstances {
    if summary["session"] != id {
        return Circumstances::default();
    }
    let devices = summary["devices"].as_array().into_iter().flatten();
    let haptic = { devices }.find(|it| it["kind"] == "haptic");
    let text = |key: &str| {
        let found = haptic.and_then(|it| it[key].as_str());
        session::printable(found.unwrap_or_default())
    };
    let has_ticks = summary["timing_records"].as_u64() > Some(0);
    Circumstances {
        realtime: summary["realtime"].as_bool().filter(|_| has_ticks),
        missed_ticks: summary["deadline_misses"].as_i64(),
        device: text("name"),
        driver: text("driver"),
        site: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_gives_the_circumstances_of_its_own_session_only() {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("session.mcap");
        let none = Circumstances::default();
        assert_eq!(circumstances_beside(&recording, "s"), none);
        let text = r#"{"session": "s", "realtime": true, "deadline_misses": 4, "timing_records": 9,
            "devices": [{"kind": "pedal", "name": "p"},
                {"kind": "haptic", "name": "Rig\u001b", "driver": "rig"}]}"#;
        std::fs::write(folder.path().join("summary.json"), text).unwrap();
        let found = circumstances_beside(&recording, "s");
        assert_eq!((found.realtime, found.missed_ticks), (Some(true), Some(4)));
        assert_eq!(found.driver, "rig");
        assert!(found.device.starts_with("Rig") && !found.device.contains('\u{1b}'));
        assert_eq!(circumstances_beside(&recording, "another"), none);
    }
}
