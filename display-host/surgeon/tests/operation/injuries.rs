//! Surgeons that injure a structure: outcome, alarms, score and the injury's record.

use assess::Severity::{Grave, Minor, Serious};
use assess::{AlarmKind, Cause, InjuryKind, Metric, Outcome, Severity, Task};
use surgeon::Surgeon;

use crate::operate;

/// An injury that a surgeon causes, and its alarm.
type Done = (
    Surgeon,
    u64,
    &'static str,
    InjuryKind,
    Cause,
    Severity,
    AlarmKind,
);

/// No injury passes, except that of the gallbladder. An opened bile duct or hepatic artery ends the
/// task at once. A bile duct that is burnt beyond the limit of the rules never passes, with a hole
/// or without.
#[test]
fn every_injury_ends_the_task_or_rules_out_a_pass() {
    use {AlarmKind as A, InjuryKind as K, Surgeon as S};
    let injuries: [Done; 8] = [
        (
            S::DuctCutter,
            12,
            "bile duct",
            K::Divided,
            Cause::Cut,
            Grave,
            A::Cut,
        ),
        (
            S::DuctTearer,
            14,
            "bile duct",
            K::Divided,
            Cause::Torn,
            Grave,
            A::Torn,
        ),
        (
            S::DuctScorcher,
            24,
            "bile duct",
            K::Perforated,
            Cause::Burnt,
            Grave,
            A::Perforated,
        ),
        (
            S::DuctCoagulator,
            30,
            "bile duct",
            K::Perforated,
            Cause::Burnt,
            Grave,
            A::Perforated,
        ),
        (
            S::Burner,
            22,
            "bile duct",
            K::Burnt,
            Cause::Burnt,
            Serious,
            A::Burnt,
        ),
        (
            S::ArteryCutter,
            10,
            "hepatic artery",
            K::Divided,
            Cause::Cut,
            Grave,
            A::Cut,
        ),
        (
            S::ArteryScorcher,
            24,
            "hepatic artery",
            K::Perforated,
            Cause::Burnt,
            Grave,
            A::Perforated,
        ),
        (
            S::BowelBurner,
            16,
            "duodenum",
            K::Burnt,
            Cause::Burnt,
            Serious,
            A::Burnt,
        ),
    ];
    for (surgeon, seconds, organ, kind, cause, severity, alarm) in injuries {
        let result = operate(surgeon, Task::Identify, seconds);
        let it = &result.assessed;
        let is_it = |injury: &&assess::Injury| injury.organ == organ && injury.kind == kind;
        let found = it.injuries.iter().find(is_it);
        let found = found.unwrap_or_else(|| panic!("{surgeon:?}: {:?}", it.injuries));
        assert_eq!(
            (found.cause, found.severity),
            (cause, severity),
            "{surgeon:?}"
        );
        let end_s = result.ticks as f64 * 1e-3;
        assert!((1.0..=end_s).contains(&found.at_s), "{surgeon:?} {found:?}");
        let told = |it: &assess::Alarm| it.kind == alarm && it.organ.as_deref() == Some(organ);
        assert!(it.alarms.iter().any(told), "{surgeon:?} {:?}", it.alarms);
        // An aborted task scores 0, so the score is that before its end.
        let (score, lost) = assess::Rules::default().score(Task::Identify, &it.metrics);
        assert!(score <= 60.0, "{surgeon:?} {score} {lost:?}");
        assert_eq!(found.ends_task, severity == Grave, "{surgeon:?}");
        match severity {
            Grave => assert_eq!(it.outcome, Outcome::Failed, "{surgeon:?}"),
            _ => assert_ne!(it.outcome, Outcome::Passed, "{surgeon:?}"),
        }
    }
}

/// Bile is lost, and that costs points.
#[test]
fn a_gallbladder_that_is_burnt_through_counts_as_perforated() {
    let result = operate(Surgeon::BagBurner, Task::Identify, 30);
    let it = &result.assessed;
    let perforations = it.metrics.get(Metric::Perforations);
    assert!(perforations >= 1.0, "{:?}", result.said);
    let name = Metric::Perforations.name();
    assert!(
        it.lost.iter().any(|lost| lost.metric == name),
        "{:?}",
        it.lost
    );
    let injury = it.injuries.iter().find(|it| it.organ == "gallbladder");
    let injury = injury.expect("it is noted");
    assert_eq!((injury.severity, injury.cause), (Minor, Cause::Burnt));
    assert_ne!(it.outcome, Outcome::Passed);
}

/// Clips need no current. Score, alarms and debrief tell the burn where nothing is to be burnt.
#[test]
fn current_held_deep_in_the_liver_fails_the_clamp_by_its_score() {
    let result = operate(Surgeon::LiverBurner, Task::Clamp, 24);
    let it = &result.assessed;
    let of_liver = |it: &assess::Alarm| it.organ.as_deref() == Some("liver");
    let mut alarms = it.alarms.iter().filter(|it| of_liver(it));
    assert!(
        alarms.any(|it| it.kind == AlarmKind::Burnt),
        "{:?}",
        it.alarms
    );
    let injury = it.injuries.iter().find(|it| it.organ == "liver");
    let injury = injury.expect("it is noted");
    assert_eq!((injury.kind, injury.severity), (InjuryKind::Burnt, Minor));
    let (score, lost) = assess::Rules::default().score(Task::Clamp, &it.metrics);
    assert!(score < 70.0, "{score} {lost:?}");
}

/// Traction at cystic duct or artery tents the bile duct, which gives way before they do: the task
/// ends as for a bile duct that is torn itself.
#[test]
fn pulling_hard_at_duct_or_artery_tears_the_bile_duct() {
    for surgeon in [Surgeon::DuctPuller, Surgeon::ArteryPuller] {
        let result = operate(surgeon, Task::Clamp, 24);
        let it = &result.assessed;
        assert_eq!(it.outcome, Outcome::Failed, "{surgeon:?} {:?}", result.said);
        let injury = it.injuries.iter().find(|it| it.organ == "bile duct");
        let injury = injury.expect("it is noted");
        let what = (injury.kind, injury.cause, injury.severity);
        assert_eq!(
            what,
            (InjuryKind::Divided, Cause::Torn, Grave),
            "{surgeon:?}"
        );
        let torn = |it: &assess::Alarm| it.kind == AlarmKind::Torn;
        assert!(it.alarms.iter().any(torn), "{:?}", it.alarms);
        assert!(it.score <= 20.0, "{surgeon:?} {}", it.score);
    }
}
