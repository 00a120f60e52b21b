//! The test's side of the window: sends screens and takes answers, and never waits for the window.

use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex};

use display_host::ui::feel::{
    CheckLine, CheckResult, Ended, Live as Shown, Part, Progress, Screen, Way,
};
use hardware::conformance::{CheckOutcome, Report};
use hardware::feel::{
    Answer, Direction, Guide, Left, Live, MOVES, PUSHES, Question, SQUEEZES, Squeezed, Step,
};

use super::signs::Signs;
use crate::devices::feel::pace::Pace;

/// A screen with its number. Each answer carries the number of its screen, so that answers to
/// earlier screens are ignored.
pub(super) struct Turn {
    pub(super) number: u32,
    pub(super) progress: Progress,
    pub(super) screen: Screen,
}

/// Answer of the person at the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Said {
    /// The step is done.
    Done,
    /// Direction in which the handle pushed.
    Pushed(Answer),
    /// Direction in which the handle pushed the fingers.
    Squeezed(Squeezed),
    /// True if the handle still pushes after Calot has fallen silent.
    Left(bool),
    /// True if there is a kitchen scale.
    HasScale(bool),
    /// Force that the scale showed, N; `None` if it was not read.
    Pressed(Option<f32>),
}

/// Guide of a person at a window.
pub(super) struct Windowed {
    turns: Sender<Turn>,
    answers: Receiver<(u32, Said)>,
    live: Arc<Mutex<Shown>>,
    signs: Arc<Signs>,
    pace: Pace,
    number: u32,
    progress: Progress,
    moves: usize,
    pushes: usize,
    squeezes: usize,
    answer: Option<Said>,
}

impl Windowed {
    pub(super) fn new(
        turns: Sender<Turn>,
        answers: Receiver<(u32, Said)>,
        live: Arc<Mutex<Shown>>,
        signs: Arc<Signs>,
        stop: Arc<AtomicBool>,
    ) -> Self {
        Self {
            turns,
            answers,
            live,
            signs,
            pace: Pace::new(stop),
            number: 0,
            progress: Progress::default(),
            moves: 0,
            pushes: 0,
            squeezes: 0,
            answer: None,
        }
    }

    /// True once the person has seen the window.
    pub(super) fn is_seen(&self) -> bool {
        self.signs.is_seen()
    }

    fn show(&mut self, screen: Screen) {
        self.number += 1;
        self.answer = None;
        let turn = Turn {
            number: self.number,
            progress: self.progress,
            screen,
        };
        if self.turns.send(turn).is_err() {
            self.pace.end();
        }
    }

    /// True once the screen that was shown last has an answer.
    fn is_answered(&mut self) -> bool {
        while self.answer.is_none() {
            match self.answers.try_recv() {
                Ok((number, said)) if number == self.number => self.answer = Some(said),
                Ok(_) => {}
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    self.pace.end();
                    break;
                }
            }
        }
        self.answer.is_some()
    }

    /// Shows the results.
    pub(super) fn end(&mut self, report: &Report) {
        let line = |check: &hardware::conformance::Check| CheckLine {
            name: check.name.to_owned(),
            result: match check.outcome {
                CheckOutcome::Pass => CheckResult::Pass,
                CheckOutcome::Fail => CheckResult::Fail,
                CheckOutcome::NotJudged => CheckResult::Open,
                CheckOutcome::Skipped => CheckResult::Skipped,
            },
            detail: check.detail.clone(),
        };
        self.show(Screen::Ended(Ended {
            device: report.device.clone(),
            passed: report.passed(),
            checks: report.checks.iter().map(line).collect(),
        }));
    }

    /// Moves the shown progress to this step of the test.
    fn advance(&mut self, step: &Step) {
        // The handle is shut first, then opened, then it pushes the fingers.
        const SHUT: usize = 1;
        const OPEN: usize = 2;
        // After the pushes to and fro come a hard push, and a push that must end by itself.
        const RESPONSES: usize = 3;
        let (part, step) = match step {
            Step::Move { .. } => {
                self.moves += 1;
                (Part::Move, [self.moves, MOVES])
            }
            Step::Hold if self.pushes == PUSHES => (Part::Response, [1, RESPONSES]),
            Step::Hold => {
                self.pushes += 1;
                (Part::Push, [self.pushes, PUSHES])
            }
            Step::HoldFirmly => (Part::Response, [2, RESPONSES]),
            Step::HoldForSilence => (Part::Response, [RESPONSES, RESPONSES]),
            Step::Shut => (Part::Opening, [SHUT, OPEN + SQUEEZES]),
            Step::Open => (Part::Opening, [OPEN, OPEN + SQUEEZES]),
            Step::HoldFingers => {
                self.squeezes += 1;
                (Part::Opening, [OPEN + self.squeezes, OPEN + SQUEEZES])
            }
            Step::Push { .. }
            | Step::PushAndFallSilent { .. }
            | Step::PushFingers { .. }
            | Step::Scale
            | Step::Press { .. }
            | Step::Response => return,
        };
        self.progress = Progress { part, step };
    }
}

impl Guide for Windowed {
    fn ask(&mut self, question: Question) {
        if question == Question::HasScale {
            self.progress = Progress {
                part: Part::Scale,
                step: [1, 1],
            };
        }
        self.show(match question {
            Question::Pushed => Screen::AskPushed,
            Question::Squeezed => Screen::AskFingers,
            Question::HasScale => Screen::AskScale,
            Question::Left => Screen::AskLeft,
            Question::Pressed => Screen::AskPressed {
                grams: String::new(),
                wrong: false,
            },
        });
    }

    fn has_answer(&mut self) -> bool {
        self.is_answered()
    }

    fn live(&mut self, live: &Live) {
        // If the window is reading now, skip this value: the next one comes in a millisecond.
        let Ok(mut shown) = self.live.try_lock() else {
            return;
        };
        *shown = Shown {
            at_m: live.at_m.map(Into::into),
            velocity_m_s: live.velocity_m_s.map(Into::into),
            force_n: live.force_n.into(),
            opening: live.opening,
            opening_n: live.opening_n,
        };
    }

    fn tell(&mut self, step: &Step) {
        self.advance(step);
        self.show(match *step {
            Step::Move { direction, way_m } => Screen::Move {
                way: way(direction),
                way_m,
            },
            Step::Hold => Screen::Hold,
            Step::HoldFirmly => Screen::HoldFirmly,
            Step::HoldForSilence => Screen::HoldForSilence,
            Step::Push { force_n } | Step::PushAndFallSilent { force_n } => {
                Screen::Push { force_n }
            }
            Step::Shut => Screen::Shut,
            Step::Open => Screen::Open,
            Step::HoldFingers => Screen::HoldFingers,
            Step::PushFingers { force_n } => Screen::PushFingers { force_n },
            Step::Scale => Screen::Scale,
            Step::Press { force_n } => Screen::Press { force_n },
            Step::Response => Screen::Response,
        });
    }

    fn is_done(&mut self) -> bool {
        self.is_answered()
    }

    fn pushed(&mut self) -> Answer {
        match self.answer {
            Some(Said::Pushed(answer)) => answer,
            _ => Answer::Nothing,
        }
    }

    fn squeezed(&mut self) -> Squeezed {
        match self.answer {
            Some(Said::Squeezed(squeezed)) => squeezed,
            _ => Squeezed::Nothing,
        }
    }

    fn has_scale(&mut self) -> bool {
        self.answer == Some(Said::HasScale(true))
    }

    fn pressed_n(&mut self) -> Option<f32> {
        match self.answer {
            Some(Said::Pressed(pressed_n)) => pressed_n,
            _ => None,
        }
    }

    fn left(&mut self) -> Option<Left> {
        match self.answer {
            Some(Said::Left(true)) => Some(Left::Pushes),
            Some(Said::Left(false)) => Some(Left::Nothing),
            _ => None,
        }
    }

    fn wait(&mut self) -> u64 {
        self.pace.wait()
    }

    fn is_stopped(&self) -> bool {
        self.pace.is_stopped() || self.signs.is_halted()
    }
}

const fn way(direction: Direction) -> Way {
    match direction {
        Direction::Right => Way::Right,
        Direction::Left => Way::Left,
        Direction::Up => Way::Up,
        Direction::Down => Way::Down,
        Direction::Towards => Way::Towards,
        Direction::Away => Way::Away,
    }
}

/// Converts a direction of the window to one of the test.
pub(super) const fn direction(way: Way) -> Direction {
    match way {
        Way::Right => Direction::Right,
        Way::Left => Direction::Left,
        Way::Up => Direction::Up,
        Way::Down => Direction::Down,
        Way::Towards => Direction::Towards,
        Way::Away => Direction::Away,
    }
}
