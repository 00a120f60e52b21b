//! Contact and grasp, and their forces.

use crate::rig::{Anatomy, Bench, SOFT, TOUCH, organ, room};
use crate::{
    AWAY, FORCE_ENABLED, NONE, PRESSED, hold_tip, kinds, loose_spheres, move_tip, new_state, sphere,
};
use rt_core::fault::Fault;
use rt_core::math::{Vec3, norm};
use rt_core::port::Buttons;
use rt_core::scene::{RestSphere, Scene};
use rt_core::sim::{Command, Sim, Task};
use rt_core::tool::Instrument;
use rt_core::words::{EventKind, SphereBits};

#[test]
fn without_contact_there_is_no_force() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let adjacent = Vec3::new(0.05, 0.03, 0.09);
    move_tip(&mut sim, &mut bench, &AWAY, &adjacent, 1500, NONE);
    assert_eq!(bench.contact_count, 0);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    assert!(bench.events.is_empty(), "{:?}", bench.events);
}

#[test]
fn pressing_dents_the_organ_pushes_the_hand_back_and_ends() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 2000, NONE);
    let before = bench.centers_m.clone();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 200, NONE);
    assert!(bench.contact_count > 0);
    assert!((0.1..3.3).contains(&bench.force_n.z), "{}", bench.force_n);
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
    let [contact, presses @ ..] = &bench.events[..] else {
        panic!("no contact");
    };
    assert_eq!(contact.kind, EventKind::Contact);
    assert!(presses.iter().all(|it| it.kind == EventKind::Press));
    assert!(presses.is_sorted_by(|a, b| a.value < b.value));
    // The tip goes in fast, so its force on the way in is larger than its force at rest.
    let (pressed_n, rests_n) = (presses.last().map_or(0.0, |it| it.value), bench.force_n.z);
    assert!(
        (rests_n..4.0 * rests_n).contains(&pressed_n),
        "{pressed_n} {rests_n}"
    );
    let presses = presses.len();
    move_tip(&mut sim, &mut bench, &PRESSED, &AWAY, 500, NONE);
    hold_tip(&mut sim, &mut bench, &AWAY, 3000, NONE);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    let mut expected = vec![EventKind::Press; presses];
    expected.insert(0, EventKind::Contact);
    expected.push(EventKind::Release);
    assert_eq!(kinds(&bench.events), expected);
    assert!(bench.events.iter().all(|event| event.organ == organ));
    let back = bench
        .centers_m
        .iter()
        .zip(&before)
        .map(|(a, b)| norm(&(a - b)));
    assert!(back.fold(0.0, f32::max) < 2.0e-4);
}

/// At its first sample, and at the first after a loss of the device, the instrument may be
/// anywhere.
#[test]
fn an_instrument_that_begins_inside_an_organ_is_reported_once() {
    let anatomy = Anatomy::liver();
    let count = |bench: &Bench| {
        let events = bench.events.iter();
        events.filter(|it| it.kind == EventKind::Buried).count()
    };
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &PRESSED, 500, NONE);
    assert_eq!(count(&bench), 1);
    let event = bench.events.iter().find(|it| it.kind == EventKind::Buried);
    let event = event.expect("an event");
    assert_eq!(event.organ, Some(0));
    assert!((0.002..0.02).contains(&event.value), "{}", event.value);
    bench.events.clear();
    move_tip(&mut sim, &mut bench, &PRESSED, &AWAY, 500, NONE);
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 100, NONE);
    assert_eq!(count(&bench), 0, "it came through the surface");
}

/// A pause, a change of instrument, a reset and the start of a task, each while the hand presses.
#[test]
fn force_that_a_command_ends_fades() {
    let anatomy = Anatomy::liver();
    for command in [
        Command::Pause(true),
        Command::Instrument(Instrument::Scissors),
        Command::Reset,
        Command::Start(Task::Identify),
    ] {
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
        hold_tip(&mut sim, &mut bench, &PRESSED, 100, NONE);
        let pressed_n = norm(&bench.force_n);
        assert!(pressed_n > 0.1, "{pressed_n}");
        let mut last_n = bench.force_n;
        for tick in 0..30 {
            bench.next_at(&PRESSED, NONE).command = (tick == 0).then_some(command);
            sim.tick(&mut bench);
            // The force falls by a twentieth a tick; by two twentieths in a pause, which also runs
            // the ramp down.
            let step_n = norm(&(bench.force_n - last_n));
            assert!(
                step_n < 0.11 * pressed_n,
                "{command:?} tick {tick}: {step_n} of {pressed_n} N"
            );
            last_n = bench.force_n;
        }
        if command == Command::Pause(true) {
            assert!(norm(&last_n) < f32::EPSILON);
        }
    }
}

#[test]
fn tissue_and_hand_are_pushed_apart() {
    // A free sphere without gravity under the tip: it moves down, the hand is pushed up.
    let mut room = room();
    room.gravity_m_s2 = Vec3::zeros();
    let anatomy = loose_spheres(&[sphere(0.0, 0.0)], SOFT);
    let scene = Scene::new(&anatomy.organs, &anatomy.spheres, &[], room).unwrap();
    let mut state = new_state();
    let mut sim = Sim::new(scene, &mut state, TOUCH, FORCE_ENABLED);
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
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 300, Buttons::GRASP);
    assert!(bench.grasped_count > 0);
    let held = bench
        .bits
        .iter()
        .position(|bits| bits.contains(SphereBits::GRASPED))
        .unwrap();
    let before = bench.centers_m[held];
    let lifted = PRESSED + Vec3::new(0.0, 0.0, 0.01);
    move_tip(&mut sim, &mut bench, &PRESSED, &lifted, 300, Buttons::GRASP);
    hold_tip(&mut sim, &mut bench, &lifted, 300, Buttons::GRASP);
    assert!(
        (bench.centers_m[held].z - before.z - 0.01).abs() < 0.004,
        "the sphere follows, as far as the grip's spring lets it"
    );
    assert!(
        bench.force_n.z < -0.1,
        "the organ pulls back: {}",
        bench.force_n
    );
    hold_tip(&mut sim, &mut bench, &lifted, 150, NONE); // as the jaws open
    assert_eq!(bench.grasped_count, 0);
    hold_tip(&mut sim, &mut bench, &AWAY, 4000, NONE);
    assert!(
        bench
            .bits
            .iter()
            .all(|bits| !bits.contains(SphereBits::GRASPED))
    );
    assert!(
        bench.centers_m[held].z < before.z + 0.005,
        "the sphere falls back"
    );
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
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 1, NONE);
    hold_tip(&mut sim, &mut bench, &AWAY, 5, Buttons::CHANGE); // one press, one change
    assert_eq!(bench.instrument, Instrument::Hook);
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 300, Buttons::GRASP);
    assert_eq!(bench.grasped_count, 0);
    bench.next().command = Some(Command::Instrument(Instrument::ClipApplier));
    sim.tick(&mut bench);
    assert_eq!(bench.instrument, Instrument::ClipApplier);
}

#[test]
fn more_contacts_than_kept_are_counted() {
    // 300 spheres at one place under the tip.
    let spheres: Vec<RestSphere> = (0..300)
        .map(|i| RestSphere {
            held: true,
            ..sphere(0.0, -0.00002 * i as f32)
        })
        .collect();
    let organ = organ([0, 300], [0, 0], SOFT);
    let anatomy = Anatomy {
        organs: vec![organ],
        spheres,
        ..Anatomy::default()
    };
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &Vec3::zeros(), 200, NONE);
    assert_eq!(bench.contact_count, 64);
    assert!(bench.counters.of(Fault::ContactOverflow) > 0);
    // The deepest, which are the uppermost, are kept.
    let touched = |i: usize| bench.bits[i].contains(SphereBits::CONTACT);
    assert!((0..20).all(touched) && !(100..300).any(touched));
}

#[test]
fn lever_reverses_a_lateral_force() {
    // The tip pushes a sphere towards +x. The sphere pushes back towards −x, and the hand, on the
    // other side of the port, feels +x.
    let mut wall = sphere(0.0, 0.0);
    wall.held = true;
    let anatomy = loose_spheres(&[wall], SOFT);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let (from, to) = (
        Vec3::new(-0.03, 0.0, -0.005),
        Vec3::new(-0.005, 0.0, -0.005),
    );
    move_tip(&mut sim, &mut bench, &from, &to, 200, NONE);
    hold_tip(&mut sim, &mut bench, &to, 50, NONE);
    assert!(
        bench.contact_count > 0 && bench.force_n.x > 0.05,
        "{}",
        bench.force_n
    );
}
