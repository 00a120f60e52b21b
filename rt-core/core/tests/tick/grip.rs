//! Force of a grasp on the hand: it has no steps, is as stiff as the tissue, and is limited by
//! friction.

use super::*;
use rt_core::fault::Fault;
use rt_core::port::DeviceCapabilities;

/// A place just below the liver's top, so that tissue lies between the jaws.
const BITTEN: Vec3 = Vec3::new(0.0, 0.0, 0.0425);

/// A Touch that renders at most this stiffness, N/m.
fn with_stiffness_max(stiffness_n_m: f32) -> DeviceCapabilities {
    DeviceCapabilities {
        stiffness_max_n_m: stiffness_n_m,
        ..TOUCH
    }
}

/// Force along the shaft, tick by tick, while the tip moves from `from` to `to`.
pub(super) fn move_and_record(
    sim: &mut Sim<'_>,
    bench: &mut Bench,
    (from, to): (&Vec3, &Vec3),
    ticks: usize,
    buttons: Buttons,
) -> Vec<f32> {
    let at = |t: usize| from + (to - from) * (t as f32 / ticks as f32);
    let tick = |t| {
        bench.next_at(&at(t), buttons);
        sim.tick(bench);
        bench.force_n.z
    };
    (1..=ticks).map(tick).collect()
}

pub(super) fn largest_step(forces: &[f32]) -> f32 {
    let steps = forces.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    steps.fold(0.0, f32::max)
}

pub(super) fn count(bench: &Bench, kind: EventKind) -> usize {
    let same = |event: &&Event| event.kind == kind;
    bench.events.iter().filter(same).count()
}

fn above(by_m: f32) -> Vec3 {
    BITTEN + Vec3::new(0.0, 0.0, by_m)
}

/// Moves the open jaws to the liver slowly, and waits until the liver rests.
fn approach(sim: &mut Sim<'_>, bench: &mut Bench) {
    move_tip(sim, bench, &AWAY, &BITTEN, 500, NONE);
    hold_tip(sim, bench, &BITTEN, 500, NONE);
}

#[test]
fn a_grasp_begins_and_carries_on_without_a_knock() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    approach(&mut sim, &mut bench);
    let closing = move_and_record(
        &mut sim,
        &mut bench,
        (&BITTEN, &BITTEN),
        400,
        Buttons::GRASP,
    );
    assert!(bench.grasped_count > 0);
    // The jaws grasp after 98 ticks; before that, they move against the tissue.
    let step = largest_step(&closing[90..]);
    // While the jaws continue to close, they push the tissue at 50 mm/s. These spheres have no
    // skin, so their contact stiffens as the contact of tubes does.
    assert!(step < 0.012, "closing: {step} N in a tick");
    // 10 mm in 2 s.
    let lifting = move_and_record(
        &mut sim,
        &mut bench,
        (&BITTEN, &above(0.01)),
        2000,
        Buttons::GRASP,
    );
    assert!(lifting[1999] < -0.1, "the grip pulls: {} N", lifting[1999]);
    let step = largest_step(&lifting);
    assert!(step < 0.005, "lifting: {step} N in a tick");
    assert_eq!(count(&bench, EventKind::Slip), 0);
}

#[test]
fn pull_stiffness_is_that_of_the_tissue() {
    let pulled = |device| {
        let anatomy = Anatomy::liver();
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, device, FORCE_ENABLED);
        let mut bench = Bench::new();
        approach(&mut sim, &mut bench);
        hold_tip(&mut sim, &mut bench, &BITTEN, 400, Buttons::GRASP);
        let held = bench.force_n.z;
        let capped = bench.counters.of(Fault::StiffnessCapped);
        move_and_record(
            &mut sim,
            &mut bench,
            (&BITTEN, &above(0.004)),
            1000,
            Buttons::GRASP,
        );
        hold_tip(&mut sim, &mut bench, &above(0.004), 1000, Buttons::GRASP);
        let capped = bench.counters.of(Fault::StiffnessCapped) - capped;
        ((held - bench.force_n.z) / 0.004, capped)
    };
    let (free_n_m, capped) = pulled(TOUCH);
    assert!(capped == 0 && free_n_m > 20.0, "{free_n_m} N/m");
    // The simulation's estimate lies between the true stiffness and three times the true stiffness.
    let (_, capped) = pulled(with_stiffness_max(3.0 * free_n_m));
    assert_eq!(capped, 0, "taken for stiffer than {} N/m", 3.0 * free_n_m);
    let (_, capped) = pulled(with_stiffness_max(0.95 * free_n_m));
    assert!(capped > 0, "taken for softer than {free_n_m} N/m");
}

#[test]
fn too_strong_a_pull_slips_out_without_a_knock() {
    let mut anatomy = Anatomy::liver();
    anatomy.organs[0].material.friction = 0.03;
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    approach(&mut sim, &mut bench);
    hold_tip(&mut sim, &mut bench, &BITTEN, 400, Buttons::GRASP);
    let pulling = move_and_record(
        &mut sim,
        &mut bench,
        (&BITTEN, &above(0.06)),
        6000,
        Buttons::GRASP,
    );
    let force_max_n = pulling
        .iter()
        .fold(0.0f32, |force_max_n, f| force_max_n.max(-f));
    // Friction of 2 · 4 · 0.03 of 4 N of grip, plus the contact with the jaws.
    assert!(
        (force_max_n - 0.96).abs() < 0.03,
        "slips at {force_max_n} N"
    );
    let step = largest_step(&pulling);
    assert!(step < 0.005, "{step} N in a tick");
    assert!(count(&bench, EventKind::Slip) > 1);
    assert_eq!(
        (bench.grasped_count, count(&bench, EventKind::LetGo)),
        (0, 1)
    );
    assert!(bench.force_n.z.abs() < 0.02, "{}", bench.force_n.z);
}

/// The hand lets go of the handle in a pause. The jaws hold on, and open once the task goes on.
#[test]
fn in_a_pause_the_jaws_hold_what_they_hold() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    approach(&mut sim, &mut bench);
    hold_tip(&mut sim, &mut bench, &BITTEN, 400, Buttons::GRASP);
    let (held, jaw) = (bench.grasped_count, bench.jaw);
    assert!(held > 0);
    bench.next_at(&BITTEN, Buttons::GRASP).command = Some(Command::Pause(true));
    sim.tick(&mut bench);
    let frozen = bench.centers_m.clone();
    bench.events.clear();
    hold_tip(&mut sim, &mut bench, &BITTEN, 400, NONE);
    assert_eq!(
        (bench.grasped_count, bench.jaw.to_bits()),
        (held, jaw.to_bits())
    );
    assert_eq!(bench.centers_m, frozen);
    assert!(bench.events.is_empty(), "{:?}", bench.events);
    bench.next_at(&BITTEN, NONE).command = Some(Command::Pause(false));
    sim.tick(&mut bench);
    hold_tip(&mut sim, &mut bench, &BITTEN, 400, NONE);
    assert_eq!(
        (bench.grasped_count, count(&bench, EventKind::LetGo)),
        (0, 1)
    );
}

#[test]
fn without_friction_nothing_is_held() {
    let mut anatomy = Anatomy::liver();
    anatomy.organs[0].material.friction = 0.0;
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    approach(&mut sim, &mut bench);
    hold_tip(&mut sim, &mut bench, &BITTEN, 800, Buttons::GRASP);
    let pulling = move_and_record(
        &mut sim,
        &mut bench,
        (&BITTEN, &above(0.01)),
        1000,
        Buttons::GRASP,
    );
    let force_max_n = pulling
        .iter()
        .fold(0.0f32, |force_max_n, f| force_max_n.max(-f));
    assert!(force_max_n < 0.01, "{force_max_n} N");
}

#[test]
fn grasped_tissue_keeps_the_jaws_open() {
    let jaw = |anatomy: &Anatomy| {
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        approach(&mut sim, &mut bench);
        hold_tip(&mut sim, &mut bench, &BITTEN, 400, Buttons::GRASP);
        bench.jaw
    };
    let soft = Anatomy::liver();
    let mut stiff = soft.clone();
    stiff.organs[0].material.young_pa = 50_000.0;
    let (soft, stiff) = (jaw(&soft), jaw(&stiff));
    assert!(0.0 < soft && soft < stiff && stiff < 0.35, "{soft} {stiff}");
    let mut elsewhere = Anatomy::liver();
    for sphere in &mut elsewhere.spheres {
        sphere.center_m.x += 0.5;
    }
    assert!(jaw(&elsewhere) < f32::EPSILON);
}

#[test]
fn jaws_crush_a_thin_duct_once_a_grip_and_broad_liver_never() {
    let crushes = |anatomy: &Anatomy, at: &Vec3| {
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        move_tip(&mut sim, &mut bench, &AWAY, at, 800, NONE);
        hold_tip(&mut sim, &mut bench, at, 800, Buttons::GRASP);
        assert!(bench.grasped_count > 0);
        hold_tip(&mut sim, &mut bench, at, 800, NONE);
        let forces = bench.events.iter().filter(|it| it.kind == EventKind::Crush);
        forces.map(|it| it.value).collect::<Vec<f32>>()
    };
    let duct = crushes(&super::vessel::artery(), &super::vessel::tip_past(0.0));
    assert!(
        duct.len() == 1 && (1.0..=4.0).contains(&duct[0]),
        "{duct:?}"
    );
    assert!(crushes(&Anatomy::liver(), &BITTEN).is_empty());
}
