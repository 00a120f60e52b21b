//! Arrow at the rim of the endoscope's picture towards an instrument that is out of view.

use egui::{Align2, Color32, FontId, Id, LayerId, Order, Pos2, Rect, Shape, Stroke, Ui, vec2};
use glam::Vec3;
use shared_mem::message::{CapsuleMsg, ToolFrame};
use shared_mem::words::CapsuleRole;

use crate::render::camera::Scope;

/// Distance of the arrow from the picture's middle, as a share of half the picture's height.
const AT: f32 = 0.74;
/// Length of the arrow, as a share of half the picture's height.
const LENGTH: f32 = 0.18;
/// Length and width of the arrow's head, as shares of half the picture's height. The head is longer
/// than wide, so that its direction is seen at a glance.
const HEAD: [f32; 2] = [0.11, 0.08];
/// Widths of the arrow's shaft and of its dark edge, points.
const SHAFT_POINTS: f32 = 5.0;
const EDGE_POINTS: f32 = 1.5;
/// Size of the instrument's name behind the arrow, and its distance from the arrow, points.
const NAME_POINTS: f32 = 16.0;
const NAME_GAP_POINTS: f32 = 10.0;
/// Step by which the arrow moves towards the picture's middle until no card covers it, and the
/// largest number of steps.
const STEP: f32 = 0.06;
const STEPS: u8 = 8;
/// Cards over the picture.
const CARDS: [&str; 4] = ["hud", "hud foot", "hud alarm", "act"];

/// Direction in the picture (right, up) towards the instrument's tips. `None` if the tips are in
/// view or unknown.
#[must_use]
pub(crate) fn towards_tip(tools: &ToolFrame, scope: &Scope) -> Option<[f32; 2]> {
    let camera = scope.world_from_view(tools).inverse();
    let tips = tools.capsules()?.iter().filter(|it| is_tip(it));
    let (sum, count) = tips.fold((Vec3::ZERO, 0.0f32), |(sum, count), it| {
        (sum + Vec3::from(it.b_m), count + 1.0)
    });
    if count < 1.0 {
        return None;
    }
    let at = camera.transform_point3(sum / count);
    // The circle of the view is higher than the picture.
    let is_seen = scope.project(at).is_some_and(|it| it.y.abs() <= 1.0);
    if !at.is_finite() || is_seen {
        return None;
    }
    let off = glam::Vec2::new(at.x, at.y).try_normalize()?;
    Some(off.to_array())
}

fn is_tip(capsule: &CapsuleMsg) -> bool {
    [
        CapsuleRole::Tip,
        CapsuleRole::UpperJaw,
        CapsuleRole::LowerJaw,
    ]
    .into_iter()
    .any(|role| capsule.is(role))
}

/// Draws the arrow over the picture, below the cards and beside them. The instrument's name stands
/// behind it, so that nobody takes it for the mouse's pointer.
pub(super) fn paint(ui: &Ui, picture: Rect, [right, up]: [f32; 2], name: Option<&str>) {
    let painter = ui.painter().with_clip_rect(picture);
    let unit = 0.5 * picture.height();
    let along = vec2(right, -up);
    let aside = vec2(along.y, -along.x);
    let cards = cards(ui);
    let ends = |at: f32| [at, at + LENGTH].map(|it| picture.center() + along * unit * it);
    let is_free = |at: &f32| {
        let room = Rect::from_points(&ends(*at)).expand(0.5 * HEAD[1] * unit);
        !cards.iter().any(|card| card.intersects(room))
    };
    let places = (0..=STEPS).map(|step| AT - STEP * f32::from(step));
    let [tail, head] = ends(places.into_iter().find(is_free).unwrap_or(AT));
    let neck = head - along * HEAD[0] * unit;
    let corner = |side: f32| -> Pos2 { neck + aside * side * 0.5 * HEAD[1] * unit };
    let corners = vec![head, corner(1.0), corner(-1.0)];
    // White with a dark edge stands out from any tissue.
    for (colour, edge) in [(Color32::BLACK, EDGE_POINTS), (Color32::WHITE, 0.0)] {
        let width = SHAFT_POINTS + 2.0 * edge;
        painter.line_segment([tail, neck], Stroke::new(width, colour));
        let edge = Stroke::new(2.0 * edge, Color32::BLACK);
        painter.add(Shape::convex_polygon(corners.clone(), colour, edge));
    }
    if let Some(name) = name {
        let font = FontId::proportional(NAME_POINTS);
        let galley = painter.layout_no_wrap(name.to_owned(), font, Color32::WHITE);
        let half = 0.5 * galley.size();
        // The half of the text that lies along the arrow's direction.
        let reach = half.x * along.x.abs() + half.y * along.y.abs();
        let middle = tail - along * (NAME_GAP_POINTS + reach);
        let at = Align2::CENTER_CENTER.anchor_size(middle, galley.size());
        painter.rect_filled(at.expand(4.0), 4.0, Color32::from_black_alpha(190));
        painter.galley(at.min, galley, Color32::WHITE);
    }
}

/// Rectangles of the cards over the picture.
fn cards(ui: &Ui) -> Vec<Rect> {
    ui.memory(|memory| {
        let seen = CARDS.into_iter().filter_map(|name| {
            let id = Id::unique(name);
            let layer = LayerId::new(Order::Middle, id);
            let is_seen = memory.areas().visible_last_frame(&layer);
            memory.area_rect(id).filter(|_| is_seen)
        });
        seen.collect()
    })
}

#[cfg(test)]
mod tests {
    use shared_mem::message::PoseMsg;

    use super::*;

    fn tools(tip_m: [f32; 3]) -> ToolFrame {
        let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
        for pose in [
            &mut tools.world_from_handle,
            &mut tools.world_from_instrument,
            &mut tools.world_from_camera,
        ] {
            *pose = PoseMsg::IDENTITY;
        }
        tools.capsule_count = 1;
        tools.capsules[0] = CapsuleMsg {
            role: 3,
            b_m: tip_m,
            ..bytemuck::Zeroable::zeroed()
        };
        tools
    }

    #[test]
    fn the_arrow_points_to_a_tip_that_the_picture_does_not_show() {
        let scope = Scope::default();
        let towards = |tip_m| towards_tip(&tools(tip_m), &scope);
        assert_eq!(towards([0.0, 0.0, -0.1]), None, "it is in view");
        for (tip_m, direction) in [
            ([0.2, 0.0, -0.05], [1.0, 0.0]),
            ([0.0, -0.2, -0.05], [0.0, -1.0]),
            ([0.0, 0.066, -0.1], [0.0, 1.0]),
            ([-0.03, 0.0, 0.1], [-1.0, 0.0]),
        ] {
            assert_eq!(towards(tip_m), Some(direction), "{tip_m:?}");
        }
        let nobody = ToolFrame {
            capsule_count: 0,
            ..tools([0.2, 0.0, -0.05])
        };
        assert_eq!(towards_tip(&nobody, &scope), None, "no tool is known");
    }
}
