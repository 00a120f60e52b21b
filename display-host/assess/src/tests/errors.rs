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
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    for step in 0..20 {
        let at_s = 0.1 + f64::from(step) * 0.05;
        assessment.take(&event(at_s, EventKind::Burn.number(), BILE_DUCT, 0.0, 0.5));
        assessment.take(&event(at_s, EventKind::Burn.number(), LIVER, 0.0, 0.25));
    }
    assessment.take(&event(
        2.0,
        EventKind::Contact.number(),
        BILE_DUCT,
        0.0,
        0.1,
    ));
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

fn injured(organ: &str, injury: InjuryKind) -> Reason {
    let organ = organ.to_owned();
    Reason::Injured { organ, injury }
}

/// A task that is done once its vessels are clipped, with an error before.
fn clamp_after(error: &Entry) -> Assessment {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    assessment.take(error);
    if !assessment.is_over() {
        clip_both(&mut assessment);
    }
    assessment
}

#[test]
fn an_opened_bile_duct_ends_the_task_at_once() {
    for (event_kind, value, kind) in [
        (EventKind::Divided, 1.0, InjuryKind::Divided),
        (EventKind::Perforation, 0.2, InjuryKind::Perforated),
    ] {
        let opened = event(0.1, event_kind.number(), BILE_DUCT, 0.0, value);
        for task in [Task::Identify, Task::Clamp, Task::Full] {
            let mut assessment = begin(task);
            rest(&mut assessment, 0.0, 0.1);
            assessment.take(&opened);
            let status = assessment.status();
            assert_eq!(status.outcome, Outcome::Failed, "{task:?}");
            assert_eq!(status.reasons, [injured("bile duct", kind)]);
            let assessed = assessment.end();
            let found: Vec<_> = assessed
                .injuries
                .iter()
                .map(|it| (it.kind, it.ends_task))
                .collect();
            assert_eq!(found, [(kind, true)]);
            is(assessed.metrics.get(Metric::Injuries), 1.0);
            assert!(assessed.score <= 60.0, "{}", assessed.score);
        }
        // Practice goes on.
        let mut practice = begin(Task::Free);
        practice.take(&opened);
        assert!(!practice.is_over());
        assert_eq!(practice.end().injuries.len(), 1);
    }
}

#[test]
fn a_bile_duct_burnt_more_than_its_wall_survives_rules_out_a_pass() {
    let burn = |heat_j| event(0.1, EventKind::Burn.number(), BILE_DUCT, 0.0, heat_j);
    let light = clamp_after(&burn(0.4));
    assert_eq!(light.status().outcome, Outcome::Passed);
    let deep = clamp_after(&burn(1.1)).end();
    assert_eq!(deep.outcome, Outcome::Failed);
    assert_eq!(deep.reasons[0], injured("bile duct", InjuryKind::Burnt));
    assert!(!deep.injuries[0].ends_task);
    // Heat adds up.
    let mut often = begin(Task::Clamp);
    rest(&mut often, 0.0, 0.1);
    (0..3).for_each(|_| often.take(&burn(0.4)));
    clip_both(&mut often);
    assert_eq!(often.status().outcome, Outcome::Failed);
}

/// Bands of fat hold bile duct and liver. Their events name one of the two.
#[test]
fn a_torn_or_cut_band_is_no_injury() {
    for kind in [EventKind::Tear, EventKind::Cut] {
        let assessment = clamp_after(&event(0.1, kind.number(), BILE_DUCT, 0.0, 0.001));
        assert!(assessment.end().injuries.is_empty(), "{kind:?}");
    }
}

#[test]
fn an_injured_liver_has_no_rule() {
    let perforated = event(0.1, EventKind::Perforation.number(), LIVER, 0.0, 0.1);
    assert!(clamp_after(&perforated).end().injuries.is_empty());
}
