//! Position, velocity and force, live.

use egui::{Grid, RichText, Ui};

use super::View;
use crate::ui::screens::BODY;

/// Shows the numbers. A secret direction hides them.
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
        .min_col_width(70.0)
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
        });
}

fn right(ui: &mut Ui, text: RichText) {
    let place = egui::Layout::right_to_left(egui::Align::Center);
    ui.with_layout(place, |ui| ui.label(text));
}
