//! Present position, velocity and force as numbers.

use egui::{Align, Grid, Layout, RichText, Ui, vec2};

use super::View;
use crate::ui::screens::BODY;

/// Width of a column of numbers, points.
const COLUMN: f32 = 96.0;

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
    Grid::new("numbers")
        .num_columns(4)
        .min_col_width(COLUMN)
        .spacing([14.0, 4.0])
        .show(ui, |ui| {
            ui.label("");
            for axis in ["feel-x", "feel-y", "feel-z"] {
                right(ui, RichText::new(words.say(axis)).size(0.75 * BODY));
            }
            ui.end_row();
            for (name, parts) in rows {
                ui.label(RichText::new(words.say(name)).size(0.85 * BODY));
                match parts {
                    _ if hidden => {
                        ui.label(RichText::new(words.say("feel-hidden")).size(0.85 * BODY));
                    }
                    None => {
                        ui.label(RichText::new(words.say("feel-none")).size(0.85 * BODY));
                    }
                    Some(parts) => {
                        for part in parts {
                            right(ui, RichText::new(part).monospace().size(0.95 * BODY));
                        }
                    }
                }
                ui.end_row();
            }
            if view.opens {
                opening(ui, view);
            }
        });
}

/// Opening of the handle, and the force that opens it.
fn opening(ui: &mut Ui, view: &View) {
    let (words, live) = (&view.words, &view.live);
    let percent = live.opening.map(|it| format!("{:.0}", it * 100.0));
    let rows = [
        ("feel-opening", percent),
        (
            "feel-opening-force",
            Some(format!("{:+.2}", live.opening_n)),
        ),
    ];
    for (name, number) in rows {
        ui.label(RichText::new(words.say(name)).size(0.85 * BODY));
        match number {
            _ if view.is_secret() => ui.label(words.say("feel-hidden")),
            None => ui.label(words.say("feel-none")),
            Some(number) => {
                right(ui, RichText::new(number).monospace().size(0.95 * BODY));
                ui.label("")
            }
        };
        ui.end_row();
    }
}

/// Shows a number at the right of its column, or the column's name.
fn right(ui: &mut Ui, text: RichText) {
    let place = Layout::right_to_left(Align::Center);
    let size = vec2(COLUMN, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, place, |ui| ui.label(text));
}
