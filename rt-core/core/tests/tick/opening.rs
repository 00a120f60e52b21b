//! A handle that opens and shuts: the jaws follow it, and the fingers feel the tissue between the
//! jaws.

use super::grip::count;
use super::vessel::{artery, tip_past};
use super::*;
use rt_core::port::{DeviceCapabilities, Opening, Polled};
use rt_core::tool::Instrument;

const HANDLE: Opening = Opening {
    travel_m: 0.03,
    force_max_n: 5.0,
    stiffness_max_n_m: 1000.0,
};
/// Force of the spring between fingers and jaws over a whole travel, N.
const SPRING_N: f32 = 30.0;
/// A place just below the liver's top.
const BITTEN: Vec3 = Vec3::new(0.0, 0.0, 0.0425);

fn device(opening: Opening) -> DeviceCapabilities {
    DeviceCapabilities { opening, ..TOUCH }
}

/// Fingers, jaws and force in a tick.
#[derive(Debug, Clone, Copy)]
struct Felt {
    handle_opening: f32,
    jaw: f32,
    opening_n: f32,
}

/// Holds the tip at `tip` while the fingers move from one opening to another.
fn move_fingers(
    sim: &mut Sim<'_>,
    bench: &mut Bench,
    tip: &Vec3,
    (from, to): (f32, f32),
    ticks: u32,
) -> Vec<Felt> {
    let tick = |t| {
        let handle_opening = from + (to - from) * (t as f32 / ticks as f32);
        set_sample(bench, tip, handle_opening);
        sim.tick(bench);
        let opening_n = bench.sent[0].opening_n;
        let jaw = bench.jaw;
        Felt {
            handle_opening,
            jaw,
            opening_n,
        }
    };
    (1..=ticks).map(tick).collect()
}

fn set_sample(bench: &mut Bench, tip: &Vec3, handle_opening: f32) {
    if let Polled::Fresh(sample) = &mut bench.next_at(tip, NONE).device {
        sample.opening = Some(handle_opening);
    }
}

fn approach(sim: &mut Sim<'_>, bench: &mut Bench, tip: &Vec3, handle_opening: f32) {
    for step in 1..=600 {
        let share = step as f32 / 600.0;
        set_sample(bench, &(AWAY + (tip - AWAY) * share), handle_opening);
        sim.tick(bench);
    }
}

fn change_instrument(sim: &mut Sim<'_>, bench: &mut Bench, instrument: Instrument) {
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(instrument));
    sim.tick(bench);
}

#[test]
fn fingers_feel_the_tissue_that_they_squeeze() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, device(HANDLE), FORCE_ENABLED);
    let mut bench = Bench::new();
    approach(&mut sim, &mut bench, &BITTEN, 1.0);
    let free = move_fingers(&mut sim, &mut bench, &BITTEN, (1.0, 0.5), 260);
    assert!(
        free.iter()
            .all(|it| it.opening_n.abs() < 1.0e-6 && it.jaw >= it.handle_opening)
    );
    let closing = move_fingers(&mut sim, &mut bench, &BITTEN, (0.5, 0.0), 260);
    assert!(bench.grasped_count > 0);
    // By virtual work, 0.1 N on the fingers press with 0.1 N · 30 mm / 8 mm on the tissue.
    let last = closing[259];
    assert!(last.jaw > 0.01 && last.opening_n > 0.1, "{last:?}");
    for it in &closing {
        let spring_n = SPRING_N * (it.jaw - it.handle_opening);
        assert!((it.opening_n - spring_n).abs() < 2.0e-3, "{it:?}");
    }
    let steps = closing
        .windows(2)
        .map(|pair| pair[1].opening_n - pair[0].opening_n);
    let largest = steps.fold(0.0f32, |largest, step| largest.max(step.abs()));
    // The spring of 1000 N/m at 58 mm/s is 0.058 N a tick.
    assert!(largest < 0.058, "{largest} N in a tick");
    let opening = move_fingers(&mut sim, &mut bench, &BITTEN, (0.0, 1.0), 520);
    assert!(opening[519].opening_n.abs() < 1.0e-6);
    assert_eq!(bench.grasped_count, 0);
    assert_eq!(count(&bench, EventKind::Grasp), 1);
    assert_eq!(count(&bench, EventKind::LetGo), 1);
}

#[test]
fn stiffer_tissue_opens_the_handle_harder_and_never_with_more_than_its_motor() {
    let pressed = |young_pa: f32, handle: Opening| {
        let mut anatomy = Anatomy::liver();
        anatomy.organs[0].material.young_pa = young_pa;
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, device(handle), FORCE_ENABLED);
        let mut bench = Bench::new();
        approach(&mut sim, &mut bench, &BITTEN, 1.0);
        let closing = move_fingers(&mut sim, &mut bench, &BITTEN, (1.0, 0.0), 520);
        closing[519]
    };
    let (soft, stiff) = (pressed(5.0e3, HANDLE), pressed(5.0e4, HANDLE));
    assert!(0.1 < soft.opening_n && soft.opening_n < stiff.opening_n);
    assert!(
        soft.jaw < stiff.jaw && stiff.jaw < 0.35,
        "{soft:?} {stiff:?}"
    );
    let weak = Opening {
        force_max_n: 0.5,
        ..HANDLE
    };
    let weak = pressed(5.0e5, weak);
    assert!((weak.opening_n - 0.5).abs() < 1.0e-3, "{weak:?}");
    // Without a motor, a handle drives its jaws as a button does.
    let limp = Opening {
        force_max_n: 0.0,
        stiffness_max_n_m: 0.0,
        ..HANDLE
    };
    let limp = pressed(5.0e4, limp);
    assert!(
        limp.opening_n.abs() < f32::MIN_POSITIVE && limp.jaw > 0.05,
        "{limp:?}"
    );
}

#[test]
fn a_cut_takes_the_fracture_energy_of_the_tissue() {
    let mut anatomy = artery();
    anatomy.organs[0].material.toughness_j_m2 = 2000.0;
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, device(HANDLE), FORCE_ENABLED);
    let mut bench = Bench::new();
    change_instrument(&mut sim, &mut bench, Instrument::Scissors);
    approach(&mut sim, &mut bench, &tip_past(0.0015), 1.0);
    let tip = tip_past(0.0015);
    let closing = move_fingers(&mut sim, &mut bench, &tip, (1.0, 0.0), 2000);
    let cuts: Vec<f32> = (bench.events.iter())
        .filter(|it| it.kind == EventKind::Cut)
        .map(|it| it.value)
        .collect();
    let [energy_j] = cuts[..] else {
        panic!("{cuts:?}");
    };
    let work_j: f32 = closing
        .windows(2)
        .map(|pair| {
            pair[0].opening_n * (pair[0].handle_opening - pair[1].handle_opening) * HANDLE.travel_m
        })
        .sum();
    // The blades already cut while the spring tightens, so the fingers do less work than this part
    // of the cut takes.
    let peak_n = closing
        .iter()
        .fold(0.0f32, |peak_n, it| peak_n.max(it.opening_n));
    let slack_j = 0.5 * peak_n * peak_n / HANDLE.stiffness_max_n_m;
    assert!(peak_n > 0.05, "{peak_n} N");
    let off = (work_j + slack_j - energy_j).abs() / energy_j;
    assert!(
        off < 0.1,
        "{work_j} J of work, {slack_j} J while it tightens, {energy_j} J to part it"
    );
    let shut = move_fingers(&mut sim, &mut bench, &tip, (0.0, 0.0), 10);
    assert!(shut[9].opening_n.abs() < 1.0e-6, "no tissue is left to cut");
    // When the blades open again, nothing resists them.
    let again = move_fingers(&mut sim, &mut bench, &tip, (0.0, 1.0), 400);
    assert!(again.iter().all(|it| it.opening_n.abs() < 1.0e-6));
}

#[test]
fn a_new_instrument_in_a_shut_hand_neither_clips_nor_cuts() {
    for instrument in [Instrument::ClipApplier, Instrument::Scissors] {
        let anatomy = artery();
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, device(HANDLE), FORCE_ENABLED);
        let mut bench = Bench::new();
        change_instrument(&mut sim, &mut bench, Instrument::Hook);
        approach(&mut sim, &mut bench, &tip_past(0.0015), 0.0);
        set_sample(&mut bench, &tip_past(0.0015), 0.0);
        bench.samples.command = Some(Command::Instrument(instrument));
        sim.tick(&mut bench);
        move_fingers(&mut sim, &mut bench, &tip_past(0.0015), (0.0, 0.0), 400);
        assert!(bench.clips.is_empty() && count(&bench, EventKind::Cut) == 0);
        assert!(bench.jaw < f32::EPSILON, "{}", bench.jaw);
    }
}

#[test]
fn a_handle_that_was_shut_in_a_gap_bites_nothing() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, device(HANDLE), FORCE_ENABLED);
    let mut bench = Bench::new();
    change_instrument(&mut sim, &mut bench, Instrument::ClipApplier);
    approach(&mut sim, &mut bench, &tip_past(0.0015), 1.0);
    for _ in 0..50 {
        bench.next().device = Polled::Lost;
        sim.tick(&mut bench);
    }
    move_fingers(&mut sim, &mut bench, &tip_past(0.0015), (0.0, 0.0), 400);
    assert!(bench.clips.is_empty(), "{:?}", bench.clips);
    // The applier clips once the hand has opened it and shuts it.
    move_fingers(&mut sim, &mut bench, &tip_past(0.0015), (0.0, 1.0), 300);
    move_fingers(&mut sim, &mut bench, &tip_past(0.0015), (1.0, 0.0), 300);
    assert_eq!(bench.clips.len(), 1);
}

#[test]
fn a_sample_without_an_opening_leaves_the_jaws_where_they_were() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, device(HANDLE), FORCE_ENABLED);
    let mut bench = Bench::new();
    approach(&mut sim, &mut bench, &BITTEN, 1.0);
    move_fingers(&mut sim, &mut bench, &BITTEN, (1.0, 0.0), 520);
    let (held, jaw) = (bench.grasped_count, bench.jaw);
    hold_tip(&mut sim, &mut bench, &BITTEN, 200, NONE);
    assert!(held > 0 && bench.grasped_count == held);
    assert!((bench.jaw - jaw).abs() < 1.0e-3);
}

#[test]
fn an_opening_that_no_handle_has_is_a_bad_sample() {
    use rt_core::fault::Fault;
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, device(HANDLE), FORCE_ENABLED);
    let mut bench = Bench::new();
    for (bad, handle_opening) in (1u64..).zip([f32::NAN, 1.5, -0.1, f32::INFINITY]) {
        set_sample(&mut bench, &AWAY, handle_opening);
        sim.tick(&mut bench);
        assert_eq!(bench.counters.of(Fault::BadSample), bad);
    }
}
