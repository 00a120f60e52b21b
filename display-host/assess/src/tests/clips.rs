//! Clips, and cuts between them.

use super::*;

#[test]
fn clamping_passes_with_two_clips_on_duct_and_artery() {
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
fn clips_that_are_lost_or_misplaced_raise_alarms_and_cost_points() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    clip(&mut assessment, 0.1, NOTHING, 0.0, 9.0);
    // A clip on duct and artery at once.
    clip(&mut assessment, 0.2, DUCT, 0.0, 8.0);
    clip(&mut assessment, 0.2, ARTERY, 0.0, 8.0);
    clip_both(&mut assessment);
    let assessed = assessment.end();
    assert_eq!(
        kinds(&assessed),
        [AlarmKind::ClipLost, AlarmKind::ClipMisplaced]
    );
    assert!((assessed.score - 80.0).abs() < 1e-9, "{:?}", assessed.lost);
    assert_eq!(
        assessed.outcome,
        Outcome::Failed,
        "no clip may be misplaced"
    );
    assert_eq!(
        assessed.reasons,
        [Reason::TooMuch {
            metric: Some(Metric::ClipsMisplaced),
            value: 1.0,
            limit: 0.0
        }]
    );
    // Reports give reasons and steps in plain English.
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

/// Closes a clip by a controller that says how much of the vessel it closes, and where.
fn close(assessment: &mut Assessment, organ: u32, number: f32, [share, along_m]: [f32; 2]) {
    for (kind, value) in [
        (EventKind::ClipCloses, share),
        (EventKind::ClipAlong, along_m),
    ] {
        assessment.take(&event(0.1, kind.number(), organ, 0.0, value));
    }
    clip(assessment, 0.1, organ, 0.0, number);
}

#[test]
fn a_clip_that_leaves_a_part_open_does_not_count() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    close(&mut assessment, DUCT, 0.0, [1.0, 0.010]);
    close(&mut assessment, DUCT, 1.0, [0.6, 0.015]);
    close(&mut assessment, ARTERY, 2.0, [1.0, 0.010]);
    close(&mut assessment, ARTERY, 3.0, [1.0, 0.015]);
    assert!(!assessment.is_over());
    close(&mut assessment, DUCT, 4.0, [0.99, 0.016]);
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Passed, "{:?}", assessed.reasons);
    assert_eq!(kinds(&assessed), [AlarmKind::ClipOpen]);
    is(assessed.metrics.get(Metric::ClipsDuct), 2.0);
}

#[test]
fn room_is_measured_along_the_vessel_and_not_where_the_applier_was() {
    for (gap_m, passes) in [(0.0005, false), (0.004, true)] {
        let mut assessment = begin(Task::Clamp);
        rest(&mut assessment, 0.0, 0.1);
        for (organ, first) in [(DUCT, 0.0), (ARTERY, 2.0)] {
            close(&mut assessment, organ, first, [1.0, 0.010]);
            close(&mut assessment, organ, first + 1.0, [1.0, 0.010 + gap_m]);
        }
        let assessed = assessment.end();
        let room_mm = assessed.metrics.get(Metric::ClipRoom);
        assert!((room_mm - f64::from(gap_m) * 1e3).abs() < 1e-3, "{room_mm}");
        assert_eq!(assessed.outcome == Outcome::Passed, passes);
    }
}

#[test]
fn a_clip_on_duct_and_artery_at_once_is_misplaced() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    for (number, x_m) in [(0.0, 0.0), (1.0, 0.004)] {
        clip(&mut assessment, 0.1, DUCT, x_m, number);
        clip(&mut assessment, 0.1, ARTERY, x_m, number);
    }
    let assessed = assessment.end();
    assert_eq!(kinds(&assessed), [AlarmKind::ClipMisplaced; 2]);
    is(assessed.metrics.get(Metric::ClipsMisplaced), 2.0);
    assert_eq!(assessed.outcome, Outcome::Failed);
}

/// An attachment of the cystic duct may tear while the duct itself stays closed.
#[test]
fn a_tear_at_the_cystic_duct_is_an_error_and_its_division_ends_the_task() {
    let mut assessment = begin(Task::Disconnect);
    rest(&mut assessment, 0.0, 0.1);
    assessment.take(&event(0.1, EventKind::Tear.number(), DUCT, 0.0, 0.001));
    assert!(!assessment.is_over());
    assert_eq!(assessment.alarms()[0].kind, AlarmKind::Torn);
    assessment.take(&event(0.2, EventKind::Divided.number(), DUCT, 0.0, 1.0));
    assert!(assessment.is_over());
    assert_eq!(assessment.status().reasons, [unclamped("cystic duct")]);
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
fn the_definition_of_a_wrong_cut_names_each_organ_that_may_be_cut() {
    let definition = Metric::CutsWrong.definition();
    let may_be_cut = |kind: OrganKind| {
        definition.contains(match kind {
            OrganKind::CysticDuct | OrganKind::CysticArtery => "cystic duct and artery",
            OrganKind::Fat => "fat",
            OrganKind::ConnectiveTissue => "connective tissue",
            OrganKind::Gallbladder => "gallbladder",
            OrganKind::Liver => "liver",
            OrganKind::BileDuct => "bile duct",
            OrganKind::Stomach => "stomach",
            OrganKind::Intestine => "intestine",
            OrganKind::AbdominalWall => "abdominal wall",
            OrganKind::Vessel => "vessel",
        })
    };
    for kind in OrganKind::ALL {
        let anatomy = Anatomy::new(&[("organ", kind)], &[]);
        let (help, rules) = (Difficulty::Trainee, Rules::default());
        let mut assessment = Assessment::new(Task::Free, help, rules, anatomy);
        rest(&mut assessment, 0.0, 0.1);
        assessment.take(&event(0.2, EventKind::Cut.number(), 0, 0.0, 0.001));
        let wrong = assessment.end().metrics.get(Metric::CutsWrong);
        is(wrong, f64::from(u8::from(!may_be_cut(kind))));
    }
}

#[test]
fn cutting_between_clips_passes_after_some_time_without_a_leak() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.5);
    clip_both(&mut assessment);
    rest(&mut assessment, 0.6, 1.0);
    cut(&mut assessment, 1.0, DUCT);
    cut(&mut assessment, 1.0, ARTERY);
    assert!(!assessment.is_over(), "a leak may still begin");
    rest(&mut assessment, 1.1, 4.0);
    let assessed = assessment.end();
    assert_eq!(assessed.outcome, Outcome::Passed, "{assessed:?}");
    is(assessed.metrics.get(Metric::CutsOneSided), 0.0);
}

#[test]
fn clips_that_leak_do_not_count_as_clamped() {
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
fn clips_on_one_side_of_the_cut_do_not_count_as_clamped() {
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
fn a_partial_cut_is_no_division_and_a_closed_end_does_not_hide_the_leak_of_the_other() {
    let mut assessment = begin(Task::Cut);
    rest(&mut assessment, 0.0, 0.1);
    clip_both(&mut assessment);
    for organ in [DUCT, ARTERY] {
        assessment.take(&event(0.5, EventKind::Cut.number(), organ, 0.0, 0.001));
    }
    rest(&mut assessment, 0.6, 4.0);
    assert!(!assessment.is_over(), "only strands of both were cut");
    assessment.take(&event(4.1, EventKind::Leak.number(), DUCT, 0.0, 0.5));
    assessment.take(&event(4.1, EventKind::Leak.number(), DUCT, 0.01, 0.0));
    cut(&mut assessment, 4.2, DUCT);
    assert_eq!(assessment.end().outcome, Outcome::Failed);
}

/// All clips of a vessel may not lie at one place: the blades need room between its two sides.
#[test]
fn clips_at_one_place_leave_no_room_for_the_blades() {
    let clamped = |places_m: [f32; 3]| {
        let mut assessment = begin(Task::Clamp);
        rest(&mut assessment, 0.0, 0.1);
        for (number, x_m) in places_m.into_iter().enumerate() {
            clip(&mut assessment, 0.1, DUCT, x_m, number as f32);
        }
        clip(&mut assessment, 0.2, ARTERY, -0.005, 3.0);
        clip(&mut assessment, 0.3, ARTERY, 0.005, 4.0);
        assessment.end()
    };
    let together = clamped([0.0, 0.001, 0.0025]);
    let room_mm = together.metrics.get(Metric::ClipRoom);
    assert!((room_mm - 1.5).abs() < 1e-3, "{room_mm}");
    assert_eq!(together.outcome, Outcome::Failed, "{:?}", together.reasons);
    // Two clips close one side, the third the other. Between the sides is room.
    let apart = clamped([0.0, 0.001, 0.008]);
    let room_mm = apart.metrics.get(Metric::ClipRoom);
    assert!((room_mm - 7.0).abs() < 1e-3, "{room_mm}");
    assert_eq!(apart.outcome, Outcome::Passed, "{:?}", apart.reasons);
}
