//! The tick as the process sees it: ports in, ports out.

mod rig;

use rig::{Anatomy, Bench, SOFT, TOUCH, organ, pedal, room, tracker_at};
use rt_core::event::{Event, EventKind};
use rt_core::fault::Fault;
use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, Polled};
use rt_core::scene::{Material, RestSphere, Scene};
use rt_core::sim::{Command, Parameters, Sim, Stage, Status};
use rt_core::soft_body::Method;
use rt_core::state::{SphereBits, State};
use rt_core::tool::Instrument;

const NONE: Buttons = Buttons(0);
const AWAY: Vec3 = Vec3::new(0.0, 0.0, 0.15);
/// 8 mm in the liver's top.
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, 0.04);

const OPEN: Parameters = Parameters {
    method: Method::NeoHookean,
    force_ramp_s: 0.01,
    force_enabled: true,
};

fn store() -> Box<State> {
    Box::new(State::new())
}

/// Moves the tip in a straight line, a tick a step.
fn go(sim: &mut Sim<'_>, bench: &mut Bench, from: &Vec3, to: &Vec3, ticks: u32, buttons: Buttons) {
    for step in 1..=ticks {
        bench.next_at(
            &(from + (to - from) * (step as f32 / ticks as f32)),
            buttons,
        );
        sim.tick(bench);
    }
}

fn stay(sim: &mut Sim<'_>, bench: &mut Bench, tip: &Vec3, ticks: u32, buttons: Buttons) {
    go(sim, bench, tip, tip, ticks, buttons);
}

fn kinds(events: &[Event]) -> Vec<EventKind> {
    events.iter().map(|event| event.kind).collect()
}

/// Largest distance of a sphere from its rest position, m.
fn moved_m(bench: &Bench, anatomy: &Anatomy) -> f32 {
    let pairs = bench.centers_m.iter().zip(&anatomy.spheres);
    pairs
        .map(|(c, s)| norm(&(c - s.center_m)))
        .fold(0.0, f32::max)
}

/// Spheres alone, without links.
fn loose(spheres: &[RestSphere], material: Material) -> Anatomy {
    let organ = |i: usize| organ([i as u32, 1], [0, 0], material);
    Anatomy {
        organs: (0..spheres.len()).map(organ).collect(),
        spheres: spheres.to_vec(),
        ..Anatomy::default()
    }
}

fn sphere(x: f32, z: f32) -> RestSphere {
    RestSphere {
        center_m: Vec3::new(x, 0.0, z),
        radius_m: 0.01,
        mass_kg: 0.004,
        held: false,
    }
}

#[test]
fn stages_come_in_order_and_force_leaves_once() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    stay(&mut sim, &mut bench, &AWAY, 3, NONE);
    assert_eq!(bench.stages, Stage::ALL);
    assert_eq!(bench.sent.len(), 1);
    assert!(bench.bits.iter().all(|bits| *bits == SphereBits::AWAKE));
    assert_eq!(bench.centers_m.len(), 581);
}

#[test]
fn a_loose_sphere_falls_as_it_should_and_a_held_one_does_not() {
    let mut still = sphere(0.1, 0.0);
    still.held = true;
    let material = Material {
        damping_per_s: 0.0,
        ..SOFT
    };
    let anatomy = loose(&[sphere(0.0, 0.0), still], material);
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
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
    // Falls to the speed at which damping takes what gravity gives: v = g / c.
    let anatomy = loose(
        &[sphere(0.0, 0.0)],
        Material {
            damping_per_s: 20.0,
            ..SOFT
        },
    );
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
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
fn without_contact_there_is_no_force() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    let beside = Vec3::new(0.05, 0.03, 0.09);
    go(&mut sim, &mut bench, &AWAY, &beside, 1500, NONE);
    assert_eq!(bench.contact_count, 0);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    assert!(bench.events.is_empty(), "{:?}", bench.events);
}

#[test]
fn pressing_dents_the_organ_pushes_the_hand_back_and_ends() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    stay(&mut sim, &mut bench, &AWAY, 2000, NONE);
    let before = bench.centers_m.clone();
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    stay(&mut sim, &mut bench, &PRESSED, 200, NONE);
    assert!(bench.contact_count > 0);
    assert!((0.2..3.3).contains(&bench.force_n.z), "{}", bench.force_n);
    let dented = bench
        .centers_m
        .iter()
        .zip(&before)
        .map(|(a, b)| b.z - a.z)
        .fold(0.0, f32::max);
    assert!(dented > 0.001, "{dented}");
    assert!(
        bench
            .bits
            .iter()
            .any(|bits| bits.contains(SphereBits::CONTACT))
    );
    let organ = Some(0);
    assert!(matches!(
        bench.events[..],
        [Event {
            kind: EventKind::Contact,
            ..
        }]
    ));
    go(&mut sim, &mut bench, &PRESSED, &AWAY, 500, NONE);
    stay(&mut sim, &mut bench, &AWAY, 3000, NONE);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    assert_eq!(
        kinds(&bench.events),
        [EventKind::Contact, EventKind::Release]
    );
    assert!(bench.events.iter().all(|event| event.organ == organ));
    let back = bench
        .centers_m
        .iter()
        .zip(&before)
        .map(|(a, b)| norm(&(a - b)));
    assert!(back.fold(0.0, f32::max) < 2.0e-4);
}

#[test]
fn tissue_and_hand_are_pushed_apart() {
    // A loose sphere without gravity under the tip: it goes down, the hand is pushed up.
    let mut room = room();
    room.gravity_m_s2 = Vec3::zeros();
    let anatomy = loose(&[sphere(0.0, 0.0)], SOFT);
    let scene = Scene::new(&anatomy.organs, &anatomy.spheres, &[], room).unwrap();
    let mut state = store();
    let mut sim = Sim::new(scene, &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    let mut touched = 0;
    for step in 0..400 {
        let before = bench.centers_m.first().map_or(0.0, |center| center.z);
        bench.next_at(&Vec3::new(0.0, 0.0, 0.05 - 0.0002 * step as f32), NONE);
        sim.tick(&mut bench);
        if bench.contact_count > 0 {
            touched += 1;
            assert!(bench.force_n.z > 0.0 && bench.centers_m[0].z < before);
        }
    }
    assert!(touched > 0);
}

#[test]
fn a_grasp_holds_pulls_and_lets_go() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    stay(&mut sim, &mut bench, &PRESSED, 300, Buttons::GRASP);
    assert!(bench.grasped_count > 0);
    let held = bench
        .bits
        .iter()
        .position(|bits| bits.contains(SphereBits::GRASPED))
        .unwrap();
    let before = bench.centers_m[held];
    let lifted = PRESSED + Vec3::new(0.0, 0.0, 0.02);
    go(&mut sim, &mut bench, &PRESSED, &lifted, 300, Buttons::GRASP);
    stay(&mut sim, &mut bench, &lifted, 300, Buttons::GRASP);
    assert!(
        (bench.centers_m[held].z - before.z - 0.02).abs() < 0.007,
        "it follows, as far as the grip's spring lets it"
    );
    assert!(
        bench.force_n.z < -0.1,
        "the organ pulls back: {}",
        bench.force_n
    );
    stay(&mut sim, &mut bench, &lifted, 1, NONE);
    assert_eq!(bench.grasped_count, 0);
    stay(&mut sim, &mut bench, &AWAY, 4000, NONE);
    assert!(
        bench
            .bits
            .iter()
            .all(|bits| !bits.contains(SphereBits::GRASPED))
    );
    assert!(bench.centers_m[held].z < before.z + 0.005, "it falls back");
    let kinds = kinds(&bench.events);
    assert!(
        kinds.contains(&EventKind::Grasp) && kinds.contains(&EventKind::LetGo),
        "{kinds:?}"
    );
    let count = |kind| {
        bench
            .events
            .iter()
            .filter(|event| event.kind == kind)
            .count()
    };
    assert_eq!((count(EventKind::Grasp), count(EventKind::LetGo)), (1, 1));
}

#[test]
fn only_a_grasper_grasps_and_the_handle_changes_instruments() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    stay(&mut sim, &mut bench, &AWAY, 1, NONE);
    stay(&mut sim, &mut bench, &AWAY, 5, Buttons::CHANGE); // one press, one change
    assert_eq!(bench.instrument, Instrument::Hook);
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    stay(&mut sim, &mut bench, &PRESSED, 300, Buttons::GRASP);
    assert_eq!(bench.grasped_count, 0);
    bench.next().command = Some(Command::Instrument(Instrument::ClipApplier));
    sim.tick(&mut bench);
    assert_eq!(bench.instrument, Instrument::ClipApplier);
}

#[test]
fn pause_freezes_and_reset_restores() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    bench.next_at(&PRESSED, NONE).command = Some(Command::Pause(true));
    sim.tick(&mut bench);
    let frozen = bench.centers_m.clone();
    stay(&mut sim, &mut bench, &PRESSED, 50, Buttons::GRASP);
    assert_eq!(bench.centers_m, frozen);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    assert!(
        bench
            .bits
            .iter()
            .all(|bits| !bits.contains(SphereBits::AWAKE))
    );
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    assert!(moved_m(&bench, &anatomy) < 1.0e-9);
    bench.next_at(&AWAY, NONE).command = Some(Command::Pause(false));
    sim.tick(&mut bench);
    assert!(
        bench
            .bits
            .iter()
            .all(|bits| bits.contains(SphereBits::AWAKE))
    );
    assert!(moved_m(&bench, &anatomy) > 0.0, "gravity is back");
}

#[test]
fn a_silent_device_loses_its_force_and_a_returning_one_gets_it_back() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    assert_eq!(bench.status[0], Status::Absent);
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    stay(&mut sim, &mut bench, &PRESSED, 300, NONE);
    let full = norm(&bench.force_n);
    assert!(full > 0.2);
    for _ in 0..5 {
        bench.next();
        sim.tick(&mut bench);
    }
    assert_eq!(bench.status[0], Status::Live, "5 ms are not too long");
    for _ in 0..25 {
        bench.next();
        sim.tick(&mut bench);
    }
    assert_eq!(bench.status[0], Status::Stale);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    assert_eq!(bench.counters.of(Fault::StaleDevice), 25);
    stay(&mut sim, &mut bench, &PRESSED, 100, NONE);
    assert!(norm(&bench.force_n) > 0.8 * full);
    bench.next().device = Polled::Lost;
    sim.tick(&mut bench);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    bench.next(); // silence does not mean that it is back
    sim.tick(&mut bench);
    assert_eq!(bench.status[0], Status::Lost);
    assert_eq!(bench.counters.of(Fault::LostDevice), 2);
    let faults: Vec<f32> = bench
        .events
        .iter()
        .filter(|e| e.kind == EventKind::Fault)
        .map(|e| e.value)
        .collect();
    assert_eq!(
        faults,
        [Fault::StaleDevice, Fault::LostDevice].map(|f| f32::from(f.code()))
    );
}

#[test]
fn a_leap_of_the_handle_trips_until_a_person_enables() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    stay(&mut sim, &mut bench, &AWAY, 50, NONE);
    stay(&mut sim, &mut bench, &PRESSED, 50, NONE); // 11 cm in a tick
    assert_eq!(bench.counters.of(Fault::SpeedTrip), 1);
    assert!(bench.contact_count > 0 && norm(&bench.force_n) < f32::EPSILON);
    bench.next_at(&PRESSED, NONE).command = Some(Command::EnableForce(true));
    sim.tick(&mut bench);
    stay(&mut sim, &mut bench, &PRESSED, 50, NONE);
    assert!(norm(&bench.force_n) > 0.05);
}

#[test]
fn samples_that_are_no_poses_are_not_taken() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    let good = bench.tip_m;
    for tip in [
        Vec3::repeat(f32::NAN),
        Vec3::repeat(f32::INFINITY),
        Vec3::repeat(1.0e6),
    ] {
        let samples = bench.next_at(&PRESSED, NONE);
        if let Polled::Fresh(sample) = &mut samples.device {
            sample.device_from_handle.translation.vector = tip;
        }
        sim.tick(&mut bench);
        assert_eq!(bench.tip_m, good);
    }
    assert_eq!(bench.counters.of(Fault::BadSample), 3);
    let samples = bench.next();
    samples.tracker = Polled::Fresh(tracker_at(Vec3::repeat(f32::NAN), samples.now_ns));
    sim.tick(&mut bench);
    assert_eq!(bench.counters.of(Fault::BadSample), 4);
}

#[test]
fn pedal_and_camera() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    let mut tick = |bench: &mut Bench, x: f32, cut: bool, lock: bool| {
        let samples = bench.next();
        samples.tracker = Polled::Fresh(tracker_at(Vec3::new(x, 0.0, 0.0), samples.now_ns));
        samples.pedal = Polled::Fresh(pedal(cut, lock, samples.now_ns));
        sim.tick(bench);
        (bench.camera.translation.vector.x * 10.0).round() as i32
    };
    assert_eq!(tick(&mut bench, 0.1, false, false), 1);
    assert_eq!(tick(&mut bench, 0.2, true, true), 1, "locked");
    assert_eq!(tick(&mut bench, 0.3, true, false), 3);
    let electro =
        |bench: &Bench| -> Vec<f32> { bench.events.iter().map(|event| event.value).collect() };
    assert_eq!(electro(&bench), [1.0]);
    bench.next().pedal = Polled::Lost;
    sim.tick(&mut bench);
    assert_eq!(
        electro(&bench),
        [1.0, 0.0],
        "a lost pedal is a released one"
    );
    assert_eq!(bench.status[2], Status::Lost);
}

#[test]
fn organs_lie_on_each_other() {
    // A row of held spheres, and a loose one that falls on them from 5 mm above.
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
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    for _ in 0..2000 {
        bench.next();
        sim.tick(&mut bench);
    }
    let z = bench.centers_m[49].z;
    assert!((0.014..0.0205).contains(&z), "{z}");
}

#[test]
fn more_contacts_than_kept_are_counted() {
    // 300 spheres in one place under the tip.
    let spheres: Vec<RestSphere> = (0..300).map(|i| sphere(0.0, -0.00002 * i as f32)).collect();
    let organ = organ([0, 300], [0, 0], SOFT);
    let anatomy = Anatomy {
        organs: vec![organ],
        spheres,
        ..Anatomy::default()
    };
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    stay(&mut sim, &mut bench, &Vec3::zeros(), 1, NONE);
    assert_eq!(bench.contact_count, 128);
    assert!(bench.counters.of(Fault::ContactOverflow) > 0);
    // The deepest, which are the uppermost, have been kept.
    let touched = |i: usize| bench.bits[i].contains(SphereBits::CONTACT);
    assert!((0..100).all(touched) && !(200..300).any(touched));
}

#[test]
fn the_lever_turns_a_sideways_push_around() {
    // The tip pushes a sphere in +x: the sphere pushes back in −x, and the hand, on the other
    // side of the trocar, feels +x.
    let mut wall = sphere(0.0, 0.0);
    wall.held = true;
    let anatomy = loose(&[wall], SOFT);
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    let (from, to) = (
        Vec3::new(-0.03, 0.0, -0.005),
        Vec3::new(-0.005, 0.0, -0.005),
    );
    go(&mut sim, &mut bench, &from, &to, 200, NONE);
    stay(&mut sim, &mut bench, &to, 50, NONE);
    assert!(
        bench.contact_count == 1 && bench.force_n.x > 0.05,
        "{}",
        bench.force_n
    );
}

#[test]
fn a_resting_organ_sleeps() {
    let mut anatomy = Anatomy::liver();
    for sphere in &mut anatomy.spheres {
        sphere.center_m += Vec3::new(0.6, 0.6, -0.6);
    }
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    for _ in 0..6000 {
        bench.next();
        sim.tick(&mut bench);
    }
    let awake = |bits: &SphereBits| bits.contains(SphereBits::AWAKE);
    assert!(!bench.bits.iter().any(awake), "it sleeps");
    assert!(sim.speed_max_m_s() < f32::EPSILON, "and is still");
}

#[test]
fn waking_is_neither_missed_nor_felt() {
    let anatomy = Anatomy::liver();
    let force_steps_n = |asleep: bool| {
        let mut state = store();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
        let mut bench = Bench::new();
        // Pressed once, so that something is left to be frozen.
        go(&mut sim, &mut bench, &AWAY, &PRESSED, 400, NONE);
        go(&mut sim, &mut bench, &PRESSED, &AWAY, 400, NONE);
        stay(
            &mut sim,
            &mut bench,
            &AWAY,
            if asleep { 4000 } else { 20 },
            NONE,
        );
        let awake = |bits: &SphereBits| bits.contains(SphereBits::AWAKE);
        assert_eq!(bench.bits.iter().any(awake), !asleep);
        let near = Vec3::new(0.0, 0.0, 0.056);
        go(&mut sim, &mut bench, &AWAY, &near, 200, NONE);
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
    let most_n = steps_n.iter().copied().fold(0.0, f32::max);
    assert!(most_n < 0.005, "{most_n} N in a tick");
    // It is woken by the tool's coming near, before there is a force.
    let first = |steps: &[f32]| steps.iter().position(|step| *step > 0.0);
    let (slept, was_awake) = (first(&steps_n), first(&force_steps_n(false)));
    let apart = slept.zip(was_awake).map(|(a, b)| a.abs_diff(b));
    assert!(
        apart.is_some_and(|ticks| ticks < 60),
        "{slept:?} {was_awake:?}"
    );
}

#[test]
fn a_standstill_starts_the_force_from_nothing() {
    let anatomy = Anatomy::liver();
    let mut state = store();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, OPEN);
    let mut bench = Bench::new();
    go(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    stay(&mut sim, &mut bench, &PRESSED, 200, NONE);
    let full = norm(&bench.force_n);
    let standstill = |bench: &mut Bench, ms: u64| {
        bench.samples.now_ns += ms * 1_000_000;
        bench.next_at(&PRESSED, NONE);
    };
    standstill(&mut bench, 18);
    sim.tick(&mut bench);
    assert!(norm(&bench.force_n) > 0.9 * full, "a hiccup is not felt");
    standstill(&mut bench, 200);
    sim.tick(&mut bench);
    assert!(norm(&bench.force_n) < 0.2 * full, "{}", bench.force_n);
    assert_eq!(bench.counters.of(Fault::StaleDevice), 1);
}
