//! Start, order of steps, restarts, pauses and time limit of a task.

use super::*;

#[test]
fn a_gap_in_the_event_numbers_counts_as_lost_events_and_a_new_controller_does_not() {
    let mut assessment = begin(Task::Free);
    rest(&mut assessment, 0.0, 0.2);
    // 42, 43 and 2 are lost. At 0 a new controller begins to count.
    for sequence in [40, 41, 44, 45, 0, 1, 3] {
        let mut entry = event(0.3, EventKind::Removed.number(), FAT, 0.0, 1.0);
        if let EntryContent::Event(event) = &mut entry.what {
            event.sequence = sequence;
        }
        assessment.take(&entry);
    }
    is(assessment.end().metrics.get(Metric::LostEvents), 3.0);
}

#[test]
fn clips_and_divisions_that_the_controller_prepared_count_as_done() {
    // 3: the clips are in place; 4: duct and artery are divided as well.
    let start = |task| Entry {
        tick: 0,
        at_ns: 1_000_000_000,
        what: EntryContent::Start { task },
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
    // A cut that is not between the clips leaks.
    let mut leaking = begin(Task::Cut);
    leaking.take(&start(3));
    cut(&mut leaking, 1.0, DUCT);
    leaking.take(&event(1.1, EventKind::Leak.number(), DUCT, 0.0, 0.5));
    assert_eq!(leaking.end().outcome, Outcome::Failed);
    let mut divided = begin(Task::Disconnect);
    divided.take(&start(4));
    rest(&mut divided, 0.0, 1.0);
    remove(&mut divided, 10..30);
    assert_eq!(divided.end().outcome, Outcome::Passed);
}

#[test]
fn the_critical_view_is_judged_by_what_is_removed_and_shown() {
    let mut assessment = begin(Task::Identify);
    rest(&mut assessment, 0.0, 0.1);
    remove(&mut assessment, 0..9);
    assert!(!assessment.is_over());
    remove(&mut assessment, 10..18);
    assert!(!assessment.is_over(), "eight of the bed's ten cells");
    remove(&mut assessment, 17..18);
    assert!(!assessment.is_over(), "a cell counts only once");
    remove(&mut assessment, 18..19);
    assert!(
        !assessment.is_over(),
        "the endoscope has not shown the view"
    );
    hold_views(&mut assessment, 0.2);
    assert!(assessment.is_over());
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Passed);
    assert!((assessed.metrics.get(Metric::CvsTriangle) - 0.9).abs() < 1e-9);
    is(assessed.metrics.get(Metric::CvsTwo), 1.0);
}

#[test]
fn the_operation_in_order_passes_without_alarms_and_early_clips_raise_alarms() {
    let operate = |is_in_order: bool| {
        let mut assessment = begin(Task::Full);
        rest(&mut assessment, 0.0, 0.5);
        if !is_in_order {
            clip_both(&mut assessment);
        }
        remove(&mut assessment, 0..20);
        if is_in_order {
            hold_views(&mut assessment, 0.6);
            clip_both(&mut assessment);
        }
        cut(&mut assessment, 2.0, DUCT);
        cut(&mut assessment, 2.0, ARTERY);
        rest(&mut assessment, 6.0, 10.0);
        assert!(!assessment.is_over());
        remove(&mut assessment, 20..30);
        assessment.end()
    };
    let good = operate(true);
    assert_eq!((good.outcome, good.alarms.len()), (Outcome::Passed, 0));
    let early = operate(false);
    assert_eq!(kinds(&early), [AlarmKind::TooEarly; 4]);
    assert_eq!(early.outcome, Outcome::Failed);
    let missed = Reason::TooLittle {
        metric: Some(Metric::ViewsHeld),
        value: 0.0,
        limit: 2.0,
    };
    assert!(early.reasons.contains(&missed), "{:?}", early.reasons);
}

#[test]
fn a_reset_begins_anew_and_is_counted() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 5.0);
    clip(&mut assessment, 5.0, NOTHING, 0.0, 0.0);
    let reset = Entry {
        tick: 1,
        at_ns: 7_000_000_000,
        what: EntryContent::Reset,
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
fn pauses_and_gaps_do_not_count_as_time() {
    let mut assessment = begin(Task::Free);
    rest(&mut assessment, 0.0, 1.0);
    // Four seconds are missing in the recording. After them the hand is elsewhere.
    assessment.take(&moved(5.0, here([0.3, 0.0, 0.0])));
    assessment.take(&moved(5.1, here([0.3, 0.0, 0.0])));
    // Bit 8: the simulation is paused.
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
fn a_pause_before_a_cut_does_not_delay_the_end_of_the_task() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.5);
    clip_both(&mut assessment);
    // Bit 8: the simulation is paused.
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
fn a_second_start_restarts_the_task_and_restores_its_clips() {
    let mut assessment = begin(Task::Cut);
    let start = |at_ns| Entry {
        tick: 0,
        at_ns,
        what: EntryContent::Start { task: 3 },
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
fn placing_the_sutures_is_a_step_only_if_the_task_starts_before_them() {
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
            what: EntryContent::Start { task },
        };
        assessment.take(&start(0));
        let step = |assessment: &Assessment| {
            let steps = assessment.status().steps;
            let mut steps = steps.into_iter();
            steps.find(|(step, _)| matches!(step, Step::Hang { count: 2 }))
        };
        assert_eq!(step(&assessment).is_some(), hangs, "{task:?}");
        // A suture that is placed twice counts once.
        for (number, is_done) in [(0.0, false), (0.0, false), (1.0, hangs)] {
            assessment.take(&event(1.0, EventKind::Stitch.number(), LIVER, 0.0, number));
            assessment.take(&event(2.0, EventKind::Hung.number(), LIVER, 0.0, number));
            let done = step(&assessment).is_some_and(|(_, done)| done);
            assert_eq!(done, is_done, "{task:?} {number}");
        }
        // The sutures complete no other step. Duct and artery are intact from the start.
        assert!(assessment.status().steps.iter().all(|(step, done)| {
            !*done || matches!(step, Step::Hang { .. } | Step::LeaveWhole)
        }));
        assessment.take(&start(1));
        assert!(
            step(&assessment).is_none(),
            "this start has placed the sutures"
        );
    }
}

#[test]
fn a_task_fails_after_its_time_limit() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 601.0);
    let too_long = Reason::TooLong { seconds: 600.0 };
    assert_eq!(assessment.status().reasons, [too_long]);
}

#[test]
fn a_beginner_is_told_to_take_the_instrument_and_then_to_use_it() {
    let (rules, anatomy) = (Rules::default(), anatomy());
    let mut assessment = Assessment::new(Task::Clamp, Difficulty::Beginner, rules, anatomy);
    for (instrument, advice) in [
        (0, Advice::Take(Instrument::ClipApplier)),
        (3, Advice::Use(Instrument::ClipApplier)),
    ] {
        assessment.take(&moved(
            f64::from(instrument) * 0.1,
            Movement {
                instrument,
                ..here([0.0; 3])
            },
        ));
        let hint = assessment.status().hint.expect("a beginner has a hint");
        assert_eq!(hint.advice, advice);
        assert!(matches!(hint.step, Step::Clip { count: 2, .. }));
    }
}
