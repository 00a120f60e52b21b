//! Lessons of a debrief: the errors, advice for the next time, a close picture of each error, and
//! buttons that replay its moments.

use std::path::Path;
use std::sync::Arc;

use assess::Reason;
use assess::report::advice;
use egui::{ColorImage, Id, RichText, TextureHandle, TextureOptions, Ui};

use super::{Wish, minutes};
use crate::ui::TaskNote;
use crate::ui::screens::part;
use crate::ui::task::alarm;
use crate::ui::widgets::{Mark, line};
use crate::words::Words;

/// Largest number of moments of a lesson.
const MOMENTS_MAX: usize = 4;
/// Width of a close picture, points.
const PICTURE_WIDTH_POINTS: f32 = 250.0;
/// Least width beside a picture, points. On a narrower page the picture stands below.
const BESIDE_WIDTH_POINTS: f32 = 260.0;

/// Errors of one kind at one organ.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LessonView {
    /// The error.
    pub note: TaskNote,
    /// Its moments: time since the task began, and time in the recording, s.
    pub moments: Vec<[f64; 2]>,
    /// Close picture of the first moment.
    pub close: Option<ClosePicture>,
}

/// A picture that a debrief shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosePicture {
    image: Arc<ColorImage>,
}

impl ClosePicture {
    /// Reads a PNG file. `None` if there is none, or if it is damaged.
    #[must_use]
    pub fn read(path: &Path) -> Option<Self> {
        let picture = image::open(path).ok()?.to_rgb8();
        let size = [picture.width(), picture.height()].map(|it| it as usize);
        Some(Self {
            image: Arc::new(ColorImage::from_rgb(size, picture.as_raw())),
        })
    }

    fn show(&self, ui: &mut Ui, text: &str) {
        // The texture lives as long as the interface, so it is loaded once for each picture.
        let id = Id::unique(("close picture", Arc::as_ptr(&self.image) as usize));
        let known = ui.data(|data| data.get_temp::<TextureHandle>(id));
        let texture = known.unwrap_or_else(|| {
            let loaded =
                ui.ctx()
                    .load_texture("close picture", self.image.clone(), TextureOptions::LINEAR);
            ui.data_mut(|data| data.insert_temp(id, loaded.clone()));
            loaded
        });
        let image =
            egui::Image::new(&texture).max_width(PICTURE_WIDTH_POINTS.min(ui.available_width()));
        ui.add(image.alt_text(text).corner_radius(4));
    }
}

/// Content of the lessons.
#[derive(Clone, Copy)]
pub(super) struct Lessons<'a> {
    pub(super) errors: &'a [LessonView],
    pub(super) lost: &'a [(String, f64)],
    pub(super) reasons: &'a [Reason],
    /// True if the recording is there to be replayed.
    pub(super) can_replay: bool,
}

pub(super) fn show(ui: &mut Ui, words: &Words, it: Lessons<'_>, wishes: &mut Vec<Wish>) {
    part(ui, &words.say("debrief-errors"));
    let open = it.reasons.iter().find_map(Reason::open_step);
    if it.errors.is_empty() && open.is_none() {
        line(ui, Mark::Good, &words.say("debrief-no-errors"));
    }
    for lesson in it.errors {
        one(ui, words, it.can_replay, lesson, wishes);
        ui.add_space(6.0);
    }
    if let Some(step) = open {
        let what = [("step", words.step(step).into())];
        let what = capital(&words.say_with("reason-not-done", &what));
        line(ui, Mark::Care, &what);
        let next = words.say("page-next-time");
        ui.label(format!("{next} {}", words.place(step)));
    }
    for (metric, points) in it.lost {
        let points = words.number(*points, 1).into();
        let cost = words.say_with("page-cost", &[("points", points)]);
        let text = format!("{}: {cost}", words.metric(metric));
        line(ui, Mark::Care, &text);
        next_time(
            ui,
            words,
            &format!("advice-metric-{}", metric.replace('_', "-")),
        );
    }
}

fn one(ui: &mut Ui, words: &Words, can_replay: bool, lesson: &LessonView, wishes: &mut Vec<Wish>) {
    let what = capital(&alarm(words, &lesson.note));
    let count = lesson.moments.len();
    let title = match count {
        0 | 1 => what.clone(),
        _ => {
            let count = count.to_string().into();
            format!(
                "{what}  {}",
                words.say_with("page-times", &[("count", count)])
            )
        }
    };
    let text = |ui: &mut Ui, wishes: &mut Vec<Wish>| {
        line(ui, Mark::Bad, &title);
        let advice = advice(&lesson.note.kind, lesson.note.organ.as_deref());
        next_time(ui, words, &advice);
        moments(ui, words, can_replay, lesson, wishes);
    };
    let width = ui.available_width();
    match &lesson.close {
        Some(picture) if width >= BESIDE_WIDTH_POINTS + PICTURE_WIDTH_POINTS => {
            ui.horizontal_top(|ui| {
                ui.vertical(|ui| {
                    ui.set_width(width - PICTURE_WIDTH_POINTS - 16.0);
                    text(ui, wishes);
                });
                picture.show(ui, &what);
            });
        }
        Some(picture) => {
            text(ui, wishes);
            picture.show(ui, &what);
        }
        None => text(ui, wishes),
    }
}

/// The text with a capital letter at its beginning, as a line of its own has.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

fn next_time(ui: &mut Ui, words: &Words, advice: &str) {
    let text = format!("{} {}", words.say("page-next-time"), words.say(advice));
    ui.label(RichText::new(text));
}

/// Shows the moments of an error, as buttons if they can be replayed.
fn moments(
    ui: &mut Ui,
    words: &Words,
    can_replay: bool,
    lesson: &LessonView,
    wishes: &mut Vec<Wish>,
) {
    ui.horizontal_wrapped(|ui| {
        for [at_s, session_s] in lesson.moments.iter().take(MOMENTS_MAX) {
            let at = minutes(*at_s);
            if !can_replay {
                ui.label(at);
                continue;
            }
            let text = words.say_with("debrief-replay", &[("at", at.into())]);
            if ui.button(text).clicked() {
                wishes.push(Wish::Replay(*session_s));
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_begins_with_a_capital_letter() {
        assert_eq!(capital("überrascht: liver"), "Überrascht: liver");
        assert_eq!(capital(""), "");
    }

    #[test]
    fn a_picture_that_is_none_is_left_out() {
        assert_eq!(
            ClosePicture::read(Path::new("/nowhere/close_0000.png")),
            None
        );
    }
}
