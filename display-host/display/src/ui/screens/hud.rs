//! Head-up display during a task: time, instrument, clips, pedal, alarm, next step.

use assess::Hint;
use egui::{Align2, Color32, Frame, Rect, RichText, Ui, vec2};
use shared_mem::message::ToolFrame;
use shared_mem::words::{Instrument, Switches};

use super::super::current;
use super::super::keys;
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
/// Width of the picture, points, below which the panel beside it shows what the cards would cover,
/// as with text of 125 % in a window of 1280 pixels.
const FOLDED_WIDTH_POINTS: f32 = 760.0;
/// Width of the picture, points, below which a result or pause in the middle replaces the other
/// cards, because it would cover them.
const NARROW_WIDTH_POINTS: f32 = 900.0;

pub(super) fn show(ui: &Ui, place: Rect, state: &UiState, asked: &mut Vec<Asked>) {
    let task = state.task_view.as_ref();
    let end = task.and_then(|task| Some((task, task.end.as_ref()?)));
    let is_paused = state.link == Link::Live && state.is_paused();
    let is_covered = (end.is_some() || is_paused) && !state.instructor;
    if let Some(direction) = state.tip_away.filter(|_| !is_covered) {
        let tools = state.tools.as_ref();
        let name = tools.map(|it| state.words.say(instrument_id(it.instrument)));
        arrow::paint(ui, place, direction, name.as_deref());
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
        let alarmed = alarmed.filter(|_| !state.alarm_is_old);
        if let Some(note) = alarmed.and_then(|task| task.alarm.as_ref()) {
            alarm(ui, place, &state.words, note);
        }
    }
    if let Some(end) = end {
        over(ui, roomy(ui, place), state, end, asked);
    }
}

/// Shows the state of the task, on the left. A narrow picture leaves to the panel what the panel
/// shows.
fn stands(ui: &Ui, place: Rect, state: &UiState, task: &TaskView) {
    let words = &state.words;
    let tools = state.tools.as_ref();
    let is_folded = is_folded(place, state);
    let speaks = tools.filter(|it| it.has(Instrument::Irrigator) || current::tells(state, it));
    if is_folded && !state.watched && speaks.is_none() {
        return;
    }
    card(ui, "hud", place, Align2::LEFT_TOP, |ui| {
        legible(ui);
        ui.set_max_width(SIDE_WIDTH_POINTS);
        if state.watched {
            let text = RichText::new(words.say("watched"));
            ui.label(text.size(HINT_TEXT_POINTS).strong());
        }
        if is_folded {
            if let Some(tools) = speaks {
                sized(ui, HINT_TEXT_POINTS);
                work(ui, state, tools);
            }
            return;
        }
        big(ui, &task::time(words, task));
        let is_guided = guide::is_of(task) && place.width() < NARROW_WIDTH_POINTS;
        if is_tight(place) || is_guided {
            return;
        }
        if state.panel_hidden {
            ui.label(task::title(words, task));
        }
        let Some(tools) = tools else { return };
        big(ui, &words.say(instrument_id(tools.instrument)));
        if !tools.has(Instrument::Irrigator) {
            let clips = tools.clips_left.to_string().into();
            ui.label(words.say_with("hud-clips", &[("count", clips)]));
        }
        work(ui, state, tools);
        if tools.switches().contains(Switches::CAMERA_LOCK) {
            ui.label(words.say("hud-camera-held"));
        }
    });
}

/// Shows what flows: current, or the irrigator's water and suction.
fn work(ui: &mut Ui, state: &UiState, tools: &ToolFrame) {
    if tools.has(Instrument::Irrigator) {
        let pedals = [Switches::CUT, Switches::COAGULATE].map(|it| tools.switches().contains(it));
        irrigator(ui, state, pedals);
    } else {
        ui.label(state.words.say(current::message(state, tools)));
    }
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

/// Shows a note and the next step at the bottom, and the way to take the instrument. In a narrow
/// picture the panel has the details. In a tight picture a running hold takes their place.
fn foot(ui: &Ui, place: Rect, state: &UiState) {
    let words = &state.words;
    let task = state.task_view.as_ref().filter(|it| it.end.is_none());
    let task = task.map(|it| task::with_tool(state, it));
    let hint = task.as_ref().and_then(|it| it.hint.as_ref());
    let hold = task.as_ref().and_then(|it| it.hold.as_ref());
    let hold = hold.filter(|_| is_tight(place));
    let note = note(state);
    let invites = task.is_some() && state.may_take_hand();
    // The panel shows the keys, if there is one.
    let has_keys = state.in_hand && state.panel_hidden && !is_tight(place);
    let is_empty = hint.is_none() && hold.is_none() && note.is_none();
    if is_empty && !invites && !has_keys {
        return;
    }
    card(ui, "hud foot", place, Align2::CENTER_BOTTOM, |ui| {
        ui.set_max_width(place.width() - 48.0);
        if let Some(hold) = hold {
            ui.label(RichText::new(words.hold(hold)).size(HINT_TEXT_POINTS));
            return;
        }
        if let Some(note) = &note {
            sized(ui, HINT_TEXT_POINTS);
            line(ui, Mark::Care, note);
            if is_tight(place) {
                return;
            }
        }
        let is_short = is_folded(place, state) || is_tight(place);
        let guided = task.as_ref().filter(|it| guide::is_of(it));
        if let Some(task) = guided {
            guide::show(ui, state, task, is_short);
        } else if let Some(hint) = hint {
            next(ui, words, hint, is_short);
        }
        if invites && !is_tight(place) {
            small(ui, &words.say("guide-take"));
        }
        if has_keys {
            let text = keys::text(words, state.settings.look.left_handed);
            small(ui, &text);
        }
    });
}

/// Sentence to the trainee that is no alarm.
fn note(state: &UiState) -> Option<String> {
    let works = state.in_hand && state.link == Link::Live && !state.is_paused();
    // The force of mouse and keys is the tissue's push on the instrument.
    let is_soft = works && state.tools.is_some() && !state.is_force_enabled();
    let soft = is_soft.then(|| state.words.say("note-force-off"));
    state.note.clone().or(soft)
}

/// Shows the next step of a task without guidance.
fn next(ui: &mut Ui, words: &Words, hint: &Hint, is_short: bool) {
    let text = words.hint(hint).into();
    let text = words.say_with("hud-hint", &[("text", text)]);
    if is_short {
        ui.label(RichText::new(text).size(HINT_TEXT_POINTS));
        return;
    }
    big(ui, &text);
    let left = words.left(hint).map(|it| format!("  {it}"));
    let place = words.place(&hint.step);
    let text = format!("{place}{}", left.unwrap_or_default());
    ui.label(RichText::new(text).size(HINT_TEXT_POINTS));
}

fn small(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(HELP_TEXT_POINTS));
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

/// True if the picture leaves to the panel beside it what the panel shows.
fn is_folded(place: Rect, state: &UiState) -> bool {
    place.width() < FOLDED_WIDTH_POINTS && !state.panel_hidden
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
