//! Leaks of vessels and ducts, and means to stop them.

use super::cautery::{COAGULATE, CUT, under_current};
use super::grip::count;
use super::tear::tube;
use super::*;
use rt_core::scene::{Anchor, Attachment, Inside};
use rt_core::tool::Instrument;

/// Distance between the vessel's ends, m.
pub(super) const LENGTH_M: f32 = 0.06;

/// An artery along x, 2.4 mm thick. Blood comes from its left end, which is held. Its right end is
/// only attached.
pub(super) fn artery() -> Anatomy {
    let (young_pa, area_m2) = (2.0e5, 4.5e-6);
    let mut artery = tube(0.0);
    artery.organs[0].inside = Inside::Blood;
    artery.organs[0].material.young_pa = young_pa;
    // The chain has no bending stiffness. It is damped as in fluid; otherwise its stumps would
    // swing.
    artery.organs[0].material.damping_per_s = 60.0;
    for sphere in &mut artery.spheres {
        sphere.radius_m = 0.001_2;
    }
    artery.spheres[20].held = false;
    artery.attachments.push(Attachment {
        sphere: 20,
        to: Anchor::World(artery.spheres[20].center_m),
        rest_length_m: 0.0,
        compliance_m_n: 1.0e-4,
        is_thread: false,
        tear_j: 0.0,
    });
    for link in &mut artery.links {
        link.compliance_m_n = link.rest_length_m / (young_pa * area_m2);
        link.rest_length_m *= 0.99;
    }
    artery
}

/// Moves this instrument to `at`, closes and opens it there, and moves it away.
pub(super) fn use_instrument(
    sim: &mut Sim<'_>,
    bench: &mut Bench,
    instrument: Instrument,
    at: &Vec3,
) {
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(instrument));
    sim.tick(bench);
    move_tip(sim, bench, &AWAY, at, 800, NONE);
    hold_tip(sim, bench, at, 100, NONE);
    hold_tip(sim, bench, at, 300, Buttons::GRASP);
    hold_tip(sim, bench, at, 300, NONE);
    move_tip(sim, bench, at, &AWAY, 500, NONE);
    hold_tip(sim, bench, &AWAY, 300, NONE);
}

/// Place of the tip for work on the vessel at `x_m`: 6 mm past the vessel, which then lies between
/// the jaws.
pub(super) fn tip_past(x_m: f32) -> Vec3 {
    Vec3::new(x_m, 0.0, -0.006)
}

/// Flow and place of every event `Leak`.
pub(super) fn leaks(bench: &Bench) -> Vec<(f32, Vec3)> {
    let leaks = bench.events.iter().filter(|it| it.kind == EventKind::Leak);
    leaks.map(|it| (it.value, it.at_m)).collect()
}

/// Share of the lumen that is open, for every event `Divided`.
pub(super) fn divided(bench: &Bench) -> Vec<f32> {
    let divided = bench
        .events
        .iter()
        .filter(|it| it.kind == EventKind::Divided);
    divided.map(|it| it.value).collect()
}

#[test]
fn the_end_that_has_pressure_bleeds_and_the_other_does_not() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0015),
    );
    assert_eq!(count(&bench, EventKind::Cut), 1);
    let divided: Vec<f32> = divided(&bench);
    assert_eq!(divided, [1.0], "no clip on either side");
    let leaks = leaks(&bench);
    assert_eq!(leaks.len(), 1, "{leaks:?}");
    let (flow, at_m) = leaks[0];
    assert!(
        flow > 0.99 && at_m.x < 0.0015 && at_m.x > -0.01,
        "{flow} {at_m}"
    );
}

#[test]
fn a_second_cut_before_the_first_moves_the_leak_there() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0105),
    );
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(-0.0105),
    );
    let values: Vec<f32> = leaks(&bench).iter().map(|leak| leak.0).collect();
    assert_eq!(count(&bench, EventKind::Cut), 2);
    assert_eq!(values.len(), 3, "{values:?}");
    assert!(values[0] > 0.99 && values[1..].contains(&0.0), "{values:?}");
}

#[test]
fn cut_ends_retract() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0015),
    );
    hold_tip(&mut sim, &mut bench, &AWAY, 2000, NONE);
    let long = |spheres: std::ops::Range<usize>| {
        let links = bench.centers_m[spheres].windows(2);
        let lengths = links.map(|pair| norm(&(pair[1] - pair[0])) / 0.003);
        let (count, sum) = (lengths.len(), lengths.sum::<f32>());
        sum / count as f32
    };
    for stump in [0..11, 11..21] {
        let length = long(stump);
        assert!(
            (0.87..0.91).contains(&length),
            "a stump shortens by a tenth, and as its tension of 1 % ends: {length}"
        );
    }
    assert!(norm(&(bench.centers_m[11] - bench.centers_m[10])) > 0.003 + 0.05 * LENGTH_M);
}

#[test]
fn coagulation_stops_a_small_artery() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0015),
    );
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(&mut bench);
    // The hook's bent end extends from its tip 4 mm towards −y. The middle of the bent end follows
    // the end of the stump.
    let on_end = |bench: &Bench| bench.centers_m[10] + Vec3::new(0.0, 0.002, 0.002);
    let first = on_end(&bench);
    move_tip(&mut sim, &mut bench, &AWAY, &first, 1000, NONE);
    for _ in 0..40 {
        let at = on_end(&bench);
        under_current(&mut sim, &mut bench, &at, COAGULATE, 100);
    }
    let at = bench.tip_m;
    hold_tip(&mut sim, &mut bench, &at, 100, NONE);
    let leaks = leaks(&bench);
    assert!(leaks.len() >= 2, "{leaks:?}");
    assert!(leaks.last().is_some_and(|leak| leak.0 < 0.01), "{leaks:?}");
}

#[test]
fn a_bag_that_is_burnt_through_leaks_once() {
    let mut bag = Anatomy::liver().with_skins();
    bag.organs[0].inside = Inside::Bile;
    let mut state = new_state();
    let mut sim = Sim::new(bag.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(&mut bench);
    let at = Vec3::new(0.0, 0.0, 0.034);
    move_tip(&mut sim, &mut bench, &AWAY, &at, 1000, NONE);
    under_current(&mut sim, &mut bench, &at, CUT, 1000);
    assert_eq!(
        count(&bench, EventKind::Perforation),
        0,
        "1 s at 13.5 W is less than the 28 J of a hole"
    );
    under_current(&mut sim, &mut bench, &at, CUT, 4000);
    hold_tip(&mut sim, &mut bench, &at, 100, NONE);
    assert_eq!(count(&bench, EventKind::Perforation), 1);
    let leaks = leaks(&bench);
    assert!(
        leaks.len() == 1 && (0.1..1.0).contains(&leaks[0].0),
        "{leaks:?}"
    );
    // A reset closes the hole, and no further leak is reported.
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    hold_tip(&mut sim, &mut bench, &AWAY, 100, NONE);
    assert_eq!(self::leaks(&bench).len(), 1);
}

/// Number of perforations after the hook's bent end has coagulated the top of an organ with this
/// content for `ticks`.
fn perforations(inside: Inside, ticks: u32) -> usize {
    let mut bag = Anatomy::liver().with_skins();
    bag.organs[0].inside = inside;
    let mut state = new_state();
    let mut sim = Sim::new(bag.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(&mut bench);
    let at = Vec3::new(0.0, 0.0, 0.034);
    move_tip(&mut sim, &mut bench, &AWAY, &at, 1000, NONE);
    under_current(&mut sim, &mut bench, &at, COAGULATE, ticks);
    count(&bench, EventKind::Perforation)
}

/// A hole takes 28 J in a bag and 42 J in gut, at 15 W.
#[test]
fn coagulation_that_is_held_long_opens_a_wall() {
    for (inside, spared, opened) in [(Inside::Bile, 1500, 4000), (Inside::Food, 2500, 6000)] {
        assert_eq!(perforations(inside, spared), 0, "{inside:?}");
        assert_eq!(perforations(inside, opened), 1, "{inside:?}");
    }
    assert_eq!(perforations(Inside::Liver, 6000), 0, "it has no wall");
}
