//! Stones that spill, are taken out, or are left behind.

use super::*;

const BAG: u32 = 5;

fn stone(at_s: f64, kind: EventKind, number: u32) -> Entry {
    event(at_s, kind.number(), BAG, 0.0, number as f32)
}

/// Spills five stones, and takes these out.
fn spill(taken: &[u32]) -> Assessed {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    for number in 0..5 {
        assessment.take(&stone(0.1, EventKind::StoneSpilled, number));
    }
    for number in taken {
        assessment.take(&stone(0.1, EventKind::StoneHeld, *number));
        assessment.take(&stone(0.1, EventKind::StoneDropped, *number));
        assessment.take(&stone(0.1, EventKind::StoneHeld, *number));
        assessment.take(&stone(0.1, EventKind::StoneRetrieved, *number));
    }
    clip_both(&mut assessment);
    rest(&mut assessment, 1.0, 125.0);
    assessment.end()
}

fn counts(assessed: &Assessed) -> [u32; 3] {
    [
        Metric::StonesSpilled,
        Metric::StonesRetrieved,
        Metric::StonesLeft,
    ]
    .map(|it| assessed.metrics.get(it) as u32)
}

#[test]
fn stones_left_behind_are_counted_and_cost_points() {
    assert_eq!(counts(&spill(&[0, 2])), [5, 2, 3]);
    let all = spill(&[0, 1, 2, 3, 4]);
    assert_eq!(counts(&all), [5, 5, 0]);
    let lost = |it: &Assessed| {
        let own = it
            .lost
            .iter()
            .find(|it| it.metric == Metric::StonesLeft.name());
        own.map_or(0.0, |it| it.points)
    };
    is(lost(&all), 0.0);
    is(lost(&spill(&[0, 2])), 9.0);
    let spills = all.moments.iter().filter(|it| it.what == "stone_spilled");
    assert_eq!(spills.count(), 5);
}

/// Spills a stone, clips both vessels, rests for this time, and takes the stone out if asked.
fn clipped_over_a_stone(rests_s: f64, takes_it_out: bool) -> Assessment {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 0.1);
    assessment.take(&stone(0.1, EventKind::StoneSpilled, 0));
    clip_both(&mut assessment);
    rest(&mut assessment, 1.0, 1.0 + rests_s);
    if takes_it_out {
        assessment.take(&stone(1.0 + rests_s, EventKind::StoneRetrieved, 0));
    }
    assessment
}

#[test]
fn a_task_leaves_time_to_pick_up_stones_after_its_last_step() {
    let waiting = clipped_over_a_stone(20.0, false);
    assert!(!waiting.is_over());
    let open: Vec<Step> = (waiting.status().steps.into_iter())
        .filter(|(_, done)| !done)
        .map(|(step, _)| step)
        .collect();
    assert_eq!(open, [Step::Collect { left: 1 }]);
    assert_eq!(
        clipped_over_a_stone(20.0, true).end().outcome,
        Outcome::Passed
    );
    // Who ends it in that time has done the task.
    let ended = waiting.end();
    assert_eq!(ended.outcome, Outcome::Passed);
    assert_eq!(
        ended.steps.last(),
        Some(&(Step::Collect { left: 1 }, false))
    );
    let late = clipped_over_a_stone(125.0, false);
    assert!(late.is_over());
    let late = late.end();
    assert_eq!(late.outcome, Outcome::Passed);
    is(late.metrics.get(Metric::StonesLeft), 1.0);
}

#[test]
fn the_time_limit_ends_the_collection_and_not_the_task() {
    let mut assessment = begin(Task::Clamp);
    rest(&mut assessment, 0.0, 590.0);
    assessment.take(&stone(590.0, EventKind::StoneSpilled, 0));
    for (at_s, organ, x_m, number) in [
        (590.1, DUCT, -0.01, 0.0),
        (590.2, DUCT, 0.01, 1.0),
        (590.3, ARTERY, -0.01, 2.0),
        (590.4, ARTERY, 0.01, 3.0),
    ] {
        clip(&mut assessment, at_s, organ, x_m, number);
    }
    rest(&mut assessment, 590.5, 599.0);
    assert!(!assessment.is_over());
    rest(&mut assessment, 599.0, 601.0);
    assert_eq!(assessment.end().outcome, Outcome::Passed);
}

#[test]
fn a_stone_counts_once_and_also_if_the_event_of_its_spill_is_lost() {
    let mut assessment = begin(Task::Free);
    rest(&mut assessment, 0.0, 0.1);
    for kind in [EventKind::StoneSpilled, EventKind::StoneSpilled] {
        assessment.take(&stone(0.1, kind, 3));
    }
    assessment.take(&stone(0.1, EventKind::StoneRetrieved, 4));
    let values = assessment.metrics();
    is(values.get(Metric::StonesSpilled), 2.0);
    is(values.get(Metric::StonesLeft), 1.0);
}
