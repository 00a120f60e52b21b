//! The workspace in an oblique view. In the picture, x points to the right and y up. The axis z
//! points towards the person, and in the picture down to the left.

use egui::{Align2, Color32, FontId, Painter, Pos2, Sense, Stroke, Ui, Vec2, pos2, vec2};

use super::{Screen, View};
use crate::ui::screens::BODY_POINTS;

/// Offset in the picture, y down, of a point that is one unit nearer to the person. The offset has
/// the same unit.
const TOWARDS: Vec2 = Vec2::new(-0.5, 0.38);
/// Share of the picture's smaller side that the workspace's radius takes.
const RADIUS_SHARE: f32 = 0.36;
/// Length of a move's arrow, as a share of the radius. It is the same for moves of any length.
const MOVE_SHARE: f32 = 0.75;
/// Length of a force's arrow for each newton, as a share of the radius.
const FORCE_SHARE: f32 = 1.3;
/// Largest coordinate at which the handle is drawn, as a share of the radius.
const FAR: f32 = 1.3;

const AXIS: Color32 = Color32::from_gray(95);
const NAME: Color32 = Color32::from_gray(165);
const MOVE: Color32 = Color32::from_rgb(110, 215, 130);
const FORCE: Color32 = Color32::from_rgb(255, 160, 60);
const HANDLE: Color32 = Color32::from_rgb(120, 190, 255);

/// Middle and scale of the picture.
struct Place {
    middle: Pos2,
    radius: f32,
}

impl Place {
    /// Place in the picture of a point that is given in radii of the workspace.
    fn of(&self, [x, y, z]: [f32; 3]) -> Pos2 {
        self.middle + self.radius * (vec2(x, -y) + z * TOWARDS)
    }
}

/// Shows the picture, `height` points high.
pub(super) fn show(ui: &mut Ui, view: &View, height: f32) {
    let size = vec2(ui.available_width(), height.max(180.0));
    let (space, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(space);
    painter.rect_filled(space, 6.0, Color32::from_gray(16));
    let place = Place {
        middle: space.center(),
        radius: RADIUS_SHARE * size.x.min(size.y),
    };
    axes(&painter, &place, view);
    if view.is_secret() {
        let text = FontId::proportional(5.0 * BODY_POINTS);
        painter.text(place.middle, Align2::CENTER_CENTER, "?", text, FORCE);
        return;
    }
    if let Screen::Move { way, .. } = &view.screen {
        let end = place.of(way.vector().map(|part| part * MOVE_SHARE));
        arrow(&painter, place.middle, end, 9.0, MOVE);
    }
    let Some(at_m) = view.live.at_m else {
        return;
    };
    let at = at_m.map(|part| part / view.radius_m.max(1e-3));
    let far = at.iter().map(|it| it.abs()).fold(0.0, f32::max);
    let at = at.map(|part| part * FAR / far.max(FAR));
    handle(&painter, &place, at);
    if far > FAR {
        let text = view.words.say("feel-outside");
        let corner = space.left_top() + vec2(12.0, 8.0);
        let font = FontId::proportional(0.85 * BODY_POINTS);
        painter.text(corner, Align2::LEFT_TOP, text, font, FORCE);
    }
    let force = view.live.force_n;
    let newton = force.iter().map(|it| it * it).sum::<f32>().sqrt();
    if newton > 0.01 {
        let from = place.of(at);
        let end = from + (place.of(force.map(|it| it * FORCE_SHARE)) - place.middle);
        arrow(&painter, from, end, 6.0, FORCE);
        let font = FontId::proportional(BODY_POINTS);
        let text = format!("{newton:.1} N");
        painter.text(
            end + vec2(12.0, 4.0),
            Align2::LEFT_CENTER,
            text,
            font,
            FORCE,
        );
    }
}

/// The three axes with their names, and the edge of the workspace's horizontal middle plane.
fn axes(painter: &Painter, place: &Place, view: &View) {
    let round = (0..=48).map(|step| {
        let turn = step as f32 / 48.0 * core::f32::consts::TAU;
        place.of([turn.cos(), 0.0, turn.sin()])
    });
    let thin = Stroke::new(1.0, Color32::from_gray(55));
    painter.add(egui::Shape::line(round.collect(), thin));
    for (axis, name, at) in [
        ([1.0, 0.0, 0.0], "feel-axis-x", Align2::LEFT_TOP),
        ([0.0, 1.0, 0.0], "feel-axis-y", Align2::LEFT_TOP),
        ([0.0, 0.0, 1.0], "feel-axis-z", Align2::CENTER_TOP),
    ] {
        let end = place.of(axis);
        let back = place.of(axis.map(|it: f32| -it));
        painter.line_segment([back, place.middle], Stroke::new(1.0, AXIS));
        arrow(painter, place.middle, end, 1.5, AXIS);
        let away = match name {
            "feel-axis-x" => vec2(-24.0, 8.0),
            "feel-axis-y" => vec2(12.0, -4.0),
            _ => vec2(0.0, 8.0),
        };
        let font = FontId::proportional(0.8 * BODY_POINTS);
        painter.text(end + away, at, view.words.say(name), font, NAME);
    }
}

/// The handle, with its height over the middle plane.
fn handle(painter: &Painter, place: &Place, at: [f32; 3]) {
    let [x, _, z] = at;
    let below = place.of([x, 0.0, z]);
    let point = place.of(at);
    painter.line_segment([below, point], Stroke::new(1.5, HANDLE));
    painter.circle_stroke(below, 3.0, Stroke::new(1.5, HANDLE));
    painter.circle_filled(point, 9.0, HANDLE);
    painter.circle_stroke(point, 9.0, Stroke::new(1.5, Color32::WHITE));
}

/// An arrow whose line is `width` points wide.
fn arrow(painter: &Painter, from: Pos2, to: Pos2, width: f32, colour: Color32) {
    let way = to - from;
    let length = way.length();
    if length < 1.0 {
        return;
    }
    let along = way / length;
    let across = vec2(-along.y, along.x);
    let head = (3.0 * width + 4.0).min(length);
    let neck = to - along * head;
    painter.line_segment([from, neck], Stroke::new(width, colour));
    let side = across * (0.5 * head);
    let corners = vec![pos2(to.x, to.y), neck + side, neck - side];
    painter.add(egui::Shape::convex_polygon(corners, colour, Stroke::NONE));
}
