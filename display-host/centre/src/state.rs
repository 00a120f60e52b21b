//! The state of a station, as `calot tell` writes it. A station is not trusted: only the fields of
//! these types reach instructors.

use serde::{Deserialize, Serialize};

/// Largest state, bytes.
pub const STATE_MAX: usize = 64_000;
/// Largest number of characters of a text.
const TEXT_MAX: usize = 300;

/// A text in the languages of the page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Said {
    /// English.
    pub en: String,
    /// German.
    pub de: String,
}

/// An error of the trainee.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    /// Number within the operation, from 1.
    pub number: u64,
    /// Time of the task, s.
    pub at_s: f64,
    /// Its text.
    pub text: Said,
}

/// An alarm with the time of its arrival.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Heard {
    /// Time of arrival, ms since 1970.
    pub at_unix_ms: u64,
    /// Operation in which it arose.
    pub operation: u64,
    /// The trainee of that operation.
    pub trainee: Option<String>,
    /// The alarm.
    #[serde(flatten)]
    pub alarm: Alarm,
}

/// State of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Name on the command line.
    pub name: String,
    /// Degree of help.
    pub difficulty: String,
    /// Title.
    pub title: Said,
    /// Time, s.
    pub time_s: f64,
    /// Score so far.
    pub score: Option<f64>,
    /// Step at hand.
    pub step: Option<Said>,
    /// Number of steps that are done.
    pub steps_done: u64,
    /// Number of steps.
    pub steps: u64,
    /// Outcome, once it is over.
    pub passed: Option<bool>,
    /// Outcome in words.
    pub end: Option<Said>,
}

/// State of a station.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Start of the operation, ms since 1970.
    pub operation: u64,
    /// Name that the trainee chose.
    pub trainee: Option<String>,
    /// The simulation runs.
    pub running: bool,
    /// It is paused.
    pub paused: bool,
    /// The controller's thread is a realtime thread; `None`: unknown.
    pub realtime: Option<bool>,
    /// Ticks so far.
    pub ticks: u64,
    /// Periods without a tick.
    pub missed: u64,
    /// Ticks that ended late.
    pub late: u64,
    /// State of the haptic device.
    pub device: String,
    /// The task, if there is one.
    pub task: Option<Task>,
    /// Alarms so far.
    pub alarms: u64,
    /// The newest alarms.
    pub newest_alarms: Vec<Alarm>,
}

impl State {
    /// Reads a state. `None` if the bytes are no state, or are too many, or if a text is too long.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        if bytes.len() > STATE_MAX {
            return None;
        }
        let state: Self = serde_json::from_slice(bytes).ok()?;
        state.is_sane().then_some(state)
    }

    fn is_sane(&self) -> bool {
        let task = self.task.iter().flat_map(|task| {
            let said = [Some(&task.title), task.step.as_ref(), task.end.as_ref()];
            let said = said.into_iter().flatten();
            let said = said.flat_map(|it| [&it.en, &it.de]);
            said.chain([&task.name, &task.difficulty])
        });
        let alarms = { self.newest_alarms.iter() }.flat_map(|it| [&it.text.en, &it.text.de]);
        let mut texts = { task.chain(alarms) }
            .chain(&self.trainee)
            .chain([&self.device]);
        texts.all(|it| it.chars().count() <= TEXT_MAX && !it.chars().any(char::is_control))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A state with this many alarms, of which it repeats the last 32.
    pub(crate) fn state(operation: u64, alarms: u64) -> State {
        let said = |text: &str| Said {
            en: text.to_owned(),
            de: text.to_owned(),
        };
        State {
            operation,
            trainee: Some("Kim".to_owned()),
            running: true,
            paused: false,
            realtime: Some(true),
            ticks: 1000,
            missed: 0,
            late: 0,
            device: "live".to_owned(),
            task: None,
            alarms,
            newest_alarms: (alarms.saturating_sub(32) + 1..=alarms)
                .map(|number| Alarm {
                    number,
                    at_s: 1.0,
                    text: said(&format!("alarm {number}")),
                })
                .collect(),
        }
    }

    #[test]
    fn a_state_is_read_and_a_foreign_one_refused() {
        let it = state(1, 3);
        let text = serde_json::to_vec(&it).unwrap();
        assert_eq!(State::parse(&text), Some(it.clone()));
        let long = State {
            trainee: Some("x".repeat(301)),
            ..it.clone()
        };
        let odd = State {
            trainee: Some("a\u{1b}[0m".to_owned()),
            ..it
        };
        for wrong in [long, odd] {
            assert_eq!(State::parse(&serde_json::to_vec(&wrong).unwrap()), None);
        }
        assert_eq!(State::parse(b"{}"), None);
        let huge = [text, vec![b' '; STATE_MAX]].concat();
        assert_eq!(State::parse(&huge), None);
    }
}
