//! Widgets of the panel. Words and shapes show every state, never colour alone.

use egui::{Color32, FontId, RichText, Sense, Stroke, TextStyle, Ui, vec2};
use egui_plot::{Bar, BarChart, Line, Plot, PlotPoints};
use shared_mem::message::DeviceHealth;
use shared_mem::words::{Instrument, Switches};

use super::screens;
use super::{Asked, Link, UiState, asked, instructor, instrument_id, recording, replay, task};
use crate::words::Words;

/// Share of the panel in the window's width, and its least and largest width, points.
const PANEL_SHARE: f32 = 0.28;
const PANEL: [f32; 2] = [240.0, 350.0];
/// Text sizes for the trainee and for the operator of the station, points.
const TEXT: f32 = 17.0;
const FINE: f32 = 13.5;

/// Haze that obscures the view, 1/m: a third of the light from 5 cm is lost, there and back.
const HAZY_PER_M: f32 = 4.0;

const GOOD: Color32 = Color32::from_rgb(120, 205, 130);
const CARE: Color32 = Color32::from_rgb(240, 190, 80);
const BAD: Color32 = Color32::from_rgb(245, 115, 105);

/// Degree of health; also the shape of its mark.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Mark {
    Good,
    Care,
    Bad,
    Off,
}

/// Shows the state. Returns the user's requests, and the pixels that the picture covers.
pub fn ui(ui: &mut Ui, state: &UiState) -> (Vec<Asked>, Option<[u32; 2]>) {
    let zoom = f32::from(state.settings.text_percent) * 0.01;
    ui.ctx().set_zoom_factor(zoom);
    let mut asked = screens::keys(ui, state).unwrap_or_else(|| asked::keys(ui, state));
    if !state.settings_open {
        asked.extend(replay::keys(ui, state));
    }
    if !state.panel_hidden && !state.settings_open {
        let width = ui.available_width();
        egui::Panel::right("panel")
            .default_size((PANEL_SHARE * width).clamp(PANEL[0], PANEL[1]))
            .max_size(0.5 * width)
            .show(ui, |ui| {
                sized(ui, TEXT);
                egui::ScrollArea::vertical().show(ui, |ui| match state.instructor {
                    true => instructor::show(ui, state, &mut asked),
                    false => panel(ui, state, &mut asked),
                });
            });
    }
    let mut covered = None;
    egui::CentralPanel::no_frame().show(ui, |ui| {
        ui.painter().rect_filled(ui.max_rect(), 0.0, Color32::BLACK);
        if screens::cover(ui, state, &mut asked) {
            return;
        }
        match (state.picture, state.link) {
            (Some((id, aspect)), Link::Live | Link::Silent(_)) => {
                covered = Some(picture(ui, state, (id, aspect), &mut asked));
            }
            _ => {
                ui.centered_and_justified(|ui| ui.label(RichText::new(waiting(state)).size(22.0)));
            }
        }
    });
    (asked, covered)
}

fn picture(
    ui: &mut Ui,
    state: &UiState,
    (id, aspect): (egui::TextureId, f32),
    asked: &mut Vec<Asked>,
) -> [u32; 2] {
    let space = ui.available_size();
    let width = space.x.min(space.y * aspect);
    let size = vec2(width, width / aspect);
    ui.centered_and_justified(|ui| {
        let image = egui::Image::new((id, size)).alt_text(state.words.say("picture-alt"));
        let picture = ui.add(match state.replay {
            Some(_) => image.sense(Sense::drag()),
            None => image,
        });
        asked.extend(replay::look_around(ui, &picture, state));
        let place = egui::Rect::from_center_size(picture.rect.center(), size);
        if let Some(overlay) = &state.overlay {
            overlay.paint(ui.painter(), place, &state.words);
        }
        screens::over(ui, place, state, asked);
    });
    let pixels = ui.ctx().pixels_per_point();
    [space.x, space.y].map(|side| (side * pixels).round().max(1.0) as u32)
}

fn waiting(state: &UiState) -> String {
    let words = &state.words;
    match state.link {
        Link::OtherScene => {
            let scene = state.scene.as_str().into();
            words.say_with("waiting-other-scene", &[("scene", scene)])
        }
        Link::Live => words.say("waiting-picture"),
        _ => {
            let station = state.station.as_str().into();
            words.say_with("waiting-controller", &[("station", station)])
        }
    }
}

fn panel(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    ui.heading(&state.scene);
    match &state.task_view {
        Some(view) => task::show(ui, words, view),
        None => {
            ui.label(&state.task);
        }
    }
    alarm(ui, state, asked);
    recording::show(ui, state);
    ui.separator();
    replay::show(ui, state, asked);
    controller(ui, state);
    devices(ui, state);
    ui.separator();
    instruments(ui, state, asked);
    ui.separator();
    scope(ui, state, asked);
    ui.separator();
    switches(ui, state, asked);
    ui.separator();
    force(ui, state);
    fine(ui, |ui| station(ui, state));
    for (text, what) in [
        ("settings", Asked::ShowSettings(true)),
        ("quit", Asked::Quit),
    ] {
        if ui.button(words.say(text)).clicked() {
            asked.push(what);
        }
    }
}

/// State of the station: safety chain, ticks, picture.
fn station(ui: &mut Ui, state: &UiState) {
    let words = &state.words;
    gates(ui, state);
    ui.separator();
    ticks(ui, state);
    ui.separator();
    let values = [
        ("rate", format!("{:.0}", state.frames_per_second).into()),
        (
            "age",
            words.number(state.motion_to_photon_ms.into(), 1).into(),
        ),
    ];
    ui.label(words.say_with("picture", &values));
    passes(ui, state);
    ui.label(RichText::new(&state.adapter).weak());
}

fn alarm(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let Some(text) = &state.alarm else { return };
    let words = &state.words;
    egui::Frame::new()
        .fill(Color32::from_rgb(120, 20, 20))
        .inner_margin(8)
        .show(ui, |ui| {
            let text = words.say_with("alarm", &[("text", text.as_str().into())]);
            ui.colored_label(Color32::WHITE, text);
            if ui.button(words.say("alarm-acknowledge")).clicked() {
                asked.push(Asked::Acknowledge);
            }
        });
}

pub(super) fn controller(ui: &mut Ui, state: &UiState) {
    let words = &state.words;
    let (mark, text) = match state.link {
        Link::Live if state.is_paused() => (Mark::Care, words.say("controller-paused")),
        Link::Live => (Mark::Good, words.say("controller-live")),
        Link::Waiting => (Mark::Off, words.say("controller-waiting")),
        Link::Silent(seconds) => {
            let seconds = words.number(seconds.into(), 1).into();
            let text = words.say_with("controller-silent", &[("seconds", seconds)]);
            (Mark::Bad, text)
        }
        Link::OtherScene => (Mark::Bad, words.say("controller-other-scene")),
    };
    line(ui, mark, &text);
}

pub(super) fn devices(ui: &mut Ui, state: &UiState) {
    let words = &state.words;
    for (name, health) in state.devices() {
        let (mark, text) = device(words, &words.say(name), health);
        line(ui, mark, &text);
    }
}

/// State of a device, by words and by mark.
fn device(words: &Words, name: &str, health: Option<DeviceHealth>) -> (Mark, String) {
    let say = |id: &str, more: &[(&'static str, String)]| {
        let name = [("device", name.into())];
        let more = more
            .iter()
            .map(|(key, value)| (*key, value.as_str().into()));
        words.say_with(id, &name.into_iter().chain(more).collect::<Vec<_>>())
    };
    let Some(health) = health else {
        return (Mark::Off, say("device-unknown", &[]));
    };
    let age_ms = f64::from(health.age_us) * 1e-3;
    let age = |digits: usize| [("age", words.number(age_ms, digits))];
    let (mark, state) = match health.status {
        DeviceHealth::ABSENT => (Mark::Off, say("device-absent", &[])),
        DeviceHealth::LIVE => (Mark::Good, say("device-live", &age(1))),
        DeviceHealth::STALE => (Mark::Care, say("device-stale", &age(0))),
        DeviceHealth::LOST => (Mark::Bad, say("device-lost", &[])),
        other => (
            Mark::Bad,
            say("device-odd", &[("status", other.to_string())]),
        ),
    };
    let bad = health.bad_frames + health.lost_frames;
    if bad > 0 {
        let values = [("state", state.into()), ("count", bad.to_string().into())];
        return (mark, words.say_with("device-bad", &values));
    }
    (mark, state)
}

fn instruments(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    let held = state.tools.as_ref().map(|tools| tools.instrument);
    ui.label(words.say("instrument"));
    for number in Instrument::ALL.map(Instrument::number) {
        let text = format!("{} ({})", words.say(instrument_id(number)), number + 1);
        if ui.selectable_label(held == Some(number), text).clicked() {
            asked.push(Asked::Instrument(number));
        }
    }
}

/// The endoscope: type, turn, and clarity of its view.
fn scope(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    let [angle, turned] = state.scope_degrees.map(|it| format!("{it:.0}").into());
    let focus = format!("{:.0}", state.focus_mm).into();
    let told = [("angle", angle), ("turned", turned), ("focus", focus)];
    ui.label(words.say_with("scope", &told));
    ui.horizontal_wrapped(|ui| {
        for (text, what) in [
            ("scope-next", Asked::NextScope),
            ("scope-left", Asked::TurnScope(-1)),
            ("scope-right", Asked::TurnScope(1)),
            ("scope-nearer", Asked::TurnFocus(-1)),
            ("scope-farther", Asked::TurnFocus(1)),
            ("scope-wipe", Asked::WipeLens),
            (
                if state.is_smoke_drawn_off {
                    "smoke-close"
                } else {
                    "smoke-draw-off"
                },
                Asked::ToggleSuction,
            ),
        ] {
            if ui.button(words.say(text)).clicked() {
                asked.push(what);
            }
        }
    });
    let dirty = state.lens_veil > 0.15;
    let held = state.has_switch(Switches::CAMERA_LOCK);
    if dirty {
        line(ui, Mark::Care, &words.say("scope-dirty"));
    }
    match (state.is_smoke_drawn_off, state.haze_per_m > HAZY_PER_M) {
        (true, _) => line(ui, Mark::Good, &words.say("smoke-drawn-off")),
        (false, true) => line(ui, Mark::Care, &words.say("smoke-gathers")),
        (false, false) => {}
    }
    if held {
        line(ui, Mark::Good, &words.say("scope-held"));
    }
}

fn switches(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    let (paused, forced) = (state.is_paused(), state.is_force_enabled());
    let either = |on: bool, yes: &str, no: &str| words.say(if on { yes } else { no });
    ui.horizontal_wrapped(|ui| {
        let pause = either(paused, "switch-go-on", "switch-pause");
        if ui.button(pause).clicked() {
            asked.push(Asked::Pause(!paused));
        }
        if ui.button(words.say("switch-reset")).clicked() {
            asked.push(Asked::Reset);
        }
        let engineering = words.say("switch-engineering");
        if ui
            .selectable_label(state.overlay.is_some(), engineering)
            .clicked()
        {
            asked.push(Asked::ToggleEngineering);
        }
        let hand = either(state.in_hand, "switch-hand-off", "switch-hand");
        if ui.selectable_label(state.in_hand, hand).clicked() {
            asked.push(Asked::ToggleHand);
        }
        let force = either(forced, "switch-force-off", "switch-force");
        if ui.button(force).clicked() {
            asked.push(Asked::EnableForce(!forced));
        }
    });
}

fn force(ui: &mut Ui, state: &UiState) {
    let [x, y, z] = state.tools.as_ref().map_or([0.0; 3], |tools| tools.force_n);
    let size = (x * x + y * y + z * z).sqrt();
    let size = state.words.number(size.into(), 2);
    let id = if state.is_force_enabled() {
        "force"
    } else {
        "force-cut"
    };
    ui.label(state.words.say_with(id, &[("force", size.into())]));
    Plot::new("force")
        .height(70.0)
        .include_y(0.0)
        .include_y(1.0)
        .show_x(false)
        .show_axes([false, true])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show(ui, |plot| {
            plot.line(Line::new("force", PlotPoints::from(state.force.clone())).color(CARE));
        });
}

/// Interventions of the safety chain, gate by gate.
fn gates(ui: &mut Ui, state: &UiState) {
    let words = &state.words;
    let total: u64 = state.health.gates().map(|(_, count)| count).sum();
    let title = words.say_with("gates", &[("count", total.to_string().into())]);
    egui::CollapsingHeader::new(title)
        .id_salt("gates")
        .show(ui, |ui| {
            for (name, count) in state.health.gates() {
                let what = words.say(&format!("gate-{}", name.replace('_', "-")));
                let values = [("count", count.to_string().into()), ("what", what.into())];
                ui.label(words.say_with("gate", &values));
            }
        });
}

pub(super) fn ticks(ui: &mut Ui, state: &UiState) {
    let (words, health) = (&state.words, &state.health);
    let Some([wake, tick]) = health.quantiles_us() else {
        line(ui, Mark::Off, &words.say("ticks-none"));
        return;
    };
    let lacks: Vec<String> = health.lacks().iter().map(|id| words.say(id)).collect();
    if lacks.is_empty() {
        line(ui, Mark::Good, &words.say("ticks-realtime"));
    } else {
        let what = lacks.join(", ").into();
        let text = words.say_with("ticks-lacks", &[("what", what)]);
        line(ui, Mark::Care, &text);
    }
    let steady = health.missed == 0 && health.overruns == 0;
    let mark = if steady { Mark::Good } else { Mark::Care };
    let rate = format!("{:.0}", health.rate_hz).into();
    line(ui, mark, &words.say_with("ticks-rate", &[("rate", rate)]));
    let values = [
        ("missed", health.missed.to_string().into()),
        ("late", health.overruns.to_string().into()),
        ("allocations", health.allocations.to_string().into()),
        ("faults", health.page_faults.to_string().into()),
    ];
    ui.label(words.say_with("ticks-counts", &values));
    for (id, [most, worst]) in [("ticks-wake", wake), ("ticks-tick", tick)] {
        let [most, worst] = [most, worst].map(|us| format!("{us:.0}").into());
        ui.label(words.say_with(id, &[("most", most), ("worst", worst)]));
    }
    histogram(ui, state, 0, &words.say("ticks-wake-name"));
    histogram(ui, state, 1, &words.say("ticks-tick-name"));
}

/// A live histogram of the last four seconds.
fn histogram(ui: &mut Ui, state: &UiState, which: usize, name: &str) {
    let bars = state.health.bars(which);
    let bars = bars
        .iter()
        .enumerate()
        .map(|(i, share)| Bar::new(i as f64, *share));
    Plot::new(name)
        .height(48.0)
        .show_x(false)
        .show_axes([false, false])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show(ui, |plot| {
            plot.bar_chart(BarChart::new(name, bars.collect()).color(GOOD));
        });
    let text = state.words.say_with("ticks-bars", &[("name", name.into())]);
    ui.label(RichText::new(text).weak());
}

/// Costs of a picture by pass, and the quality chosen by them.
pub(super) fn passes(ui: &mut Ui, state: &UiState) {
    let [tier, tiers] = state.quality;
    if tiers > 1 {
        let values = [
            ("tier", (tier + 1).to_string().into()),
            ("tiers", tiers.to_string().into()),
        ];
        ui.label(state.words.say_with("quality", &values));
    }
    let Some(times) = state.pass_times else {
        return;
    };
    let total: f32 = times.iter().sum();
    let words = &state.words;
    let total = words.number(total.into(), 1).into();
    egui::CollapsingHeader::new(words.say_with("graphics", &[("ms", total)]))
        .id_salt("passes")
        .show(ui, |ui| {
            for (name, ms) in crate::render::timing::PASSES.iter().zip(times) {
                let name = words.say(&format!("pass-{name}"));
                let ms = words.number(ms.into(), 2);
                ui.label(words.say_with("pass-time", &[("name", name.into()), ("ms", ms.into())]));
            }
        });
}

/// Text of this size, with matching headings and buttons.
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

/// Small text for the operator of the station.
pub(super) fn fine(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.scope(|ui| {
        sized(ui, FINE);
        add(ui);
    });
}

/// A mark of its own shape and colour, and words.
pub(super) fn line(ui: &mut Ui, mark: Mark, text: &str) {
    ui.horizontal_wrapped(|ui| {
        sign(ui, mark);
        ui.label(text);
    });
}

/// The mark alone.
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
