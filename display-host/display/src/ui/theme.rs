//! Colours of the interface, with contrasts after WCAG 2.2: text at least 4.5 to 1 (AA), in high
//! contrast at least 7 to 1 (AAA); marks and edges of controls at least 3 to 1.

use egui::{Color32, Context, Stroke, Visuals};

/// Colours of a theme.
#[derive(Debug, Clone, Copy)]
struct Palette {
    ground: Color32,
    field: Color32,
    button: Color32,
    text: Color32,
    weak: Color32,
    edge: Color32,
    focus: Color32,
    chosen: Color32,
    stripe: Color32,
}

const USUAL: Palette = Palette {
    ground: Color32::from_gray(27),
    field: Color32::from_gray(14),
    button: Color32::from_gray(56),
    text: Color32::from_gray(226),
    weak: Color32::from_gray(178),
    edge: Color32::from_gray(140),
    focus: Color32::from_rgb(255, 205, 90),
    chosen: Color32::from_rgb(0, 84, 130),
    stripe: Color32::from_gray(38),
};

const HIGH: Palette = Palette {
    ground: Color32::BLACK,
    field: Color32::BLACK,
    button: Color32::BLACK,
    text: Color32::WHITE,
    weak: Color32::from_gray(225),
    edge: Color32::WHITE,
    focus: Color32::from_rgb(255, 225, 60),
    chosen: Color32::from_rgb(0, 60, 110),
    stripe: Color32::from_gray(24),
};

/// Sets the colours of the whole interface.
pub(super) fn apply(context: &Context, high_contrast: bool) {
    let palette = if high_contrast { HIGH } else { USUAL };
    let mut visuals = Visuals::dark();
    paint(&mut visuals, palette);
    context.set_visuals(visuals);
}

fn paint(visuals: &mut Visuals, it: Palette) {
    (visuals.panel_fill, visuals.window_fill) = (it.ground, it.ground);
    (visuals.extreme_bg_color, visuals.faint_bg_color) = (it.field, it.stripe);
    visuals.weak_text_color = Some(it.weak);
    visuals.selection.bg_fill = it.chosen;
    visuals.selection.stroke = Stroke::new(1.5, Color32::WHITE);
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, it.text);
    for widget in [
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        (widget.bg_fill, widget.weak_bg_fill) = (it.button, it.button);
        widget.bg_stroke = Stroke::new(1.0, it.edge);
        widget.fg_stroke = Stroke::new(1.5, it.text);
    }
    for widget in [&mut widgets.hovered, &mut widgets.active] {
        widget.bg_stroke = Stroke::new(2.0, it.focus);
    }
}

#[cfg(test)]
mod tests {
    use super::super::widgets::{BAD, CARE, GOOD};
    use super::*;

    /// Relative luminance after WCAG 2.2.
    fn luminance(colour: Color32) -> f64 {
        let linear = |value: u8| {
            let share = f64::from(value) / 255.0;
            match share <= 0.04045 {
                true => share / 12.92,
                false => ((share + 0.055) / 1.055).powf(2.4),
            }
        };
        let [r, g, b] = [colour.r(), colour.g(), colour.b()].map(linear);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    fn contrast(one: Color32, other: Color32) -> f64 {
        let [a, b] = [one, other].map(luminance);
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn contrast_is_that_of_the_standard() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9);
        // WCAG's own examples name this grey as just enough on white.
        let grey = Color32::from_gray(0x76);
        assert!((contrast(grey, Color32::WHITE) - 4.54).abs() < 0.01);
    }

    #[test]
    fn text_and_marks_have_enough_contrast_in_both_themes() {
        for (it, least) in [(USUAL, 4.5), (HIGH, 7.0)] {
            for ground in [it.ground, it.field, it.button, it.chosen, it.stripe] {
                let found = contrast(it.text, ground);
                assert!(found >= least, "text on {ground:?}: {found}");
            }
            for ground in [it.ground, it.stripe] {
                let found = contrast(it.weak, ground);
                assert!(found >= least, "weak text on {ground:?}: {found}");
                for mark in [GOOD, CARE, BAD, it.edge, it.focus] {
                    let found = contrast(mark, ground);
                    assert!(found >= 3.0, "{mark:?} on {ground:?}: {found}");
                }
            }
        }
    }

    #[test]
    fn boxes_with_a_colour_of_their_own_have_white_text_that_is_legible() {
        for ground in [
            Color32::from_rgb(25, 95, 60),
            Color32::from_rgb(120, 20, 20),
        ] {
            let found = contrast(Color32::WHITE, ground);
            assert!(found >= 7.0, "{ground:?}: {found}");
        }
    }
}
