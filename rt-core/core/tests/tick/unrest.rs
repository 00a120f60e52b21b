//! Events of organs that fall or shake.

use super::*;
use crate::grip::count;
use crate::rig::tracker_at;
use rt_core::port::Polled;

/// Loose spheres of 1 cm radius, far from the tool, fall 0.3 m in a quarter of a second.
#[test]
fn a_loose_organ_that_falls_is_reported_once_and_again_after_a_reset() {
    let anatomy = loose_spheres(&[sphere(0.1, 0.0), sphere(-0.1, 0.0)], SOFT);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 1500, NONE);
    let falls: Vec<Event> = (bench.events.iter().copied())
        .filter(|it| it.kind == EventKind::Fall)
        .collect();
    assert_eq!(falls.len(), 2, "one for each: {falls:?}");
    assert!(
        falls.iter().all(|it| it.value > 0.02 && it.at_m.z < -0.02),
        "{falls:?}"
    );
    assert_eq!(count(&bench, EventKind::Shake), 0);
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    hold_tip(&mut sim, &mut bench, &AWAY, 1500, NONE);
    assert_eq!(count(&bench, EventKind::Fall), 4);
}

#[test]
fn a_whole_liver_that_is_pressed_and_let_go_neither_falls_nor_shakes() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 7000, NONE);
    move_tip(&mut sim, &mut bench, &PRESSED, &AWAY, 500, NONE);
    hold_tip(&mut sim, &mut bench, &AWAY, 7000, NONE);
    let reported = [EventKind::Fall, EventKind::Shake].map(|kind| count(&bench, kind));
    assert_eq!(reported, [0, 0]);
}

/// A checkpoint holds the memory of reported falls.
#[test]
fn a_fall_is_reported_again_from_a_checkpoint_before_it() {
    let anatomy = loose_spheres(&[sphere(0.1, 0.0)], SOFT);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 50, NONE);
    let before = sim.checkpoint();
    hold_tip(&mut sim, &mut bench, &AWAY, 1000, NONE);
    assert_eq!(count(&bench, EventKind::Fall), 1);
    sim.go_back(&before);
    hold_tip(&mut sim, &mut bench, &AWAY, 1000, NONE);
    assert_eq!(count(&bench, EventKind::Fall), 2);
}

/// A liver without damping that is `factor` times as stiff as soft tissue. Its weight pulls at it
/// if it is `heavy`.
fn liver(factor: f32, heavy: bool) -> Anatomy {
    let mut anatomy = Anatomy::liver();
    for organ in &mut anatomy.organs {
        organ.substeps = 1;
        organ.gravity_share = if heavy { 1.0 } else { 0.0 };
        organ.material.young_pa *= factor;
        organ.material.damping_per_s = 0.0;
        organ.material.retardation_s = 0.0;
    }
    anatomy
}

/// A hand strokes the liver at 10 mm/s and never rests. Two livers are stable, one of them as stiff
/// as cartilage. The third liver is too soft for its weight: it collapses and shakes.
#[test]
fn a_liver_that_shakes_under_a_moving_hand_is_reported_once() {
    for (factor, heavy, times) in [(1.0, false, 0), (300.0, false, 0), (0.005, true, 1)] {
        let anatomy = liver(factor, heavy);
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 1000, NONE);
        let aside = PRESSED + Vec3::x() * 0.01;
        for _ in 0..4 {
            move_tip(&mut sim, &mut bench, &PRESSED, &aside, 1000, NONE);
            move_tip(&mut sim, &mut bench, &aside, &PRESSED, 1000, NONE);
        }
        assert_eq!(count(&bench, EventKind::Shake), times, "{factor}");
    }
}

/// Lets the endoscope sway across the liver's top, by 10 mm to both sides once a second, with the
/// instrument away. Returns the largest distance of a sphere from its place, m.
fn sway(sim: &mut Sim<'_>, bench: &mut Bench, anatomy: &Anatomy, ticks: u16) -> f32 {
    for tick in 0..ticks {
        let turn = core::f32::consts::TAU * f32::from(tick) * 0.001;
        let camera = Vec3::new(0.02, 0.01 * turn.sin(), 0.045);
        let samples = bench.next_at(&AWAY, NONE);
        samples.tracker = Polled::Fresh(tracker_at(camera, samples.now_ns));
        sim.tick(bench);
    }
    moved_m(bench, anatomy)
}

/// The endoscope presses the liver aside for 10 s, faster than an organ may shake. A liver that is
/// too soft for its weight shakes under the same endoscope.
#[test]
fn an_organ_that_the_endoscope_pushes_does_not_shake_and_one_that_collapses_does() {
    for (factor, heavy, times) in [(1.0, false, 0), (0.005, true, 1)] {
        let anatomy = liver(factor, heavy);
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        let moved = sway(&mut sim, &mut bench, &anatomy, 10_000);
        assert!(moved > 0.002, "{moved}");
        assert_eq!(count(&bench, EventKind::Shake), times, "{factor}");
    }
}
