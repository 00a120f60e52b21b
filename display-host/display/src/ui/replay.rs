//! Panel of a replay: position, and navigation.

use egui::{Key, RichText, Slider, Ui};

use super::acts::message;
use super::task::minutes;
use super::widgets::CARE;
use super::{Asked, FreeView, UiState};

/// Steps of the keys and buttons, s.
const STEPS_S: [i32; 4] = [-10, -1, 1, 10];
/// Time by which a replay begins before an act, s.
const BEFORE_S: f64 = 1.0;
/// Speeds to choose from, in thousandths of the recorded one.
const SPEEDS: [u32; 5] = [100, 250, 500, 1000, 2000];

/// State of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReplayView {
    /// Time in the session, s.
    pub at_s: f64,
    /// Length of the session, s; 0: not known yet.
    pub length_s: f64,
    /// Speed relative to the recorded one.
    pub speed: f64,
    /// Target of a running seek, s.
    pub seeks_s: Option<f64>,
}

impl ReplayView {
    /// Request to go to the moment that is `by_s` later.
    fn moved(&self, by_s: f64) -> Asked {
        let from_s = self.seeks_s.unwrap_or(self.at_s);
        seek((from_s + by_s).clamp(0.0, self.end_s()))
    }

    fn end_s(&self) -> f64 {
        self.length_s.max(self.at_s)
    }
}

fn seek(at_s: f64) -> Asked {
    Asked::Seek((at_s * 1e3).round().clamp(0.0, f64::from(u32::MAX)) as u32)
}

/// Shows the controls of a replay.
pub(super) fn show(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let Some(view) = &state.replay else { return };
    let words = &state.words;
    let time = |s: f64| {
        let text = format!("{}:{:04.1}", (s / 60.0).floor(), s.rem_euclid(60.0));
        words.localised(text)
    };
    let values = [
        ("at", time(view.at_s).into()),
        ("length", time(view.end_s()).into()),
    ];
    ui.label(words.say_with("replay-at", &values));
    ui.label(RichText::new(words.say("replay-clock")).weak());
    // A dragged slider stays under the pointer. The session follows once the slider is released.
    let held = ui.scope_id().with("replay-slider");
    let dragged: Option<f64> = ui.data(|it| it.get_temp(held));
    let mut at_s = dragged.or(view.seeks_s).unwrap_or(view.at_s);
    ui.spacing_mut().slider_width = ui.available_width() - 70.0;
    let slider = Slider::new(&mut at_s, 0.0..=view.end_s().max(0.1))
        .suffix(" s")
        .fixed_decimals(1);
    let slider = ui.add(slider);
    let name = words.say("replay-slider");
    marks(ui, slider.rect, state, view.end_s());
    slider.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, &name));
    if slider.dragged() {
        ui.data_mut(|it| it.insert_temp(held, at_s));
    } else if dragged.is_some() || slider.changed() {
        ui.data_mut(|it| it.remove::<f64>(held));
        asked.push(seek(at_s));
    }
    ui.horizontal_wrapped(|ui| {
        for step_s in STEPS_S {
            let step = format!("{step_s:+}").into();
            let text = words.say_with("replay-step", &[("step", step)]);
            if ui.button(text).clicked() {
                asked.push(view.moved(f64::from(step_s)));
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        for speed in SPEEDS {
            let times = f64::from(speed) / 1e3;
            let text = words.say_with(
                "replay-speed",
                &[("speed", words.localised(times.to_string()).into())],
            );
            let is_it = (view.speed - times).abs() < 1e-6;
            if ui.selectable_label(is_it, text).clicked() {
                asked.push(Asked::Speed(speed));
            }
        }
    });
    acts(ui, state, asked);
    if let Some(to) = view.seeks_s {
        let values = [("at", time(view.at_s).into()), ("to", time(to).into())];
        ui.label(words.say_with("replay-seeks", &values));
    }
    ui.horizontal_wrapped(|ui| {
        let free = words.say("replay-free");
        if ui.selectable_label(state.is_view_free, free).clicked() {
            asked.push(Asked::FreeView(!state.is_view_free));
        }
    });
    ui.label(words.say("replay-free-help"));
    ui.separator();
}

/// Marks the instructor's acts under the slider.
fn marks(ui: &Ui, slider: egui::Rect, state: &UiState, end_s: f64) {
    // The ends of the way of the slider's handle. The number stands to the right of the way.
    let half = 0.5 * slider.height();
    let width = (ui.spacing().slider_width - 2.0 * half).max(0.0);
    for (at_s, _) in &state.acts.all {
        let share = (at_s / end_s.max(0.1)).clamp(0.0, 1.0) as f32;
        let x = slider.left() + half + share * width;
        let ends = [slider.bottom() - 4.0, slider.bottom() + 2.0].map(|y| egui::pos2(x, y));
        ui.painter()
            .line_segment(ends, egui::Stroke::new(3.0, CARE));
    }
}

/// Lists the instructor's acts. Each goes to its moment.
fn acts(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    if state.acts.all.is_empty() {
        return;
    }
    ui.label(words.say("page-acts"));
    ui.horizontal_wrapped(|ui| {
        for (at_s, kind) in &state.acts.all {
            let what = words.say(&message(*kind));
            if ui.button(format!("{}  {what}", minutes(*at_s))).clicked() {
                asked.push(seek((at_s - BEFORE_S).max(0.0)));
            }
        }
    });
}

/// Requests by keys in a replay.
pub(super) fn keys(ui: &Ui, state: &UiState) -> Vec<Asked> {
    let Some(view) = &state.replay else {
        return Vec::new();
    };
    let table = [
        (Key::ArrowLeft, view.moved(-1.0)),
        (Key::ArrowRight, view.moved(1.0)),
        (Key::PageUp, view.moved(-10.0)),
        (Key::PageDown, view.moved(10.0)),
        (Key::Home, seek(0.0)),
        (Key::C, Asked::FreeView(!state.is_view_free)),
    ];
    // A focused widget takes the arrow keys itself.
    let is_taken = ui.memory(|it| it.focused().is_some());
    let pressed = |key: Key| ui.input(|input| input.key_pressed(key));
    let mut asked = Vec::new();
    for (key, what) in table {
        if pressed(key) && !is_taken {
            asked.push(what);
        }
    }
    asked
}

/// Requests by the pointer on the picture: dragging looks around, the wheel zooms.
pub(super) fn look_around(ui: &Ui, picture: &egui::Response, state: &UiState) -> Option<Asked> {
    state.replay.as_ref()?;
    let turned = picture.drag_delta();
    let wheel = match picture.hovered() {
        true => ui.input(|input| input.smooth_scroll_delta.y),
        false => 0.0,
    };
    let whole = |x: f32| x.round().clamp(-2000.0, 2000.0) as i16;
    let view = FreeView {
        right: whole(turned.x),
        down: whole(turned.y),
        nearer: whole(wheel),
    };
    (view != FreeView::default()).then_some(Asked::LookAround(view))
}
