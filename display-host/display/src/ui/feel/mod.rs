//! Screens of `calot devices feel --window`, the test of a haptic device by hand: a pure function
//! from the state of the test to widgets and the person's wishes.
//!
//! In some steps the handle pushes, and the person names the direction. Until then the window hides
//! force and position, because the person must feel the answer and not read it.

mod numbers;
mod outcome;
mod parts;
mod picture;

pub use outcome::{CheckLine, CheckResult, Ended};
pub use parts::{Part, Progress};

use egui::{Key, RichText, TextEdit, Ui};

use super::page::{drop_repeats, pressed, screen};
use super::screens::BODY_POINTS;
use super::widgets::{Mark, line};
use crate::words::Words;

/// Smallest width at which words and picture stand side by side, points.
const SIDE_BY_SIDE_POINTS: f32 = 1000.0;

/// Answers to the question about the fingers, each with its key and name. The handle opened the
/// fingers, shut them, or neither.
const FINGERS: [(Key, &str, Option<bool>); 3] = [
    (Key::O, "open", Some(true)),
    (Key::S, "shut", Some(false)),
    (Key::N, "nothing", None),
];

/// A direction, as the person sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Positive x.
    Right,
    /// Negative x.
    Left,
    /// Positive y.
    Up,
    /// Negative y.
    Down,
    /// Positive z.
    Towards,
    /// Negative z.
    Away,
}

impl Way {
    /// Each direction with the key that names it, as in the terminal.
    const KEYS: [(Self, Key); 6] = [
        (Self::Right, Key::R),
        (Self::Left, Key::L),
        (Self::Up, Key::U),
        (Self::Down, Key::D),
        (Self::Towards, Key::T),
        (Self::Away, Key::A),
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
            Self::Up => "up",
            Self::Down => "down",
            Self::Towards => "towards",
            Self::Away => "away",
        }
    }

    /// Unit vector: x right, y up, z towards the person.
    const fn vector(self) -> [f32; 3] {
        match self {
            Self::Right => [1.0, 0.0, 0.0],
            Self::Left => [-1.0, 0.0, 0.0],
            Self::Up => [0.0, 1.0, 0.0],
            Self::Down => [0.0, -1.0, 0.0],
            Self::Towards => [0.0, 0.0, 1.0],
            Self::Away => [0.0, 0.0, -1.0],
        }
    }
}

/// The step or question that the person sees.
#[derive(Debug, Clone, PartialEq)]
pub enum Screen {
    /// The test has not begun.
    Waiting,
    /// Move the handle.
    Move {
        /// Direction.
        way: Way,
        /// Length of the move, m.
        way_m: f32,
    },
    /// Hold the handle loosely before it pushes.
    Hold,
    /// Hold the handle firmly before a hard push.
    HoldFirmly,
    /// Hold the handle loosely before a push that must end by itself.
    HoldForSilence,
    /// The handle pushes.
    Push {
        /// Size of the force, N.
        force_n: f32,
    },
    /// Question: which way did the handle push?
    AskPushed,
    /// Shut the handle.
    Shut,
    /// Open the handle.
    Open,
    /// Hold the handle half open before it pushes the fingers.
    HoldFingers,
    /// The handle pushes the fingers.
    PushFingers {
        /// Size of the force, N.
        force_n: f32,
    },
    /// Question: which way did the handle push the fingers?
    AskFingers,
    /// Question: does the handle still push, although nothing is sent?
    AskLeft,
    /// Question: is there a scale?
    AskScale,
    /// Stand the handle on the scale.
    Scale,
    /// The handle presses on the scale.
    Press {
        /// Size of the force, N.
        force_n: f32,
    },
    /// Question: what did the scale show?
    AskPressed {
        /// Text in the field.
        grams: String,
        /// True if the text that was entered is not a weight.
        wrong: bool,
    },
    /// The handle pushes to and fro.
    Response,
    /// The test is over.
    Ended(Ended),
}

/// State of the device, to be shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Live {
    /// Position of the handle, m.
    pub at_m: Option<[f32; 3]>,
    /// Velocity as the device reports it, m/s.
    pub velocity_m_s: Option<[f32; 3]>,
    /// Commanded force, N.
    pub force_n: [f32; 3],
    /// Opening of the handle, 0 shut to 1 wide open.
    pub opening: Option<f32>,
    /// Commanded force that opens the handle, N.
    pub opening_n: f32,
}

/// State of the window.
#[derive(Debug, Clone)]
pub struct View {
    /// Words in the user's language.
    pub words: Words,
    /// Progress of the test.
    pub progress: Progress,
    /// The step or question.
    pub screen: Screen,
    /// State of the device.
    pub live: Live,
    /// Radius of the device's workspace, m.
    pub radius_m: f32,
    /// True if the device's handle opens and shuts.
    pub opens: bool,
}

/// A wish of the person.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// The step is done.
    Done,
    /// The handle pushed this way. `None` if nothing was felt.
    Felt(Option<Way>),
    /// The handle opened the fingers (true) or shut them. `None` if nothing was felt.
    FeltFingers(Option<bool>),
    /// The handle still pushes (true), or no more.
    Left(bool),
    /// There is a scale, or none.
    HasScale(bool),
    /// The field of grams has this text now.
    Grams(String),
    /// Take the field of grams as the answer.
    TakeGrams,
    /// End every force, and the test.
    Stop,
    /// Close the window.
    Close,
}

impl View {
    /// Title of the window.
    #[must_use]
    pub fn title(&self) -> String {
        format!("Calot: {}", self.headline())
    }

    /// The instruction, in a few words.
    #[must_use]
    pub fn headline(&self) -> String {
        let words = &self.words;
        let newton = |force_n: f32| [("newton", format!("{force_n:.1}").into())];
        match &self.screen {
            Screen::Waiting => words.say("feel-waiting"),
            Screen::Move { way, way_m } => {
                let way = words.say(&format!("feel-way-{}", way.name()));
                let mm = format!("{:.0}", way_m * 1e3);
                words.say_with("feel-move", &[("mm", mm.into()), ("way", way.into())])
            }
            Screen::Hold | Screen::HoldForSilence => words.say("feel-hold"),
            Screen::HoldFirmly => words.say("feel-hold-firmly"),
            Screen::AskLeft => words.say("feel-ask-left"),
            Screen::Push { force_n } => words.say_with("feel-push", &newton(*force_n)),
            Screen::AskPushed => words.say("feel-ask-pushed"),
            Screen::Shut => words.say("feel-shut"),
            Screen::Open => words.say("feel-open"),
            Screen::HoldFingers => words.say("feel-hold-fingers"),
            Screen::PushFingers { force_n } => {
                words.say_with("feel-push-fingers", &newton(*force_n))
            }
            Screen::AskFingers => words.say("feel-ask-fingers"),
            Screen::AskScale => words.say("feel-ask-scale"),
            Screen::Scale => words.say("feel-scale"),
            Screen::Press { force_n } => words.say_with("feel-press", &newton(*force_n)),
            Screen::AskPressed { .. } => words.say("feel-ask-pressed"),
            Screen::Response => words.say("feel-response"),
            Screen::Ended(ended) => ended.headline(words),
        }
    }

    /// Note on the step.
    fn note(&self) -> Option<String> {
        let id = match &self.screen {
            Screen::Move { .. } => "feel-move-note",
            Screen::Shut | Screen::Open => "feel-ends-note",
            Screen::HoldFingers => "feel-hold-note-push",
            Screen::Hold if self.progress.part == Part::Response => "feel-hold-note-response",
            Screen::Hold => "feel-hold-note-push",
            Screen::HoldFirmly => "feel-hold-note-hard",
            Screen::HoldForSilence => "feel-hold-note-silence",
            Screen::AskLeft => "feel-ask-left-note",
            _ if self.is_secret() => "feel-push-note",
            Screen::AskScale => "feel-ask-scale-note",
            Screen::Scale => "feel-scale-note",
            Screen::Press { .. } => "feel-press-note",
            Screen::AskPressed { .. } => "feel-ask-pressed-note",
            Screen::Response => "feel-response-note",
            _ => return None,
        };
        Some(self.words.say(id))
    }

    /// Note for a rig whose handle is an instrument in a port.
    fn port_note(&self) -> Option<String> {
        let words = &self.words;
        match &self.screen {
            Screen::Move {
                way: way @ (Way::Up | Way::Down | Way::Towards | Way::Away),
                ..
            } => {
                let way = words.say(&format!("feel-way-{}", way.name()));
                Some(words.say_with("feel-port-draw", &[("way", way.into())]))
            }
            Screen::Move { .. } => Some(words.say("feel-port-move")),
            Screen::Hold | Screen::HoldFirmly | Screen::HoldForSilence => {
                Some(words.say("feel-port-hold"))
            }
            Screen::AskPushed => Some(words.say("feel-port-pushed")),
            Screen::Scale => Some(words.say("feel-port-scale")),
            _ => None,
        }
    }

    /// True while the window hides force and position, because the person must feel them.
    const fn is_secret(&self) -> bool {
        matches!(
            self.screen,
            Screen::Push { .. }
                | Screen::AskPushed
                | Screen::AskLeft
                | Screen::PushFingers { .. }
                | Screen::AskFingers
        )
    }
}

/// Shows the window. Returns the person's wishes.
pub fn feel(ui: &mut Ui, view: &View) -> Vec<Wish> {
    let mut wishes = Vec::new();
    drop_repeats(ui);
    if let Screen::Ended(ended) = &view.screen {
        outcome::show(ui, view, ended, &mut wishes);
        return wishes;
    }
    keys(ui, view, &mut wishes);
    let (name, meant, buttons) = buttons(view);
    screen(ui, name, meant, &buttons, &mut wishes, |ui, wishes| {
        parts::show(ui, &view.words, &view.progress, view.opens);
        ui.add_space(12.0);
        if ui.available_width() < SIDE_BY_SIDE_POINTS {
            instruction(ui, view, wishes);
            picture::show(ui, view, 0.5 * ui.ctx().content_rect().height());
            numbers::show(ui, view);
            return;
        }
        ui.columns_const(|[left, right]| {
            instruction(left, view, wishes);
            numbers::show(left, view);
            picture::show(right, view, 0.72 * right.ctx().content_rect().height());
        });
    });
    wishes
}

fn instruction(ui: &mut Ui, view: &View, wishes: &mut Vec<Wish>) {
    ui.label(
        RichText::new(view.headline())
            .size(2.0 * BODY_POINTS)
            .strong(),
    );
    for (note, size) in [
        (view.note(), 1.1 * BODY_POINTS),
        (view.port_note(), BODY_POINTS),
    ] {
        if let Some(note) = note {
            ui.add_space(6.0);
            ui.label(RichText::new(note).size(size));
        }
    }
    if let Screen::AskPressed { grams, wrong } = &view.screen {
        ui.add_space(6.0);
        let mut text = grams.clone();
        let response = ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut text)
                .char_limit(12)
                .desired_width(160.0)
                .font(egui::FontId::proportional(1.6 * BODY_POINTS));
            let response = ui.add(field);
            let unit = ui.label(RichText::new("g").size(1.6 * BODY_POINTS));
            response.labelled_by(unit.id)
        });
        let field = response.inner;
        if text != *grams {
            wishes.push(Wish::Grams(text));
        }
        // The field loses the focus when Enter is pressed.
        if field.lost_focus() && pressed(ui, Key::Enter) {
            wishes.push(Wish::TakeGrams);
        }
        field.request_focus();
        if *wrong {
            line(ui, Mark::Bad, &view.words.say("feel-grams-wrong"));
        }
    }
    ui.add_space(12.0);
}

/// Name of the screen for its widgets, index of the button that Enter presses, and the buttons.
fn buttons(view: &View) -> (&'static str, Option<usize>, Vec<(String, Wish)>) {
    let words = &view.words;
    let done = || vec![(words.say("feel-done"), Wish::Done)];
    let (name, meant, mut buttons) = match &view.screen {
        Screen::Move { .. } => ("move", Some(0), done()),
        Screen::Hold => ("hold", Some(0), done()),
        Screen::HoldFirmly => ("hold firmly", Some(0), done()),
        Screen::HoldForSilence => ("hold for silence", Some(0), done()),
        Screen::Shut => ("shut", Some(0), done()),
        Screen::Open => ("open", Some(0), done()),
        Screen::HoldFingers => ("hold fingers", Some(0), done()),
        Screen::Scale => ("scale", Some(0), done()),
        Screen::Press { .. } => ("press", Some(0), done()),
        Screen::AskPushed => {
            let answer = |(way, _): (Way, Key)| {
                let text = words.say(&format!("feel-answer-{}", way.name()));
                (text, Wish::Felt(Some(way)))
            };
            let mut answers: Vec<_> = Way::KEYS.into_iter().map(answer).collect();
            answers.push((words.say("feel-answer-nothing"), Wish::Felt(None)));
            ("pushed", None, answers)
        }
        Screen::AskFingers => {
            let answer = |(_, name, open): (Key, &str, Option<bool>)| {
                let text = words.say(&format!("feel-answer-{name}"));
                (text, Wish::FeltFingers(open))
            };
            ("fingers", None, FINGERS.map(answer).into())
        }
        Screen::AskLeft => {
            let yes = (words.say("feel-yes"), Wish::Left(true));
            let no = (words.say("feel-no"), Wish::Left(false));
            ("left", None, vec![yes, no])
        }
        Screen::AskScale => {
            let yes = (words.say("feel-yes"), Wish::HasScale(true));
            let no = (words.say("feel-no"), Wish::HasScale(false));
            ("has scale", None, vec![yes, no])
        }
        Screen::AskPressed { .. } => {
            let take = (words.say("feel-take"), Wish::TakeGrams);
            ("pressed", None, vec![take])
        }
        Screen::Waiting
        | Screen::Push { .. }
        | Screen::PushFingers { .. }
        | Screen::Response
        | Screen::Ended(_) => ("watch", None, Vec::new()),
    };
    buttons.push((words.say("feel-stop"), Wish::Stop));
    (name, meant, buttons)
}

fn keys(ui: &Ui, view: &View, wishes: &mut Vec<Wish>) {
    if pressed(ui, Key::Escape) {
        wishes.push(Wish::Stop);
    }
    match &view.screen {
        Screen::AskPushed => {
            let felt = Way::KEYS.into_iter().find(|(_, key)| pressed(ui, *key));
            wishes.extend(felt.map(|(way, _)| Wish::Felt(Some(way))));
            if pressed(ui, Key::N) {
                wishes.push(Wish::Felt(None));
            }
        }
        Screen::AskFingers => {
            let felt = FINGERS.into_iter().filter(|(key, ..)| pressed(ui, *key));
            wishes.extend(felt.map(|(.., open)| Wish::FeltFingers(open)));
        }
        Screen::AskScale | Screen::AskLeft => {
            for (key, yes) in [(Key::Y, true), (Key::J, true), (Key::N, false)] {
                if pressed(ui, key) {
                    wishes.push(match view.screen {
                        Screen::AskLeft => Wish::Left(yes),
                        _ => Wish::HasScale(yes),
                    });
                }
            }
        }
        _ => {}
    }
}
