//! Tests of the trocar's law by itself, along the shaft and across it.

extern crate std;

use super::*;
use crate::math;
use crate::testing::vector;
use proptest::prelude::*;

const LEVER: Kinematics = Kinematics {
    port_m: Vec3::new(0.0, 0.0, 0.0),
    length_m: 0.33,
};
/// Stiffness that a Touch renders stably, N/m.
const TOUCH_N_M: f32 = 840.0;
/// A seal without a wall.
const SEAL: Trocar = Trocar {
    sliding_n: 1.0,
    breakaway_n: 1.8,
    ..Trocar::NONE
};
/// A wall without a seal.
const WALL: Trocar = Trocar {
    wall_nm_rad: 0.3,
    axis: Vec3::new(0.0, 0.0, -1.0),
    ..Trocar::NONE
};

fn at(x: f32, y: f32, z: f32) -> Pose {
    Pose::translation(x, y, z)
}

/// Handle above the port. At 0 its distance from the port is 0.2 m; from there the shaft is pushed
/// in by `inside_m`.
fn drawn_in(inside_m: f32) -> Pose {
    at(0.0, 0.0, 0.2 - inside_m)
}

/// Force along the shaft at each place, N: positive pushes the hand out.
fn push(law: &mut TrocarLaw, places_m: impl Iterator<Item = f32>) -> std::vec::Vec<f32> {
    let felt = |m: f32| law.felt(&LEVER, &drawn_in(m), 0.0).force_n.z;
    places_m.map(felt).collect()
}

/// Places of a stroke at a constant speed, one a tick.
fn stroke(from_m: f32, to_m: f32, speed_m_s: f32) -> impl Iterator<Item = f32> {
    let ticks = ((to_m - from_m).abs() / (speed_m_s * TICK_S)).ceil() as u32;
    (0..=ticks).map(move |t| from_m + (to_m - from_m) * (t as f32 / ticks as f32))
}

#[test]
fn a_shaft_breaks_away_slides_and_jumps_when_it_reverses() {
    let mut law = TrocarLaw::new(&SEAL, TOUCH_N_M);
    let inwards = push(&mut law, stroke(0.0, 0.05, 0.05));
    let peak_n = inwards.iter().copied().fold(0.0, f32::max);
    assert!((peak_n - 1.8).abs() < 0.05, "breaks away at {peak_n} N");
    let sliding_n = inwards[inwards.len() - 1];
    assert!(
        (sliding_n - 1.0).abs() < 1.0e-4,
        "slides with {sliding_n} N"
    );
    // The force changes its sign, and the lips break away again on the other side.
    let outwards = push(&mut law, stroke(0.05, 0.0, 0.05));
    let peak_n = outwards.iter().copied().fold(0.0, f32::min);
    assert!((peak_n + 1.8).abs() < 0.05, "reverses at {peak_n} N");
    assert!((outwards[outwards.len() - 1] + 1.0).abs() < 1.0e-4);
    // Within the bend of the lips the force falls in proportion to the travel.
    let steps = outwards.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let step_n = steps.fold(0.0, f32::max);
    assert!(step_n < 0.05, "{step_n} N in a tick of 0.05 mm");
}

#[test]
fn slow_shaft_has_more_friction_than_fast_shaft_and_a_rest_restores_breakaway() {
    let last = |speed_m_s: f32| {
        let mut law = TrocarLaw::new(&SEAL, TOUCH_N_M);
        let all = push(&mut law, stroke(0.0, 0.03, speed_m_s));
        all[all.len() - 1]
    };
    assert!(last(0.005) > last(0.01) && last(0.01) > last(0.05) + 0.1);
    let mut law = TrocarLaw::new(&SEAL, TOUCH_N_M);
    push(&mut law, stroke(0.0, 0.05, 0.05));
    push(&mut law, core::iter::repeat_n(0.05, 1000));
    let again = push(&mut law, stroke(0.05, 0.06, 0.05));
    let peak_n = again.iter().copied().fold(0.0, f32::max);
    assert!((peak_n - 1.8).abs() < 0.05, "{peak_n} N after a rest");
}

#[test]
fn a_trembling_hand_at_rest_does_not_drift() {
    let mut law = TrocarLaw::new(&SEAL, TOUCH_N_M);
    push(&mut law, stroke(0.0, 0.02, 0.05));
    push(&mut law, core::iter::repeat_n(0.019, 1000));
    let before_n = push(&mut law, core::iter::once(0.019))[0];
    // 0.1 mm at 9 Hz for a minute.
    let tremor = (0..60_000).map(|t| {
        let turn = core::f64::consts::TAU * 9.0 * f64::from(t) * 1.0e-3;
        0.019 + (1.0e-4 * turn.sin()) as f32
    });
    push(&mut law, tremor);
    let after_n = push(&mut law, core::iter::once(0.019))[0];
    assert!((after_n - before_n).abs() < 1.0e-3, "{before_n} {after_n}");
}

#[test]
fn a_trocar_leaves_tissue_half_of_the_stiffness_and_a_weak_device_has_none() {
    let both = Trocar {
        breakaway_n: 3.0,
        ..Trocar {
            sliding_n: 3.0,
            ..WALL
        }
    };
    for outside_m in [0.02, 0.05, 0.1, 0.3] {
        let mut law = TrocarLaw::new(&both, TOUCH_N_M);
        let felt = law.felt(&LEVER, &at(0.0, 0.0, outside_m), 0.0);
        assert!(felt.stiffness_n_m <= 0.5001 * TOUCH_N_M, "{felt:?}");
    }
    let mut weak = TrocarLaw::new(&both, 10.0);
    assert_eq!(weak.felt(&LEVER, &drawn_in(0.1), 0.0), TrocarForce::NONE);
    let mut none = TrocarLaw::new(&Trocar::NONE, TOUCH_N_M);
    assert_eq!(
        none.felt(&LEVER, &at(0.1, 0.0, 0.1), 0.0),
        TrocarForce::NONE
    );
}

#[test]
fn stiff_tissue_softens_the_lips_and_the_change_gains_no_energy() {
    let mut law = TrocarLaw::new(&SEAL, TOUCH_N_M);
    push(&mut law, stroke(0.0, 0.02, 0.05));
    let energy_j = |law: &TrocarLaw| 0.5 * law.lips_n_m * law.bent_m * law.bent_m;
    let mut last_j = energy_j(&law);
    for tissue_n_m in [600.0, 0.0, 5000.0, 100.0] {
        for _ in 0..500 {
            let felt = law.felt(&LEVER, &drawn_in(0.02), tissue_n_m);
            let now_j = energy_j(&law);
            assert!(now_j <= last_j * 1.000_01, "{now_j} J after {last_j} J");
            assert!(felt.stiffness_n_m <= 0.5001 * TOUCH_N_M);
            last_j = now_j;
        }
        let expected = (TOUCH_N_M - tissue_n_m).clamp(0.2 * TOUCH_N_M, 0.5 * TOUCH_N_M);
        assert!((law.lips_n_m - expected).abs() < 1.0, "{law:?}");
    }
}

#[test]
fn released_lips_are_straight() {
    let mut law = TrocarLaw::new(&SEAL, TOUCH_N_M);
    push(&mut law, stroke(0.0, 0.02, 0.05));
    law.release();
    assert_eq!(push(&mut law, core::iter::once(0.1)), [0.0]);
}

#[test]
fn wall_turns_a_tilted_trocar_back_by_the_computed_force() {
    let mut law = TrocarLaw::new(&WALL, TOUCH_N_M);
    // 30 degrees, 0.2 m outside: 0.3 N m/rad times sin 30 degrees over 0.2 m is 0.75 N.
    let tilted = at(0.1, 0.0, 0.2 * 0.866_025_4);
    let felt = law.felt(&LEVER, &tilted, 0.0);
    let expected = Vec3::new(-0.866_025_4, 0.0, 0.5) * 0.75;
    assert!(math::norm(&(felt.force_n - expected)) < 1.0e-4, "{felt:?}");
    assert!((felt.stiffness_n_m - 7.5).abs() < 1.0e-3);
}

/// A handle of 45 g in a hand, on a Touch: dry friction, damping, coarse encoder, a force that acts
/// a tick after its sample. Returns the swing in the last half second, m, and the work of the motor
/// on the handle, J.
fn closed_loop(trocar: &Trocar, hand_n_m: f64, start_m_s: f64) -> (f64, f64) {
    const STEPS: u32 = 20;
    const STEP_S: f64 = 1.0e-3 / STEPS as f64;
    let (mass_kg, damping, dry_n, encoder_m) = (0.045, 0.2 + hand_n_m * 0.007, 0.26, 0.055e-3);
    let mut law = TrocarLaw::new(trocar, TOUCH_N_M);
    let (mut x_m, mut v_m_s, mut work_j) = (0.0f64, start_m_s, 0.0);
    let (mut coming_n, mut least, mut most) = (0.0, f64::MAX, f64::MIN);
    for tick in 0..2000 {
        let sample_m = (x_m / encoder_m).round() * encoder_m;
        let acting_n = coming_n;
        // Inwards is positive here, and the law's force pushes outwards.
        coming_n = -f64::from(law.felt(&LEVER, &drawn_in(sample_m as f32), 0.0).force_n.z);
        for _ in 0..STEPS {
            let free_n = acting_n - hand_n_m * x_m - damping * v_m_s;
            let v = v_m_s + free_n * STEP_S / mass_kg;
            v_m_s = v.signum() * (v.abs() - dry_n * STEP_S / mass_kg).max(0.0);
            x_m += v_m_s * STEP_S;
            work_j += acting_n * v_m_s * STEP_S;
        }
        if tick >= 1500 {
            (least, most) = (least.min(x_m), most.max(x_m));
        }
    }
    (most - least, work_j)
}

#[test]
fn trocar_and_touch_in_a_closed_loop_come_to_rest() {
    let strong = Trocar {
        sliding_n: 3.0,
        breakaway_n: 3.0,
        ..SEAL
    };
    for trocar in [Trocar::DRY, Trocar::WET, SEAL, strong] {
        let trocar = Trocar {
            wall_nm_rad: 0.0,
            ..trocar
        };
        for hand_n_m in [0.0, 30.0, 400.0] {
            for start_m_s in [0.05, 0.3, 1.0] {
                let (swing_m, work_j) = closed_loop(&trocar, hand_n_m, start_m_s);
                let case = (trocar, hand_n_m, start_m_s);
                assert!(swing_m < 0.01e-3, "{case:?} swings by {swing_m} m");
                // Lips that throw a fast handle back add energy, because their force acts late: at
                // most 1.2 times the handle's kinetic energy. At the speed of a hand at work, the
                // lips only dissipate.
                let kinetic_j = 0.5 * 0.045 * start_m_s * start_m_s;
                let most_j = if start_m_s > 0.1 {
                    1.2 * kinetic_j
                } else {
                    0.0
                };
                assert!(work_j < most_j, "{case:?} gives {work_j} J");
            }
        }
    }
}

proptest! {
    /// On any path, the hand gets back at most the energy that it put in.
    #[test]
    fn seal_is_passive(
        steps_m in prop::collection::vec(-0.001f32..0.001, 1..400),
        sliding_n in 0.0f32..4.0, jump_n in 0.0f32..4.0, device_n_m in 40.0f32..4000.0,
    ) {
        let trocar = Trocar { sliding_n, breakaway_n: sliding_n + jump_n, ..Trocar::NONE };
        let mut law = TrocarLaw::new(&trocar, device_n_m);
        let (mut inside_m, mut last_n, mut work_j) = (0.05f32, 0.0f64, 0.0f64);
        let mut passed_m = f64::from(inside_m);
        push(&mut law, core::iter::once(inside_m));
        for step_m in steps_m {
            inside_m = (inside_m + step_m).clamp(0.0, 0.15);
            let now_n = f64::from(push(&mut law, core::iter::once(inside_m))[0]);
            // The force grows in proportion to the travel while the lips bend, so its mean counts.
            work_j += 0.5 * (last_n + now_n) * (f64::from(inside_m) - passed_m);
            (last_n, passed_m) = (now_n, f64::from(inside_m));
            prop_assert!(now_n.abs() <= f64::from(trocar.breakaway_n) * 1.0001);
            prop_assert!(work_j >= -1.0e-5, "{work_j} J");
        }
    }

    /// The wall's force is the gradient of a potential, so no closed path gains energy.
    #[test]
    fn wall_force_is_the_gradient_of_a_potential(offset_m in vector(0.05), step in vector(1.0)) {
        let from = Vec3::new(0.0, 0.0, 0.2) + offset_m;
        let step = step * 1.0e-3;
        let felt = |m: &Vec3| {
            let mut law = TrocarLaw::new(&WALL, TOUCH_N_M);
            law.felt(&LEVER, &at(m.x, m.y, m.z), 0.0).force_n
        };
        let potential_j = |m: &Vec3| -0.3 * LEVER.axis(&at(m.x, m.y, m.z)).dot(&WALL.axis);
        let (before, after) = (from - step * 0.5, from + step * 0.5);
        let lost_j = potential_j(&before) - potential_j(&after);
        prop_assert!((felt(&from).dot(&step) - lost_j).abs() < 2.0e-6);
    }
}
