//! The endoscope in the body: tissue yields to it. The hand feels it only if the instrument touches
//! it.

use crate::rig::{Anatomy, Bench, TOUCH, tracker_at};
use crate::{AWAY, FORCE_ENABLED, NONE, moved_m, new_state};
use rt_core::math::{Vec3, norm};
use rt_core::port::Polled;
use rt_core::sim::Sim;

/// Moves tip and camera along straight lines, one step a tick.
fn move_tip(sim: &mut Sim<'_>, bench: &mut Bench, tip: [Vec3; 2], camera: [Vec3; 2], ticks: u16) {
    for tick in 1..=ticks {
        let share = f32::from(tick) / f32::from(ticks);
        let at = |[from, to]: [Vec3; 2]| from + (to - from) * share;
        let samples = bench.next_at(&at(tip), NONE);
        samples.tracker = Polled::Fresh(tracker_at(at(camera), samples.now_ns));
        sim.tick(bench);
    }
}

#[test]
fn endoscope_presses_on_tissue_and_the_hand_does_not_feel_it() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let (over, on) = (Vec3::new(0.02, 0.0, 0.09), Vec3::new(0.02, 0.0, 0.040));
    move_tip(&mut sim, &mut bench, [AWAY; 2], [over; 2], 100);
    let before = moved_m(&bench, &anatomy);
    move_tip(&mut sim, &mut bench, [AWAY; 2], [over, on], 500);
    let moved = moved_m(&bench, &anatomy) - before;
    assert!(moved > 0.002, "{moved} m");
    assert!(norm(&bench.force_n) < f32::EPSILON && bench.contact_count == 0);
    assert!(bench.events.is_empty(), "{:?}", bench.events);
}

#[test]
fn the_instrument_does_not_go_through_it() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let camera = Vec3::new(0.02, 0.0, 0.07);
    let (from, to) = (Vec3::new(-0.02, 0.0, 0.075), Vec3::new(0.035, 0.0, 0.075));
    move_tip(&mut sim, &mut bench, [from; 2], [camera; 2], 100);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    // 55 mm in 0.9 s, with the shaft across the endoscope.
    move_tip(&mut sim, &mut bench, [from, to], [camera; 2], 900);
    assert!(bench.contact_count > 0);
    // The tip is pushed towards −x, and the hand beyond the port towards x.
    assert!(bench.force_n.x > 0.1, "{}", bench.force_n);
    move_tip(&mut sim, &mut bench, [to, from], [camera; 2], 900);
    assert!(norm(&bench.force_n) < f32::EPSILON && bench.contact_count == 0);
}
