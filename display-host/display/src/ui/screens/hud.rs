//! Head-up display during a task: time, instrument, clips, pedal, alarm, next step.

use egui::{Align2, Color32, Frame, Rect, RichText, Ui, vec2};
use shared_mem::words::{Instrument, Switches};

use super::super::task::{self, TaskEnd, TaskNote, TaskView};
use super::super::widgets::{Mark, line, sized};
use super::super::{Asked, Link, UiState, arrow, instrument_id};
use super::{guide, legible};
use crate::words::Words;

/// Size of the text, points.
const TEXT_POINTS: f32 = 22.0;
/// Size of the second line of a hint, points.
const HINT_TEXT_POINTS: f32 = 17.0;
/// Size of help text, points.
const HELP_TEXT_POINTS: f32 = 14.0;
/// Width of the left column, points. The alarm stays clear of this column.
const SIDE_WIDTH_POINTS: f32 = 236.0;
/// Space between the left column and the alarm, including margins and frames, points.
const CLEAR_POINTS: f32 = 62.0;
/// Width of the left column in a tight picture, points. The column then shows the time alone.
const TIME_WIDTH_POINTS: f32 = 140.0;
/// Width below which a picture is tight, points, as with large text. The cards then show only time,
/// next step and result, and the alarm if the panel does not show it.
const TIGHT_WIDTH_POINTS: f32 = 480.0;
/// Width of the picture, points, below which a result or pause in the middle replaces the other
/// cards, because it would cover them.
const NARROW_WIDTH_POINTS: f32 = 900.0;

pub(super) fn show(ui: &Ui, place: Rect, state: &UiState, asked: &mut Vec<Asked>) {
    let task = state.task_view.as_ref();
    let end = task.and_then(|task| Some((task, task.end.as_ref()?)));
    let is_paused = state.link == Link::Live && state.is_paused();
    let is_covered = (end.is_some() || is_paused) && !state.instructor;
    if let Some(direction) = state.tip_away.filter(|_| !is_covered) {
        arrow::paint(ui.ctx(), place, direction);
    }
    if place.width() >= NARROW_WIDTH_POINTS || !is_covered {
        let place = tall(ui, place);
        // In a narrow picture the note of an act takes the place of the next step.
        if place.width() >= NARROW_WIDTH_POINTS || state.acts.notice.is_none() {
            foot(ui, place, state);
        }
        if let Some(task) = task {
            stands(ui, place, state, task);
        }
        // In a tight picture the panel, if there is one, shows the alarm.
        let alarmed = task.filter(|_| !is_tight(place) || state.panel_hidden);
        if let Some(note) = alarmed.and_then(|task| task.alarm.as_ref()) {
            alarm(ui, place, &state.words, note);
        }
    }
    if let Some(end) = end {
        over(ui, roomy(ui, place), state, end, asked);
    }
}

/// Shows the state of the task, on the left.
fn stands(ui: &Ui, place: Rect, state: &UiState, task: &TaskView) {
    let words = &state.words;
    card(ui, "hud", place, Align2::LEFT_TOP, |ui| {
        legible(ui);
        ui.set_max_width(SIDE_WIDTH_POINTS);
        big(ui, &task::time(words, task));
        let is_guided = guide::is_of(task) && place.width() < NARROW_WIDTH_POINTS;
        if is_tight(place) || is_guided {
            return;
        }
        ui.label(task::title(words, task));
        let Some(tools) = &state.tools else { return };
        big(ui, &words.say(instrument_id(tools.instrument)));
        let pedals = [Switches::CUT, Switches::COAGULATE].map(|it| tools.switches().contains(it));
        if tools.has(Instrument::Irrigator) {
            irrigator(ui, state, pedals);
        } else {
            let clips = tools.clips_left.to_string().into();
            ui.label(words.say_with("hud-clips", &[("count", clips)]));
            ui.label(words.say(match pedals {
                [false, false] => "hud-pedal-none",
                [true, false] => "hud-pedal-cut",
                [false, true] => "hud-pedal-coagulate",
                [true, true] => "hud-pedal-both",
            }));
        }
        if tools.switches().contains(Switches::CAMERA_LOCK) {
            ui.label(words.say("hud-camera-held"));
        }
    });
}

/// Shows what the irrigator does, and the volume in its jar.
fn irrigator(ui: &mut Ui, state: &UiState, pedals: [bool; 2]) {
    let words = &state.words;
    ui.label(words.say(match pedals {
        [false, false] => "hud-irrigator-none",
        [true, false] => "hud-irrigator-rinses",
        [false, true] => "hud-irrigator-sucks",
        [true, true] => "hud-irrigator-both",
    }));
    let ml = words.number(state.jar_ml.into(), 0).into();
    ui.label(words.say_with("hud-jar", &[("ml", ml)]));
    if state.jar_is_full {
        line(ui, Mark::Care, &words.say("hud-jar-full"));
    }
}

/// Shows the latest error in the middle, or on the right if the middle has too little room.
fn alarm(ui: &Ui, place: Rect, words: &Words, note: &TaskNote) {
    let middle = place.width() - 2.0 * (SIDE_WIDTH_POINTS + CLEAR_POINTS);
    let (side, width, size) = match middle >= SIDE_WIDTH_POINTS {
        true => (Align2::CENTER_TOP, middle, TEXT_POINTS),
        false if is_tight(place) => (
            Align2::RIGHT_TOP,
            place.width() - TIME_WIDTH_POINTS - CLEAR_POINTS,
            HINT_TEXT_POINTS,
        ),
        false => (
            Align2::RIGHT_TOP,
            place.width() - SIDE_WIDTH_POINTS - CLEAR_POINTS,
            TEXT_POINTS,
        ),
    };
    card(ui, "hud alarm", place, side, |ui| {
        ui.style_mut().override_font_id = Some(egui::FontId::proportional(size));
        ui.set_max_width(width);
        let text = task::alarm(words, note).into();
        let text = words.say_with("hud-alarm", &[("text", text)]);
        line(ui, Mark::Bad, &text);
    });
}

/// Shows the result of the task, in the middle.
fn over(
    ui: &Ui,
    place: Rect,
    state: &UiState,
    (task, end): (&TaskView, &TaskEnd),
    asked: &mut Vec<Asked>,
) {
    let words = &state.words;
    let [large, text] = match is_tight(place) {
        true => [HINT_TEXT_POINTS, HELP_TEXT_POINTS],
        false => [1.8 * TEXT_POINTS, TEXT_POINTS],
    };
    card(ui, "hud over", place, Align2::CENTER_CENTER, |ui| {
        fitting(ui, place);
        ui.set_max_width(place.width() - 48.0);
        let outcome = words.say(&format!("outcome-{}", end.outcome));
        ui.label(RichText::new(outcome).size(large).strong());
        if let Some(score) = task.score {
            let score = format!("{score:.0}").into();
            let score = words.say_with("task-score", &[("score", score)]);
            ui.label(RichText::new(score).size(text));
        }
        for reason in &end.reasons {
            ui.label(RichText::new(words.reason(reason)).size(text));
        }
        // The trainee ends the task; the instructor does not.
        if !state.instructor && ui.button(words.say("hud-end")).clicked() {
            asked.push(Asked::Quit);
        }
    });
}

/// Shows the next step at the bottom, and the instrument's keys while mouse and keyboard lead it.
/// In a tight picture a running hold takes their place.
fn foot(ui: &Ui, place: Rect, state: &UiState) {
    let words = &state.words;
    let task = state.task_view.as_ref().filter(|it| it.end.is_none());
    let hint = task.and_then(|it| it.hint.as_ref());
    let hold = task.and_then(|it| it.hold.as_ref());
    let hold = hold.filter(|_| is_tight(place));
    if hint.is_none() && hold.is_none() && !state.in_hand {
        return;
    }
    card(ui, "hud foot", place, Align2::CENTER_BOTTOM, |ui| {
        ui.set_max_width(place.width() - 48.0);
        if let Some(hold) = hold {
            ui.label(RichText::new(words.hold(hold)).size(HINT_TEXT_POINTS));
            return;
        }
        let is_guided = task.is_some_and(|task| guide::show(ui, state, task, is_tight(place)));
        if let Some(hint) = hint.filter(|_| !is_guided) {
            let text = words.hint(hint).into();
            let text = words.say_with("hud-hint", &[("text", text)]);
            if is_tight(place) {
                ui.label(RichText::new(text).size(HINT_TEXT_POINTS));
                return;
            }
            big(ui, &text);
            let left = words.left(hint).map(|it| format!("  {it}"));
            let place = words.place(&hint.step);
            let text = format!("{place}{}", left.unwrap_or_default());
            ui.label(RichText::new(text).size(HINT_TEXT_POINTS));
        }
        if state.in_hand && !is_tight(place) {
            let help = match state.settings.look.left_handed {
                true => "help-left",
                false => "help",
            };
            ui.label(RichText::new(words.say(help)).size(HELP_TEXT_POINTS));
        }
    });
}

/// Corner of the picture that the other cards leave free.
pub(super) fn side(place: Rect) -> Align2 {
    match place.width() - 2.0 * (SIDE_WIDTH_POINTS + CLEAR_POINTS) >= SIDE_WIDTH_POINTS {
        true => Align2::RIGHT_TOP,
        false => Align2::RIGHT_CENTER,
    }
}

/// Place for a card in the middle: the picture, or the whole black area if the picture is tight.
pub(super) fn roomy(ui: &Ui, place: Rect) -> Rect {
    match is_tight(place) {
        true => ui.max_rect(),
        false => place,
    }
}

/// Place for the cards at the edges: the picture, or if the picture is tight, the black areas above
/// and below it too.
pub(super) fn tall(ui: &Ui, place: Rect) -> Rect {
    match is_tight(place) {
        true => Rect::from_x_y_ranges(place.x_range(), ui.max_rect().y_range()),
        false => place,
    }
}

/// Sets sizes of text that are legible from two metres away, or in a tight place, sizes that fit.
pub(super) fn fitting(ui: &mut Ui, place: Rect) {
    match is_tight(place) {
        true => sized(ui, HELP_TEXT_POINTS),
        false => legible(ui),
    }
}

pub(super) fn is_tight(place: Rect) -> bool {
    place.width() < TIGHT_WIDTH_POINTS
}

fn big(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(TEXT_POINTS));
}

/// Text on a dark card at one side of the picture.
pub(super) fn card(
    ui: &Ui,
    name: &'static str,
    place: Rect,
    side: Align2,
    add: impl FnOnce(&mut Ui),
) {
    let margin = vec2(14.0, 14.0);
    let at = side.pos_in_rect(&place.shrink2(margin));
    egui::Area::new(egui::Id::unique(name))
        .pivot(side)
        .fixed_pos(at)
        .constrain_to(place)
        .show(ui.ctx(), |ui| {
            Frame::new()
                .fill(Color32::from_black_alpha(190))
                .corner_radius(6)
                .inner_margin(10)
                .show(ui, |ui| {
                    ui.visuals_mut().override_text_color = Some(Color32::WHITE);
                    add(ui);
                });
        });
}
