//! The debrief: outcome, score, errors, and results compared with the pass rules and earlier
//! sessions.

use assess::{Act, Reason};
use egui::{Grid, Key, Label, RichText, Ui};

use super::lessons::{self, LessonView, Lessons};
use super::progress::{self, ProgressView};
use super::{Asking, Name, Wish, minutes, pressed, screen};
use crate::ui::names;
use crate::ui::screens::{BODY_POINTS, part, title};
use crate::ui::widgets::{Mark, folded, line, sign};
use crate::words::Words;

/// Largest number of earlier sessions in the list.
const EARLIER_MAX: usize = 5;

/// Width of a page below which everything stands in one column, points.
const SIDE_BY_SIDE_POINTS: f32 = 1100.0;

/// Smallest width of the table of results, points.
const TABLE_WIDTH_MIN_POINTS: f32 = 600.0;

/// Content of a debrief.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Debrief {
    /// Name of the trainee; empty: a guest, whose session counts for nobody.
    pub trainee: String,
    /// True if the scripted expert operated.
    pub watched: bool,
    /// Name of the task.
    pub task: String,
    /// Degree of help: a difficulty's name.
    pub difficulty: String,
    /// Outcome, as in `summary.json`.
    pub outcome: String,
    /// Reasons for the outcome.
    pub reasons: Vec<Reason>,
    /// Score, 0 to 100.
    pub score: f64,
    /// Score that the work would have had, if the task was not finished: its score is 0.
    pub unfinished: Option<f64>,
    /// Errors, the gravest first.
    pub lessons: Vec<LessonView>,
    /// Metrics that cost points, each with the lost points. An error in `lessons` explains none of
    /// them.
    pub lost: Vec<(String, f64)>,
    /// Acts of an instructor.
    pub acts: Vec<Act>,
    /// True if the recording is there to be replayed.
    pub can_replay: bool,
    /// Rows of the results.
    pub metrics: Vec<MetricRow>,
    /// Earlier comparable sessions, the oldest first.
    pub earlier: Vec<Earlier>,
    /// Progress of the trainee in the curriculum; `None` for a guest.
    pub progress: Option<ProgressView>,
    /// Path of the full report, if written.
    pub report: Option<String>,
    /// True if the questionnaire was answered since the launcher started.
    pub answered: bool,
    /// Sum of the instructor's points, if given.
    pub sheet: Option<u32>,
    /// Warnings to the trainee.
    pub warnings: Vec<String>,
    /// Warnings of the machine, for engineers, in English.
    pub machine: Vec<String>,
    /// Result of the last request.
    pub notice: Option<String>,
}

/// A metric, its pass rule and its earlier best.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MetricRow {
    /// Name, as in `summary.json`.
    pub name: String,
    /// Unit of the metric; `1` for a share, `n` for a count.
    pub unit: String,
    /// Value of the metric; `None` if it was not measured.
    pub value: Option<f64>,
    /// Least and largest value that pass. A bound that is not finite sets no limit.
    pub passes: Option<[f64; 2]>,
    /// Best value of earlier sessions.
    pub best: Option<f64>,
}

impl MetricRow {
    /// True if the value meets the rule. `None` without a rule or without a value.
    fn is_met(&self) -> Option<bool> {
        let [least, most] = self.passes?;
        let value = self.value?;
        Some(!(value < least || value > most))
    }

    /// Text of the value.
    fn now(&self, words: &Words) -> String {
        let amount = self.value.map(|it| words.amount(it, &self.unit));
        amount.unwrap_or_else(|| "–".to_owned())
    }

    /// Texts of the pass rule and of the earlier best, empty if there is none.
    fn beside(&self, words: &Words) -> [String; 2] {
        let rule = self.passes.map(|it| bounds(words, it, &self.unit));
        let best = self.best.map(|it| words.amount(it, &self.unit));
        [rule, best].map(Option::unwrap_or_default)
    }
}

/// An earlier session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Earlier {
    /// Time, as text.
    pub when: String,
    /// Its outcome.
    pub outcome: String,
    /// Score, 0 to 100.
    pub score: f64,
}

pub(super) fn show(ui: &mut Ui, words: &Words, debrief: &Debrief, wishes: &mut Vec<Wish>) {
    let again = match debrief.watched {
        true => words.say("debrief-own-turn"),
        false => words.say("debrief-again"),
    };
    let mut buttons = vec![
        (again, Wish::Again),
        (words.say("debrief-another"), Wish::Another),
    ];
    let next = debrief.progress.as_ref();
    buttons.extend(next.and_then(|it| progress::button(words, it)));
    if next.is_some_and(|it| it.has_certificate) {
        buttons.push((words.say("certificate"), Wish::Certificate));
    }
    if debrief.report.is_some() {
        buttons.push((words.say("debrief-report"), Wish::OpenReport));
    }
    // The session of a guest is not stored, so it has neither questionnaire nor sheet.
    if !debrief.trainee.is_empty() {
        let questions = Wish::Ask(Asking::Questions);
        buttons.push((words.say("debrief-questions"), questions));
        buttons.push((words.say("debrief-sheet"), Wish::Ask(Asking::Sheet)));
    }
    let keys = [
        (Key::Escape, Wish::Another),
        (Key::N, Wish::Next),
        (Key::C, Wish::Certificate),
        (Key::R, Wish::OpenReport),
        (Key::Q, Wish::Ask(Asking::Questions)),
        (Key::I, Wish::Ask(Asking::Sheet)),
    ];
    let offered = |wish: &Wish| buttons.iter().any(|(_, it)| it == wish);
    let keyed = keys.into_iter().find(|(key, _)| pressed(ui, *key));
    wishes.extend(keyed.map(|(_, wish)| wish).filter(offered));
    let lessons = Lessons {
        errors: &debrief.lessons,
        lost: &debrief.lost,
        reasons: &debrief.reasons,
        can_replay: debrief.can_replay,
    };
    // The report's path names the session, so that the debrief of another one opens at its top.
    let name = Name {
        screen: "debrief",
        of: debrief.report.as_deref().unwrap_or_default(),
        notice: debrief.notice.as_deref(),
    };
    screen(ui, name, Some(0), &buttons, wishes, |ui, wishes| {
        head(ui, words, debrief);
        if ui.available_width() < SIDE_BY_SIDE_POINTS {
            lessons::show(ui, words, lessons, wishes);
            acts(ui, words, debrief, wishes);
            table(ui, words, debrief);
            past(ui, words, debrief);
            return;
        }
        ui.columns(2, |columns| {
            if let [left, right] = columns {
                left.vertical(|ui| {
                    lessons::show(ui, words, lessons, wishes);
                    acts(ui, words, debrief, wishes);
                    past(ui, words, debrief);
                });
                right.vertical(|ui| table(ui, words, debrief));
            }
        });
    });
}

fn head(ui: &mut Ui, words: &Words, debrief: &Debrief) {
    let task = words.say(&format!("task-{}", debrief.task));
    let difficulty = words.say(&format!("difficulty-{}", debrief.difficulty));
    let who = match debrief.trainee.as_str() {
        _ if debrief.watched => words.say("who-expert"),
        "" => words.say("start-nobody"),
        name => names::drawn(name),
    };
    ui.label(format!("{who} – {task} – {difficulty}"));
    let mark = match debrief.outcome.as_str() {
        "passed" => Mark::Good,
        "practised" => Mark::Off,
        _ => Mark::Bad,
    };
    ui.horizontal_wrapped(|ui| {
        line(ui, mark, "");
        title(ui, &words.say(&format!("outcome-{}", debrief.outcome)));
        let score = format!("{:.0}", debrief.score).into();
        let score = words.say_with("task-score", &[("score", score)]);
        ui.label(RichText::new("·").size(1.6 * BODY_POINTS));
        ui.label(RichText::new(score).size(1.6 * BODY_POINTS));
    });
    if let Some(score) = debrief.unfinished {
        let score = format!("{score:.0}").into();
        ui.label(words.say_with("page-unfinished", &[("score", score)]));
    }
    let open: Vec<String> = (debrief.reasons.iter())
        .filter_map(|it| it.open_step().map(|step| words.step(step)))
        .collect();
    // One line for all open steps, so that the lessons stay near the top.
    if !open.is_empty() {
        let what = [("step", open.join("; ").into())];
        ui.label(lessons::capital(&words.say_with("reason-not-done", &what)));
    }
    for reason in debrief.reasons.iter().filter(|it| it.open_step().is_none()) {
        ui.label(lessons::capital(&words.reason(reason)));
    }
    if debrief.answered {
        line(ui, Mark::Good, &words.say("debrief-answered"));
    }
    if let Some(points) = debrief.sheet {
        let points = points.to_string().into();
        let text = words.say_with("debrief-sheet-points", &[("points", points)]);
        line(ui, Mark::Good, &text);
    }
    for warning in &debrief.warnings {
        line(ui, Mark::Care, warning);
    }
    if !debrief.machine.is_empty() {
        folded(ui, "machine", words.say("debrief-machine"), |ui| {
            for warning in &debrief.machine {
                line(ui, Mark::Care, warning);
            }
        });
    }
}

/// Shows what an instructor did, and buttons that replay it.
fn acts(ui: &mut Ui, words: &Words, debrief: &Debrief, wishes: &mut Vec<Wish>) {
    if debrief.acts.is_empty() {
        return;
    }
    part(ui, &words.say("page-acts"));
    for act in &debrief.acts {
        let what = match &act.remark {
            Some(remark) => remark.clone(),
            None => words.say(&act.message()),
        };
        let text = format!("{}  {what}", minutes(act.at_s));
        if debrief.can_replay {
            if ui.button(text).clicked() {
                wishes.push(Wish::Replay(act.session_s));
            }
        } else {
            ui.label(text);
        }
    }
}

fn past(ui: &mut Ui, words: &Words, debrief: &Debrief) {
    if let Some(view) = &debrief.progress {
        progress::after(ui, words, view);
    }
    part(ui, &words.say("debrief-past"));
    if debrief.earlier.is_empty() {
        ui.label(words.say("debrief-no-past"));
    }
    for it in debrief.earlier.iter().rev().take(EARLIER_MAX) {
        let outcome = words.say(&format!("outcome-{}", it.outcome));
        let score = format!("{:.0}", it.score).into();
        let score = words.say_with("task-score", &[("score", score)]);
        ui.label(format!("{}  {outcome}, {score}", it.when));
    }
}

fn table(ui: &mut Ui, words: &Words, debrief: &Debrief) {
    part(ui, &words.say("debrief-metrics"));
    if ui.available_width() < TABLE_WIDTH_MIN_POINTS {
        return list(ui, words, debrief);
    }
    Grid::new("metrics")
        .num_columns(4)
        .striped(true)
        .spacing([12.0, 6.0])
        .show(ui, |ui| {
            for id in ["metric", "metric-now", "metric-rule", "metric-best"] {
                ui.label(RichText::new(words.say(id)).weak());
            }
            ui.end_row();
            for row in &debrief.metrics {
                ui.label(words.metric(&row.name));
                let now = row.now(words);
                match row.is_met() {
                    Some(met) => {
                        let mark = if met { Mark::Good } else { Mark::Bad };
                        // The value stays on one line, because a column of a table does not wrap.
                        ui.horizontal(|ui| {
                            sign(ui, mark);
                            ui.add(Label::new(&now).extend());
                        });
                    }
                    None => {
                        ui.label(now);
                    }
                }
                for text in row.beside(words) {
                    ui.label(text);
                }
                ui.end_row();
            }
        });
}

/// Shows the results below each other, where a table has too little room.
fn list(ui: &mut Ui, words: &Words, debrief: &Debrief) {
    for row in &debrief.metrics {
        let text = format!("{}: {}", words.metric(&row.name), row.now(words));
        match row.is_met() {
            Some(true) => line(ui, Mark::Good, &text),
            Some(false) => line(ui, Mark::Bad, &text),
            None => {
                ui.label(text);
            }
        }
        let beside = ["metric-rule", "metric-best"]
            .into_iter()
            .zip(row.beside(words));
        for (id, text) in beside.filter(|(_, text)| !text.is_empty()) {
            ui.label(RichText::new(format!("{}: {text}", words.say(id))).weak());
        }
    }
}

fn bounds(words: &Words, [least, most]: [f64; 2], unit: &str) -> String {
    let [low, high] = [least, most].map(|it| words.amount(it, unit));
    match (least.is_finite(), most.is_finite()) {
        (true, true) => format!("{low} – {high}"),
        (true, false) => format!("≥ {low}"),
        // At most none of a thing that is counted is none.
        (false, true) if unit == "n" && most < 1.0 => words.say("metric-none"),
        (false, true) => format!("≤ {high}"),
        (false, false) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_have_their_bounds() {
        let words = Words::default();
        assert_eq!(bounds(&words, [f64::NEG_INFINITY, 600.0], "s"), "≤ 600 s");
        assert_eq!(bounds(&words, [0.9, f64::INFINITY], "1"), "≥ 90 %");
        assert_eq!(bounds(&words, [f64::NEG_INFINITY, 0.0], "n"), "none");
        assert_eq!(bounds(&words, [f64::NEG_INFINITY, 2.0], "n"), "≤ 2");
    }

    #[test]
    fn a_rule_is_met_between_its_bounds() {
        let row = |value| MetricRow {
            value,
            passes: Some([f64::NEG_INFINITY, 2.0]),
            ..MetricRow::default()
        };
        assert_eq!(row(Some(2.0)).is_met(), Some(true));
        assert_eq!(row(Some(2.1)).is_met(), Some(false));
        assert_eq!(row(None).is_met(), None);
    }
}
