//! The panel next to the picture.

use assess::report::PICTURES_MIN;
use egui::{Color32, RichText, Sense, Ui, vec2};
use egui_plot::{Line, Plot, PlotPoints};
use shared_mem::words::{Instrument, Switches};

use super::screens;
use super::station::{controller, devices, passes, ticks};
use super::widgets::{CARE, Mark, fine, folded, line, sized};
use super::{
    Asked, Link, UiState, alarms, asked, current, instructor, instrument_id, keys, recording,
    replay, task, theme,
};

/// Width of the panel as a share of the window's width.
const PANEL_SHARE: f32 = 0.28;
/// Least and largest width of the panel, points.
const PANEL_WIDTH_POINTS: [f32; 2] = [240.0, 350.0];
/// Size of the text for the trainee, points.
const TEXT_POINTS: f32 = 17.0;

/// Haze that obscures the view, 1/m: a seventh of the light from tissue 5 cm away is lost.
const HAZY_PER_M: f32 = 4.0;

/// Shows the state. Returns the user's requests, and the size of the picture's area, pixels.
pub fn ui(ui: &mut Ui, state: &UiState) -> (Vec<Asked>, Option<[u32; 2]>) {
    let look = state.settings.look;
    ui.ctx()
        .set_zoom_factor(f32::from(look.text_percent) * 0.01);
    theme::apply(ui.ctx(), look.high_contrast);
    let mut asked = screens::keys(ui, state).unwrap_or_else(|| asked::keys(ui, state));
    if !state.settings_open {
        asked.extend(replay::keys(ui, state));
    }
    if !state.panel_hidden && !state.settings_open {
        let width = ui.available_width();
        let side = match look.left_handed {
            true => egui::Panel::left("panel"),
            false => egui::Panel::right("panel"),
        };
        side.default_size(
            (PANEL_SHARE * width).clamp(PANEL_WIDTH_POINTS[0], PANEL_WIDTH_POINTS[1]),
        )
        .max_size(0.5 * width)
        .show(ui, |ui| {
            sized(ui, TEXT_POINTS);
            let height = ui.available_height();
            keys::foot(ui, state);
            egui::ScrollArea::vertical().show(ui, |ui| match state.instructor {
                true => instructor::show(ui, state, &mut asked),
                false => panel(ui, state, height, &mut asked),
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
            None if state.instructor => image.sense(Sense::click()),
            None => image,
        });
        asked.extend(replay::look_around(ui, &picture, state));
        let place = egui::Rect::from_center_size(picture.rect.center(), size);
        if let Some(at) = picture.interact_pointer_pos().filter(|_| picture.clicked()) {
            let from_middle = (at - place.center()) / (0.5 * place.height());
            asked.push(Asked::Point([from_middle.x, -from_middle.y]));
        }
        if let Some(overlay) = &state.overlay {
            overlay.paint(ui.painter(), place);
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

fn panel(ui: &mut Ui, state: &UiState, height: f32, asked: &mut Vec<Asked>) {
    let words = &state.words;
    head(ui, state);
    keys::among(ui, state, height);
    let is_engineering = state.overlay.is_some();
    alarms::show(ui, state, is_engineering, asked);
    too_slow(ui, state);
    recording::show(ui, state);
    ui.separator();
    replay::show(ui, state, asked);
    if let Some(overlay) = &state.overlay {
        fine(ui, |ui| _ = ui.label(overlay.said(words)));
    }
    // A trainee sees the controller only while it is not live or is paused.
    if is_engineering || state.link != Link::Live || state.is_paused() {
        controller(ui, state);
    }
    devices(ui, state, is_engineering);
    ui.separator();
    // A replay shows the recorded hand, which nobody can lead.
    if state.replay.is_none() {
        instruments(ui, state, asked);
        ui.separator();
    }
    scope(ui, state, asked);
    ui.separator();
    switches(ui, state, asked);
    ui.separator();
    force(ui, state);
    if is_engineering {
        fine(ui, |ui| station(ui, state));
    }
    for (text, what) in [
        ("settings", Asked::ShowSettings(true)),
        ("quit", Asked::Quit),
    ] {
        if ui.button(words.say(text)).clicked() {
            asked.push(what);
        }
    }
}

/// Names the scene and the task, with the task's state; in a replay, the recorded task.
fn head(ui: &mut Ui, state: &UiState) {
    let words = &state.words;
    if state.replay.is_some() {
        ui.heading(words.say("replay-title"));
        if let Some(task) = &state.replayed_task {
            ui.label(RichText::new(words.say(&format!("task-{task}"))).strong());
        }
        ui.label(state.scene_said());
        return;
    }
    ui.heading(state.scene_said());
    if state.watched {
        line(ui, Mark::Good, &words.say("watched"));
    }
    match &state.task_view {
        Some(view) => task::show(ui, words, &task::with_tool(state, view), state.alarm_is_old),
        None => {
            ui.label(&state.task);
        }
    }
}

/// Warns if the computer draws too few pictures to train with.
fn too_slow(ui: &mut Ui, state: &UiState) {
    let rate = state.frames_per_second;
    if rate > 0.0 && f64::from(rate) < PICTURES_MIN && state.replay.is_none() {
        let rate = state.words.number(rate.into(), 1).into();
        let text = state.words.say_with("slow-computer", &[("rate", rate)]);
        line(ui, Mark::Care, &text);
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
            words.number(state.motion_to_picture_ms.into(), 1).into(),
        ),
    ];
    ui.label(words.say_with("picture", &values));
    passes(ui, state);
    ui.label(RichText::new(&state.adapter).weak());
}

fn instruments(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    let held = state.tools.as_ref().map(|tools| tools.instrument);
    ui.label(words.say("instrument"));
    for number in Instrument::ALL.map(Instrument::number) {
        let text = format!("{} ({})", words.say(instrument_id(number)), number + 1);
        // An exchange would release tissue, and nothing may change in a pause. The expert chooses
        // the instruments of an operation that the trainee watches.
        let button = egui::Button::selectable(held == Some(number), text);
        let is_open = !state.is_paused() && !state.watched;
        if ui.add_enabled(is_open, button).clicked() {
            asked.push(Asked::Instrument(number));
        }
    }
    // In a narrow picture these lines leave the picture to the organs.
    if let Some(tools) = state
        .tools
        .as_ref()
        .filter(|it| !it.has(Instrument::Irrigator))
    {
        let clips = tools.clips_left.to_string().into();
        let clips = words.say_with("hud-clips", &[("count", clips)]);
        let current = words.say(current::message(state, tools));
        ui.label(RichText::new(format!("{clips} · {current}")).weak());
    }
}

/// The endoscope: its type, its turn, and how clear its view is.
fn scope(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    let [angle, turned] = state.scope_degrees.map(|it| format!("{it:.0}").into());
    let focus = format!("{:.0}", state.focus_mm).into();
    let values = [("angle", angle), ("turned", turned), ("focus", focus)];
    ui.label(words.say_with("scope", &values));
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
        let is_replay = state.replay.is_some();
        if !is_replay && ui.button(words.say("switch-reset")).clicked() {
            asked.push(Asked::Reset);
        }
        let engineering = words.say("switch-engineering");
        if ui
            .selectable_label(state.overlay.is_some(), engineering)
            .clicked()
        {
            asked.push(Asked::ToggleEngineering);
        }
        if is_replay {
            return;
        }
        let hand = either(state.in_hand, "switch-hand-off", "switch-hand");
        if !state.watched && ui.selectable_label(state.in_hand, hand).clicked() {
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

/// Interventions of each gate of the safety chain.
fn gates(ui: &mut Ui, state: &UiState) {
    let words = &state.words;
    let total: u64 = state.health.gates().map(|(_, count)| count).sum();
    let title = words.say_with("gates", &[("count", total.to_string().into())]);
    folded(ui, "gates", title, |ui| {
        for (name, count) in state.health.gates() {
            let what = words.say(&format!("gate-{}", name.replace('_', "-")));
            let values = [("count", count.to_string().into()), ("what", what.into())];
            ui.label(words.say_with("gate", &values));
        }
    });
}
