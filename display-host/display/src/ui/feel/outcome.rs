//! The outcome: each check with its result and its sentence.

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
    /// It was left out.
    Skipped,
}

/// A check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckLine {
    /// Its name, as in the terminal.
    pub name: String,
    /// Its result.
    pub result: CheckResult,
    /// Finding of the check, in English, as in the terminal.
    pub detail: String,
}

/// A test that is over.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ended {
    /// Name of the device.
    pub device: String,
    /// True if it passed.
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
        ui.horizontal(|ui| {
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
            ui.horizontal(|ui| {
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
