//! Arrow at the rim of the endoscope's picture towards an instrument that is out of view.

use egui::{Color32, Context, Id, LayerId, Order, Pos2, Rect, Shape, Stroke, vec2};
use glam::Vec3;
use shared_mem::message::{CapsuleMsg, ToolFrame};
use shared_mem::words::CapsuleRole;

use crate::render::camera::Scope;

/// Distance of the arrow from the picture's middle, as a share of half the picture's height.
const AT: f32 = 0.74;
/// Length of the arrow, as a share of half the picture's height.
const LENGTH: f32 = 0.14;

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

/// Draws the arrow over the picture and its cards.
pub(super) fn paint(context: &Context, picture: Rect, [right, up]: [f32; 2]) {
    let layer = LayerId::new(Order::Foreground, Id::unique("arrow to the instrument"));
    let painter = context.layer_painter(layer);
    let unit = 0.5 * picture.height();
    let along = vec2(right, -up);
    let aside = vec2(along.y, -along.x);
    let head = picture.center() + along * unit * (AT + LENGTH);
    let corner = |side: f32| -> Pos2 {
        picture.center() + along * unit * AT + aside * side * 0.5 * LENGTH * unit
    };
    let corners = vec![head, corner(1.0), corner(-1.0)];
    // White with a dark edge stands out from any tissue.
    let edge = Stroke::new(2.5, Color32::BLACK);
    painter.add(Shape::convex_polygon(corners, Color32::WHITE, edge));
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
