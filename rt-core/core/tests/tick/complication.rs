//! Complications that an instructor triggers.

use super::start::{anatomy, begin_with};
use super::*;
use rt_core::sim::{Complication, Task};

/// Events of this kind: value and place.
fn of_kind(bench: &Bench, kind: EventKind) -> Vec<(f32, Vec3)> {
    let events = bench.events.iter().filter(|it| it.kind == kind);
    events.map(|it| (it.value, it.at_m)).collect()
}

/// Starts `task`, triggers `complications`, each half a second after the one before, and waits a
/// second.
fn complicated(task: Task, complications: &[Complication]) -> Bench {
    let anatomy = anatomy();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = begin_with(&mut sim, task, 500);
    for complication in complications {
        bench.next_at(&AWAY, NONE).command = Some(Command::Complication(*complication));
        sim.tick(&mut bench);
        hold_tip(&mut sim, &mut bench, &AWAY, 500, NONE);
    }
    hold_tip(&mut sim, &mut bench, &AWAY, 500, NONE);
    bench
}

#[test]
fn the_artery_bleeds_from_a_hole_where_blood_reaches_it() {
    let bench = complicated(Task::Clamp, &[Complication::Bleeding]);
    let opened = of_kind(&bench, EventKind::Opened);
    let leaks = of_kind(&bench, EventKind::Leak);
    let [(area_m2, place)] = opened[..] else {
        panic!("{opened:?}");
    };
    // Half of a lumen with a radius of 1.2 mm.
    assert!((area_m2 - 2.26e-6).abs() < 0.01e-6, "{area_m2}");
    let [(flow, leaks_at)] = leaks[..] else {
        panic!("{leaks:?}");
    };
    assert!((flow - 0.5).abs() < 0.01, "{flow}");
    assert!(norm(&(leaks_at - place)) < 1.0e-3, "{leaks_at} {place}");
    // It is no injury of the trainee.
    assert!(of_kind(&bench, EventKind::Perforation).is_empty());
}

#[test]
fn an_artery_that_is_open_is_not_opened_again_at_the_same_place() {
    let bench = complicated(Task::Clamp, &[Complication::Bleeding; 3]);
    assert_eq!(of_kind(&bench, EventKind::Opened).len(), 1);
    assert_eq!(of_kind(&bench, EventKind::Leak).len(), 1);
}

#[test]
fn an_artery_that_clips_close_bleeds_only_on_the_side_of_the_blood() {
    let bench = complicated(Task::Cut, &[Complication::Bleeding]);
    let opened = of_kind(&bench, EventKind::Opened);
    let clipped_m = bench.clips[0].spheres[0];
    let [(_, place)] = opened[..] else {
        panic!("{opened:?}");
    };
    assert!(place.x < bench.centers_m[clipped_m as usize].x + 1.0e-3);
    assert_eq!(of_kind(&bench, EventKind::Leak).len(), 1);
}

#[test]
fn the_newest_clip_slips_off_and_a_vessel_that_only_it_closed_bleeds() {
    let slip = Complication::SlippedClip;
    let bench = complicated(Task::Disconnect, &[slip, slip, slip, slip]);
    let numbers = of_kind(&bench, EventKind::Unclipped);
    let numbers: Vec<f32> = numbers.iter().map(|it| it.0).collect();
    assert_eq!(numbers, [2.0, 1.0, 0.0], "the fourth finds no clip");
    assert_eq!(
        (bench.clips.len(), bench.clips_left),
        (0, 12),
        "the applier got them back"
    );
    let leaks = of_kind(&bench, EventKind::Leak);
    assert!(leaks.iter().any(|it| it.0 > 0.99), "{leaks:?}");
}

#[test]
fn without_a_clip_or_an_artery_nothing_happens() {
    let liver = Anatomy::liver();
    for complication in [Complication::Bleeding, Complication::SlippedClip] {
        // The hashes of a run with a complication that finds nothing, and of one without any.
        let runs = [Some(Command::Complication(complication)), None].map(|command| {
            let mut state = new_state();
            let mut sim = Sim::new(liver.scene(), &mut state, TOUCH, FORCE_ENABLED);
            let mut bench = Bench::new();
            bench.next_at(&PRESSED, NONE).command = command;
            sim.tick(&mut bench);
            hold_tip(&mut sim, &mut bench, &PRESSED, 200, NONE);
            (sim.state_hash(), kinds(&bench.events))
        });
        assert_eq!(runs[0], runs[1], "{complication:?}");
    }
    assert_eq!(Complication::from_number(2), None);
}
