//! Relaxation under a tool, in the jaws and under a weight.

use super::*;
use rt_core::scene::Relaxation;

/// A third of the stress is lost quickly, a fifth slowly.
const RELAXES: Relaxation = Relaxation {
    shares: [0.3, 0.2],
    times_s: [0.2, 2.0],
};

fn liver(relaxation: Relaxation) -> Anatomy {
    let mut anatomy = Anatomy::liver();
    anatomy.organs[0].material.relaxation = relaxation;
    anatomy
}

/// Tissue's force in each tick of a press of 200 ms that is then held.
fn pressed(relaxation: Relaxation, ticks: u32) -> Vec<f32> {
    let anatomy = liver(relaxation);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let above = Vec3::new(0.0, 0.0, 0.06);
    let mut forces = Vec::new();
    for step in 1..=ticks {
        let share = (step as f32 / 200.0).min(1.0);
        hold_tip(
            &mut sim,
            &mut bench,
            &(above + (PRESSED - above) * share),
            1,
            NONE,
        );
        forces.push(bench.force_n.z);
    }
    forces
}

/// Share of its first force with which tissue that was strained `age_s` ago pushes back.
fn left(age_s: f64) -> f64 {
    let Relaxation { shares, times_s } = RELAXES;
    let lost = |i: usize| f64::from(shares[i]) * (1.0 - (-age_s / f64::from(times_s[i])).exp());
    1.0 - lost(0) - lost(1)
}

#[test]
fn a_held_press_loses_its_force_by_the_two_terms() {
    let elastic = pressed(Relaxation::NONE, 3000);
    let relaxing = pressed(RELAXES, 3000);
    // Boltzmann's superposition: each increment of the elastic force relaxes from its own time.
    let mut last = 0.0;
    let steps: Vec<f64> = elastic
        .iter()
        .map(|&n| {
            let step = f64::from(n) - last;
            last = f64::from(n);
            step
        })
        .collect();
    for tick in [250usize, 400, 800, 1500, 2999] {
        let expected: f64 = steps[..=tick]
            .iter()
            .enumerate()
            .map(|(born, step)| step * left((tick - born) as f64 * 1.0e-3))
            .sum();
        let found = f64::from(relaxing[tick]);
        assert!(
            (found / expected - 1.0).abs() < 0.05,
            "after {tick} ms: {found} N, expected {expected} N of {} N",
            elastic[tick]
        );
    }
}

#[test]
fn tissue_that_does_not_ask_computes_the_same_bits() {
    let digests = |relaxation: Relaxation| {
        let anatomy = liver(relaxation);
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 300, NONE);
        sim.state_hash()
    };
    let without = digests(Relaxation::NONE);
    let other_times = Relaxation {
        times_s: [0.2, 2.0],
        ..Relaxation::NONE
    };
    assert_eq!(without, digests(other_times));
    assert_ne!(without, digests(RELAXES));
}

#[test]
fn grasped_tissue_relaxes() {
    let pulled = |relaxation: Relaxation| {
        let anatomy = liver(relaxation);
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        let bite = Vec3::new(0.0, 0.0, 0.046);
        move_tip(&mut sim, &mut bench, &AWAY, &bite, 300, NONE);
        hold_tip(&mut sim, &mut bench, &bite, 300, Buttons::GRASP);
        assert!(bench.grasped_count > 0, "the jaws hold the liver");
        let lifted = Vec3::new(0.0, 0.0, 0.058);
        move_tip(&mut sim, &mut bench, &bite, &lifted, 200, Buttons::GRASP);
        let first_n = norm(&bench.force_n);
        hold_tip(&mut sim, &mut bench, &lifted, 3000, Buttons::GRASP);
        assert!(bench.grasped_count > 0, "the jaws still hold the liver");
        (first_n, norm(&bench.force_n))
    };
    let (first_n, held_n) = pulled(Relaxation::NONE);
    assert!(held_n > 0.9 * first_n, "{first_n} {held_n}");
    let (first_n, held_n) = pulled(RELAXES);
    assert!(
        held_n < 0.72 * first_n && held_n > 0.4 * first_n,
        "{first_n} {held_n}"
    );
}
