//! Sentences to the trainee that end by themselves, and the age of the task's newest alarm.

use std::time::{Duration, Instant};

use assess::Step;
use shared_mem::message::{EventMsg, SphereState, StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::Instrument;

use super::Session;
use super::hook::Hook;
use crate::ui::TaskView;

/// Time for which a sentence and an alarm stay over the picture: enough to read twelve words twice,
/// at 180 words a minute.
const SHOWN: Duration = Duration::from_secs(8);
/// Opening from which the jaws count as open, and up to which they count as closed.
const OPEN_CLOSED: [f32; 2] = [0.5, 0.05];
/// Time that closed jaws get to hold tissue: several pictures of a fast computer.
const HOLDS_WITHIN: Duration = Duration::from_millis(300);

/// The sentence, the newest alarm, the jaws and the hook.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// Time of the sentence.
    told: Option<Instant>,
    /// Number of the newest alarm, and the time at which it came.
    alarm: (usize, Option<Instant>),
    jaws: Jaws,
    hook: Hook,
}

impl Notes {
    pub(super) fn of(scene: &SceneFile) -> Self {
        Self {
            hook: Hook::of(scene),
            ..Self::default()
        }
    }

    /// Takes an event of the controller.
    pub(super) fn event(&mut self, event: &EventMsg) {
        self.hook.event(event);
    }
}

/// Watches the jaws of the grasper.
#[derive(Debug, Default)]
struct Jaws {
    /// True from the time at which they were open until their closing is judged.
    were_open: bool,
    /// Time since which they are closed.
    closed: Option<Instant>,
}

impl Jaws {
    /// Returns true once the jaws have closed on nothing.
    fn closed_on_nothing(&mut self, tools: &ToolFrame, holds: bool, now: Instant) -> bool {
        let [open, closed] = OPEN_CLOSED;
        if !tools.has(Instrument::Grasper) || tools.jaw > open {
            *self = Self {
                were_open: tools.has(Instrument::Grasper),
                closed: None,
            };
            return false;
        }
        if holds {
            self.were_open = false;
        }
        if !self.were_open || tools.jaw > closed {
            self.closed = None;
            return false;
        }
        let since = *self.closed.get_or_insert(now);
        let is_judged = now.saturating_duration_since(since) >= HOLDS_WITHIN;
        self.were_open = !is_judged;
        is_judged
    }
}

/// True if the present step asks to hold something, or if no step is named. In other steps closed
/// jaws may be meant.
fn asks_to_hold(task: Option<&TaskView>) -> bool {
    let hint = task.and_then(|it| it.hint.as_ref());
    hint.is_none_or(|it| matches!(it.step, Step::Grasp { .. } | Step::Carry { .. }))
}

/// True if the present step asks for current on loose tissue.
fn asks_for_current(task: Option<&TaskView>) -> bool {
    use Step as S;
    let hint = task.and_then(|it| it.hint.as_ref());
    hint.is_some_and(|it| {
        matches!(
            it.step,
            S::Coagulate | S::Triangle | S::LowerBed | S::Free | S::Clear { .. }
        )
    })
}

impl Session {
    /// Tells the trainee this sentence for a while.
    pub(super) fn note(&mut self, text: String) {
        self.ui.note = Some(text);
        self.notes.told = Some(Instant::now());
    }

    /// Ends an old sentence, takes the age of the newest alarm, and looks at the jaws.
    pub(super) fn take_notes(&mut self) {
        let now = Instant::now();
        let is_new = |at: Option<Instant>| at.is_some_and(|it| now - it < SHOWN);
        if !is_new(self.notes.told) {
            self.ui.note = None;
        }
        let count = self.ui.task_view.as_ref().map_or(0, |task| task.alarms);
        if count != self.notes.alarm.0 {
            self.notes.alarm = (count, Some(now));
        }
        self.ui.alarm_is_old = !is_new(self.notes.alarm.1);
        let works = self.replay.is_none() && !self.ui.instructor && !self.ui.watched;
        let Some((state, tools)) = self.feed.state().zip(self.feed.tools()) else {
            return;
        };
        let holds = holds(state);
        let heats = self.notes.hook.heats_wrong(tools, now);
        if self.notes.jaws.closed_on_nothing(tools, holds, now)
            && works
            && asks_to_hold(self.ui.task_view.as_ref())
        {
            self.note(self.ui.words.say("note-jaws-empty"));
        }
        let Some(organ) = heats.filter(|_| works && asks_for_current(self.ui.task_view.as_ref()))
        else {
            return;
        };
        let words = &self.ui.words;
        let text = match organ.and_then(|it| self.organs.get(it as usize)) {
            Some(name) => {
                let organ = words.organ(name).into();
                words.say_with("note-hook-other", &[("organ", organ)])
            }
            None => words.say("note-hook-air"),
        };
        self.note(text);
    }
}

/// True if the jaws hold tissue.
fn holds(state: &StateFrame) -> bool {
    let spheres = state.spheres().unwrap_or(&[]);
    let is_held = |it: &SphereState| it.bits & SphereState::GRASPED != 0;
    spheres.iter().any(is_held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jaws_that_close_on_nothing_are_reported_once() {
        let tools = |instrument: Instrument, jaw: f32| ToolFrame {
            instrument: instrument.number(),
            jaw,
            ..bytemuck::Zeroable::zeroed()
        };
        let begin = Instant::now();
        let run = |instrument, openings: &[f32], holds: bool| {
            let mut jaws = Jaws::default();
            let frames = openings.iter().zip(0u32..);
            let seen = frames.filter(|(jaw, number)| {
                let now = begin + Duration::from_millis(100) * *number;
                jaws.closed_on_nothing(&tools(instrument, **jaw), holds, now)
            });
            seen.count()
        };
        let once = [1.0, 0.6, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(run(Instrument::Grasper, &once, false), 1);
        assert_eq!(run(Instrument::Grasper, &once, true), 0, "tissue is held");
        assert_eq!(run(Instrument::Scissors, &once, false), 0);
        assert_eq!(run(Instrument::Grasper, &[0.0; 9], false), 0, "never open");
        let twice = [once, once].concat();
        assert_eq!(run(Instrument::Grasper, &twice, false), 2);
        let opened_again = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        assert_eq!(run(Instrument::Grasper, &opened_again, false), 0);
    }

    #[test]
    fn only_a_step_that_asks_for_it_speaks_of_empty_jaws_and_of_current() {
        let with = |step| TaskView {
            hint: Some(assess::Hint {
                step,
                advice: assess::Advice::Hold,
                percent: None,
            }),
            ..TaskView::default()
        };
        let organ = || "rope".to_owned();
        assert!(asks_to_hold(None));
        assert!(asks_to_hold(Some(&with(Step::Grasp { organ: organ() }))));
        assert!(!asks_to_hold(Some(&with(Step::Touch { organ: organ() }))));
        assert!(asks_for_current(Some(&with(Step::Coagulate))));
        assert!(!asks_for_current(Some(&with(Step::Grasp {
            organ: organ()
        }))));
        assert!(!asks_for_current(None));
    }
}
