//! Rules that are read, refused and applied.

use proptest::prelude::*;
use shared_mem::scene::OrganKind;

use super::*;
use crate::alarm::AlarmKind;
use crate::metrics::{Metric, Values};
use crate::task::Difficulty;

fn refused(from: &str, to: &str) -> String {
    assert!(BUILT_IN.contains(from), "{from}");
    Rules::parse(&BUILT_IN.replacen(from, to, 1))
        .expect_err("refused")
        .to_string()
}

#[test]
fn the_built_in_rules_are_sound_and_say_what_every_task_asks() {
    let rules = Rules::parse(BUILT_IN).unwrap();
    assert_eq!(rules, Rules::default());
    for task in Task::ALL.into_iter().filter(|task| *task != Task::Free) {
        assert!(rules.time_max_s(task).is_finite(), "{}", task.name());
        assert!(
            !rules.pass(task, Difficulty::Trainee).is_empty(),
            "{}",
            task.name()
        );
    }
    assert!(rules.must_not_touch(Some(OrganKind::BileDuct)));
    assert!(!rules.must_not_touch(Some(OrganKind::CysticDuct)));
    assert!(rules.must_not_burn(Task::Full, Some(OrganKind::CysticDuct)));
}

#[test]
fn mistakes_are_named_with_their_line_and_the_allowed_values() {
    let line = |text: &str| {
        let at = BUILT_IN.find(text).unwrap();
        BUILT_IN[..at].matches('\n').count() + 1
    };
    let error = refused("triangle = 0.9", "triangle = 1.9");
    let expected = format!(
        "line {}: triangle is 1.9; allowed is 0 to 1",
        line("triangle =")
    );
    assert!(error.contains(&expected), "{error}");
    let error = refused("\"clips_lost\"", "\"clips_lots\"");
    let place = format!("line {}: a metric is clips_lots", line("\"clips_lost\""));
    assert!(
        error.contains(&place) && error.contains("clips_lost,"),
        "{error}"
    );
    let error = refused("\"stomach\"", "\"stomack\"");
    assert!(
        error.contains("an organ is stomack") && error.contains("stomach,"),
        "{error}"
    );
    let error = refused("open = \"fails\"", "open = \"kills\"");
    assert!(error.contains("open is kills; allowed is fails"), "{error}");
    assert!(refused("version = 1", "version = 2").contains("version is 2; allowed is 1"));
    assert!(refused("[task.scope]", "[task.dance]").contains("a task is dance"));
    assert!(refused("quiet_s = 1.0", "quiet_s = nan").contains("quiet_s is NaN"));
    assert!(refused("quiet_s = 1.0", "quit_s = 1.0").contains("quit_s"));
    assert!(refused("clips = 2", "clips = 0").contains("clips is 0; allowed is 1 to 3"));
    assert!(refused("clips = 2", "clips = 4").contains("allowed is 1 to 3"));
    assert!(Rules::parse(&"#".repeat(MAX_BYTES + 1)).is_err());
}

#[test]
fn a_rule_that_anybody_or_nobody_passes_is_refused() {
    let task = |pass: &str| {
        let from = BUILT_IN.find("[task.").unwrap();
        let text = format!("{}[task.cut]\npass = [{pass}]\n", &BUILT_IN[..from]);
        Rules::parse(&text).map_err(|error| error.to_string())
    };
    task("{ metric = \"score\", at_least = 5.0, at_most = 5.0 }").unwrap();
    let error = task("{ metric = \"score\" }").unwrap_err();
    assert!(
        error.contains("asked of score is nothing; allowed is at_least"),
        "{error}"
    );
    let error = task("{ metric = \"time_s\", at_least = 6.0, at_most = 5.0 }").unwrap_err();
    assert!(error.contains("at least 6 and at most 5"), "{error}");
}

#[test]
fn a_file_without_injuries_has_the_built_in_ones() {
    let tables: Vec<&str> = BUILT_IN.split("\n\n").collect();
    let without = tables.iter().filter(|it| !it.contains("[[injury]]"));
    let without: Vec<&str> = without.copied().collect();
    assert!(without.len() < tables.len());
    let rules = Rules::parse(&without.join("\n\n")).unwrap();
    assert_eq!(rules.injuries, Rules::default().injuries);
    let none = format!("injury = []\n{}", without.join("\n\n"));
    assert!(Rules::parse(&none).unwrap().injuries.is_empty());
}

/// A cap must not let a trainee pass who makes one kind of error again and again.
#[test]
fn enough_of_any_one_error_fails_an_operation() {
    let rules = Rules::default();
    for metric in rules.penalties.iter().map(|it| it.metric) {
        let mut values = Values::none();
        values.set(metric, 1e6);
        let (score, _) = rules.score(Task::Full, &values);
        assert!(score < 70.0, "{} {score}", metric.name());
    }
}

/// The careful scripted surgeon burns the liver with 340 J where it frees the gallbladder.
#[test]
fn heat_in_the_liver_costs_beyond_what_the_bed_takes() {
    let score = |heat_j| {
        let mut values = Values::none();
        values.set(Metric::BurnLiver, heat_j);
        Rules::default().score(Task::Disconnect, &values).0
    };
    assert!(score(340.0) > 99.9 && score(600.0) < 91.0 && score(900.0) < 70.0);
}

/// An alarm that costs nothing would let a poor surgeon pass.
#[test]
fn every_alarm_costs_points_in_an_operation() {
    let rules = Rules::default();
    for (kind, metric) in [
        (AlarmKind::Touched, Metric::TouchesWrong),
        (AlarmKind::Burnt, Metric::BurnsWrong),
        (AlarmKind::Cut, Metric::CutsWrong),
        (AlarmKind::Torn, Metric::Tears),
        (AlarmKind::Perforated, Metric::Perforations),
        (AlarmKind::Crushed, Metric::Crushes),
        (AlarmKind::ClipLost, Metric::ClipsLost),
        (AlarmKind::ClipMisplaced, Metric::ClipsMisplaced),
        (AlarmKind::TooEarly, Metric::ClipsEarly),
        (AlarmKind::Unseen, Metric::ActsBlind),
        (AlarmKind::Unclamped, Metric::Unclamped),
    ] {
        let mut values = Values::none();
        values.set(metric, 1.0);
        let (score, _) = rules.score(Task::Full, &values);
        assert!(score < 98.0, "{kind:?} {score}");
    }
}

/// Each of these is ruled out in every operation in which it can happen, whatever the score.
#[test]
fn a_clip_outside_the_picture_or_before_the_view_rules_out_a_pass() {
    let rules = Rules::default();
    for (task, metric, value) in [
        (Task::Clamp, Metric::ActsBlind, 1.0),
        (Task::Cut, Metric::ActsBlind, 1.0),
        (Task::Full, Metric::ActsBlind, 1.0),
        (Task::Full, Metric::ClipsEarly, 1.0),
        (Task::Clamp, Metric::ClipRoom, 1.0),
        (Task::Clamp, Metric::Perforations, 2.0),
        (Task::Cut, Metric::Perforations, 2.0),
        (Task::Identify, Metric::CauterySafe, 0.9),
        (Task::Disconnect, Metric::Tears, 2.0),
        (Task::Full, Metric::Tears, 2.0),
    ] {
        let mut values = Values::none();
        values.set(Metric::ViewsHeld, 2.0);
        values.set(metric, value);
        let unmet = rules.unmet(task, Difficulty::Trainee, 100.0, &values);
        assert_eq!(unmet.len(), 1, "{} {}", task.name(), metric.name());
    }
}

/// A poor surgeon must not pass an exam by starting over, by thinking while the clock stands, or
/// because the recording misses the errors.
#[test]
fn an_exam_has_one_attempt_no_pause_and_a_whole_recording() {
    let rules = Rules::default();
    for metric in [
        Metric::Restarts,
        Metric::Paused,
        Metric::Gaps,
        Metric::DeviceLost,
        Metric::LostEvents,
    ] {
        let mut values = Values::none();
        values.set(Metric::ViewsHeld, 2.0);
        let unmet =
            |difficulty, values: &Values| rules.unmet(Task::Identify, difficulty, 100.0, values);
        assert!(unmet(Difficulty::Exam, &values).is_empty());
        values.set(metric, 6.0);
        assert_eq!(
            unmet(Difficulty::Exam, &values).len(),
            1,
            "{}",
            metric.name()
        );
        assert!(
            unmet(Difficulty::Trainee, &values).is_empty(),
            "{}",
            metric.name()
        );
    }
}

/// One misplaced clip or wrong cut leaves enough points, but rules out a pass.
#[test]
fn one_clip_or_cut_in_the_wrong_place_rules_out_a_pass_in_every_operation() {
    let rules = Rules::default();
    for task in [
        Task::Identify,
        Task::Clamp,
        Task::Cut,
        Task::Disconnect,
        Task::Full,
    ] {
        for metric in [Metric::ClipsMisplaced, Metric::CutsWrong] {
            let mut values = Values::none();
            values.set(Metric::ViewsHeld, 2.0);
            values.set(metric, 1.0);
            let (score, _) = rules.score(task, &values);
            let unmet = rules.unmet(task, Difficulty::Trainee, score, &values);
            assert!(
                score > 70.0 && unmet.len() == 1,
                "{} {}",
                task.name(),
                metric.name()
            );
        }
    }
}

#[test]
fn rules_and_published_values_say_where_they_come_from() {
    let rules = Rules::default();
    let time = rules.time_rule(Task::Full).unwrap();
    assert!(time.source.contains("PMID 11285960"), "{}", time.source);
    let pass = rules.pass(Task::Full, Difficulty::Trainee);
    let of = |name: &str| {
        pass.iter()
            .find(|rule| rule.name == name)
            .map(|it| it.source)
    };
    assert_eq!(of("score"), Some("no source"));
    assert!(of("views_held").is_some_and(|it| it.contains("doublet view")));
    let identify = rules.pass(Task::Identify, Difficulty::Trainee);
    let safe = identify.iter().find(|rule| rule.name == "cautery_safe");
    assert!(safe.is_some_and(|it| it.source.contains("LAP Mentor")));
    assert_eq!(rules.weight_source(Task::Full, "burns_wrong"), "no source");
    assert!(
        rules
            .weight_source(Task::Full, "touches_wrong")
            .contains("OCHRA")
    );
    let own = |from: &str, to: &str| Rules::parse(&BUILT_IN.replacen(from, to, 1)).unwrap();
    let sourced = own(
        "each = 5.0\nmost = 50.0",
        "each = 5.0\nmost = 50.0\nsource = \"A 2020\"",
    );
    assert_eq!(sourced.weight_source(Task::Full, "burns_wrong"), "A 2020");
    let sourced = own(
        "at_least = 70.0 }",
        "at_least = 70.0, source = \"B 2021\" }",
    );
    assert_eq!(
        sourced.pass(Task::Identify, Difficulty::Trainee)[0].source,
        "B 2021"
    );
    for task in [Task::Identify, Task::Cut, Task::Full] {
        let mut references = rules.references(task);
        assert!(references.all(|it| !it.source.is_empty() && !it.who.is_empty()));
        assert!(rules.references(task).count() > 0, "{}", task.name());
    }
    for (from, to, error) in [
        (
            "task = \"cut\"",
            "task = \"dance\"",
            "a task is dance; allowed is basics, scope,",
        ),
        (
            "metric = \"movements\"\n",
            "metric = \"steps\"\n",
            "a metric is steps",
        ),
        ("value = 512.0", "value = nan", "a published value is NaN"),
        (
            "touch_n = 0.2",
            "touch_n = -1.0",
            "touch_n is -1; allowed is 0 to 100",
        ),
        (
            "liver = 1.0",
            "liver = -1.0",
            "press_n is -1; allowed is 0 to 100",
        ),
        (
            "liver = 1.0",
            "spleen = 1.0",
            "an organ is spleen; allowed is liver",
        ),
        (
            "burn = [\"liver\", \"gallbladder\"]",
            "burn = [\"spleen\"]",
            "an organ is spleen; allowed is liver",
        ),
    ] {
        let refused = refused(from, to);
        assert!(refused.contains(error), "{refused}");
    }
}

/// Texts under these keys, anywhere in a file.
fn texts_of(value: &toml::Value, keys: &[&str], found: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                match value.as_str() {
                    Some(text) if keys.contains(&key.as_str()) => found.push(text.to_owned()),
                    _ => texts_of(value, keys, found),
                }
            }
        }
        toml::Value::Array(all) => all.iter().for_each(|it| texts_of(it, keys, found)),
        _ => {}
    }
}

#[test]
fn sources_are_told_in_german_too() {
    let rules = Rules::default();
    let mut texts = Vec::new();
    let file: toml::Value = toml::from_str(BUILT_IN).unwrap();
    texts_of(&file, &["source", "time_source", "who"], &mut texts);
    assert!(texts.len() > 20, "{}", texts.len());
    // Some are nothing but names and numbers.
    for text in texts.iter().filter(|it| !it.starts_with("10.1007/")) {
        assert_ne!(rules.said("de", text), text);
        assert_eq!(rules.said("en", text), text);
    }
    assert_eq!(rules.said("de", "another source"), "another source");
}

#[test]
fn the_endoscope_drill_is_scored_by_its_camera_whatever_the_file() {
    let tables: Vec<&str> = BUILT_IN.split("\n\n").collect();
    let without = tables.iter().filter(|it| !it.contains("task.scope"));
    let without: Vec<&str> = without.copied().collect();
    assert!(without.len() < tables.len());
    let older = Rules::parse(&without.join("\n\n")).unwrap();
    let mut values = Values::none();
    values.set(Metric::OutOfView, 300.0);
    values.set(Metric::ScopeSway, 25.0);
    for rules in [Rules::default(), older] {
        let lost = |task| rules.score(task, &values).1;
        let of = |lost: Vec<Lost>| lost.iter().map(|it| it.metric).collect::<Vec<_>>();
        assert_eq!(of(lost(Task::Scope)), ["scope_sway_mm_s"]);
        assert_eq!(of(lost(Task::Identify)), ["out_of_view_s"]);
        assert!(rules.score(Task::Scope, &Values::none()).0 > 99.9);
    }
    let error = refused("\"scope_sway_mm_s\"", "\"scope_swing\"");
    assert!(error.contains("a metric is scope_swing"), "{error}");
}

#[test]
fn a_file_without_end_is_refused() {
    let error = Rules::read(std::path::Path::new("/dev/zero")).unwrap_err();
    assert!(error.to_string().contains("at most 65536"), "{error}");
}

#[test]
fn points_are_lost_beyond_what_is_free_and_bounded() {
    let rules = Rules::default();
    let mut values = Values::none();
    assert_eq!(
        rules.score(Task::Full, &values),
        (100.0, Vec::new()),
        "what is not known costs nothing"
    );
    values.set(Metric::ClipsLost, 1.0);
    values.set(Metric::CauteryAir, 2.0);
    assert!((rules.score(Task::Full, &values).0 - 95.0).abs() < 1e-9);
    values.set(Metric::ClipsLost, 1e9);
    assert!((rules.score(Task::Full, &values).0 - 60.0).abs() < 1e-9);
    values.set(Metric::Unclamped, 5.0);
    assert!(rules.score(Task::Full, &values).0 < 1e-9);
    assert!(
        !rules
            .unmet(Task::Clamp, Difficulty::Trainee, 0.0, &values)
            .is_empty()
    );
    assert!(
        rules
            .unmet(Task::Free, Difficulty::Exam, 0.0, &values)
            .is_empty()
    );
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,300}") {
        let _ = Rules::parse(&text);
    }

    #[test]
    fn damaged_rules_are_read_or_refused_and_score_within_bounds(
        at in 0.0f64..1.0, with in "[ -~\n]{0,6}", value in any::<f64>(),
    ) {
        let at = (at * BUILT_IN.len() as f64) as usize;
        let mut text = BUILT_IN.to_owned();
        if text.is_char_boundary(at) {
            text.insert_str(at, &with);
        }
        if let Ok(rules) = Rules::parse(&text) {
            let mut values = Values::none();
            for metric in Metric::ALL {
                values.set(metric, value);
            }
            for task in Task::ALL {
                let (score, _) = rules.score(task, &values);
                prop_assert!((0.0..=100.0).contains(&score));
            }
        }
    }
}
