//! State of the station: controller, devices, ticks, cost of a picture.

use egui::{RichText, Ui};
use egui_plot::{Bar, BarChart, Plot};
use shared_mem::message::DeviceHealth;

use super::widgets::{GOOD, Mark, folded, line};
use super::{Link, UiState};
use crate::words::Words;

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

/// Shows all devices if `all`, else only lost ones that somebody can plug in again.
pub(super) fn devices(ui: &mut Ui, state: &UiState, all: bool) {
    let words = &state.words;
    let is_there = state.simulated.map(|it| !it && state.replay.is_none());
    for ((name, health), is_there) in state.devices().into_iter().zip(is_there) {
        let is_lost = health.is_some_and(|it| it.status == DeviceHealth::LOST);
        let is_shown = all || (is_lost && is_there);
        if !is_shown {
            continue;
        }
        let (mark, text) = device(words, &words.say(name), health);
        line(ui, mark, &text);
    }
}

/// Mark and text of a device's state.
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
    let steady = health.missed == 0 && health.late_ticks == 0;
    let mark = if steady { Mark::Good } else { Mark::Care };
    let rate = format!("{:.0}", health.rate_hz).into();
    line(ui, mark, &words.say_with("ticks-rate", &[("rate", rate)]));
    let values = [
        ("missed", health.missed.to_string().into()),
        ("late", health.late_ticks.to_string().into()),
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
    let title = words.say_with("graphics", &[("ms", total)]);
    folded(ui, "passes", title, |ui| {
        for (name, ms) in crate::render::timing::PASSES.iter().zip(times) {
            let name = words.say(&format!("pass-{name}"));
            let ms = words.number(ms.into(), 2);
            ui.label(words.say_with("pass-time", &[("name", name.into()), ("ms", ms.into())]));
        }
    });
}
