//! Current of the hook: the tissue that it burns and divides, and the tissue that it spares.

use super::grip::count;
use super::tear::tube;
use super::*;
use rt_core::port::{PedalSample, Polled};
use rt_core::tool::Instrument;

/// Place at which the hook's bent end lies across the tube's top.
const ACROSS: Vec3 = Vec3::new(0.0005, 0.002, 0.003_5);
pub(super) const CUT: (bool, bool) = (true, false);
pub(super) const COAGULATE: (bool, bool) = (false, true);
const OFF: (bool, bool) = (false, false);

/// A tight tube of 200 kPa with a cross-section of 3.1 mm², which cannot tear.
fn thin_tube() -> Anatomy {
    let mut tube = tube(0.0);
    let young_pa = 2.0e5;
    tube.organs[0].material.young_pa = young_pa;
    for link in &mut tube.links {
        link.compliance_m_n = link.rest_length_m / (young_pa * 3.1e-6);
        link.rest_length_m *= 0.95;
    }
    tube
}

/// The bench after this instrument has moved to `at` and stayed there for `ticks` under this
/// current. The current is off at the end.
fn burnt(
    anatomy: &Anatomy,
    instrument: Instrument,
    at: &Vec3,
    (cut, coagulate): (bool, bool),
    ticks: u32,
) -> Bench {
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(instrument));
    sim.tick(&mut bench);
    move_tip(&mut sim, &mut bench, &AWAY, at, 1000, NONE);
    hold_tip(&mut sim, &mut bench, at, 300, NONE);
    under_current(&mut sim, &mut bench, at, (cut, coagulate), ticks);
    bench
}

/// Holds the tip at `at` for `ticks` under this current. The current is off at the end.
pub(super) fn under_current(
    sim: &mut Sim<'_>,
    bench: &mut Bench,
    at: &Vec3,
    (cut, coagulate): (bool, bool),
    ticks: u32,
) {
    for tick in 0..=ticks {
        let samples = bench.next_at(at, NONE);
        samples.pedal = Polled::Fresh(PedalSample {
            cut: cut && tick < ticks,
            coagulate: coagulate && tick < ticks,
            camera_lock: false,
            at_ns: samples.now_ns,
        });
        sim.tick(bench);
    }
}

fn reported(bench: &Bench, kind: EventKind) -> impl Iterator<Item = &Event> {
    bench.events.iter().filter(move |event| event.kind == kind)
}

#[test]
fn current_divides_a_tube_and_reports_its_energy() {
    let bench = burnt(&thin_tube(), Instrument::Hook, &ACROSS, CUT, 4000);
    assert!(count(&bench, EventKind::Cut) >= 1);
    for cut in reported(&bench, EventKind::Cut) {
        assert!(norm(&(cut.at_m - ACROSS)) < 0.008, "{}", cut.at_m);
    }
    let energy_j: f32 = reported(&bench, EventKind::Burn)
        .map(|burn| burn.value)
        .sum();
    let burns = count(&bench, EventKind::Burn);
    assert!(
        reported(&bench, EventKind::Burn).all(|burn| burn.organ == Some(0) && burn.value > 0.0)
    );
    // 15 W at most, reported twenty times a second.
    assert!((5.0..=60.01).contains(&energy_j), "{energy_j} J");
    assert!((5..=82).contains(&burns), "{burns}");
}

#[test]
fn no_current_no_hook_and_no_touch_burn_nothing() {
    let tube = thin_tube();
    let whole =
        |bench: &Bench| count(bench, EventKind::Burn) == 0 && count(bench, EventKind::Cut) == 0;
    assert!(whole(&burnt(&tube, Instrument::Hook, &ACROSS, OFF, 500)));
    assert!(whole(&burnt(
        &tube,
        Instrument::Hook,
        &ACROSS,
        (true, true),
        500
    )));
    assert!(whole(&burnt(&tube, Instrument::Grasper, &ACROSS, CUT, 500)));
    let air = burnt(
        &tube,
        Instrument::Hook,
        &(ACROSS + Vec3::z() * 0.002),
        CUT,
        500,
    );
    assert!(whole(&air) && count(&air, EventKind::Electro) == 2);
    // The insulated shaft rests on the tube.
    let adjacent = Vec3::new(0.0, -0.0035, -0.02);
    let shaft = burnt(&tube, Instrument::Hook, &adjacent, CUT, 500);
    assert!(whole(&shaft) && count(&shaft, EventKind::Contact) > 0);
}

#[test]
fn coagulation_divides_slowly_and_burns_as_much() {
    let tube = thin_tube();
    let first_cut = |current| {
        let bench = burnt(&tube, Instrument::Hook, &ACROSS, current, 4000);
        let before = bench
            .events
            .iter()
            .take_while(|event| event.kind != EventKind::Cut);
        let burnt = before.filter(|event| event.kind == EventKind::Burn);
        (burnt.count(), count(&bench, EventKind::Cut))
    };
    let (cutting, cuts) = first_cut(CUT);
    let (coagulating, _) = first_cut(COAGULATE);
    assert!(
        cuts >= 1 && 2 * coagulating > 5 * cutting,
        "{cutting} {coagulating}"
    );
}

#[test]
fn an_organ_s_surface_is_burnt() {
    let liver = Anatomy::liver().with_skins();
    let bench = burnt(
        &liver,
        Instrument::Hook,
        &Vec3::new(0.0, 0.0, 0.034),
        COAGULATE,
        1000,
    );
    let energy_j: f32 = reported(&bench, EventKind::Burn)
        .map(|burn| burn.value)
        .sum();
    assert!(
        (14.0..=15.01).contains(&energy_j),
        "{energy_j} J in a second"
    );
    assert!(reported(&bench, EventKind::Burn).all(|burn| burn.organ == Some(0)));
}
