use bytemuck::Zeroable as _;
use proptest::prelude::*;
use session::{Entry, Movement, What};
use shared_mem::message::{EventMsg, PoseMsg};
use shared_mem::scene::OrganKind;
use shared_mem::words::{EventKind, Fault};

use crate::*;

const LIVER: u32 = 0;
const DUCT: u32 = 1;
const ARTERY: u32 = 2;
const BILE_DUCT: u32 = 3;
const FAT: u32 = 4;
/// An organ number without an organ.
const NOTHING: u32 = u32::MAX;

fn anatomy() -> Anatomy {
    let organs = [
        ("liver", OrganKind::Liver),
        ("cystic duct", OrganKind::CysticDuct),
        ("cystic artery", OrganKind::CysticArtery),
        ("bile duct", OrganKind::BileDuct),
        ("fat", OrganKind::Fat),
    ];
    let regions = [Region::Triangle, Region::LowerBed, Region::UpperBed];
    let cells: Vec<Region> = regions.into_iter().flat_map(|it| [it; 10]).collect();
    Anatomy::new(&organs, &cells)
}

fn begin(task: Task) -> Assessment {
    Assessment::new(task, Difficulty::Trainee, Rules::default(), anatomy())
}

fn here(tip_m: [f32; 3]) -> Movement {
    Movement {
        world_from_handle: PoseMsg::IDENTITY,
        world_from_instrument: PoseMsg::IDENTITY,
        world_from_camera: PoseMsg::IDENTITY,
        tip_m,
        force_n: [0.0; 3],
        jaw: 1.0,
        instrument: 0,
        switches: 16,
        live: 7,
        contacts: 0,
    }
}

fn moved(at_s: f64, movement: Movement) -> Entry {
    let at_ns = 1_000_000_000 + (at_s * 1e9) as u64;
    Entry {
        tick: at_ns / 1_000_000,
        at_ns,
        what: What::Moved(movement),
    }
}

fn event(at_s: f64, kind: u32, organ: u32, x_m: f32, value: f32) -> Entry {
    let at_ns = 1_000_000_000 + (at_s * 1e9) as u64;
    let event = EventMsg {
        at_ns,
        kind,
        organ,
        at_m: [x_m, 0.0, 0.0],
        value,
        ..EventMsg::zeroed()
    };
    Entry {
        tick: 0,
        at_ns,
        what: What::Event(event),
    }
}

fn unclamped(organ: &str) -> Reason {
    let organ = organ.to_owned();
    Reason::Unclamped { organ }
}

/// Keeps the hands at rest between two times, with ten movements a second.
fn rest(assessment: &mut Assessment, from_s: f64, to_s: f64) {
    let steps = ((to_s - from_s) * 10.0).round() as u32;
    for step in 0..=steps {
        let at_s = from_s + f64::from(step) * 0.1;
        assessment.take(&moved(at_s, here([0.0, 0.0, -0.1])));
    }
}

#[test]
fn a_gap_in_the_events_numbers_is_a_loss_and_another_controller_is_none() {
    let mut assessment = begin(Task::Free);
    rest(&mut assessment, 0.0, 0.2);
    for sequence in [40, 41, 44, 45, 0, 1, 3] {
        let mut entry = event(0.3, EventKind::Removed.number(), FAT, 0.0, 1.0);
        if let What::Event(event) = &mut entry.what {
            event.sequence = sequence;
        }
        assessment.take(&entry);
    }
    is(assessment.end().metrics.get(Metric::LostEvents), 3.0);
}

fn clip(assessment: &mut Assessment, at_s: f64, organ: u32, x_m: f32, number: f32) {
    assessment.take(&event(at_s, EventKind::Clip.number(), organ, x_m, number));
}

fn clip_both(assessment: &mut Assessment) {
    clip(assessment, 0.1, DUCT, -0.01, 0.0);
    clip(assessment, 0.2, DUCT, 0.01, 1.0);
    clip(assessment, 0.3, ARTERY, -0.01, 2.0);
    clip(assessment, 0.4, ARTERY, 0.01, 3.0);
}

/// Divides a vessel with clips closed on both sides.
fn cut(assessment: &mut Assessment, at_s: f64, organ: u32) {
    cut_open(assessment, at_s, organ, 0.0);
}

/// Divides a vessel, with this share of one side open.
fn cut_open(assessment: &mut Assessment, at_s: f64, organ: u32, open: f32) {
    assessment.take(&event(at_s, EventKind::Cut.number(), organ, 0.0, 0.001));
    assessment.take(&event(at_s, EventKind::Divided.number(), organ, 0.0, open));
}

#[track_caller]
fn is(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
}

fn kinds(assessed: &Assessed) -> Vec<AlarmKind> {
    assessed.alarms.iter().map(|alarm| alarm.kind).collect()
}

#[test]
fn clamping_passes_with_two_clips_on_each() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 1.0);
    clip(&mut assessment, 1.0, DUCT, 0.0, 0.0);
    // One clip is reported once for each organ that it closed on.
    clip(&mut assessment, 1.0, FAT, 0.0, 0.0);
    clip(&mut assessment, 1.1, DUCT, 0.004, 1.0);
    assert!(!assessment.is_over());
    clip(&mut assessment, 1.2, ARTERY, 0.0, 2.0);
    clip(&mut assessment, 1.3, ARTERY, 0.003, 3.0);
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Passed);
    is(assessed.score, 100.0);
    let metrics = assessed.metrics;
    is(metrics.get(Metric::ClipsUsed), 4.0);
    is(metrics.get(Metric::ClipsMisplaced), 0.0);
    assert!((metrics.get(Metric::ClipSpacing) - 3.0).abs() < 1e-6);
}

#[test]
fn clips_that_are_lost_or_misplaced_sound_and_cost() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    clip(&mut assessment, 0.1, NOTHING, 0.0, 9.0);
    clip(&mut assessment, 0.2, BILE_DUCT, 0.0, 8.0);
    clip_both(&mut assessment);
    let assessed = assessment.end();
    assert_eq!(
        kinds(&assessed),
        [AlarmKind::ClipLost, AlarmKind::ClipMisplaced]
    );
    assert!((assessed.score - 80.0).abs() < 1e-9, "{:?}", assessed.lost);
    assert_eq!(assessed.outcome, Outcome::Failed, "none may be misplaced");
    assert_eq!(
        assessed.reasons,
        [Reason::TooMuch {
            metric: Some(Metric::ClipsMisplaced),
            value: 1.0,
            limit: 0.0
        }]
    );
    // Reports give it in plain English.
    let report = serde_json::to_value(&assessed).unwrap();
    assert_eq!(
        report["reasons"][0],
        "clips_misplaced is 1.0, at most 0 is allowed"
    );
    assert_eq!(
        report["steps"][0],
        serde_json::json!(["Place 2 clips on the cystic duct", true])
    );
}

#[test]
fn cutting_unclamped_fails_at_once() {
    for task in [
        Task::Identify,
        Task::Clamp,
        Task::Cut,
        Task::Disconnect,
        Task::Full,
    ] {
        let mut assessment = begin(task);
        rest(&mut assessment, 0.0, 0.1);
        clip(&mut assessment, 0.1, DUCT, 0.0, 0.0);
        cut(&mut assessment, 0.2, DUCT);
        assert!(assessment.is_over(), "{}", task.name());
        let status = assessment.status();
        assert_eq!(status.outcome, Outcome::Failed);
        assert_eq!(status.reasons, [unclamped("cystic duct")]);
        // Later entries change nothing.
        clip_both(&mut assessment);
        assert_eq!(assessment.status(), status);
    }
    let mut free = begin(Task::Free);
    cut(&mut free, 0.2, DUCT);
    assert!(!free.is_over());
    let free = free.end();
    assert_eq!(free.outcome, Outcome::Practised);
    assert_eq!(kinds(&free), [AlarmKind::Unclamped]);
}

#[test]
fn cutting_between_clips_passes_once_nothing_leaks() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.5);
    clip_both(&mut assessment);
    rest(&mut assessment, 0.6, 1.0);
    cut(&mut assessment, 1.0, DUCT);
    cut(&mut assessment, 1.0, ARTERY);
    assert!(!assessment.is_over(), "a leak may still show");
    rest(&mut assessment, 1.1, 4.0);
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Passed, "{assessed:?}");
    is(assessed.metrics.get(Metric::CutsOneSided), 0.0);
}

#[test]
fn a_prepared_task_has_the_clips_that_come_before_it() {
    let start = |task| Entry {
        tick: 0,
        at_ns: 1_000_000_000,
        what: What::Start { task },
    };
    let mut prepared = begin(Task::Cut);
    rest(&mut prepared, 0.0, 0.5);
    prepared.take(&start(3));
    cut(&mut prepared, 1.0, DUCT);
    cut(&mut prepared, 1.0, ARTERY);
    rest(&mut prepared, 1.0, 5.0);
    let prepared = prepared.end();
    assert_eq!(prepared.outcome, Outcome::Passed);
    is(prepared.score, 100.0);
    is(prepared.metrics.get(Metric::ClipsUsed), 0.0);
    is(prepared.metrics.get(Metric::Restarts), 0.0);
    // A cut beside the clips leaks.
    let mut beside = begin(Task::Cut);
    beside.take(&start(3));
    cut(&mut beside, 1.0, DUCT);
    beside.take(&event(1.1, EventKind::Leak.number(), DUCT, 0.0, 0.5));
    assert_eq!(beside.end().outcome, Outcome::Failed);
    let mut divided = begin(Task::Disconnect);
    divided.take(&start(4));
    rest(&mut divided, 0.0, 1.0);
    remove(&mut divided, 10..30);
    assert_eq!(divided.end().outcome, Outcome::Passed);
}

#[test]
fn clips_that_do_not_hold_are_no_clamp() {
    // The leak is reported after the cut, or before it in the same tick.
    for before in [false, true] {
        let mut assessment = begin(Task::Cut);
        rest(&mut assessment, 0.0, 0.5);
        clip_both(&mut assessment);
        let leak = event(1.0, EventKind::Leak.number(), ARTERY, 0.0, 0.4);
        if before {
            assessment.take(&leak);
        }
        cut(&mut assessment, 1.0, ARTERY);
        if !before {
            assert!(!assessment.is_over());
            assessment.take(&leak);
        }
        let assessed = assessment.end();
        assert_eq!(assessed.outcome, Outcome::Failed);
        assert_eq!(kinds(&assessed), [AlarmKind::Unclamped]);
        assert!(assessed.score < 50.0);
    }
}

#[test]
fn clips_on_one_side_of_the_cut_are_no_clamp() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.1);
    clip(&mut assessment, 0.1, DUCT, 0.01, 0.0);
    clip(&mut assessment, 0.2, DUCT, 0.02, 1.0);
    cut_open(&mut assessment, 0.3, DUCT, 1.0);
    let assessed = assessment.end();
    is(assessed.metrics.get(Metric::CutsOneSided), 1.0);
    assert_eq!(assessed.outcome, Outcome::Failed);
    assert_eq!(assessed.reasons, [unclamped("cystic duct")]);
}

#[test]
fn cut_that_divides_nothing_is_none_and_a_dry_end_hides_no_leak() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.1);
    clip_both(&mut assessment);
    for organ in [DUCT, ARTERY] {
        assessment.take(&event(0.5, EventKind::Cut.number(), organ, 0.0, 0.001));
    }
    rest(&mut assessment, 0.6, 4.0);
    assert!(!assessment.is_over(), "strands of them were cut, no more");
    assessment.take(&event(4.1, EventKind::Leak.number(), DUCT, 0.0, 0.5));
    assessment.take(&event(4.1, EventKind::Leak.number(), DUCT, 0.01, 0.0));
    cut(&mut assessment, 4.2, DUCT);
    assert_eq!(assessment.end().outcome, Outcome::Failed);
}

fn remove(assessment: &mut Assessment, cells: core::ops::Range<u32>) {
    for cell in cells {
        assessment.take(&event(
            1.0,
            EventKind::Removed.number(),
            FAT,
            0.0,
            cell as f32,
        ));
    }
}

#[test]
fn the_critical_view_is_judged_by_what_is_removed() {
    let mut assessment = begin(Task::Identify);
    rest(&mut assessment, 0.0, 0.1);
    remove(&mut assessment, 0..9);
    assert!(!assessment.is_over());
    remove(&mut assessment, 10..18);
    assert!(!assessment.is_over(), "eight of ten");
    remove(&mut assessment, 17..18);
    assert!(!assessment.is_over(), "the same again is not more");
    remove(&mut assessment, 18..19);
    assert!(assessment.is_over());
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Passed);
    assert!((assessed.metrics.get(Metric::CvsTriangle) - 0.9).abs() < 1e-9);
    is(assessed.metrics.get(Metric::CvsTwo), 1.0);
}

#[test]
fn the_whole_operation_in_order_passes_and_out_of_order_sounds() {
    let all = |order: bool| {
        let mut assessment = begin(Task::Full);
        rest(&mut assessment, 0.0, 0.5);
        if !order {
            clip_both(&mut assessment);
        }
        remove(&mut assessment, 0..20);
        if order {
            clip_both(&mut assessment);
        }
        cut(&mut assessment, 2.0, DUCT);
        cut(&mut assessment, 2.0, ARTERY);
        rest(&mut assessment, 0.6, 5.0);
        assert!(!assessment.is_over());
        remove(&mut assessment, 20..30);
        assessment.end()
    };
    let good = all(true);
    assert_eq!((good.outcome, good.alarms.len()), (Outcome::Passed, 0));
    let early = all(false);
    assert_eq!(kinds(&early), [AlarmKind::TooEarly; 4]);
}

#[test]
fn a_structure_is_burnt_once_enough_heat_has_come_together() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    // Built-in rules: 0.1 J, and no repetition for a second.
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
    // Two ends lie close together; one of them stops leaking.
    assessment.take(&event(20.0, EventKind::Leak.number(), ARTERY, 0.0, 1.0));
    assessment.take(&event(20.0, EventKind::Leak.number(), ARTERY, 0.002, 1.0));
    assessment.take(&event(20.0, EventKind::Leak.number(), ARTERY, 0.002, 0.0));
    rest(&mut assessment, 20.0, 21.0);
    let blood_ml = assessment.end().metrics.get(Metric::Blood);
    // 30 ml/min, half of it for 6 s and all of it for 1 s.
    assert!((blood_ml - 2.0).abs() < 0.05, "{blood_ml}");
}

#[test]
fn a_reset_begins_anew_and_is_counted() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 5.0);
    clip(&mut assessment, 5.0, NOTHING, 0.0, 0.0);
    let reset = Entry {
        tick: 1,
        at_ns: 7_000_000_000,
        what: What::Reset,
    };
    assessment.take(&reset);
    rest(&mut assessment, 6.0, 7.0);
    is(assessment.status().score, 100.0);
    let assessed = assessment.end();
    is(assessed.metrics.get(Metric::Restarts), 1.0);
    // A trainee who does nothing makes no error and achieves nothing.
    assert_eq!(assessed.outcome, Outcome::Aborted);
    is(assessed.score, 0.0);
    assert!((assessed.metrics.get(Metric::Time) - 1.0).abs() < 0.01);
}

#[test]
fn pauses_and_gaps_are_no_time() {
    let mut assessment = begin(Task::Free);
    rest(&mut assessment, 0.0, 1.0);
    // Four seconds without a movement, then the hand is elsewhere.
    assessment.take(&moved(5.0, here([0.3, 0.0, 0.0])));
    assessment.take(&moved(5.1, here([0.3, 0.0, 0.0])));
    let paused = Movement {
        switches: 8,
        ..here([0.3, 0.0, 0.0])
    };
    for step in 0..50 {
        assessment.take(&moved(5.2 + f64::from(step) * 0.1, paused));
    }
    let metrics = assessment.end().metrics;
    assert!((metrics.get(Metric::Time) - 1.1).abs() < 1e-6);
    assert!((metrics.get(Metric::Gaps) - 4.0).abs() < 1e-6);
    assert!((metrics.get(Metric::Paused) - 5.0).abs() < 1e-6);
    is(metrics.get(Metric::Path), 0.0);
}

#[test]
fn a_pause_before_a_cut_does_not_hold_the_end_up() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.5);
    clip_both(&mut assessment);
    let paused = Movement {
        switches: 8,
        ..here([0.0, 0.0, -0.1])
    };
    for step in 0..6000 {
        assessment.take(&moved(0.6 + f64::from(step) * 0.1, paused));
    }
    for organ in [DUCT, ARTERY] {
        cut(&mut assessment, 600.6, organ);
    }
    rest(&mut assessment, 600.7, 610.0);
    assert_eq!(assessment.end().outcome, Outcome::Passed);
}

#[test]
fn task_prepared_again_begins_again_with_its_clips() {
    let mut assessment = begin(Task::Cut);
    let start = |at_ns| Entry {
        tick: 0,
        at_ns,
        what: What::Start { task: 3 },
    };
    rest(&mut assessment, 0.0, 0.3);
    assessment.take(&start(300_000_000));
    rest(&mut assessment, 0.4, 3.0);
    assessment.take(&start(3_000_000_000));
    rest(&mut assessment, 3.1, 4.0);
    for organ in [DUCT, ARTERY] {
        cut(&mut assessment, 4.0, organ);
    }
    rest(&mut assessment, 4.1, 12.0);
    let assessed = assessment.end();
    is(assessed.metrics.get(Metric::Restarts), 1.0);
    assert!(assessed.metrics.get(Metric::Time) < 9.0);
    assert!(assessed.alarms.is_empty(), "{:?}", assessed.alarms);
}

#[test]
fn trainee_who_places_the_sutures_begins_with_them() {
    let mut hung = anatomy();
    hung.sutures = 2;
    for (task, hangs) in [
        (Task::Full, true),
        (Task::Identify, true),
        (Task::Free, false),
    ] {
        let rules = Rules::default();
        let mut assessment = Assessment::new(task, Difficulty::Trainee, rules, hung.clone());
        let start = |task| Entry {
            tick: 0,
            at_ns: 0,
            what: What::Start { task },
        };
        assessment.take(&start(0));
        let step = |assessment: &Assessment| {
            let steps = assessment.status().steps;
            let mut own = steps.into_iter();
            own.find(|(step, _)| matches!(step, Step::Hang { count: 2 }))
        };
        assert_eq!(step(&assessment).is_some(), hangs, "{task:?}");
        // Placing one suture twice counts once.
        for (number, is_done) in [(0.0, false), (0.0, false), (1.0, hangs)] {
            assessment.take(&event(1.0, EventKind::Stitch.number(), LIVER, 0.0, number));
            assessment.take(&event(2.0, EventKind::Hung.number(), LIVER, 0.0, number));
            let done = step(&assessment).is_some_and(|(_, done)| done);
            assert_eq!(done, is_done, "{task:?} {number}");
        }
        // Clips of the prepared start are not the trainee's.
        assert!(assessment.status().steps.iter().all(|(step, done)| {
            !*done || matches!(step, Step::Hang { .. } | Step::LeaveWhole)
        }));
        assessment.take(&start(1));
        assert!(step(&assessment).is_none(), "they are given");
    }
}

#[test]
fn view_of_an_angled_endoscope_is_not_that_of_its_shaft() {
    let away_s = |looks_off: Option<f32>, tip_m: [f32; 3]| {
        let mut assessment = begin(Task::Free);
        if let Some(degrees) = looks_off {
            let (off_rad, turned_rad) = (degrees.to_radians(), 0.0);
            let what = What::Sight {
                off_rad,
                turned_rad,
            };
            assessment.take(&Entry {
                tick: 0,
                at_ns: 0,
                what,
            });
        }
        for step in 0..=20 {
            assessment.take(&moved(0.1 * f64::from(step), here(tip_m)));
        }
        assessment.end().metrics.get(Metric::OutOfView)
    };
    let (ahead, below) = ([0.0, 0.0, -0.1], [0.0, -0.1, -0.1]);
    is(away_s(None, ahead), 0.0);
    is(away_s(Some(0.0), below), 2.0);
    is(away_s(Some(45.0), below), 0.0);
    is(away_s(Some(45.0), ahead), 2.0);
}

#[test]
fn task_takes_too_long_at_last() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 601.0);
    let too_long = Reason::TooLong { seconds: 600.0 };
    assert_eq!(assessment.status().reasons, [too_long]);
}

#[test]
fn a_beginner_is_told_which_instrument_and_then_how() {
    let (rules, anatomy) = (Rules::default(), anatomy());
    let mut assessment = Assessment::new(Task::Clamp, Difficulty::Beginner, rules, anatomy);
    for (held, advice) in [
        (0, Advice::Take(Instrument::ClipApplier)),
        (3, Advice::Use(Instrument::ClipApplier)),
    ] {
        let instrument = held;
        assessment.take(&moved(
            f64::from(held) * 0.1,
            Movement {
                instrument,
                ..here([0.0; 3])
            },
        ));
        let hint = assessment.status().hint.expect("a beginner's");
        assert_eq!(hint.advice, advice);
        assert!(matches!(hint.step, Step::Clip { count: 2, .. }));
    }
}

#[test]
fn the_drill_is_done_when_each_organ_was_shown() {
    let mut organs = anatomy();
    for (number, organ) in organs.organs.iter_mut().enumerate() {
        organ.middle_m = [0.05 * number as f64, 0.0, -0.1];
    }
    let mut drill = Assessment::new(Task::Scope, Difficulty::Beginner, Rules::default(), organs);
    let mut at_s = 0.0;
    // In the order of the drill: cystic duct, liver, cystic artery.
    for number in [1, 0, 2] {
        assert!(!drill.is_over());
        let hint = drill.status().hint.expect("a beginner's");
        assert_eq!(hint.advice, Advice::Hold);
        for _ in 0..20 {
            let mut look = here([0.0, 0.0, -0.1]);
            look.world_from_camera.position_m[0] = 0.05 * number as f32;
            drill.take(&moved(at_s, look));
            at_s += 0.1;
        }
    }
    assert_eq!(
        drill.status().outcome,
        Outcome::Passed,
        "{:?}",
        drill.status()
    );
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

/// Current that burns across a gap does not count as current in air.
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

#[test]
fn definitions_are_complete_and_their_names_differ() {
    let mut names: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Metric::ALL.len());
    for metric in Metric::ALL {
        assert!(metric.definition().ends_with('.'), "{}", metric.name());
        assert!(!metric.source().is_empty());
        assert_eq!(Metric::from_name(metric.name()), Some(metric));
        let unit = metric.unit();
        let told = unit == "n" || unit == "1" || metric.name().ends_with(&unit.to_lowercase());
        assert!(told, "{} in {unit}", metric.name());
    }
}

/// A hand on a circle of 5 cm, one turn in four seconds, sampled at this rate.
fn circle(hz: f64, seconds: f64, tremor_m: f64) -> Values {
    let mut assessment = begin(Task::Free);
    for step in 0..=(hz * seconds) as u32 {
        let at_s = f64::from(step) / hz;
        let turn = at_s * std::f64::consts::TAU / 4.0;
        let shake = tremor_m * (at_s * std::f64::consts::TAU * 9.0).sin();
        let place = [0.05 * turn.cos(), 0.05 * turn.sin(), shake - 0.1];
        assessment.take(&moved(at_s, here(place.map(|x| x as f32))));
    }
    assessment.end().metrics
}

/// A random number of standard deviation 1, as good as normal: twelve uniform ones.
fn normal(seed: &mut u64) -> f64 {
    let mut uniform = || {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// A hand whose handle and tip go this way for a minute, with this noise, sampled at this rate.
fn minute(hz: f64, noise_m: f64, way: impl Fn(f64) -> [f64; 3]) -> Values {
    let mut assessment = begin(Task::Free);
    let mut seed = 7;
    for step in 0..=(hz * 60.0) as u32 {
        let at_s = f64::from(step) / hz;
        let place = way(at_s).map(|x| (x + noise_m * normal(&mut seed)) as f32);
        let mut movement = here(place);
        movement.world_from_handle.position_m = place;
        assessment.take(&moved(at_s, movement));
    }
    assessment.end().metrics
}

const RATES_HZ: [f64; 4] = [100.0, 200.0, 500.0, 1000.0];

#[test]
fn a_resting_hand_with_a_noisy_device_rests_at_every_rate() {
    for (noise_m, hz) in [0.0, 0.05e-3, 0.3e-3]
        .into_iter()
        .flat_map(|noise| RATES_HZ.map(|hz| (noise, hz)))
    {
        let values = minute(hz, noise_m, |_| [0.0, 0.0, -0.1]);
        let [path_m, idle_s] = [Metric::Path, Metric::Idle].map(|it| values.get(it));
        assert!(path_m < 2e-3, "{path_m} m at {hz} Hz with {noise_m} m");
        is(values.get(Metric::Movements), 0.0);
        assert!(idle_s > 59.5, "{idle_s} s at {hz} Hz with {noise_m} m");
        let noise_mm = values.get(Metric::Noise);
        assert!(
            (noise_mm - noise_m * 1e3).abs() < 0.2 * noise_m * 1e3 + 0.011,
            "{noise_mm} mm"
        );
    }
}

#[test]
fn tremor_and_strokes_count_the_same_at_every_rate() {
    let turn = std::f64::consts::TAU;
    let tremor = |at_s: f64| [0.0, 3e-3 * (8.0 * turn * at_s).sin(), -0.1];
    // Thirty strokes of 4 cm, each a second long and followed by a second of rest.
    let strokes = |at_s: f64| {
        let (stroke, within) = ((at_s / 2.0).floor(), (at_s % 2.0).min(1.0));
        let part = 0.5 - 0.5 * (0.5 * turn * within).cos();
        let part = if stroke % 2.0 == 0.0 {
            part
        } else {
            1.0 - part
        };
        [0.04 * part, 0.0, -0.1]
    };
    let of = |hz, noise_m, way: &dyn Fn(f64) -> [f64; 3]| minute(hz, noise_m, way);
    let shaken = RATES_HZ.map(|hz| of(hz, 0.0, &tremor));
    let stroked = RATES_HZ.map(|hz| of(hz, 0.0, &strokes));
    let noisy = RATES_HZ.map(|hz| of(hz, 0.3e-3, &strokes));
    for values in [shaken, stroked, noisy] {
        for metric in [Metric::Path, Metric::Idle, Metric::Movements, Metric::Time] {
            let all = values.map(|it| it.get(metric));
            let [least, most] = [f64::min, f64::max].map(|of| all.into_iter().reduce(of).unwrap());
            assert!(most - least <= 0.05 * most, "{} {all:?}", metric.name());
        }
    }
    is(shaken[0].get(Metric::Movements), 1.0);
    let noise_mm = shaken[0].get(Metric::Noise);
    assert!(noise_mm.is_nan(), "{noise_mm} mm: it moves");
    for values in [&stroked[0], &noisy[0]] {
        is(values.get(Metric::Movements), 30.0);
        let path_m = values.get(Metric::Path);
        assert!((path_m - 1.2).abs() < 0.05 * 1.2, "{path_m}");
    }
}

#[test]
fn time_without_a_lost_device_is_not_the_trainees() {
    let mut assessment = begin(Task::Free);
    let at = |at_s: f64, live| Movement {
        live,
        ..here([(at_s * 0.03) as f32, 0.0, -0.1])
    };
    for step in 0..3000 {
        let at_s = f64::from(step) * 0.01;
        let live = if (10.0..19.0).contains(&at_s) { 6 } else { 7 };
        assessment.take(&moved(at_s, at(at_s, live)));
    }
    let values = assessment.end().metrics;
    assert!(
        (values.get(Metric::DeviceLost) - 9.0).abs() < 0.03,
        "{}",
        values.get(Metric::DeviceLost)
    );
    assert!((values.get(Metric::Time) - 21.0).abs() < 0.05);
    assert!(
        (values.get(Metric::Path) - 0.63).abs() < 0.01,
        "{}",
        values.get(Metric::Path)
    );
    // Without the pedal the hands go on: only the hook waits for it.
    for (instrument, gone) in [(Instrument::Grasper, 0.0), (Instrument::Hook, 2.0)] {
        let mut pedal = begin(Task::Free);
        for step in 0..500 {
            let live = if (100..300).contains(&step) { 3 } else { 7 };
            let held = Movement {
                instrument: instrument.number() as u8,
                ..at(0.0, live)
            };
            pedal.take(&moved(f64::from(step) * 0.01, held));
        }
        let values = pedal.end().metrics;
        let lost_s = values.get(Metric::DeviceLost);
        assert!((lost_s - gone).abs() < 0.03, "{instrument:?}: {lost_s}");
        assert!((values.get(Metric::Time) + lost_s - 4.99).abs() < 1e-6);
    }
    // Neither does anybody see without the tracker of the endoscope.
    let mut blind = begin(Task::Free);
    for step in 0..300 {
        let live = if step < 100 { 7 } else { 5 };
        blind.take(&moved(f64::from(step) * 0.01, at(0.0, live)));
    }
    let lost_s = blind.end().metrics.get(Metric::DeviceLost);
    assert!((lost_s - 2.0).abs() < 0.03, "{lost_s}");
    // A station without that device has lost none.
    let mut without = begin(Task::Free);
    for step in 0..100 {
        without.take(&moved(f64::from(step) * 0.01, at(0.0, 6)));
    }
    is(without.end().metrics.get(Metric::DeviceLost), 0.0);
    // One that is open and never sent anything is missing, too.
    let mut silent = begin(Task::Free);
    let fault = Fault::SilentDevice.number() as f32;
    for step in 0..300 {
        let at_s = f64::from(step) * 0.01;
        if step == 100 {
            silent.take(&event(at_s, EventKind::Fault.number(), DUCT, 0.0, fault));
        }
        silent.take(&moved(at_s, at(0.0, 6)));
    }
    let lost_s = silent.end().metrics.get(Metric::DeviceLost);
    assert!((lost_s - 2.0).abs() < 0.05, "{lost_s}");
}

proptest! {
    #[test]
    fn a_path_does_not_depend_on_how_often_it_is_looked_at(hz in 20.0f64..250.0, seconds in 2.0f64..9.0) {
        let path_m = circle(hz, seconds, 0.0).get(Metric::Path);
        let true_m = 0.05 * std::f64::consts::TAU / 4.0 * (hz * seconds).floor() / hz;
        prop_assert!((path_m - true_m).abs() < 0.02 * true_m + 0.002, "{} {}", path_m, true_m);
        is(circle(hz, seconds, 0.0).get(Metric::Movements), 1.0);
    }

    #[test]
    fn tremor_is_no_path(amplitude in 0.0f64..0.0003) {
        let calm = circle(100.0, 4.0, 0.0).get(Metric::Path);
        let shaky = circle(100.0, 4.0, amplitude).get(Metric::Path);
        prop_assert!((shaky - calm).abs() < 0.06 * calm, "{} {}", calm, shaky);
    }

    #[test]
    fn times_of_parts_sum_to_the_whole(
        steps in prop::collection::vec((0.001f64..0.2, any::<bool>()), 2..80),
        split in 0.0f64..1.0,
    ) {
        let mut entries = Vec::new();
        let mut at_s = 0.0;
        for (seconds, on) in &steps {
            at_s += seconds;
            let switches = if *on { 17 } else { 16 };
            entries.push(moved(at_s, Movement { instrument: 1, switches, ..here([0.0; 3]) }));
        }
        let middle = ((split * entries.len() as f64) as usize).min(entries.len() - 1);
        let over = |entries: &[Entry]| {
            let mut assessment = begin(Task::Free);
            entries.iter().for_each(|entry| assessment.take(entry));
            assessment.end().metrics
        };
        // The entry in the middle ends one part and begins the next.
        let [one, two, whole] =
            [&entries[..=middle], &entries[middle..], &entries[..]].map(over);
        for metric in [Metric::Time, Metric::CauteryOn, Metric::CauteryAir] {
            let sum = one.get(metric) + two.get(metric);
            prop_assert!((sum - whole.get(metric)).abs() < 1e-6);
        }
    }

    /// The assessment of any file ends, has a score in range, and is reproducible.
    #[test]
    fn hostile_entries_are_assessed(
        raw in prop::collection::vec((0u8..5, any::<u64>(), any::<[f32; 4]>(), 0u32..18, 0u32..7), 0..200),
        task in 0usize..7,
    ) {
        let entries: Vec<Entry> = raw.iter().map(|&(kind, at_ns, [x, y, z, value], event, organ)| {
            let what = match kind {
                0 if event == 0 => What::Start { task: organ as u8 },
            0 => What::Reset,
                1 => What::Device { force_max_n: value },
                2 => What::Moved(Movement { force_n: [x, y, z], ..here([x, y, z]) }),
                _ => What::Event(EventMsg {
                    kind: event,
                    organ,
                    at_m: [x, y, z],
                    value,
                    ..EventMsg::zeroed()
                }),
            };
            Entry { tick: 0, at_ns, what }
        }).collect();
        let run = || {
            let mut assessment = begin(Task::ALL[task]);
            for entry in &entries {
                assessment.take(entry);
                let _ = assessment.status();
            }
            assessment.end()
        };
        let assessed = run();
        prop_assert!((0.0..=100.0).contains(&assessed.score));
        prop_assert_ne!(assessed.outcome, Outcome::Running);
        prop_assert_eq!(run().metrics, assessed.metrics);
    }
}
