//! Progress: the four parts of the test, and the place in the present one.

use egui::{Color32, Frame, Margin, RichText, Stroke, Ui};

use crate::ui::screens::BODY;
use crate::words::Words;

/// Parts of the test, by the ends of their messages' names.
pub const PARTS: [&str; 4] = ["move", "push", "scale", "response"];

/// Colours of a part that is done, of the present one, and of a later one.
const DONE: Color32 = Color32::from_rgb(35, 70, 45);
const NOW: Color32 = Color32::from_rgb(30, 75, 125);
const LATER: Color32 = Color32::from_gray(38);

/// Place in the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Index of the present part in [`PARTS`].
    pub part: usize,
    /// Number of the present step of the part, from 1, and how many it has.
    pub step: [usize; 2],
}

impl Progress {
    /// True in the last part.
    pub(super) const fn is_response(&self) -> bool {
        self.part + 1 == PARTS.len()
    }
}

/// Shows the parts in a row.
pub(super) fn show(ui: &mut Ui, words: &Words, progress: &Progress) {
    ui.horizontal_wrapped(|ui| {
        for (index, part) in PARTS.into_iter().enumerate() {
            let name = words.say(&format!("feel-part-{part}"));
            let [number, of] = progress.step.map(|it| it.to_string());
            let (fill, text) = if index < progress.part {
                let values = [("part", name.into())];
                (DONE, words.say_with("feel-part-done", &values))
            } else if index == progress.part && progress.step[1] > 1 {
                let values = [
                    ("part", name.into()),
                    ("number", number.into()),
                    ("of", of.into()),
                ];
                (NOW, words.say_with("feel-part-now", &values))
            } else {
                (if index == progress.part { NOW } else { LATER }, name)
            };
            let now = index == progress.part;
            let edge = if now { Color32::WHITE } else { fill };
            let frame = Frame::new()
                .fill(fill)
                .stroke(Stroke::new(1.5, edge))
                .corner_radius(4.0)
                .inner_margin(Margin::symmetric(12, 5));
            frame.show(ui, |ui| {
                let text = RichText::new(text).size(0.9 * BODY);
                ui.label(if now { text.strong() } else { text });
            });
        }
    });
}
