//! Widgets that all parts of the interface share. Every state shows by a word or a shape, never by
//! colour alone.

use egui::{CollapsingHeader, Color32, FontId, ProgressBar, Sense, Stroke, TextStyle, Ui, vec2};

/// Size of small text, points.
const FINE_TEXT_POINTS: f32 = 13.5;

pub(super) const GOOD: Color32 = Color32::from_rgb(120, 205, 130);
pub(super) const CARE: Color32 = Color32::from_rgb(240, 190, 80);
pub(super) const BAD: Color32 = Color32::from_rgb(245, 115, 105);

/// State of a thing. Each state has a mark of its own shape and colour.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Mark {
    Good,
    Care,
    Bad,
    Off,
}

/// A bar that is filled to this share. An empty bar has no colour: egui would draw a dot.
pub(super) fn bar(share: f32) -> ProgressBar {
    let is_empty = share <= 0.0;
    let fill = if is_empty { Color32::TRANSPARENT } else { GOOD };
    ProgressBar::new(share).fill(fill)
}

/// Sets the size of text, and matching sizes of headings and buttons.
pub(super) fn sized(ui: &mut Ui, points: f32) {
    let styles = &mut ui.style_mut().text_styles;
    for (name, share) in [
        (TextStyle::Body, 1.0),
        (TextStyle::Button, 0.95),
        (TextStyle::Heading, 1.25),
    ] {
        styles.insert(name, FontId::proportional(share * points));
    }
    styles.insert(TextStyle::Monospace, FontId::monospace(points));
}

/// Adds widgets with small text, for the technical state of the station, which a trainee can
/// ignore.
pub(super) fn fine(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.scope(|ui| {
        sized(ui, FINE_TEXT_POINTS);
        add(ui);
    });
}

/// Adds a line: the mark of a state, and words.
pub(super) fn line(ui: &mut Ui, mark: Mark, text: &str) {
    ui.horizontal_wrapped(|ui| {
        sign(ui, mark);
        ui.label(text);
    });
}

/// Adds a heading whose click shows or hides more widgets. The heading is wrapped here, because a
/// [`CollapsingHeader`] does not wrap.
pub(super) fn folded(ui: &mut Ui, id: &'static str, title: String, add: impl FnOnce(&mut Ui)) {
    let font = TextStyle::Button.resolve(ui.style());
    let spacing = ui.spacing();
    let width = ui.available_width() - spacing.indent - 2.0 * spacing.button_padding.x;
    let galley = ui.painter().layout(title, font, Color32::WHITE, width);
    let rows: Vec<String> = galley.rows.iter().map(|row| row.text()).collect();
    let rows: Vec<&str> = rows.iter().map(|row| row.trim_end()).collect();
    CollapsingHeader::new(rows.join("\n"))
        .id_salt(id)
        .show(ui, add);
}

/// Adds the mark of a state alone.
pub(super) fn sign(ui: &mut Ui, mark: Mark) {
    let (space, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
    let (at, painter) = (space.center(), ui.painter());
    match mark {
        Mark::Good => {
            painter.circle_filled(at, 5.0, GOOD);
        }
        Mark::Care => {
            let corners = [vec2(0.0, -6.0), vec2(6.0, 5.0), vec2(-6.0, 5.0)];
            let corners = corners.map(|corner| at + corner).to_vec();
            painter.add(egui::Shape::convex_polygon(corners, CARE, Stroke::NONE));
        }
        Mark::Bad => {
            for end in [vec2(5.0, 5.0), vec2(5.0, -5.0)] {
                painter.line_segment([at - end, at + end], Stroke::new(3.0, BAD));
            }
        }
        Mark::Off => {
            painter.circle_stroke(at, 4.5, Stroke::new(1.5, Color32::GRAY));
        }
    }
}
