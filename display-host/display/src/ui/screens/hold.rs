//! Display of a running hold. A reticle is in the middle of the picture, and a ring around it fills
//! while the hold lasts. A text names the thing that the picture lacks.

use egui::{Align2, Color32, FontId, Pos2, Rect, Shape, Stroke, Ui, pos2, vec2};

use super::super::UiState;
use super::hud;

/// Radius of the ring, as a share of the picture's height.
const RING: f32 = 0.17;
/// Widths of lines, points. The white ring's line is the first width less 1.5. The line of the
/// ring's filled part is the second.
const LINE_WIDTHS_POINTS: [f32; 2] = [3.0, 6.0];
/// Half of the gap in the reticle, points.
const HALF_GAP_POINTS: f32 = 6.0;
/// Length of the reticle's arms, points.
const ARM_POINTS: f32 = 16.0;
/// Size of the text, points.
const TEXT_POINTS: f32 = 18.0;
/// Corners of a full ring.
const CORNERS: f32 = 96.0;

pub(super) fn show(ui: &Ui, place: Rect, state: &UiState) {
    let task = state.task_view.as_ref().filter(|it| it.end.is_none());
    let Some(hold) = task.and_then(|it| it.hold.as_ref()) else {
        return;
    };
    let painter = ui.painter().with_clip_rect(place);
    let (middle, radius) = (place.center(), RING * place.height());
    // White over a wider dark line is visible on any tissue.
    for (colour, more) in [(Color32::from_black_alpha(170), 2.0), (Color32::WHITE, 0.0)] {
        for way in [
            vec2(1.0, 0.0),
            vec2(-1.0, 0.0),
            vec2(0.0, 1.0),
            vec2(0.0, -1.0),
        ] {
            let ends = [
                middle + way * HALF_GAP_POINTS,
                middle + way * (HALF_GAP_POINTS + ARM_POINTS),
            ];
            painter.line_segment(ends, Stroke::new(1.5 + more, colour));
        }
        painter.circle_stroke(
            middle,
            radius,
            Stroke::new(LINE_WIDTHS_POINTS[0] - 1.5 + more, colour),
        );
    }
    let filled = arc(middle, radius, hold.share as f32);
    painter.add(Shape::line(
        filled,
        Stroke::new(LINE_WIDTHS_POINTS[1], Color32::from_rgb(90, 230, 140)),
    ));
    // A tight picture has no room below the ring; there the card at its foot has this text.
    if hud::is_tight(place) {
        return;
    }
    let text = state.words.hold(hold);
    let keys = state.words.hold_keys(hold).filter(|_| state.in_hand);
    let text = keys.map_or(text.clone(), |keys| format!("{text} ({keys})"));
    let font = FontId::proportional(TEXT_POINTS);
    let galley = painter.layout(text, font, Color32::WHITE, (place.width() - 40.0).max(40.0));
    let at = Align2::CENTER_TOP.anchor_size(middle + vec2(0.0, radius + 10.0), galley.size());
    painter.rect_filled(at.expand(5.0), 4.0, Color32::from_black_alpha(190));
    painter.galley(at.min, galley, Color32::WHITE);
}

/// Part of a circle, clockwise from its top.
fn arc(middle: Pos2, radius: f32, share: f32) -> Vec<Pos2> {
    let corners = (CORNERS * share.clamp(0.0, 1.0)).ceil() as u32;
    let corner = |number: u32| {
        let turn = share * number as f32 / corners.max(1) as f32 * core::f32::consts::TAU;
        pos2(
            middle.x + radius * turn.sin(),
            middle.y - radius * turn.cos(),
        )
    };
    (0..=corners).map(corner).collect()
}
