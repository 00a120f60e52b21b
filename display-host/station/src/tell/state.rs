//! The state of a station as it is reported to a centre.

use std::time::{Duration, Instant};

use display_host::ui::{Bulletin, Spoken};
use display_host::words::{Language, Words};
use serde::Serialize;
use shared_mem::message::{DeviceHealth, TimingBatch, ToolFrame};
use shared_mem::words::Switches;

/// Age of the newest state at which the station counts as silent.
const SILENT: Duration = Duration::from_secs(1);
/// Number of alarms that each report repeats, so that a lost report loses no alarm.
const ALARMS_TOLD: usize = 32;

/// A text in the languages of the interface.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Said {
    en: String,
    de: String,
}

/// An error of the trainee.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Alarm {
    /// Number within the operation, from 1.
    number: usize,
    /// Time of the task, s.
    at_s: f64,
    text: Said,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Task {
    name: String,
    difficulty: String,
    title: Said,
    time_s: f64,
    score: Option<f64>,
    step: Option<Said>,
    steps_done: usize,
    steps: usize,
    passed: Option<bool>,
    end: Option<Said>,
}

/// The state as JSON.
#[derive(Debug, Clone, Serialize)]
struct State<'a> {
    /// Start of this operation, ms since 1970. Numbers of alarms count from it.
    operation: u64,
    trainee: Option<&'a str>,
    /// States of the simulation arrive.
    running: bool,
    paused: bool,
    /// The controller's thread is a realtime thread; `None`: unknown yet.
    realtime: Option<bool>,
    ticks: u64,
    missed: u64,
    late: u64,
    device: &'static str,
    task: Option<Task>,
    alarms: usize,
    newest_alarms: &'a [Alarm],
}

/// Collects the report of a station.
pub(super) struct Teller {
    operation: u64,
    trainee: Option<String>,
    words: [Words; 2],
    heard: Option<Instant>,
    timing: Option<(bool, [u64; 3])>,
    tools: Option<(&'static str, bool)>,
    task: Option<Task>,
    alarms: Vec<Alarm>,
    counted: usize,
}

/// Facts that are reported at once when they change: alarms, step, end, silence, pause, realtime,
/// device.
pub(super) type News = (usize, usize, bool, bool, bool, Option<bool>, &'static str);

impl Teller {
    pub(super) fn new(operation: u64, trainee: Option<String>) -> Self {
        Self {
            operation,
            trainee,
            words: [Language::English, Language::German].map(Words::new),
            heard: None,
            timing: None,
            tools: None,
            task: None,
            alarms: Vec::new(),
            counted: 0,
        }
    }

    /// A state of the simulation arrived.
    pub(super) fn hear(&mut self) {
        self.heard = Some(Instant::now());
    }

    pub(super) fn tools(&mut self, tools: &ToolFrame) {
        let device = match tools.health[0].status {
            DeviceHealth::LIVE => "live",
            DeviceHealth::STALE => "stale",
            DeviceHealth::LOST => "lost",
            _ => "absent",
        };
        self.tools = Some((device, tools.switches().contains(Switches::PAUSED)));
    }

    pub(super) fn timing(&mut self, batch: &TimingBatch) {
        let needed = TimingBatch::FIFO | TimingBatch::LOCKED | TimingBatch::PINNED;
        let is_realtime = batch.realtime & needed == needed;
        let counts = [batch.ticks, batch.missed_periods, batch.late_ticks];
        self.timing = Some((is_realtime, counts));
    }

    pub(super) fn task(&mut self, bulletin: &Bulletin) {
        let [en, de] = { self.words.each_ref() }.map(|words| Spoken::of(bulletin, words));
        let view = &bulletin.task;
        let both =
            |en: Option<String>, de: Option<String>| en.zip(de).map(|(en, de)| Said { en, de });
        // A new task counts its alarms anew.
        if view.alarms < self.counted {
            self.alarms.clear();
            self.counted = 0;
        }
        let first = view.alarms.saturating_sub(bulletin.alarms.len());
        let texts = en.alarms.into_iter().zip(de.alarms);
        for (at, ((at_s, _), (en, de))) in bulletin.alarms.iter().zip(texts).enumerate() {
            let number = first + at + 1;
            if number > self.counted {
                let text = Said { en, de };
                let at_s = *at_s;
                self.alarms.push(Alarm { number, at_s, text });
            }
        }
        self.counted = view.alarms;
        let spare = self.alarms.len().saturating_sub(ALARMS_TOLD);
        self.alarms.drain(..spare);
        self.task = Some(Task {
            name: view.task.clone(),
            difficulty: bulletin.difficulty.clone(),
            title: Said {
                en: en.task,
                de: de.task,
            },
            time_s: view.time_s,
            score: view.score,
            step: both(en.step, de.step),
            steps_done: view.steps.iter().filter(|(_, done)| *done).count(),
            steps: view.steps.len(),
            passed: view.end.as_ref().map(|end| end.passed),
            end: both(en.end, de.end),
        });
    }

    fn is_running(&self) -> bool {
        self.heard.is_some_and(|it| it.elapsed() < SILENT)
    }

    pub(super) fn news(&self) -> News {
        let (device, is_paused) = self.tools.unwrap_or(("absent", false));
        let task = self.task.as_ref();
        (
            self.counted,
            task.map_or(0, |it| it.steps_done),
            task.is_some_and(|it| it.end.is_some()),
            self.is_running(),
            is_paused,
            self.timing.map(|it| it.0),
            device,
        )
    }

    pub(super) fn json(&self) -> Vec<u8> {
        let (device, paused) = self.tools.unwrap_or(("absent", false));
        let [ticks, missed, late] = self.timing.map_or([0; 3], |it| it.1);
        let state = State {
            operation: self.operation,
            trainee: self.trainee.as_deref(),
            running: self.is_running(),
            paused,
            realtime: self.timing.map(|it| it.0),
            ticks,
            missed,
            late,
            device,
            task: self.task.clone(),
            alarms: self.counted,
            newest_alarms: &self.alarms,
        };
        serde_json::to_vec(&state).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use display_host::ui::{TaskNote, TaskView};

    use super::*;

    fn bulletin(alarms: usize, shown: usize) -> Bulletin {
        let note = TaskNote {
            kind: "perforated".to_owned(),
            organ: Some("gallbladder".to_owned()),
        };
        Bulletin {
            task: TaskView {
                task: "clamp".to_owned(),
                alarms,
                ..TaskView::default()
            },
            alarms: vec![(2.0, note); shown],
            ..Bulletin::default()
        }
    }

    #[test]
    fn every_alarm_is_told_once_with_its_number_and_repeated_in_later_states() {
        let mut teller = Teller::new(5, Some("Kim".to_owned()));
        teller.task(&bulletin(1, 1));
        let first = teller.news();
        teller.task(&bulletin(3, 3));
        assert_ne!(teller.news(), first);
        for total in 4..60 {
            teller.task(&bulletin(total, 12.min(total)));
        }
        let told: serde_json::Value = serde_json::from_slice(&teller.json()).unwrap();
        let newest = told["newest_alarms"].as_array().unwrap();
        let numbers: Vec<u64> = newest
            .iter()
            .map(|it| it["number"].as_u64().unwrap())
            .collect();
        assert_eq!(numbers, (28..60).collect::<Vec<_>>());
        assert_eq!(
            (&told["alarms"], &told["trainee"]),
            (&59.into(), &"Kim".into())
        );
        assert_eq!(told["realtime"], serde_json::Value::Null, "unknown yet");
        // The next task begins with none.
        teller.task(&bulletin(1, 1));
        let told: serde_json::Value = serde_json::from_slice(&teller.json()).unwrap();
        assert_eq!(told["newest_alarms"].as_array().map(Vec::len), Some(1));
    }
}
