//! Injuries and touches of protected structures: what they cost, and when they rule out a pass.

use shared_mem::words::Instrument;

use super::*;

const BAG: u32 = 5;
const HEPATIC: u32 = 6;
const BOWEL: u32 = 7;

/// The anatomy of the other tests, and organs that an operation may injure.
fn whole() -> Anatomy {
    let mut whole = anatomy();
    for (name, kind) in [
        ("gallbladder", OrganKind::Gallbladder),
        ("hepatic artery", OrganKind::Vessel),
        ("duodenum", OrganKind::Intestine),
    ] {
        let more = Anatomy::new(&[(name, kind)], &[]);
        whole.organs.extend(more.organs);
    }
    whole
}

fn clamp() -> Assessment {
    Assessment::new(Task::Clamp, Difficulty::Trainee, Rules::default(), whole())
}

/// The hand rests with this instrument and these switches.
fn hold(assessment: &mut Assessment, at_s: f64, instrument: Instrument, switches: u8) {
    let held = Movement {
        instrument: instrument.number() as u8,
        switches,
        ..here([0.0, 0.0, -0.1])
    };
    assessment.take(&moved(at_s, held));
    assessment.take(&moved(at_s + 0.05, held));
}

fn injured(organ: &str, injury: InjuryKind) -> Reason {
    let organ = organ.to_owned();
    Reason::Injured { organ, injury }
}

/// Makes an error, then clips both vessels. With that, the task is done.
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
        // Free practice goes on.
        let mut practice = begin(Task::Free);
        practice.take(&opened);
        assert!(!practice.is_over());
        assert_eq!(practice.end().injuries.len(), 1);
    }
}

#[test]
fn a_bile_duct_burnt_more_than_its_wall_survives_rules_out_a_pass() {
    let burn = |heat_j| event(0.1, EventKind::Burn.number(), BILE_DUCT, 0.0, heat_j);
    let light = clamp_after(&burn(0.3));
    assert_eq!(light.status().outcome, Outcome::Passed);
    let deep = clamp_after(&burn(1.1)).end();
    assert_eq!(deep.outcome, Outcome::Failed);
    assert_eq!(deep.reasons[0], injured("bile duct", InjuryKind::Burnt));
    assert!(!deep.injuries[0].ends_task);
    // The heat of several burns adds up, wherever they are: five that just count.
    let mut often = begin(Task::Clamp);
    rest(&mut often, 0.0, 0.1);
    for place in 0..5 {
        let at_m = 0.01 * place as f32;
        let kind = EventKind::Burn.number();
        often.take(&event(0.1, kind, BILE_DUCT, at_m, 0.11));
    }
    clip_both(&mut often);
    let often = often.end();
    assert_eq!(often.outcome, Outcome::Failed);
    let depth_mm = often.injuries[0].depth_mm.expect("a burn");
    assert!(depth_mm < 0.5, "{depth_mm}");
}

/// As much heat does more harm at one place than along the duct.
#[test]
fn a_bile_duct_burnt_deep_at_one_place_rules_out_a_pass() {
    let burnt = |apart_m: f32| {
        let mut assessment = begin(Task::Clamp);
        rest(&mut assessment, 0.0, 0.1);
        for burn in 0..4 {
            let kind = EventKind::Burn.number();
            let at_m = apart_m * burn as f32;
            assessment.take(&event(0.1, kind, BILE_DUCT, at_m, 0.1));
        }
        clip_both(&mut assessment);
        assessment.end()
    };
    let along = burnt(0.005);
    assert_eq!((along.outcome, along.injuries.len()), (Outcome::Passed, 0));
    let deep = burnt(0.0002);
    assert_eq!(deep.outcome, Outcome::Failed);
    let injury = &deep.injuries[0];
    assert_eq!(
        (injury.kind, injury.severity),
        (InjuryKind::Burnt, Severity::Serious)
    );
    // 0.1 J coagulate a cubic millimetre, and the place has a radius of 1.5 mm.
    let depth_mm = injury.depth_mm.expect("a burn");
    assert!((depth_mm - 0.566).abs() < 0.001, "{depth_mm}");
    assert!(
        injury
            .heat_j
            .is_some_and(|heat_j| (heat_j - 0.4).abs() < 1e-6)
    );
    let opened = event(0.1, EventKind::Divided.number(), BILE_DUCT, 0.0, 1.0);
    assert_eq!(clamp_after(&opened).end().injuries[0].depth_mm, None);
}

/// A protected structure that the jaws crush counts as pressed hard.
#[test]
fn a_crushed_bile_duct_costs_more_than_crushed_liver() {
    let crushed = |organ| {
        let crush = event(0.1, EventKind::Crush.number(), organ, 0.0, 9.0);
        clamp_after(&crush).end().score
    };
    is(crushed(LIVER), 97.0);
    is(crushed(BILE_DUCT), 92.0);
}

#[test]
fn a_bile_duct_that_heat_destroyed_from_beside_rules_out_a_pass() {
    let seared = |organ| event(0.1, EventKind::Seared.number(), organ, 0.0, 3.0e-8);
    let assessed = clamp_after(&seared(BILE_DUCT)).end();
    assert_eq!(assessed.outcome, Outcome::Failed);
    assert_eq!(assessed.reasons[0], injured("bile duct", InjuryKind::Burnt));
    assert!(!assessed.injuries[0].ends_task);
    let burnt = |it: &&Alarm| it.kind == AlarmKind::Burnt;
    assert_eq!(assessed.alarms.iter().filter(burnt).count(), 1);
    // The cystic duct is divided anyway.
    let assessed = clamp_after(&seared(DUCT)).end();
    assert_eq!(assessed.alarms.iter().filter(burnt).count(), 0);
    // The liver may be burnt.
    let assessed = clamp_after(&seared(LIVER)).end();
    assert_eq!(assessed.outcome, Outcome::Passed);
    assert!(assessed.injuries.is_empty());
}

/// Bands of fat hold bile duct and liver. Their events name one of the two.
#[test]
fn a_cut_band_is_no_injury() {
    let cut = event(0.1, EventKind::Cut.number(), BILE_DUCT, 0.0, 0.001);
    assert!(clamp_after(&cut).end().injuries.is_empty());
}

#[test]
fn a_tear_at_bile_duct_or_hepatic_artery_rules_out_a_pass_and_one_at_the_bowel_does_not() {
    for (organ, is_injury) in [(BILE_DUCT, true), (HEPATIC, true), (BOWEL, false)] {
        let tear = event(0.1, EventKind::Tear.number(), organ, 0.0, 0.001);
        let mut rules = Rules::built_in().to_owned();
        // As in the whole operation, where one tear is allowed.
        rules = rules.replace(
            "{ metric = \"tears\", at_most = 0.0 }",
            "{ metric = \"tears\", at_most = 1.0 }",
        );
        let rules = Rules::parse(&rules).unwrap();
        let mut assessment = Assessment::new(Task::Clamp, Difficulty::Trainee, rules, whole());
        rest(&mut assessment, 0.0, 0.1);
        assessment.take(&tear);
        clip_both(&mut assessment);
        let assessed = assessment.end();
        let found: Vec<_> = assessed
            .injuries
            .iter()
            .map(|it| (it.kind, it.severity))
            .collect();
        let torn = (InjuryKind::Torn, Severity::Serious);
        assert_eq!(found, if is_injury { vec![torn] } else { vec![] });
        assert_eq!(assessed.outcome == Outcome::Passed, !is_injury, "{organ}");
    }
}

#[test]
fn a_clip_on_the_bile_duct_is_an_injury_and_the_first_lesson() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    clip(&mut assessment, 0.1, BILE_DUCT, 0.0, 7.0);
    clip_both(&mut assessment);
    let assessed = assessment.end();
    let injury = &assessed.injuries[0];
    assert_eq!(
        (injury.kind, injury.cause, injury.severity),
        (InjuryKind::Clipped, Cause::Clipped, Severity::Serious)
    );
    assert_eq!(assessed.outcome, Outcome::Failed);
    assert!(assessed.score <= 20.0, "{}", assessed.score);
}

#[test]
fn an_organ_that_tears_and_opens_has_one_injury() {
    let (help, rules) = (Difficulty::Trainee, Rules::default());
    let mut assessment = Assessment::new(Task::Free, help, rules, whole());
    rest(&mut assessment, 0.0, 0.1);
    for kind in [EventKind::Tear, EventKind::Divided, EventKind::Tear] {
        assessment.take(&event(0.1, kind.number(), BILE_DUCT, 0.0, 1.0));
    }
    let kinds: Vec<_> = assessment.end().injuries.iter().map(|it| it.kind).collect();
    assert_eq!(kinds, [InjuryKind::Divided]);
}

#[test]
fn who_stops_after_an_injury_has_failed() {
    let tear = event(0.1, EventKind::Tear.number(), BILE_DUCT, 0.0, 0.001);
    let mut stopped = begin(Task::Full);
    rest(&mut stopped, 0.0, 0.1);
    stopped.take(&tear);
    let assessed = stopped.end();
    assert_eq!(assessed.outcome, Outcome::Failed);
    let first = Reason::Injured {
        organ: "bile duct".to_owned(),
        injury: InjuryKind::Torn,
    };
    assert_eq!(assessed.reasons[0], first);
    assert!(assessed.reasons.len() > 1, "and what was not done");
}

#[test]
fn a_perforated_liver_is_noted_and_rules_out_no_pass() {
    let perforated = event(0.1, EventKind::Perforation.number(), LIVER, 0.0, 0.1);
    let assessed = clamp_after(&perforated).end();
    assert_eq!(assessed.injuries[0].severity, Severity::Minor);
    assert_eq!(assessed.outcome, Outcome::Passed);
}

/// Holds the current on the liver for this many events of 0.75 J, 20 a second, each this far beside
/// the last, and returns the result of the clamp or, with `task`, of another task.
fn burn_liver(task: Task, events: u32, aside_m: f32) -> Assessed {
    let mut assessment = Assessment::new(task, Difficulty::Trainee, Rules::default(), whole());
    rest(&mut assessment, 0.0, 0.1);
    for number in 0..events {
        let at_s = 0.1 + 0.05 * f64::from(number);
        let x_m = aside_m * number as f32;
        assessment.take(&event(at_s, EventKind::Burn.number(), LIVER, x_m, 0.75));
        rest(&mut assessment, at_s, at_s + 0.05);
    }
    if task == Task::Clamp {
        clip_both(&mut assessment);
    }
    assessment.end()
}

#[test]
fn current_held_on_the_liver_fails_a_clamp_in_which_nothing_is_to_be_burnt() {
    let once = burn_liver(Task::Clamp, 2, 0.0);
    assert_eq!(kinds(&once), [AlarmKind::Burnt]);
    is(once.metrics.get(Metric::BurnsWrong), 1.0);
    assert_eq!(once.outcome, Outcome::Passed);
    assert!(once.score < 95.0, "{}", once.score);
    // Seven seconds.
    let long = burn_liver(Task::Clamp, 140, 0.0);
    is(long.metrics.get(Metric::BurnWrong), 105.0);
    assert_eq!(long.outcome, Outcome::Failed, "{}", long.score);
    // The debrief names liver, heat and depth.
    assert_eq!(long.injuries[0].organ, "liver");
    assert!(long.injuries[0].depth_mm.is_some_and(|it| it > 14.9));
}

/// The liver takes heat all over the bed from which the gallbladder is freed.
#[test]
fn the_liver_may_be_burnt_along_the_bed_and_not_deep_at_one_place() {
    let along = burn_liver(Task::Disconnect, 140, 0.0016);
    assert!(along.alarms.is_empty() && along.injuries.is_empty());
    is(along.metrics.get(Metric::BurnWrong), 0.0);
    let deep = burn_liver(Task::Disconnect, 140, 0.0);
    assert_eq!(kinds(&deep), [AlarmKind::Burnt]);
    assert!(deep.metrics.get(Metric::BurnWrong) > 90.0);
    assert_eq!(deep.injuries[0].severity, Severity::Minor);
    let rules = Rules::default();
    let lost: f64 = deep.lost.iter().map(|it| it.points).sum();
    let (score, _) = rules.score(Task::Disconnect, &deep.metrics);
    assert!(lost > 40.0 && score < 60.0, "{lost} {score}");
}

#[test]
fn more_places_of_a_bed_than_are_kept_leave_room_for_those_of_other_organs() {
    let mut assessment = clamp();
    rest(&mut assessment, 0.0, 0.1);
    for number in 0..3000u32 {
        let x_m = 0.002 * number as f32;
        assessment.take(&event(0.1, EventKind::Burn.number(), LIVER, x_m, 0.01));
    }
    // 0.5 mm deep in the bile duct, from two events at one place.
    for _ in 0..2 {
        assessment.take(&event(0.1, EventKind::Burn.number(), BILE_DUCT, 0.0, 0.18));
    }
    let injuries = assessment.end().injuries;
    assert_eq!(injuries.len(), 1);
    assert_eq!(injuries[0].organ, "bile duct");
}

#[test]
fn a_hard_press_on_the_liver_is_an_error_and_a_light_one_is_none() {
    for (force_n, is_hard) in [(0.2, false), (0.9, false), (1.0, true), (2.9, true)] {
        let press = event(0.1, EventKind::Press.number(), LIVER, 0.0, force_n);
        let assessed = clamp_after(&press).end();
        assert_eq!(
            kinds(&assessed) == [AlarmKind::Touched],
            is_hard,
            "{force_n}"
        );
        is(
            assessed.metrics.get(Metric::TouchesWrong),
            f64::from(u8::from(is_hard)),
        );
        is(assessed.metrics.get(Metric::PressWrongMax), 0.0);
    }
}

#[test]
fn light_touches_are_counted_and_cost_nothing_and_presses_cost_without_an_early_end() {
    let touched = |presses: u32| {
        let mut assessment = clamp();
        for touch in 0..60 {
            let at_s = 2.0 * f64::from(touch);
            rest(&mut assessment, at_s, at_s + 1.9);
            let kind = EventKind::Contact.number();
            assessment.take(&event(at_s + 1.9, kind, BILE_DUCT, 0.0, 0.03));
            let press_n = if touch < presses { 0.25 } else { 0.15 };
            let kind = EventKind::Press.number();
            assessment.take(&event(at_s + 1.9, kind, BILE_DUCT, 0.0, press_n));
            // The liver may be pressed, though not as hard as from 1 N on.
            assessment.take(&event(at_s + 1.9, kind, LIVER, 0.0, 0.9));
        }
        clip_both(&mut assessment);
        assessment.end()
    };
    let light = touched(0);
    assert_eq!((light.outcome, light.alarms.len()), (Outcome::Passed, 0));
    is(light.score, 100.0);
    is(light.metrics.get(Metric::Touches), 60.0);
    is(light.metrics.get(Metric::TouchesWrong), 0.0);
    let hard = touched(7);
    // Seven presses of 5 points, and 20 points for each newton above 0.2 N.
    assert!((hard.score - 64.0).abs() < 1e-6, "{}", hard.score);
    is(hard.metrics.get(Metric::PressWrongMax), 0.25);
    assert_eq!((hard.outcome, hard.alarms.len()), (Outcome::Failed, 7));
}

#[test]
fn any_touch_counts_by_an_older_file() {
    let text = Rules::built_in().replace("touch_n = 0.2\n", "");
    let rules = Rules::parse(&text).unwrap();
    let mut assessment = Assessment::new(Task::Clamp, Difficulty::Trainee, rules, whole());
    rest(&mut assessment, 0.0, 0.1);
    for kind in [EventKind::Contact, EventKind::Press] {
        assessment.take(&event(0.2, kind.number(), BILE_DUCT, 0.0, 0.3));
    }
    is(assessment.end().metrics.get(Metric::TouchesWrong), 1.0);
}

/// Each injury is told with its structure, kind, cause, severity and time.
#[test]
fn every_injury_has_its_cause_and_its_severity() {
    use {EventKind as E, InjuryKind as K, Instrument as I, Severity as S};
    let (off, cuts, dries) = (16, 17, 18);
    for (instrument, switches, kind, organ, value, injury, cause, severity) in [
        (
            I::Scissors,
            off,
            E::Divided,
            BILE_DUCT,
            1.0,
            K::Divided,
            Cause::Cut,
            S::Grave,
        ),
        (
            I::Scissors,
            off,
            E::Perforation,
            BILE_DUCT,
            0.0,
            K::Perforated,
            Cause::Cut,
            S::Grave,
        ),
        (
            I::Grasper,
            off,
            E::Divided,
            BILE_DUCT,
            1.0,
            K::Divided,
            Cause::Torn,
            S::Grave,
        ),
        (
            I::Grasper,
            off,
            E::Perforation,
            BILE_DUCT,
            0.0,
            K::Perforated,
            Cause::Torn,
            S::Grave,
        ),
        (
            I::Hook,
            cuts,
            E::Divided,
            BILE_DUCT,
            1.0,
            K::Divided,
            Cause::Burnt,
            S::Grave,
        ),
        (
            I::Hook,
            dries,
            E::Perforation,
            BILE_DUCT,
            14.0,
            K::Perforated,
            Cause::Burnt,
            S::Grave,
        ),
        (
            I::Hook,
            dries,
            E::Burn,
            BILE_DUCT,
            1.2,
            K::Burnt,
            Cause::Burnt,
            S::Serious,
        ),
        (
            I::Scissors,
            off,
            E::Divided,
            HEPATIC,
            1.0,
            K::Divided,
            Cause::Cut,
            S::Grave,
        ),
        (
            I::Grasper,
            off,
            E::Perforation,
            HEPATIC,
            0.0,
            K::Perforated,
            Cause::Torn,
            S::Grave,
        ),
        (
            I::Hook,
            cuts,
            E::Burn,
            HEPATIC,
            1.2,
            K::Burnt,
            Cause::Burnt,
            S::Serious,
        ),
        (
            I::Hook,
            cuts,
            E::Perforation,
            BOWEL,
            42.0,
            K::Perforated,
            Cause::Burnt,
            S::Serious,
        ),
        (
            I::Hook,
            cuts,
            E::Burn,
            BOWEL,
            3.5,
            K::Burnt,
            Cause::Burnt,
            S::Serious,
        ),
        (
            I::Grasper,
            off,
            E::Perforation,
            DUCT,
            0.0,
            K::Perforated,
            Cause::Torn,
            S::Serious,
        ),
        (
            I::Grasper,
            off,
            E::Perforation,
            ARTERY,
            0.0,
            K::Perforated,
            Cause::Torn,
            S::Serious,
        ),
        (
            I::Hook,
            cuts,
            E::Perforation,
            BAG,
            28.0,
            K::Perforated,
            Cause::Burnt,
            S::Minor,
        ),
    ] {
        let mut assessment = clamp();
        hold(&mut assessment, 3.0, instrument, switches);
        assessment.take(&event(3.05, kind.number(), organ, 0.0, value));
        if !assessment.is_over() {
            clip_both(&mut assessment);
        }
        let assessed = assessment.end();
        let what = format!(
            "{instrument:?} {kind:?} of {organ}: {:?}",
            assessed.injuries
        );
        assert_eq!(assessed.injuries.len(), 1, "{what}");
        let found = &assessed.injuries[0];
        assert_eq!(found.organ, whole().organs[organ as usize].name, "{what}");
        assert_eq!(
            (found.kind, found.cause, found.severity),
            (injury, cause, severity),
            "{what}"
        );
        assert!((found.at_s - 0.05).abs() < 1e-6, "{what}");
        assert_eq!(found.ends_task, severity == S::Grave, "{what}");
        let is_passed = assessed.outcome == Outcome::Passed;
        assert_eq!(
            is_passed,
            severity == S::Minor,
            "{what} {:?}",
            assessed.reasons
        );
        assert!(
            assessed.score <= if is_passed { 90.0 } else { 60.0 },
            "{what}"
        );
    }
}

/// A hook under current may tear a tube, too. The tear's event comes just before the division's.
#[test]
fn a_division_that_follows_a_tear_is_torn() {
    let mut assessment = clamp();
    hold(&mut assessment, 0.0, Instrument::Hook, 17);
    for kind in [EventKind::Tear, EventKind::Divided] {
        assessment.take(&event(0.1, kind.number(), BILE_DUCT, 0.0, 1.0));
    }
    assert_eq!(assessment.end().injuries[0].cause, Cause::Torn);
}

/// Cystic duct and artery are there to be divided.
#[test]
fn a_divided_cystic_duct_is_no_injury() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.5);
    clip_both(&mut assessment);
    cut(&mut assessment, 0.6, DUCT);
    cut(&mut assessment, 0.6, ARTERY);
    rest(&mut assessment, 0.7, 5.0);
    let assessed = assessment.end();
    assert_eq!(
        (assessed.outcome, assessed.injuries.len()),
        (Outcome::Passed, 0)
    );
}

/// One pull tears a tube link by link, and one closing of the blades cuts it so. Each is one error.
#[test]
fn what_tears_or_is_cut_at_once_is_one_error() {
    for (kind, alarm, metric) in [
        (EventKind::Tear, AlarmKind::Torn, Metric::Tears),
        (EventKind::Cut, AlarmKind::Cut, Metric::CutsWrong),
    ] {
        let (help, rules) = (Difficulty::Trainee, Rules::default());
        let mut assessment = Assessment::new(Task::Free, help, rules, whole());
        rest(&mut assessment, 0.0, 0.1);
        for (from_s, to_s, links) in [(0.1, 0.3, 5), (0.3, 3.2, 3)] {
            rest(&mut assessment, from_s, to_s);
            for _ in 0..links {
                assessment.take(&event(to_s, kind.number(), BILE_DUCT, 0.0, 0.001));
            }
        }
        // Another organ is another error.
        assessment.take(&event(3.2, kind.number(), HEPATIC, 0.0, 0.001));
        let assessed = assessment.end();
        assert_eq!(kinds(&assessed), [alarm; 3]);
        is(assessed.metrics.get(metric), 3.0);
    }
}
