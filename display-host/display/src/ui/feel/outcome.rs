//! Last screen of the hand test: the result and the finding of each check.

use egui::{Key, RichText, Ui};

use super::{View, Wish};
use crate::ui::page::{pressed, screen};
use crate::ui::screens::title;
use crate::ui::widgets::{Mark, sign};
use crate::words::Words;

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CheckResult {
    /// It passed.
    Pass,
    /// It failed.
    Fail,
    /// It could not be judged.
    Open,
    /// It does not apply to this device, or its tool was missing.
    Skipped,
}

/// A check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckLine {
    /// Its name, which the terminal shows too.
    pub name: String,
    /// Its result.
    pub result: CheckResult,
    /// Finding of the check: the terminal's English text.
    pub detail: String,
}

/// Results of a finished test.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ended {
    /// Name of the device.
    pub device: String,
    /// True if no check failed and every check that applies was judged.
    pub passed: bool,
    /// Its checks.
    pub checks: Vec<CheckLine>,
}

impl Ended {
    pub(super) fn headline(&self, words: &Words) -> String {
        words.say(match self.passed {
            true => "feel-passed",
            false => "feel-failed",
        })
    }
}

pub(super) fn show(ui: &mut Ui, view: &View, ended: &Ended, wishes: &mut Vec<Wish>) {
    let words = &view.words;
    if pressed(ui, Key::Escape) {
        wishes.push(Wish::Close);
    }
    let buttons = [(words.say("feel-close"), Wish::Close)];
    screen(ui, "outcome", Some(0), &buttons, wishes, |ui, _| {
        ui.horizontal_wrapped(|ui| {
            sign(ui, if ended.passed { Mark::Good } else { Mark::Bad });
            title(ui, &ended.headline(words));
        });
        ui.label(&ended.device);
        ui.add_space(10.0);
        for check in &ended.checks {
            let (mark, result) = match check.result {
                CheckResult::Pass => (Mark::Good, "feel-check-ok"),
                CheckResult::Fail => (Mark::Bad, "feel-check-fail"),
                CheckResult::Open => (Mark::Care, "feel-check-open"),
                CheckResult::Skipped => (Mark::Off, "feel-check-skipped"),
            };
            ui.horizontal_wrapped(|ui| {
                sign(ui, mark);
                let text = format!("{}: {}", check.name, words.say(result));
                ui.label(RichText::new(text).strong());
            });
            ui.indent("detail", |ui| ui.label(&check.detail));
        }
        ui.add_space(10.0);
        ui.label(words.say("feel-terminal"));
    });
}
