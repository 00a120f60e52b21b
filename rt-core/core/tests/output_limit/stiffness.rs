//! Stiffness gate: the share of a contact's force that a device may render.

use crate::{DEVICE, HALF_NEWTON, apply, enabled_limit, near, only_fault};
use rt_core::fault::Fault;
use rt_core::haptics::output_limit::{Demand, OutputLimit};
use rt_core::math::Vec3;
use rt_core::port::DeviceCapabilities;
use rt_core::words::Status;

#[test]
fn too_stiff_is_scaled_down() {
    let (force, faults) = apply(
        &mut enabled_limit(),
        &Demand {
            stiffness_n_m: 1000.0,
            ..HALF_NEWTON
        },
    );
    assert!(
        near(force, 0.25) && faults == only_fault(Fault::StiffnessCapped),
        "{force}"
    );
}

#[test]
fn stiffness_that_comes_under_load_takes_force_away_slowly() {
    let mut limit = enabled_limit();
    apply(&mut limit, &HALF_NEWTON);
    let stiff = Demand {
        stiffness_n_m: 1000.0,
        ..HALF_NEWTON
    };
    let mut forces = vec![0.5];
    forces.extend((0..300).map(|_| apply(&mut limit, &stiff).0));
    forces.extend((0..500).map(|_| apply(&mut limit, &HALF_NEWTON).0));
    let steps = forces.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    assert!(steps.fold(0.0, f32::max) < 0.00101);
    assert!(near(forces[300], 0.25) && near(forces[800], 0.5));
}

/// A second and a third part of the tool begin to touch a wall on the way in, and leave it on the
/// way out. The felt force never falls on the way in, and never rises on the way out.
#[test]
fn new_contact_takes_no_force_from_a_hand_that_goes_deeper() {
    let mut limit = enabled_limit();
    let mut at = |depth_m: f32| {
        let parts = [0.0, 0.004, 0.0043].map(|from_m: f32| (depth_m - from_m).max(0.0));
        let touching = parts.iter().filter(|m| **m > 0.0).count();
        let demand = Demand {
            force_n: Vec3::z() * (2000.0 * parts.iter().sum::<f32>()),
            stiffness_n_m: 2000.0 * touching as f32,
            ..HALF_NEWTON
        };
        apply(&mut limit, &demand).0
    };
    let path = |tick: i32| tick as f32 * 1.0e-6;
    let entering_n: Vec<f32> = (0..6400).map(path).map(&mut at).collect();
    let leaving_n: Vec<f32> = (0..6400).rev().map(path).map(&mut at).collect();
    let rises = |(a, b): (&f32, &f32)| b >= &(a - 1.0e-5);
    assert!(entering_n.iter().zip(&entering_n[1..]).all(rises));
    assert!(leaving_n[1..].iter().zip(&leaving_n).all(rises));
    // The felt stiffness is half a newton a millimetre while only the first part touches.
    assert!(
        (entering_n[900] - 500.0 * path(900)).abs() < 0.02,
        "{}",
        entering_n[900]
    );
}

#[test]
fn a_slow_device_bears_less_stiffness() {
    let bears = |damping_n_s_m, delay_s, rate_hz| {
        let device = DeviceCapabilities {
            damping_n_s_m,
            delay_s,
            rate_hz,
            ..DEVICE
        };
        OutputLimit::new(&device, 0.0).stiffness_max_n_m()
    };
    assert!(near(bears(1.0, 0.002, 1000.0), 280.0)); // 0.7 · 1 / (0.5 ms + 2 ms)
    assert!(near(bears(1.0, 0.002, 250.0), 175.0));
    assert!(
        near(bears(9.0, 0.0, 1000.0), 500.0),
        "what it states itself"
    );
    for bad in [f32::NAN, -1.0, f32::INFINITY] {
        assert!(near(bears(bad, 0.001, 1000.0), 0.0));
        assert!(near(bears(1.0, bad, 1000.0), 0.0));
    }
    assert!(near(bears(1.0, 0.001, f32::NAN), 0.0));
}

/// Spheres that stick and slip make the stiffness flicker from tick to tick. The rendered force
/// must not flicker.
#[test]
fn stiffness_that_flickers_is_not_felt() {
    let mut limit = enabled_limit();
    apply(&mut limit, &HALF_NEWTON);
    let forces: Vec<f32> = (0..2000)
        .map(|tick| {
            // The force itself varies a little.
            let by = [1.0, 1.001, 0.999, 1.0005][tick % 4];
            let demand = Demand {
                force_n: HALF_NEWTON.force_n * by,
                stiffness_n_m: [1000.0, 600.0][tick % 2],
                ..HALF_NEWTON
            };
            apply(&mut limit, &demand).0
        })
        .collect();
    let steps = forces.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let settled = forces[500..].windows(2);
    let settled = settled.map(|pair| (pair[1] - pair[0]).abs());
    assert!(steps.fold(0.0, f32::max) < 0.003);
    assert!(
        settled.fold(0.0, f32::max) < 0.0015,
        "{:?}",
        &forces[1990..]
    );
    assert!((forces[1999] - 0.25).abs() < 0.01, "{}", forces[1999]);
}

/// A cut resets the gate: the next contact begins with a scale for its own stiffness, not with the
/// scale of the contact before.
#[test]
fn contact_after_a_cut_begins_with_its_own_share() {
    let with = |stiffness_n_m: f32| Demand {
        stiffness_n_m,
        ..HALF_NEWTON
    };
    let lost = Demand {
        device: Status::Lost,
        ..HALF_NEWTON
    };
    for (before_n_m, after_n_m, share) in [(100.0, 5000.0, 0.1), (5000.0, 100.0, 1.0)] {
        let cuts: [&dyn Fn(&mut OutputLimit); 3] = [
            &|limit| {
                for _ in 0..3 {
                    apply(limit, &lost);
                }
            },
            &|limit| limit.enable(true),
            &|limit| limit.restart(),
        ];
        for (number, cut) in cuts.iter().enumerate() {
            let mut limit = enabled_limit();
            for _ in 0..500 {
                apply(&mut limit, &with(before_n_m));
            }
            cut(&mut limit);
            let forces: Vec<f32> = (0..500)
                .map(|_| apply(&mut limit, &with(after_n_m)).0)
                .collect();
            let force_max_n = forces.iter().copied().fold(0.0, f32::max);
            assert!(
                force_max_n < 0.5 * share + 1.0e-4 && near(forces[499], 0.5 * share),
                "{before_n_m} to {after_n_m} N/m, cut {number}: {force_max_n} {}",
                forces[499]
            );
        }
    }
}

/// An infinite stiffness blocks the force while it lasts. Soon after, the gate has forgotten it.
#[test]
fn infinite_stiffness_is_forgotten() {
    let mut limit = enabled_limit();
    apply(&mut limit, &HALF_NEWTON);
    let endless = Demand {
        stiffness_n_m: f32::INFINITY,
        ..HALF_NEWTON
    };
    apply(&mut limit, &endless);
    let last = (0..2000).map(|_| apply(&mut limit, &HALF_NEWTON).0).last();
    assert!(near(last.unwrap(), 0.5), "{last:?}");
}
