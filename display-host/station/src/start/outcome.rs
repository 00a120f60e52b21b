//! Builds the debrief of an operation from its folder and the store.

use std::path::Path;

use assess::report::Lesson;
use assess::{Act, Alarm, AlarmKind, Difficulty, Metric, Outcome, Reason, Rules, Task};
use display_host::ui::TaskNote;
use display_host::ui::launcher::{ClosePicture, Debrief, Earlier, LessonView, MetricRow};
use display_host::words::Words;
use serde::Deserialize as _;
use serde_json::Value;
use shared_mem::words::ActKind;
use store::Store;

use super::problem;
use crate::report::close_file;
use crate::store::{SessionCriteria, past};

/// Metrics shown for an operation, in addition to those of its pass rule.
const OF_OPERATION: [Metric; 10] = [
    Metric::Time,
    Metric::Alarms,
    Metric::Path,
    Metric::Economy,
    Metric::PressWrongMax,
    Metric::Force95,
    Metric::CauteryAir,
    Metric::Blood,
    Metric::Bile,
    Metric::OutOfView,
];
/// Metrics shown for the endoscope drill, in which the instrument has no part.
const OF_DRILL: [Metric; 6] = [
    Metric::Time,
    Metric::Alarms,
    Metric::ScopePath,
    Metric::ScopeTurn,
    Metric::ScopeTilt,
    Metric::ScopeSway,
];
/// Metrics shown only if their value matters. They are rare, the trainee does not cause them, or
/// they explain other metrics.
const SHOWN_IF_ANY: [Metric; 6] = [
    Metric::StonesSpilled,
    Metric::StonesLeft,
    Metric::Paused,
    Metric::Gaps,
    Metric::DeviceLost,
    Metric::Noise,
];
/// Largest number of warnings shown.
const WARNINGS_MAX: usize = 4;

/// Debrief of an operation and the id of its session. Returns `None` if the operation left no
/// result.
pub(super) fn read(
    out: &Path,
    trainee: &str,
    rules: &Rules,
    store: &Result<Store, String>,
    words: &Words,
) -> Option<(Debrief, String)> {
    let text = std::fs::read_to_string(out.join("summary.json")).ok()?;
    let summary: Value = serde_json::from_str(&text).ok()?;
    let text = |key: &str| summary[key].as_str().map(str::to_owned);
    let (task, session) = (text("task")?, text("session")?);
    let difficulty = text("difficulty").unwrap_or_default();
    let version = summary["metrics_version"].as_u64().unwrap_or(0) as u32;
    let criteria = SessionCriteria {
        task: &task,
        difficulty: &difficulty,
        version,
    };
    let before = match (store, trainee) {
        (_, "") => None,
        (Ok(store), _) => {
            let found = past(store, trainee, criteria, &session);
            Some(found.map_err(|it| problem::of_store(words, &it)))
        }
        (Err(problem), _) => Some(Err(problem.clone())),
    };
    let (before, problem) = match before {
        Some(Ok(before)) => (Some(before), None),
        Some(Err(problem)) => (None, Some(problem)),
        None => (None, None),
    };
    let (past, sheet) = before.map_or_else(Default::default, |it| (it.past, it.sheet));
    let report = out.join("debrief.html");
    let score = summary["score"].as_f64().unwrap_or(0.0);
    let debrief = Debrief {
        watched: text("hand").is_some_and(|hand| hand == store::Hand::Scripted.name()),
        trainee: trainee.to_owned(),
        outcome: text("outcome").unwrap_or_default(),
        reasons: reasons(&summary),
        score,
        unfinished: unfinished(&summary),
        lessons: lessons(out, &summary),
        acts: acts(&summary),
        lost: lost(&summary, words),
        can_replay: crate::report::recording(out).exists(),
        metrics: rows(&task, rules, &summary, &past),
        earlier: past
            .into_iter()
            .map(|it| Earlier {
                when: it.when,
                outcome: it.outcome,
                score: it.score,
            })
            .collect(),
        report: report.exists().then(|| report.display().to_string()),
        sheet: sum(&sheet),
        warnings: problem.into_iter().collect(),
        machine: unrest(&summary, words)
            .into_iter()
            .take(WARNINGS_MAX)
            .chain(others(&summary, words))
            .collect(),
        task,
        difficulty,
        ..Debrief::default()
    };
    Some((debrief, session))
}

/// Sum of an instructor's points, if there are any.
pub(super) fn sum(sheet: &[(String, u8)]) -> Option<u32> {
    let points = sheet.iter().map(|(_, points)| u32::from(*points));
    (!sheet.is_empty()).then(|| points.sum())
}

/// Organs that fell, shook or hold the instrument inside, in the user's language.
fn unrest(summary: &Value, words: &Words) -> Vec<String> {
    let all = summary["unrest"].as_array().into_iter().flatten();
    let sentence = |it: &Value| {
        let id = match it["what"].as_str()? {
            "fall" => "unrest-falls",
            "shake" => "unrest-shakes",
            "buried" => "unrest-buried",
            _ => return None,
        };
        let organ = words.organ(&session::printable(it["organ"].as_str()?));
        Some(words.say_with(id, &[("organ", organ.into())]))
    };
    all.filter_map(sentence).collect()
}

/// A sentence about the run's other warnings, if there are any. They are in English and for
/// engineers, who find them in the page about the station.
fn others(summary: &Value, words: &Words) -> Option<String> {
    let all = summary["unrest"].as_array().into_iter().flatten();
    let known: Vec<_> = all.filter_map(|it| it["warning"].as_str()).collect();
    let warnings = summary["warnings"].as_array().into_iter().flatten();
    let others = warnings.filter(|it| it.as_str().is_some_and(|it| !known.contains(&it)));
    let count = others.count();
    let told = || words.say_with("debrief-machine-more", &[("count", count.into())]);
    (count > 0).then(told)
}

/// Reasons for the outcome, without kinds that this program does not know.
fn reasons(summary: &Value) -> Vec<Reason> {
    let all = summary["reason_kinds"].as_array().into_iter().flatten();
    all.filter_map(|it| Reason::deserialize(it).ok()).collect()
}

/// Acts of an instructor, without those that this program does not understand.
fn acts(summary: &Value) -> Vec<Act> {
    let all = summary["acts"].as_array().into_iter().flatten();
    let act = |it: &Value| {
        let act = Act::deserialize(it).ok()?;
        ActKind::ALL.iter().find(|kind| kind.name() == act.kind)?;
        let remark = act.remark.as_deref().map(session::printable);
        Some(Act { remark, ..act })
    };
    all.filter_map(act).collect()
}

/// Lessons of the summary's errors, each with its close picture if there is one.
fn lessons(out: &Path, summary: &Value) -> Vec<LessonView> {
    let all = summary["alarms"].as_array().into_iter().flatten();
    let alarm = |(number, it): (usize, &Value)| {
        let seconds = |key: &str| it[key].as_f64().unwrap_or(0.0);
        let alarm = Alarm {
            at_s: seconds("at_s"),
            session_s: seconds("session_s"),
            kind: AlarmKind::deserialize(&it["kind"]).ok()?,
            organ: it["organ"].as_str().map(str::to_owned),
            at_m: [0.0; 3],
        };
        Some((number, alarm))
    };
    // The numbers of close pictures count all alarms, also those that this program does not know.
    let (numbers, alarms): (Vec<usize>, Vec<Alarm>) = all.enumerate().filter_map(alarm).unzip();
    let view = |lesson: Lesson| {
        let own = lesson.alarms.iter().filter_map(|it| alarms.get(*it));
        let first = lesson.alarms.first().and_then(|it| numbers.get(*it));
        LessonView {
            note: TaskNote {
                kind: lesson.kind.name().to_owned(),
                organ: lesson.organ.clone(),
            },
            moments: own.map(|it| [it.at_s, it.session_s]).collect(),
            close: first.and_then(|it| ClosePicture::read(&close_file(out, *it))),
        }
    };
    Lesson::of(&alarms).into_iter().map(view).collect()
}

/// Score that the work of an aborted task would have had. The score of such a task is 0.
fn unfinished(summary: &Value) -> Option<f64> {
    let is_aborted = summary["outcome"].as_str() == Some(Outcome::Aborted.name());
    let all = summary["lost"].as_array().into_iter().flatten();
    let lost: f64 = all.filter_map(|it| it["points"].as_f64()).sum();
    is_aborted.then(|| (100.0 - lost).max(0.0))
}

/// Metrics with advice, and the points that they lost. Other metrics count errors, which the
/// lessons explain.
fn lost(summary: &Value, words: &Words) -> Vec<(String, f64)> {
    let all = summary["lost"].as_array().into_iter().flatten();
    let found = all.filter_map(|it| {
        let metric = it["metric"].as_str()?.to_owned();
        Some((metric, it["points"].as_f64()?))
    });
    let has_advice = |metric: &str| {
        let id = format!("advice-metric-{}", metric.replace('_', "-"));
        assess::report::Words::has(words, &id)
    };
    found.filter(|(metric, _)| has_advice(metric)).collect()
}

/// Rows of metrics: first those of the pass rule, then the usual ones of the task. Each has the
/// best value of passed earlier sessions.
fn rows(
    task: &str,
    rules: &Rules,
    summary: &Value,
    past: &[assess::report::Past],
) -> Vec<MetricRow> {
    let task = Task::from_name(task);
    let difficulty = summary["difficulty"]
        .as_str()
        .and_then(Difficulty::from_name);
    let difficulty = difficulty.unwrap_or_default();
    let pass = task.map_or_else(Vec::new, |task| rules.pass(task, difficulty));
    let ruled = pass.iter().map(|it| it.name);
    let usual = match task {
        Some(Task::Scope) => &OF_DRILL[..],
        _ => &OF_OPERATION[..],
    };
    let usual = usual.iter().map(|it| it.name());
    let any = |metric: &&Metric| {
        summary["metrics"][metric.name()]
            .as_f64()
            .is_some_and(|it| metric.is_worth_mention(it))
    };
    let extra = SHOWN_IF_ANY.iter().filter(any).map(|it| it.name());
    let usual = usual.chain(extra);
    let usual = usual.filter(|name| pass.iter().all(|it| it.name != *name));
    ruled
        .chain(usual)
        .map(|name| {
            let value = match name {
                "score" => summary["score"].as_f64(),
                name => summary["metrics"][name].as_f64(),
            };
            let rule = pass.iter().find(|it| it.name == name);
            let passes = rule.map(|it| [it.at_least, it.at_most]);
            // A session that failed early is short, so the best values come from passed sessions.
            let passed = past.iter().filter(|it| it.outcome == "passed");
            let earlier = passed.filter_map(|it| match name {
                "score" => Some(it.score),
                name => it.metrics.get(name).copied(),
            });
            let more_is_better = passes.is_some_and(|[least, _]| least.is_finite());
            let best = match more_is_better {
                true => earlier.reduce(f64::max),
                false => earlier.reduce(f64::min),
            };
            // Economy is no judgement: neither more nor less is better.
            let judges = passes.is_some() || name != Metric::Economy.name();
            MetricRow {
                name: name.to_owned(),
                unit: Metric::from_name(name).map_or("n", Metric::unit).to_owned(),
                value,
                passes,
                best: best.filter(|_| judges),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Debrief for a trainee whose store cannot be opened.
    fn read_it(out: &Path, trainee: &str) -> Option<(Debrief, String)> {
        let store = Err("it is in use".to_owned());
        read(out, trainee, &Rules::default(), &store, &Words::default())
    }

    fn folder(text: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("summary.json"), text).unwrap();
        folder
    }

    #[test]
    fn a_summary_is_a_debrief_with_the_pass_rule_first() {
        let folder = folder(
            r#"{"task": "clamp", "difficulty": "trainee", "outcome": "failed",
                "reason_kinds": [{"kind": "bored"}, {"kind": "too-long", "seconds": 60.0}],
                "score": 61.0, "session": "s", "metrics_version": 1, "warnings": ["\u001b[31mred"],
                "alarms": [{"at_s": 75.5, "session_s": 80.0, "kind": "burnt", "organ": "liver"},
                           {"at_s": 80.5, "session_s": 85.0, "kind": "bored", "organ": "liver"},
                           {"at_s": 90.0, "session_s": 95.0, "kind": "burnt", "organ": "liver"}],
                "lost": [{"metric": "blood_ml", "value": 9.0, "points": 4.5},
                         {"metric": "burns_wrong", "value": 2.0, "points": 10.0}],
                "metrics": {"time_s": 80.0, "economy": null, "paused_s": 0.2, "gaps_s": 0.05}}"#,
        );
        let (debrief, session) = read_it(folder.path(), "").unwrap();
        assert_eq!((&*session, &*debrief.outcome), ("s", "failed"));
        assert_eq!(debrief.reasons, [Reason::TooLong { seconds: 60.0 }]);
        assert_eq!(debrief.lessons[0].note.organ.as_deref(), Some("liver"));
        assert_eq!(debrief.lessons[0].moments, [[75.5, 80.0], [90.0, 95.0]]);
        assert_eq!(debrief.lost, [("blood_ml".to_owned(), 4.5)]);
        assert!(!debrief.can_replay, "there is no recording");
        assert_eq!(debrief.report, None, "there is no page in the folder");
        assert!(debrief.machine[0].contains("report.html"));
        let ruled = debrief.metrics.iter().take_while(|it| it.passes.is_some());
        assert!(ruled.count() >= 2, "{:?}", debrief.metrics);
        let named: std::collections::BTreeSet<_> =
            debrief.metrics.iter().map(|it| &it.name).collect();
        assert_eq!(
            named.len(),
            debrief.metrics.len(),
            "each metric appears once"
        );
        let time = debrief.metrics.iter().find(|it| it.name == "time_s");
        assert_eq!(time.unwrap().value, Some(80.0));
        assert!(named.contains(&"paused_s".to_owned()));
        assert!(!named.contains(&"gaps_s".to_owned()), "too short");
    }

    #[test]
    fn the_debrief_of_an_aborted_task_has_the_score_of_its_work_and_the_hardest_press() {
        let of = |outcome: &str| {
            let text = format!(
                r#"{{"task": "clamp", "session": "s", "outcome": "{outcome}", "score": 0.0,
                    "lost": [{{"metric": "clips_lost", "value": 4.0, "points": 20.0}}],
                    "metrics": {{"press_wrong_max_n": 2.9, "force_p95_n": 0.0}}}}"#
            );
            read_it(folder(&text).path(), "").unwrap().0
        };
        let aborted = of("aborted");
        assert_eq!(aborted.unfinished, Some(80.0));
        assert_eq!(of("failed").unfinished, None);
        let mut rows = aborted.metrics.iter();
        let press = rows.find(|it| it.name == "press_wrong_max_n").unwrap();
        assert_eq!(press.value, Some(2.9));
    }

    #[test]
    fn a_store_that_cannot_be_opened_is_a_warning_to_trainees_and_not_to_guests() {
        let folder = folder(r#"{"task": "clamp", "session": "s", "warnings": ["late"]}"#);
        let warnings = |trainee| {
            let debrief = read_it(folder.path(), trainee).unwrap().0;
            (debrief.warnings, debrief.machine)
        };
        let late = vec![
            "Warnings about the station: 1. They are in report.html, in the session's folder."
                .to_owned(),
        ];
        assert_eq!(
            warnings("Ada"),
            (vec!["it is in use".to_owned()], late.clone())
        );
        assert_eq!(warnings(""), (Vec::new(), late));
    }

    #[test]
    fn a_camera_drill_shows_its_camera_and_not_the_instrument() {
        let folder = folder(
            r#"{"task": "scope", "session": "s", "metrics": {"scope_sway_mm_s": 3.0,
                "out_of_view_s": 200.0}}"#,
        );
        let (debrief, _) = read_it(folder.path(), "").unwrap();
        let shown = |name: &str| debrief.metrics.iter().find(|it| it.name == name);
        assert_eq!(shown("scope_sway_mm_s").and_then(|it| it.value), Some(3.0));
        assert!(shown("out_of_view_s").is_none() && shown("blood_ml").is_none());
    }

    #[test]
    fn a_file_that_is_no_summary_of_a_task_gives_no_debrief() {
        for text in ["", "{}", "[]", r#"{"task": 5}"#] {
            let found = read_it(folder(text).path(), "");
            assert!(found.is_none(), "{text}");
        }
        assert!(read_it(Path::new("/nowhere"), "").is_none());
    }

    #[test]
    fn every_metric_that_may_be_shown_has_a_name_in_every_language() {
        use display_host::words::Language;
        for language in Language::ALL {
            let words = Words::new(language);
            for metric in Metric::ALL {
                let id = format!("metric-{}", metric.name().replace('_', "-"));
                assert_ne!(words.say(&id), id, "{language:?}");
            }
            for task in Task::ALL {
                let id = format!("start-asks-{}", task.name());
                assert_ne!(words.say(&id), id, "{language:?}");
            }
            for (name, _) in store::GOALS {
                let id = format!("goals-{name}");
                assert_ne!(words.say(&id), id, "{language:?}");
            }
            for item in store::Questionnaire::default().items {
                let id = format!("question-{}", item.id);
                assert_ne!(words.say(&id), id, "{language:?}");
            }
        }
    }
}
