//! The instructor's mark in the picture, and a note of each act beside it.

use egui::{Color32, Rect, RichText, Stroke, Ui, vec2};

use super::super::{UiState, acts};
use super::hud;

/// Radius of the mark, points.
const RADIUS: f32 = 20.0;
/// Length of its four strokes, points.
const STROKE: f32 = 12.0;
/// Largest width of the note, points.
const NOTE: f32 = 230.0;
/// Size of its text, points.
const TEXT: f32 = 18.0;

pub(super) fn show(ui: &Ui, place: Rect, state: &UiState) {
    if let Some(at) = state.act_mark {
        let unit = 0.5 * place.height();
        let middle = place.center() + vec2(at.x, -at.y) * unit;
        let painter = ui.painter().with_clip_rect(place);
        // White over a wider black line is visible on any tissue.
        for (colour, width) in [(Color32::BLACK, 6.0), (Color32::WHITE, 3.0)] {
            let stroke = Stroke::new(width, colour);
            painter.circle_stroke(middle, RADIUS, stroke);
            for way in [
                vec2(1.0, 0.0),
                vec2(-1.0, 0.0),
                vec2(0.0, 1.0),
                vec2(0.0, -1.0),
            ] {
                let ends = [middle + way * RADIUS, middle + way * (RADIUS + STROKE)];
                painter.line_segment(ends, stroke);
            }
        }
    }
    let Some((kind, remark)) = &state.acts.notice else {
        return;
    };
    let words = &state.words;
    hud::card(ui, "act", place, hud::side(place), |ui| {
        ui.set_max_width(NOTE.min(place.width() - 48.0));
        ui.label(RichText::new(words.say("act-by")).size(0.8 * TEXT));
        let text = remark
            .clone()
            .unwrap_or_else(|| words.say(&acts::message(*kind)));
        ui.label(RichText::new(text).size(TEXT).strong());
    });
}
