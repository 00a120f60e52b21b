//! Tests of the tick through its ports, as the process uses it.

mod cautery;
mod clip;
mod complication;
mod cut;
mod devices;
mod endoscope;
mod energy;
mod grip;
mod heat;
mod motion;
mod opening;
mod proxy;
#[path = "../rig/mod.rs"]
mod rig;
mod sew;
mod start;
mod stones;
mod tear;
mod touch;
mod trocar;
mod unrest;
mod vessel;

use rig::{Anatomy, Bench, SOFT, TOUCH, organ};
use rt_core::math::{Vec3, norm};
use rt_core::port::Buttons;
use rt_core::scene::{Material, Organ, RestSphere};
use rt_core::sim::{Command, Parameters, Sim, Stage};
use rt_core::state::State;
use rt_core::words::{Event, EventKind, SphereBits};

const NONE: Buttons = Buttons(0);
const AWAY: Vec3 = Vec3::new(0.0, 0.0, 0.15);
/// A place 8 mm below the liver's top.
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, 0.04);

const FORCE_ENABLED: Parameters = Parameters {
    force_ramp_s: 0.01,
    force_enabled: true,
};

fn new_state() -> Box<State> {
    Box::new(State::new())
}

/// Moves the tip along a straight line, in equal steps, one a tick.
fn move_tip(
    sim: &mut Sim<'_>,
    bench: &mut Bench,
    from: &Vec3,
    to: &Vec3,
    ticks: u32,
    buttons: Buttons,
) {
    for step in 1..=ticks {
        bench.next_at(
            &(from + (to - from) * (step as f32 / ticks as f32)),
            buttons,
        );
        sim.tick(bench);
    }
}

fn hold_tip(sim: &mut Sim<'_>, bench: &mut Bench, tip: &Vec3, ticks: u32, buttons: Buttons) {
    move_tip(sim, bench, tip, tip, ticks, buttons);
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

/// Spheres without links, each an organ of its own.
fn loose_spheres(spheres: &[RestSphere], material: Material) -> Anatomy {
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
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 3, NONE);
    assert_eq!(bench.stages, Stage::ALL);
    assert_eq!(bench.sent.len(), 1);
    assert!(bench.bits.iter().all(|bits| *bits == SphereBits::AWAKE));
    assert_eq!(bench.centers_m.len(), 581);
}

#[test]
fn pause_freezes_and_reset_restores() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    bench.next_at(&PRESSED, NONE).command = Some(Command::Pause(true));
    sim.tick(&mut bench);
    let frozen = bench.centers_m.clone();
    hold_tip(&mut sim, &mut bench, &PRESSED, 50, Buttons::GRASP);
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
