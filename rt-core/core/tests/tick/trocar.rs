//! The trocar in the whole tick: at the device, beside tissue, and away from tissue.

use super::rig::room;
use super::*;
use rt_core::scene::{Room, Scene, Trocar};

/// A place 30 mm farther in than [`AWAY`], still in free air.
const NEARER: Vec3 = Vec3::new(0.0, 0.0, 0.12);

fn room_with(trocar: Trocar) -> Room {
    let axis = Vec3::new(0.0, 0.0, -1.0);
    Room {
        trocar: Trocar { axis, ..trocar },
        ..room()
    }
}

/// Force at the device along z after each tick of a stroke from [`AWAY`] to [`NEARER`] and back.
fn strokes(trocar: Trocar) -> (Vec<f32>, Bench) {
    let mut state = new_state();
    let scene = Scene::new(&[], &[], &[], room_with(trocar)).expect("a good scene");
    let mut sim = Sim::new(scene, &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let mut forces = Vec::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 50, NONE);
    for (from, to) in [(AWAY, NEARER), (NEARER, AWAY)] {
        for step in 1..=600u32 {
            let tip = from + (to - from) * (step as f32 / 600.0);
            hold_tip(&mut sim, &mut bench, &tip, 1, NONE);
            forces.push(bench.sent[0].force_n.z);
            assert!(
                norm(&bench.force_n) < 1.0e-6,
                "the tissue's force has no friction in it"
            );
        }
    }
    bench.next_at(&AWAY, NONE).command = Some(Command::Pause(true));
    sim.tick(&mut bench);
    hold_tip(&mut sim, &mut bench, &AWAY, 50, NONE);
    (forces, bench)
}

#[test]
fn the_device_feels_a_trocar_that_the_tissue_s_force_leaves_out() {
    let (forces, bench) = strokes(Trocar::DRY);
    let most = forces.iter().copied().fold(0.0, f32::max);
    let least = forces.iter().copied().fold(0.0, f32::min);
    assert!((most - 1.58).abs() < 0.05, "starts with {most} N");
    assert!((least + 1.58).abs() < 0.05, "reverses with {least} N");
    let sliding = forces[599];
    assert!((sliding - 0.87).abs() < 0.05, "slides with {sliding} N");
    assert!(
        norm(&bench.sent[0].force_n) < 1.0e-6,
        "a pause releases the lips"
    );
}

#[test]
fn a_port_without_friction_sends_nothing() {
    let (forces, _) = strokes(Trocar::NONE);
    assert!(forces.iter().all(|n| n.abs() < f32::MIN_POSITIVE));
}

#[test]
fn a_press_feels_tissue_and_seal_together() {
    let anatomy = Anatomy::liver();
    let press = |trocar: Trocar| {
        let mut state = new_state();
        let mut made = anatomy.clone();
        made.trocar = trocar;
        let mut sim = Sim::new(made.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 2000, NONE);
        hold_tip(&mut sim, &mut bench, &PRESSED, 20, NONE);
        (bench.sent[0].force_n, bench.force_n)
    };
    let (free_n, tissue_n) = press(Trocar::NONE);
    let tissue_n = norm(&tissue_n);
    assert!((norm(&free_n) - tissue_n).abs() < 1.0e-6 && tissue_n > 0.1);
    let wet = Trocar {
        wall_nm_rad: 0.0,
        ..Trocar::WET
    };
    let (sent_n, still_n) = press(wet);
    // These bare spheres press with 640 N/m. A Touch renders 840 N/m stably, and the lips keep a
    // fifth of it; so tissue is scaled a little.
    assert!(
        (0.9 * tissue_n..1.01 * tissue_n).contains(&norm(&still_n)),
        "{still_n} {tissue_n}"
    );
    // Beside stiff tissue the lips are softer: they have 0.53 of the 0.61 N of a sliding shaft.
    let seal_n = norm(&(sent_n - still_n));
    assert!(
        (0.8 * wet.sliding_n..=wet.breakaway_n).contains(&seal_n),
        "{seal_n} N"
    );
}
