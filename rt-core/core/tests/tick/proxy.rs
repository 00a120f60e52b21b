//! Proxy pose: equal to the device pose while the device can push as hard as the tissue.

use super::grip::move_and_record;
use super::*;
use rt_core::port::DeviceCapabilities;

/// A device with the peak force `force_max_n`.
fn with_force_max(force_max_n: f32) -> DeviceCapabilities {
    DeviceCapabilities {
        force_max_n,
        ..TOUCH
    }
}

/// An immovable ball of 5 cm, its top at 5 cm.
fn ball() -> Anatomy {
    let material = Material {
        young_pa: 50_000.0,
        ..SOFT
    };
    Anatomy {
        organs: vec![organ([0, 1], [0, 0], material)],
        spheres: vec![RestSphere {
            center_m: Vec3::zeros(),
            radius_m: 0.05,
            mass_kg: 0.5,
            held: true,
        }],
        ..Anatomy::default()
    }
}

/// Place above the ball.
const ABOVE: Vec3 = Vec3::new(0.0, 0.0, 0.07);
/// Place of the tip at which the open jaws are just in the ball.
const LIGHT: Vec3 = Vec3::new(0.0, 0.0, 0.0472);
/// Place of the tip at which the open jaws are 8 mm deep in the ball.
const DEEP: Vec3 = Vec3::new(0.0, 0.0, 0.0405);

/// Displacement of the proxy's tip from the device's, tick by tick, while the hand moves from one
/// place to another.
fn proxy_displacements(
    sim: &mut Sim<'_>,
    bench: &mut Bench,
    ends: (&Vec3, &Vec3),
    ticks: usize,
) -> Vec<Vec3> {
    let (from, to) = ends;
    let tick = |t: usize| {
        let tip_m = from + (to - from) * (t as f32 / ticks as f32);
        move_and_record(sim, bench, (&tip_m, &tip_m), 1, NONE);
        bench.tip_m - tip_m
    };
    (1..=ticks).map(tick).collect()
}

#[test]
fn proxy_lags_while_the_device_is_too_weak_and_returns() {
    let anatomy = ball();
    let mut state = new_state();
    let mut sim = Sim::new(
        anatomy.scene(),
        &mut state,
        with_force_max(0.55),
        FORCE_ENABLED,
    );
    let mut bench = Bench::new();
    let rounding_m = 1.0e-6;
    let light = proxy_displacements(&mut sim, &mut bench, (&ABOVE, &LIGHT), 1000);
    assert!(bench.force_n.z > 0.05 && light.iter().all(|m| norm(m) < rounding_m));
    let pressing = proxy_displacements(&mut sim, &mut bench, (&LIGHT, &DEEP), 1000);
    let (held_back_m, force_n) = (pressing[999].z, bench.force_n.z);
    assert!((force_n - 0.55).abs() < 0.01, "{force_n} N");
    assert!(held_back_m > 0.001, "{held_back_m} m");
    let leaving = proxy_displacements(&mut sim, &mut bench, (&DEEP, &ABOVE), 1000);
    assert!(norm(&leaving[999]) < rounding_m);
    let all: Vec<Vec3> = light.into_iter().chain(pressing).chain(leaving).collect();
    let steps = all.windows(2).map(|pair| norm(&(pair[1] - pair[0])));
    let step_m = steps.fold(0.0, f32::max);
    assert!(step_m < 0.0001, "{step_m} m in a tick"); // the hand goes 28 µm
}

#[test]
fn proxy_of_a_device_without_force_follows_the_hand() {
    let anatomy = ball();
    let mut state = new_state();
    let mut sim = Sim::new(
        anatomy.scene(),
        &mut state,
        with_force_max(0.0),
        FORCE_ENABLED,
    );
    let mut bench = Bench::new();
    let pressing = proxy_displacements(&mut sim, &mut bench, (&ABOVE, &DEEP), 1000);
    assert!(pressing.iter().all(|m| norm(m) < 1.0e-6));
}
