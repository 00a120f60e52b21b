//! The panel's widgets. Every state is told by words and shape, never by colour alone.

use egui::{Color32, Key, RichText, Sense, Stroke, Ui, vec2};
use egui_plot::{Bar, BarChart, Line, Plot, PlotPoints};
use shared_mem::message::DeviceHealth;

use super::{Link, TickHealth, UiState, instrument_name};

/// What the user asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Stand still, or go on.
    Pause(bool),
    /// Put every organ back to rest.
    Reset,
    /// Let force through, or cut it.
    EnableForce(bool),
    /// Take an instrument.
    Instrument(u32),
    /// The alarm was seen.
    Acknowledge,
    /// Show the simulation over the picture, or not.
    ToggleEngineering,
    /// Hide or show the panel.
    TogglePanel,
    /// Take the instrument with mouse and keyboard, or let it go.
    ToggleHand,
    /// Fill the screen, or not.
    ToggleFullScreen,
    /// Take the next endoscope: 0°, 30°, 45°.
    NextScope,
    /// Turn its light cable a step to the left (−1) or the right (1).
    TurnScope(i8),
    /// Wipe its lens.
    WipeLens,
    /// End.
    Quit,
}

const GOOD: Color32 = Color32::from_rgb(120, 205, 130);
const CARE: Color32 = Color32::from_rgb(240, 190, 80);
const BAD: Color32 = Color32::from_rgb(245, 115, 105);

/// How well something does; also the shape of its mark.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Mark {
    Good,
    Care,
    Bad,
    Off,
}

/// Shows the state; returns what was asked, and the pixels that the picture covers.
pub fn ui(ui: &mut Ui, state: &UiState) -> (Vec<Asked>, Option<[u32; 2]>) {
    let mut asked = keys(ui, state);
    if !state.panel_hidden {
        egui::Panel::right("panel")
            .default_size(300.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| panel(ui, state, &mut asked));
            });
    }
    let mut covered = None;
    egui::CentralPanel::no_frame().show(ui, |ui| {
        ui.painter().rect_filled(ui.max_rect(), 0.0, Color32::BLACK);
        match (state.picture, state.link) {
            (Some((id, aspect)), Link::Live | Link::Silent(_)) => {
                covered = Some(picture(ui, state, id, aspect));
            }
            _ => {
                ui.centered_and_justified(|ui| ui.label(RichText::new(waiting(state)).size(22.0)));
            }
        }
    });
    (asked, covered)
}

fn keys(ui: &Ui, state: &UiState) -> Vec<Asked> {
    ui.input(|input| {
        let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4];
        let instruments = (0..)
            .zip(numbers)
            .map(|(i, key)| (key, Asked::Instrument(i)));
        let table = [
            // Whoever is caught in the picture gets out before the station ends.
            (
                Key::Escape,
                if state.in_hand {
                    Asked::ToggleHand
                } else {
                    Asked::Quit
                },
            ),
            (Key::M, Asked::ToggleHand),
            (Key::P, Asked::Pause(!state.is_paused())),
            (Key::R, Asked::Reset),
            (Key::F, Asked::EnableForce(!state.is_force_enabled())),
            (Key::A, Asked::Acknowledge),
            (Key::E, Asked::ToggleEngineering),
            (Key::H, Asked::TogglePanel),
            (Key::F11, Asked::ToggleFullScreen),
            (Key::S, Asked::NextScope),
            (Key::OpenBracket, Asked::TurnScope(-1)),
            (Key::CloseBracket, Asked::TurnScope(1)),
            (Key::W, Asked::WipeLens),
        ];
        let pressed = table.into_iter().chain(instruments);
        pressed
            .filter(|&(key, _)| input.key_pressed(key))
            .map(|(_, asked)| asked)
            .collect()
    })
}

fn picture(ui: &mut Ui, state: &UiState, id: egui::TextureId, aspect: f32) -> [u32; 2] {
    let space = ui.available_size();
    let width = space.x.min(space.y * aspect);
    let size = vec2(width, width / aspect);
    ui.centered_and_justified(|ui| {
        let picture = ui.add(egui::Image::new((id, size)).alt_text("Endoscope picture"));
        if let Some(overlay) = &state.overlay {
            let place = egui::Rect::from_center_size(picture.rect.center(), size);
            overlay.paint(ui.painter(), place);
        }
        if state.in_hand {
            help(
                ui,
                egui::Rect::from_center_size(picture.rect.center(), size),
            );
        }
    });
    let pixels = ui.ctx().pixels_per_point();
    [space.x, space.y].map(|side| (side * pixels).round().max(1.0) as u32)
}

/// What leads the instrument, along the picture's lower edge.
fn help(ui: &Ui, place: egui::Rect) {
    let text = "Mouse or arrows: move   Wheel or Page keys: deeper, out   Left or Space: jaws   \
                Right or V: coagulate   C: cut   , and .: roll\n\
                Middle button or Ctrl: endoscope   L: hold the camera   Shift: slow   M or Esc: let go";
    let painter = ui.painter();
    let galley = painter.layout(
        text.to_owned(),
        egui::FontId::proportional(14.0),
        Color32::WHITE,
        place.width() - 24.0,
    );
    let at = place.center_bottom() - vec2(0.5 * galley.size().x, galley.size().y + 12.0);
    let behind = egui::Rect::from_min_size(at, galley.size()).expand(6.0);
    painter.rect_filled(behind, 4.0, Color32::from_black_alpha(170));
    painter.galley(at, galley, Color32::WHITE);
}

fn waiting(state: &UiState) -> String {
    match state.link {
        Link::OtherScene => format!(
            "The controller runs another scene.\nThis display has '{}': start both with the same \
             one.",
            state.scene
        ),
        Link::Live => "Preparing the picture".into(),
        _ => format!(
            "Waiting for the controller on station '{}'.\nStart one with: calot rt",
            state.station
        ),
    }
}

fn panel(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    ui.heading(&state.scene);
    match &state.task_view {
        Some(task) => super::task::show(ui, task),
        None => {
            ui.label(&state.task);
        }
    }
    alarm(ui, state, asked);
    ui.separator();
    controller(ui, state);
    for (name, health) in state.devices() {
        let (mark, text) = device(health);
        line(ui, mark, &format!("{name}: {text}"));
    }
    ui.separator();
    instruments(ui, state, asked);
    ui.separator();
    scope(ui, state, asked);
    ui.separator();
    switches(ui, state, asked);
    ui.separator();
    force(ui, state);
    gates(ui, state);
    ui.separator();
    ticks(ui, state);
    ui.separator();
    ui.label(format!(
        "Picture: {:.0} a second, {:.1} ms after the hand",
        state.frames_per_second, state.motion_to_photon_ms
    ));
    passes(ui, state);
    ui.label(RichText::new(&state.adapter).weak());
    if ui.button("Quit (Esc)").clicked() {
        asked.push(Asked::Quit);
    }
}

fn alarm(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let Some(text) = &state.alarm else { return };
    egui::Frame::new()
        .fill(Color32::from_rgb(120, 20, 20))
        .inner_margin(8)
        .show(ui, |ui| {
            ui.colored_label(Color32::WHITE, format!("Alarm: {text}"));
            if ui.button("Acknowledge (A)").clicked() {
                asked.push(Asked::Acknowledge);
            }
        });
}

fn controller(ui: &mut Ui, state: &UiState) {
    let (mark, text) = match state.link {
        Link::Live if state.is_paused() => (Mark::Care, "paused".to_owned()),
        Link::Live => (Mark::Good, "live".to_owned()),
        Link::Waiting => (Mark::Off, "waiting for it".to_owned()),
        Link::Silent(seconds) => (Mark::Bad, format!("silent for {seconds:.1} s")),
        Link::OtherScene => (Mark::Bad, "runs another scene".to_owned()),
    };
    line(ui, mark, &format!("Controller: {text}"));
}

fn device(health: Option<DeviceHealth>) -> (Mark, String) {
    let Some(health) = health else {
        return (Mark::Off, "unknown".into());
    };
    let age_ms = health.age_us as f32 * 1e-3;
    let (mark, text) = match health.status {
        DeviceHealth::ABSENT => (Mark::Off, "not connected".to_owned()),
        DeviceHealth::LIVE => (Mark::Good, format!("live, {age_ms:.1} ms old")),
        DeviceHealth::STALE => (Mark::Care, format!("stale, {age_ms:.0} ms old")),
        DeviceHealth::LOST => (Mark::Bad, "line lost: plug it in again".to_owned()),
        other => (Mark::Bad, format!("unknown status {other}")),
    };
    let bad = health.bad_frames + health.lost_frames;
    if bad > 0 {
        return (mark, format!("{text}, {bad} frames bad or lost"));
    }
    (mark, text)
}

fn instruments(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let held = state.tools.as_ref().map(|tools| tools.instrument);
    ui.label("Instrument");
    for number in 0..4 {
        let text = format!("{} ({})", instrument_name(number), number + 1);
        if ui.selectable_label(held == Some(number), text).clicked() {
            asked.push(Asked::Instrument(number));
        }
    }
}

/// The endoscope: which one, how it is turned, how well it sees.
fn scope(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let [angle, turned] = state.scope_degrees;
    ui.label(format!("Endoscope: {angle:.0}°, cable turned {turned:.0}°"));
    ui.horizontal_wrapped(|ui| {
        for (text, what) in [
            ("Next endoscope (S)", Asked::NextScope),
            ("Turn left ([)", Asked::TurnScope(-1)),
            ("Turn right (])", Asked::TurnScope(1)),
            ("Wipe lens (W)", Asked::WipeLens),
        ] {
            if ui.button(text).clicked() {
                asked.push(what);
            }
        }
    });
    let dirty = state.lens_veil > 0.15;
    let held = state.tools.as_ref().is_some_and(|t| t.switches & 4 != 0);
    if dirty {
        line(ui, Mark::Care, "Lens: fogged or sooty, wipe it");
    }
    if held {
        line(ui, Mark::Good, "Camera: held still by the pedal");
    }
}

fn switches(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let (paused, forced) = (state.is_paused(), state.is_force_enabled());
    ui.horizontal_wrapped(|ui| {
        if ui
            .button(if paused { "Go on (P)" } else { "Pause (P)" })
            .clicked()
        {
            asked.push(Asked::Pause(!paused));
        }
        if ui.button("Reset organs (R)").clicked() {
            asked.push(Asked::Reset);
        }
        let engineering = state.overlay.is_some();
        let toggle = ui.selectable_label(engineering, "Engineering view (E)");
        if toggle.clicked() {
            asked.push(Asked::ToggleEngineering);
        }
        let text = if state.in_hand {
            "Let go of the instrument (M)"
        } else {
            "Take the instrument: mouse and keyboard (M)"
        };
        if ui.selectable_label(state.in_hand, text).clicked() {
            asked.push(Asked::ToggleHand);
        }
        let text = if forced {
            "Cut force (F)"
        } else {
            "Enable force (F)"
        };
        if ui.button(text).clicked() {
            asked.push(Asked::EnableForce(!forced));
        }
    });
}

fn force(ui: &mut Ui, state: &UiState) {
    let [x, y, z] = state.tools.as_ref().map_or([0.0; 3], |tools| tools.force_n);
    let size = (x * x + y * y + z * z).sqrt();
    let note = if state.is_force_enabled() {
        ""
    } else {
        ", cut"
    };
    ui.label(format!("Force on the hand: {size:.2} N{note}"));
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

/// What the safety chain did to the force, gate by gate.
fn gates(ui: &mut Ui, state: &UiState) {
    let total: u64 = state.health.gates().map(|(_, count)| count).sum();
    egui::CollapsingHeader::new(format!("Safety chain: acted {total} times"))
        .id_salt("gates")
        .show(ui, |ui| {
            for (words, count) in state.health.gates() {
                ui.label(format!("{count} × {words}"));
            }
        });
}

fn ticks(ui: &mut Ui, state: &UiState) {
    let health = &state.health;
    let Some([wake, tick]) = health.quantiles_us() else {
        line(ui, Mark::Off, "Ticks: no record yet");
        return;
    };
    let lacks = health.lacks();
    if lacks.is_empty() {
        line(ui, Mark::Good, "Realtime: yes");
    } else {
        let text = format!("Not realtime: lacks {}", lacks.join(", "));
        line(ui, Mark::Care, &text);
    }
    let steady = health.missed == 0 && health.overruns == 0;
    let mark = if steady { Mark::Good } else { Mark::Care };
    line(ui, mark, &format!("Ticks: {:.0} a second", health.rate_hz));
    ui.label(format!(
        "Missed {}, late {}, allocations {}, page faults {}",
        health.missed, health.overruns, health.allocations, health.page_faults
    ));
    ui.label(format!(
        "Wake-up: 99 % within {:.0} µs, worst {:.0} µs",
        wake[0], wake[1]
    ));
    ui.label(format!(
        "Tick: 99 % within {:.0} µs, worst {:.0} µs",
        tick[0], tick[1]
    ));
    histogram(ui, health, 0, "Wake-up latency");
    histogram(ui, health, 1, "Time of a tick");
}

/// A live histogram of the last four seconds.
fn histogram(ui: &mut Ui, health: &TickHealth, which: usize, name: &str) {
    let bars = health.bars(which);
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
    ui.label(RichText::new(format!("{name}, 1 µs to 33 ms, each bar twice the last")).weak());
}

/// What a picture costs, pass by pass, and the quality that was chosen by it.
fn passes(ui: &mut Ui, state: &UiState) {
    let [tier, tiers] = state.quality;
    if tiers > 1 {
        ui.label(format!("Quality: {} of {tiers}, 1 the best", tier + 1));
    }
    let Some(times) = state.pass_times else {
        return;
    };
    let total: f32 = times.iter().sum();
    egui::CollapsingHeader::new(format!("Graphics: {total:.1} ms a picture"))
        .id_salt("passes")
        .show(ui, |ui| {
            for (name, ms) in crate::render::timing::PASSES.iter().zip(times) {
                ui.label(format!("{name}: {ms:.2} ms"));
            }
        });
}

/// A mark of its own shape and colour, and words.
pub(super) fn line(ui: &mut Ui, mark: Mark, text: &str) {
    ui.horizontal_wrapped(|ui| {
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
        ui.label(text);
    });
}
