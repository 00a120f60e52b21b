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
