//! Ratings from 1 to 5, one item after the other: the questionnaire, and the instructor's sheet.

use egui::{Id, Key, RichText, TextEdit, Ui};

use super::{Wish, pressed, screen, typed};
use crate::ui::names;
use crate::ui::screens::{BODY_POINTS, title};
use crate::ui::widgets::{Mark, line};
use crate::words::Words;

/// Name of the field for the rater's name.
const RATER: &str = "rater";

/// Kind of form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asking {
    /// The trainee's questionnaire.
    Questions,
    /// The instructor's sheet.
    Sheet,
}

/// Items and their ratings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Points {
    /// Kind of form.
    pub asking: Asking,
    /// Name of the trainee.
    pub trainee: String,
    /// Name of each item, and its text for languages without a translation.
    pub items: Vec<(String, String)>,
    /// Ratings, as far as given; 0: the item does not apply.
    pub given: Vec<Option<u8>>,
    /// Index of the present item; after the last item, the number of items.
    pub at: usize,
    /// Name of the rater who fills a sheet; may be empty.
    pub rater: String,
    /// Reason why the ratings were not saved.
    pub problem: Option<String>,
}

impl Points {
    /// True if an item may be left out. Each item of an instructor's sheet has its points.
    fn may_skip(&self) -> bool {
        self.asking == Asking::Questions
    }

    /// Title of the form.
    #[must_use]
    pub fn title(&self, words: &Words) -> String {
        words.say(match self.asking {
            Asking::Questions => "launcher-questions",
            Asking::Sheet => "launcher-sheet",
        })
    }

    /// Text of an item, in the user's language if translated.
    fn text(&self, words: &Words, (name, text): &(String, String)) -> String {
        let id = match self.asking {
            Asking::Questions => format!("question-{name}"),
            Asking::Sheet => format!("goals-{name}"),
        };
        let said = words.say(&id);
        if said == id { text.clone() } else { said }
    }
}

pub(super) fn show(ui: &mut Ui, words: &Words, points: &Points, wishes: &mut Vec<Wish>) {
    let item = points.items.get(points.at);
    let mut buttons = Vec::new();
    if item.is_none() {
        buttons.push((words.say("points-keep"), Wish::Keep));
    }
    if points.at > 0 {
        buttons.push((words.say("points-previous"), Wish::Previous));
    }
    buttons.push((words.say("points-back"), Wish::Back));
    keys(ui, points, wishes);
    let meant = item.is_none().then_some(0);
    screen(ui, "points", meant, &buttons, wishes, |ui, wishes| {
        title(ui, &points.title(words));
        let who = names::drawn(&points.trainee).into();
        ui.label(words.say_with("points-about", &[("name", who)]));
        if points.asking == Asking::Sheet {
            ui.label(words.say("points-goals"));
        }
        if let Some(problem) = &points.problem {
            line(ui, Mark::Bad, problem);
        }
        ui.add_space(16.0);
        let Some(item) = item else {
            if points.asking == Asking::Sheet {
                rater(ui, words, &points.rater, wishes);
            }
            ui.label(words.say("points-all"));
            for (item, given) in points.items.iter().zip(&points.given) {
                let given = given.filter(|it| *it > 0);
                let given = given.map_or_else(|| "–".to_owned(), |it| it.to_string());
                ui.label(format!("{given}   {}", points.text(words, item)));
            }
            if points.given.contains(&Some(0)) {
                ui.label(words.say("points-skipped"));
            }
            return;
        };
        let values = [
            ("number", (points.at + 1).to_string().into()),
            ("of", points.items.len().to_string().into()),
        ];
        ui.label(words.say_with("points-number", &values));
        ui.label(
            RichText::new(points.text(words, item))
                .size(1.5 * BODY_POINTS)
                .strong(),
        );
        ui.add_space(16.0);
        let given = points.given.get(points.at).copied().flatten();
        ui.horizontal_wrapped(|ui| {
            for number in 1..=5u8 {
                let text = RichText::new(format!("  {number}  ")).size(2.0 * BODY_POINTS);
                let button = egui::Button::selectable(given == Some(number), text);
                if ui.add(button.frame_when_inactive(true)).clicked() {
                    wishes.push(Wish::Answer(number));
                }
            }
        });
        ui.label(words.say("points-scale"));
        if points.may_skip() {
            ui.add_space(8.0);
            let text = words.say("points-not-applicable");
            let button = egui::Button::selectable(given == Some(0), text);
            if ui.add(button.frame_when_inactive(true)).clicked() {
                wishes.push(Wish::Answer(0));
            }
        }
    });
}

/// Asks for the rater's name. Points of several raters of a session are kept apart by it.
fn rater(ui: &mut Ui, words: &Words, name: &str, wishes: &mut Vec<Wish>) {
    let label = ui.label(words.say("points-rater"));
    let mut own = name.to_owned();
    let field = TextEdit::singleline(&mut own)
        .id(Id::unique(RATER))
        .char_limit(64);
    if ui.add(field).labelled_by(label.id).changed() {
        wishes.push(Wish::Rater(own));
    }
    ui.add_space(8.0);
}

fn keys(ui: &Ui, points: &Points, wishes: &mut Vec<Wish>) {
    // In the field, Backspace deletes a letter, and Esc and Enter leave the field.
    let field = Id::unique(RATER);
    if ui.memory(|memory| memory.has_focus(field) || memory.had_focus_last_frame(field)) {
        return;
    }
    let numbers = [
        Key::Num0,
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
    ];
    let least = usize::from(!points.may_skip());
    let mut left = points.items.len() - points.at.min(points.items.len());
    let is_answered = left == 0;
    for key in typed(ui) {
        let number = numbers.iter().position(|it| *it == key);
        match number {
            Some(number) if left > 0 && number >= least => {
                wishes.push(Wish::Answer(number as u8));
                left -= 1;
            }
            // Enter was typed before the button is on the screen. Later the button itself takes
            // Enter.
            None if key == Key::Enter && left == 0 && !is_answered => wishes.push(Wish::Keep),
            _ => {}
        }
    }
    if points.at > 0 && pressed(ui, Key::Backspace) {
        wishes.push(Wish::Previous);
    }
    if pressed(ui, Key::Escape) {
        wishes.push(Wish::Back);
    }
}
