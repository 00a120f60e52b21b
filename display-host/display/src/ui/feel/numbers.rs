//! Present position, velocity and force as numbers.

use egui::{Align, Grid, Layout, RichText, Ui, vec2};

use super::View;
use crate::ui::screens::BODY_POINTS;
use crate::words::Words;

/// Width of a column of numbers, points.
const COLUMN_POINTS: f32 = 96.0;
/// Space between columns, points.
const SPACE_POINTS: f32 = 14.0;
/// Smallest width at which the names of the rows are beside the numbers, points.
const BESIDE_WIDTH_POINTS: f32 = 560.0;

/// Shows the numbers, or hides them while the person must feel the direction.
pub(super) fn show(ui: &mut Ui, view: &View) {
    let words = &view.words;
    let live = &view.live;
    let hidden = view.is_secret();
    let scaled = |vector: [f32; 3], by: f32, digits: usize| {
        vector.map(|part| format!("{:+.digits$}", part * by))
    };
    let rows = [
        ("feel-position", live.at_m.map(|it| scaled(it, 1e3, 1))),
        (
            "feel-velocity",
            live.velocity_m_s.map(|it| scaled(it, 1e3, 0)),
        ),
        ("feel-force", Some(scaled(live.force_n, 1.0, 2))),
    ];
    let mut rows: Vec<(&str, Vec<RichText>)> = rows
        .map(|(name, parts)| {
            let shown = match parts {
                _ if hidden => vec![other(words, "feel-hidden")],
                None => vec![other(words, "feel-none")],
                Some(parts) => parts.map(number).into(),
            };
            (name, shown)
        })
        .into();
    if view.opens {
        rows.extend(opening(view));
    }
    let axes = ["feel-x", "feel-y", "feel-z"];
    let axes = axes.map(|axis| RichText::new(words.say(axis)).size(0.75 * BODY_POINTS));
    // In a narrow window, the name of a row is above its numbers.
    if ui.available_width() < BESIDE_WIDTH_POINTS {
        line(ui, axes.into());
        for (name, parts) in rows {
            ui.label(RichText::new(words.say(name)).size(0.85 * BODY_POINTS));
            line(ui, parts);
        }
        return;
    }
    Grid::new("numbers")
        .num_columns(4)
        .min_col_width(COLUMN_POINTS)
        .spacing([SPACE_POINTS, 4.0])
        .show(ui, |ui| {
            ui.label("");
            cells(ui, axes.into());
            ui.end_row();
            for (name, parts) in rows {
                ui.label(RichText::new(words.say(name)).size(0.85 * BODY_POINTS));
                cells(ui, parts);
                ui.end_row();
            }
        });
}

/// Opening of the handle, and the force that opens it.
fn opening(view: &View) -> [(&'static str, Vec<RichText>); 2] {
    let (words, live) = (&view.words, &view.live);
    let percent = live.opening.map(|it| format!("{:.0}", it * 100.0));
    let force = Some(format!("{:+.2}", live.opening_n));
    [("feel-opening", percent), ("feel-opening-force", force)].map(|(name, value)| {
        let shown = match value {
            _ if view.is_secret() => other(words, "feel-hidden"),
            None => other(words, "feel-none"),
            Some(value) => number(value),
        };
        (name, vec![shown])
    })
}

fn number(text: String) -> RichText {
    RichText::new(text).monospace().size(0.95 * BODY_POINTS)
}

/// Words in place of numbers.
fn other(words: &Words, id: &str) -> RichText {
    RichText::new(words.say(id)).size(0.85 * BODY_POINTS)
}

/// Shows a row without its name.
fn line(ui: &mut Ui, parts: Vec<RichText>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = SPACE_POINTS;
        cells(ui, parts);
    });
}

fn cells(ui: &mut Ui, parts: Vec<RichText>) {
    for part in parts {
        right(ui, part);
    }
}

/// Shows a number at the right of its column, or the column's name.
fn right(ui: &mut Ui, text: RichText) {
    let place = Layout::right_to_left(Align::Center);
    let size = vec2(COLUMN_POINTS, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, place, |ui| ui.label(text));
}
