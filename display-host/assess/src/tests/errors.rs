//! Errors that do harm, and the points that they cost.

use super::*;

#[test]
fn a_structure_is_burnt_once_enough_heat_has_come_together() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    // By the built-in rules a burn takes 0.1 J, and its alarm is not repeated for a second.
    let (mut alarms, mut before_s) = (Vec::new(), 0.1);
    for (at_s, heat_j) in [
        (0.2, 0.04),
        (0.3, 0.04),
        (0.4, 0.04),
        (2.0, 0.04),
        (4.0, 0.5),
    ] {
        rest(&mut assessment, before_s, at_s);
        before_s = at_s;
        assessment.take(&event(
            at_s,
            EventKind::Burn.number(),
            BILE_DUCT,
            0.0,
            heat_j,
        ));
        alarms.push(assessment.alarms().len());
    }
    assert_eq!(alarms, [0, 0, 1, 1, 2]);
}

#[test]
fn wrong_structures_sound_and_cost_but_not_without_end() {
    let mut assessment = begin(Task::Identify);
    rest(&mut assessment, 0.0, 0.1);
    for step in 0..20 {
        let at_s = 0.1 + f64::from(step) * 0.05;
        assessment.take(&event(at_s, EventKind::Burn.number(), BILE_DUCT, 0.0, 0.5));
        assessment.take(&event(at_s, EventKind::Burn.number(), LIVER, 0.0, 0.25));
    }
    assessment.take(&event(2.0, EventKind::Press.number(), BILE_DUCT, 0.0, 0.3));
    let assessed = assessment.end();
    assert_eq!(kinds(&assessed), [AlarmKind::Burnt, AlarmKind::Touched]);
    assert!((assessed.metrics.get(Metric::BurnWrong) - 10.0).abs() < 1e-6);
    assert!((assessed.metrics.get(Metric::BurnLiver) - 5.0).abs() < 1e-6);
    assert!(assessed.score < 92.0);
}

#[test]
fn blood_is_flow_over_time_until_it_is_stopped() {
    let mut assessment = begin(Task::Free);
    rest(&mut assessment, 0.0, 1.0);
    assessment.take(&event(1.0, EventKind::Leak.number(), ARTERY, 0.0, 0.5));
    rest(&mut assessment, 1.1, 7.0);
    assessment.take(&event(7.0, EventKind::Leak.number(), ARTERY, 0.0, 0.0));
    rest(&mut assessment, 7.1, 20.0);
    // Two cut ends lie close together, and one of them stops leaking.
    assessment.take(&event(20.0, EventKind::Leak.number(), ARTERY, 0.0, 1.0));
    assessment.take(&event(20.0, EventKind::Leak.number(), ARTERY, 0.002, 1.0));
    assessment.take(&event(20.0, EventKind::Leak.number(), ARTERY, 0.002, 0.0));
    rest(&mut assessment, 20.0, 21.0);
    let blood_ml = assessment.end().metrics.get(Metric::Blood);
    // The flow is 30 ml/min: half of that for 6 s, and all of it for 1 s.
    assert!((blood_ml - 2.0).abs() < 0.05, "{blood_ml}");
}

#[test]
fn the_current_counts_with_and_without_contact() {
    let mut assessment = begin(Task::Free);
    for step in 0..=40 {
        let touches = step > 20;
        let mut hook = Movement {
            instrument: 1,
            switches: 17,
            contacts: u16::from(touches),
            ..here([0.0, 0.0, -0.1])
        };
        hook.force_n = [0.0, 0.0, if touches { 1.0 } else { 0.0 }];
        assessment.take(&moved(f64::from(step) * 0.1, hook));
    }
    let metrics = assessment.end().metrics;
    let near = |metric, value: f64| {
        let found = metrics.get(metric);
        assert!((found - value).abs() < 0.06, "{metric:?} {found}");
    };
    near(Metric::CauteryOn, 4.0);
    near(Metric::CauteryAir, 2.0);
    near(Metric::ForceMean, 1.0);
    near(Metric::Force95, 1.05);
}

/// Current that burns tissue across a gap does not count as current in air.
#[test]
fn current_that_burns_is_not_in_air() {
    let mut assessment = begin(Task::Free);
    for step in 0..=40 {
        let at_s = f64::from(step) * 0.05;
        let hook = Movement {
            instrument: 1,
            switches: 17,
            ..here([0.0, 0.0, -0.1])
        };
        assessment.take(&moved(at_s, hook));
        if step < 20 {
            assessment.take(&event(at_s, EventKind::Burn.number(), FAT, 0.0, 0.5));
        }
    }
    let air_s = assessment.end().metrics.get(Metric::CauteryAir);
    assert!((0.85..1.05).contains(&air_s), "{air_s}");
}

/// Moves the hand for a second with the tip in the picture or beside it.
fn work(assessment: &mut Assessment, from_s: f64, instrument: u8, is_out: bool) {
    for step in 0..=20 {
        let tip_m = if is_out {
            [0.2, 0.0, -0.1]
        } else {
            [0.0, 0.0, -0.1]
        };
        let held = Movement {
            instrument,
            switches: 17,
            contacts: 1,
            ..here(tip_m)
        };
        assessment.take(&moved(from_s + 0.05 * f64::from(step), held));
    }
}

/// Clips, divisions and current count where nobody sees the tip.
#[test]
fn acts_outside_the_picture_are_told_and_cost_points() {
    let (hook, scissors, applier) = (1, 2, 3);
    let mut assessment = begin(Task::Clamp);
    work(&mut assessment, 0.0, applier, false);
    clip(&mut assessment, 1.0, DUCT, -0.01, 0.0);
    is(assessment.metrics().get(Metric::ActsBlind), 0.0);
    work(&mut assessment, 1.0, applier, true);
    // A clip on two organs has two events, and is one act.
    clip(&mut assessment, 2.0, DUCT, 0.01, 1.0);
    clip(&mut assessment, 2.0, FAT, 0.01, 1.0);
    is(assessment.metrics().get(Metric::ActsBlind), 1.0);
    // The trainee is told at once, and the debrief replays that moment.
    let told: Vec<_> = assessment
        .alarms()
        .iter()
        .map(|it| (it.kind, it.organ.is_some()))
        .collect();
    assert_eq!(told, [(AlarmKind::Unseen, false)]);
    work(&mut assessment, 2.0, applier, false);
    clip(&mut assessment, 3.0, ARTERY, -0.01, 2.0);
    clip(&mut assessment, 3.0, ARTERY, 0.01, 3.0);
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Failed, "{:?}", assessed.lost);
    is(assessed.score, 80.0);

    let mut cuts = begin(Task::Free);
    work(&mut cuts, 0.0, scissors, true);
    cut(&mut cuts, 1.0, DUCT);
    // Current divides, too, but a blind current has a measure of its own.
    work(&mut cuts, 1.0, hook, true);
    cut(&mut cuts, 2.0, ARTERY);
    work(&mut cuts, 2.0, hook, false);
    let metrics = cuts.end().metrics;
    is(metrics.get(Metric::ActsBlind), 1.0);
    let near = |metric, value: f64| {
        let found = metrics.get(metric);
        assert!((found - value).abs() < 0.06, "{metric:?} {found}");
    };
    near(Metric::CauteryBlind, 1.0);
    near(Metric::CauterySafe, 0.5);
}
