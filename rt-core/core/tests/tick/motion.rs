//! Motion of tissue without tools: it falls, rests, sleeps and wakes.

use crate::rig::{Anatomy, Bench, SOFT, TOUCH, organ};
use crate::{
    AWAY, FORCE_ENABLED, NONE, PRESSED, hold_tip, loose_spheres, move_tip, new_state, sphere,
};
use rt_core::math::{Vec3, norm};
use rt_core::scene::{Material, RestSphere};
use rt_core::sim::Sim;
use rt_core::words::SphereBits;

#[test]
fn a_loose_sphere_falls_as_it_should_and_a_held_one_does_not() {
    let mut still = sphere(0.1, 0.0);
    still.held = true;
    let material = Material {
        damping_per_s: 0.0,
        ..SOFT
    };
    let anatomy = loose_spheres(&[sphere(0.0, 0.0), still], material);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    for _ in 0..100 {
        bench.next();
        sim.tick(&mut bench);
    }
    // Symplectic Euler: −g dt² n (n + 1) / 2.
    let expected = -9.81e-6 * 100.0 * 101.0 / 2.0;
    assert!(
        (bench.centers_m[0].z - expected).abs() < 1.0e-5,
        "{}",
        bench.centers_m[0]
    );
    assert!(norm(&(bench.centers_m[1] - still.center_m)) < 1.0e-9);
}

#[test]
fn damping_is_a_share_of_speed_per_second() {
    // Falls at the terminal speed, at which damping balances gravity: v = g / c.
    let anatomy = loose_spheres(
        &[sphere(0.0, 0.0)],
        Material {
            damping_per_s: 20.0,
            ..SOFT
        },
    );
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let mut z = [0.0; 2];
    for _ in 0..1000 {
        bench.next();
        sim.tick(&mut bench);
        z = [z[1], bench.centers_m[0].z];
    }
    let speed = (z[0] - z[1]) / 0.001;
    assert!((speed - 9.81 / 20.0).abs() < 1.0e-3, "{speed}");
}

#[test]
fn organs_lie_on_each_other() {
    // A grid of held spheres, and a free one that falls on them from 5 mm above.
    let mut spheres: Vec<RestSphere> = (-3..=3)
        .flat_map(|x| (-3..=3).map(move |y| (x, y)))
        .map(|(x, y)| RestSphere {
            center_m: Vec3::new(x as f32, y as f32, 0.0) * 0.012,
            held: true,
            ..sphere(0.0, 0.0)
        })
        .collect();
    spheres.push(sphere(0.0, 0.025));
    let (floor, ball) = (49, 1);
    let organ = |start, count| organ([start, count], [0, 0], SOFT);
    let anatomy = Anatomy {
        organs: vec![organ(0, floor), organ(floor, ball)],
        spheres,
        ..Anatomy::default()
    };
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    for _ in 0..2000 {
        bench.next();
        sim.tick(&mut bench);
    }
    let z = bench.centers_m[49].z;
    assert!((0.014..0.0205).contains(&z), "{z}");
}

#[test]
fn a_resting_organ_sleeps() {
    let mut anatomy = Anatomy::liver();
    for sphere in &mut anatomy.spheres {
        sphere.center_m += Vec3::new(0.6, 0.6, -0.6);
    }
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    for _ in 0..6000 {
        bench.next();
        sim.tick(&mut bench);
    }
    let awake = |bits: &SphereBits| bits.contains(SphereBits::AWAKE);
    assert!(!bench.bits.iter().any(awake), "the organ sleeps");
    assert!(sim.speed_max_m_s() < f32::EPSILON, "the organ is still");
}

#[test]
fn waking_is_neither_missed_nor_felt() {
    let anatomy = Anatomy::liver();
    let force_steps_n = |asleep: bool| {
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        // The liver is pressed once, so that some displacement remains when it sleeps.
        move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 400, NONE);
        move_tip(&mut sim, &mut bench, &PRESSED, &AWAY, 400, NONE);
        hold_tip(
            &mut sim,
            &mut bench,
            &AWAY,
            if asleep { 4000 } else { 20 },
            NONE,
        );
        let awake = |bits: &SphereBits| bits.contains(SphereBits::AWAKE);
        assert_eq!(bench.bits.iter().any(awake), !asleep);
        let near = Vec3::new(0.0, 0.0, 0.056);
        move_tip(&mut sim, &mut bench, &AWAY, &near, 200, NONE);
        let mut steps_n = Vec::new();
        let mut last_n = bench.force_n;
        for tick in 0..3000 {
            let tip = near - Vec3::z() * (5.0e-6 * tick as f32);
            bench.next_at(&tip, NONE);
            sim.tick(&mut bench);
            steps_n.push(norm(&(bench.force_n - last_n)));
            last_n = bench.force_n;
        }
        assert!(
            bench.bits.iter().any(awake) && norm(&last_n) > 0.1,
            "{last_n}"
        );
        steps_n
    };
    let steps_n = force_steps_n(true);
    let step_max_n = steps_n.iter().copied().fold(0.0, f32::max);
    assert!(step_max_n < 0.005, "{step_max_n} N in a tick");
    // The approaching tool wakes the organ before there is a force.
    let first = |steps: &[f32]| steps.iter().position(|step| *step > 0.0);
    let (slept, was_awake) = (first(&steps_n), first(&force_steps_n(false)));
    let difference_ticks = slept.zip(was_awake).map(|(a, b)| a.abs_diff(b));
    assert!(
        difference_ticks.is_some_and(|ticks| ticks < 60),
        "{slept:?} {was_awake:?}"
    );
}
