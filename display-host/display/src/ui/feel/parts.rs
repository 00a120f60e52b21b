//! Progress of `calot devices feel`: its parts, and the step of the present part.

use egui::{Color32, Frame, Margin, RichText, Stroke, TextStyle, TextWrapMode, Ui, WidgetText};

use crate::ui::screens::BODY_POINTS;
use crate::words::Words;

/// A part of the test. The parts are in the order in which they are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Part {
    /// The person moves the handle.
    #[default]
    Move,
    /// The handle pushes.
    Push,
    /// The person shuts and opens the handle, then it pushes the fingers.
    Opening,
    /// The handle presses on a scale.
    Scale,
    /// The handle pushes to and fro.
    Response,
}

impl Part {
    const ALL: [Self; 5] = [
        Self::Move,
        Self::Push,
        Self::Opening,
        Self::Scale,
        Self::Response,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Move => "move",
            Self::Push => "push",
            Self::Opening => "opening",
            Self::Scale => "scale",
            Self::Response => "response",
        }
    }
}

/// Colour of a part that is done.
const DONE: Color32 = Color32::from_rgb(35, 70, 45);
/// Colour of the present part.
const NOW: Color32 = Color32::from_rgb(30, 75, 125);
/// Colour of a later part.
const LATER: Color32 = Color32::from_gray(38);

/// Place in the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Present part.
    pub part: Part,
    /// Number of the present step, from 1, and the number of steps of the part.
    pub step: [usize; 2],
}

/// Shows the parts in a row. [`Part::Opening`] is left out if the handle does not open.
pub(super) fn show(ui: &mut Ui, words: &Words, progress: &Progress, opens: bool) {
    ui.horizontal_wrapped(|ui| {
        let has = |part: &Part| opens || *part != Part::Opening;
        for part in Part::ALL.into_iter().filter(has) {
            let name = words.say(&format!("feel-part-{}", part.name()));
            let [number, of] = progress.step.map(|it| it.to_string());
            let (fill, text) = if part < progress.part {
                let values = [("part", name.into())];
                (DONE, words.say_with("feel-part-done", &values))
            } else if part == progress.part && progress.step[1] > 1 {
                let values = [
                    ("part", name.into()),
                    ("number", number.into()),
                    ("of", of.into()),
                ];
                (NOW, words.say_with("feel-part-now", &values))
            } else {
                (if part == progress.part { NOW } else { LATER }, name)
            };
            let now = part == progress.part;
            let edge = if now { Color32::WHITE } else { fill };
            let frame = Frame::new()
                .fill(fill)
                .stroke(Stroke::new(1.5, edge))
                .corner_radius(4.0)
                .inner_margin(Margin::symmetric(12, 5));
            let text = RichText::new(text).size(0.9 * BODY_POINTS);
            let text = WidgetText::from(if now { text.strong() } else { text });
            // A frame does not wrap by itself, because it does not know its width before its text.
            let extend = Some(TextWrapMode::Extend);
            let galley = text.into_galley(ui, extend, f32::INFINITY, TextStyle::Body);
            let width = galley.size().x + frame.total_margin().sum().x;
            if width > ui.available_size_before_wrap().x {
                ui.end_row();
            }
            frame.show(ui, |ui| ui.label(galley));
        }
    });
}
