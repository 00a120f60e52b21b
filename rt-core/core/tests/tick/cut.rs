//! Scissors: the tissue that they cut, and the tissue that they spare.

use super::grip::count;
use super::tear::tube;
use super::*;
use rt_core::scene::{Anchor, Attachment};
use rt_core::tool::Instrument;

/// Place of the tip at which the blades reach 4 mm beyond the tube's middle.
const ACROSS: Vec3 = Vec3::new(0.0005, 0.0, -0.004);

/// A tight tube that cannot tear, and a suture across it to a point of the world.
fn anatomy() -> Anatomy {
    let mut tube = tube(0.0);
    for link in &mut tube.links {
        link.compliance_m_n *= 0.01;
        link.rest_length_m *= 0.98;
    }
    tube.attachments.push(Attachment {
        sphere: 8,
        to: Anchor::World(Vec3::new(0.01, 0.0, 0.003)),
        rest_length_m: 0.02,
        compliance_m_n: 1.0e-3,
        is_thread: true,
        tear_j: 0.0,
    });
    tube
}

/// Number of `Cut` events, and centres of the spheres, after this instrument has moved to `at`,
/// closed and opened its jaws, and moved away.
fn cuts(instrument: Instrument, at: &Vec3) -> (usize, Vec<Vec3>) {
    let anatomy = anatomy();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(instrument));
    sim.tick(&mut bench);
    move_tip(&mut sim, &mut bench, &AWAY, at, 500, NONE);
    hold_tip(&mut sim, &mut bench, at, 300, Buttons::GRASP);
    hold_tip(&mut sim, &mut bench, at, 300, NONE);
    move_tip(&mut sim, &mut bench, at, &AWAY, 500, NONE);
    hold_tip(&mut sim, &mut bench, &AWAY, 1000, NONE);
    (count(&bench, EventKind::Cut), bench.centers_m.clone())
}

#[test]
fn scissors_cut_the_tube_and_the_suture_and_nothing_else_does() {
    let (cut, _) = cuts(Instrument::Scissors, &ACROSS);
    assert_eq!(cut, 2, "a link and the suture");
    assert_eq!(cuts(Instrument::Grasper, &ACROSS).0, 0);
    assert_eq!(cuts(Instrument::ClipApplier, &ACROSS).0, 0);
    // Next to the tube, and above it.
    assert_eq!(
        cuts(Instrument::Scissors, &(ACROSS + Vec3::y() * 0.02)).0,
        0
    );
    assert_eq!(
        cuts(Instrument::Scissors, &(ACROSS + Vec3::z() * 0.02)).0,
        0
    );
}

#[test]
fn closed_scissors_that_are_pushed_across_cut_nothing() {
    let anatomy = anatomy();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Scissors));
    sim.tick(&mut bench);
    hold_tip(&mut sim, &mut bench, &AWAY, 300, Buttons::GRASP);
    move_tip(&mut sim, &mut bench, &AWAY, &ACROSS, 500, Buttons::GRASP);
    hold_tip(&mut sim, &mut bench, &ACROSS, 300, Buttons::GRASP);
    assert_eq!(count(&bench, EventKind::Cut), 0);
}

#[test]
fn a_cut_tube_comes_apart() {
    let widest = |instrument| {
        let (_, centers_m) = cuts(instrument, &ACROSS);
        let gaps = centers_m.windows(2).map(|pair| norm(&(pair[1] - pair[0])));
        gaps.fold(0.0, f32::max)
    };
    let (whole_m, cut_m) = (
        widest(Instrument::ClipApplier),
        widest(Instrument::Scissors),
    );
    assert!(whole_m < 0.0031 && cut_m > 0.004, "{whole_m} {cut_m}");
}
