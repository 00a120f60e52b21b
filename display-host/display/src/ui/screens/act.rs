//! The instructor's mark in the picture, and a note of each act beside it.

use egui::{Align2, Color32, Pos2, Rect, RichText, Stroke, Ui, vec2};

use super::super::{UiState, acts};
use super::hud;

/// Radius of the mark, points.
const RADIUS_POINTS: f32 = 20.0;
/// Length of the mark's four strokes, points.
const STROKE_POINTS: f32 = 12.0;
/// Largest width of the note, points.
const NOTE_WIDTH_POINTS: f32 = 230.0;
/// Size of the note's text, points.
const TEXT_POINTS: f32 = 18.0;
/// Size of the note's text in a tight picture, points.
const TIGHT_TEXT_POINTS: f32 = 15.0;

pub(super) fn show(ui: &Ui, place: Rect, state: &UiState) {
    if let Some(at) = state.act_mark {
        let middle = on(place, at);
        let painter = ui.painter().with_clip_rect(place);
        // White over a wider black line is visible on any tissue.
        for (colour, width) in [(Color32::BLACK, 6.0), (Color32::WHITE, 3.0)] {
            let stroke = Stroke::new(width, colour);
            painter.circle_stroke(middle, RADIUS_POINTS, stroke);
            for way in [
                vec2(1.0, 0.0),
                vec2(-1.0, 0.0),
                vec2(0.0, 1.0),
                vec2(0.0, -1.0),
            ] {
                let ends = [
                    middle + way * RADIUS_POINTS,
                    middle + way * (RADIUS_POINTS + STROKE_POINTS),
                ];
                painter.line_segment(ends, stroke);
            }
        }
    }
    let Some((kind, remark)) = &state.acts.notice else {
        return;
    };
    let words = &state.words;
    let ((room, side), size) = match hud::is_tight(place) {
        true => (
            (hud::tall(ui, place), Align2::CENTER_BOTTOM),
            TIGHT_TEXT_POINTS,
        ),
        false => (
            beside(place, state.act_mark.map(|at| on(place, at))),
            TEXT_POINTS,
        ),
    };
    hud::card(ui, "act", room, side, |ui| {
        ui.set_max_width(NOTE_WIDTH_POINTS.min(place.width() - 48.0));
        ui.label(RichText::new(words.say("act-by")).size(0.8 * size));
        let text = remark
            .clone()
            .unwrap_or_else(|| words.say(&acts::message(*kind)));
        ui.label(RichText::new(text).size(size).strong());
    });
}

/// Place of the picture, which is given in half heights from its middle, y up.
fn on(place: Rect, at: glam::Vec2) -> Pos2 {
    place.center() + vec2(at.x, -at.y) * (0.5 * place.height())
}

/// Room for the note and its corner there. The note stays above or below a mark on its side of the
/// picture, on the side with more room.
fn beside(place: Rect, mark: Option<Pos2>) -> (Rect, Align2) {
    let reach = RADIUS_POINTS + STROKE_POINTS;
    let is_near = |mark: &Pos2| mark.x + reach > place.right() - NOTE_WIDTH_POINTS - 48.0;
    match mark.filter(is_near) {
        None => (place, hud::side(place)),
        Some(mark) if mark.y < place.center().y => {
            let room = place.with_min_y((mark.y + reach).max(place.top()));
            (room, Align2::RIGHT_TOP)
        }
        Some(mark) => {
            let room = place.with_max_y((mark.y - reach).min(place.bottom()));
            (room, Align2::RIGHT_BOTTOM)
        }
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn the_note_leaves_the_mark_free() {
        let place = Rect::from_min_size(pos2(0.0, 0.0), vec2(560.0, 420.0));
        assert_eq!(beside(place, None), (place, hud::side(place)));
        let left = pos2(100.0, 200.0);
        assert_eq!(beside(place, Some(left)).0, place);
        for mark in [pos2(500.0, 100.0), pos2(330.0, 209.0), pos2(500.0, 300.0)] {
            let (room, _) = beside(place, Some(mark));
            let around = Rect::from_center_size(
                mark,
                vec2(1.0, 1.0) * 2.0 * (RADIUS_POINTS + STROKE_POINTS - 1.0),
            );
            assert!(!room.intersects(around), "{room:?}");
            assert!(room.height() > 0.4 * place.height(), "{room:?}");
        }
    }
}
