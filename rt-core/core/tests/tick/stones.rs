//! Stones: they leave the gallbladder through a hole, come to rest, and are picked up.

use super::cautery::{COAGULATE, CUT, under_current};
use super::grip::count;
use super::*;
use rt_core::math::{Pose, Quat};
use rt_core::procedure::stones::{Place, Stone};
use rt_core::scene::{Bowl, Inside, Stones};
use rt_core::tool::Instrument;

/// Five stones in so little bile that one leaves in two seconds through a burnt hole.
const FEW: Stones = Stones {
    count: 5,
    diameter_m: 0.004,
    room_m3: 1.0e-6,
    ..Stones::NONE
};
/// Place of the hook's tip that burns a hole, on the flat top of the bag.
const HOLE: Vec3 = Vec3::new(0.0, 0.0, 0.034);

/// A bag of bile that lies in a bowl.
fn bag(stones: Stones) -> Anatomy {
    let mut bag = Anatomy::liver().with_skins();
    bag.organs[0].inside = Inside::Bile;
    let upright = Quat::from_axis_angle(&Vec3::x_axis(), std::f32::consts::FRAC_PI_2);
    let bowl = Bowl {
        world_from_bowl: Pose::from_parts(Vec3::zeros().into(), upright),
        radii_m: [0.09, 0.036, 0.08],
    };
    bag.stones = Some(Stones { bowl, ..stones });
    bag
}

/// Burns a hole into the top of the bag, and lifts the hook.
fn perforate(sim: &mut Sim<'_>, bench: &mut Bench) {
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(bench);
    move_tip(sim, bench, &AWAY, &HOLE, 1000, NONE);
    under_current(sim, bench, &HOLE, CUT, 5000);
    move_tip(sim, bench, &HOLE, &AWAY, 500, NONE);
    assert_eq!(count(bench, EventKind::Perforation), 1);
}

fn in_place(bench: &Bench, is_there: impl Fn(&Stone) -> bool) -> usize {
    bench.stones.iter().filter(|it| is_there(it)).count()
}

fn at_rest(stone: &Stone) -> bool {
    matches!(stone.place, Place::Rests(_))
}

/// Largest depth of a loose stone below the spheres of the tissue, m.
fn sunk_m(bench: &Bench, anatomy: &Anatomy, radius_m: f32) -> f32 {
    let depth = |stone: &Stone| {
        let spheres = bench.centers_m.iter().zip(&anatomy.spheres);
        let depths = spheres.map(|(at, it)| it.radius_m + radius_m - norm(&(at - stone.at_m)));
        depths.fold(f32::MIN, f32::max)
    };
    let loose = bench.stones.iter().filter(|it| it.is_loose());
    loose.map(depth).fold(f32::MIN, f32::max)
}

#[test]
fn stones_leave_through_a_hole_one_after_the_other_until_none_are_left() {
    let anatomy = bag(FEW);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    perforate(&mut sim, &mut bench);
    let mut last = count(&bench, EventKind::StoneSpilled);
    for _ in 0..12_000 {
        bench.next_at(&AWAY, NONE);
        sim.tick(&mut bench);
        let spilled = count(&bench, EventKind::StoneSpilled);
        let inside = in_place(&bench, |it| it.place == Place::Inside);
        assert_eq!(inside + spilled, 5, "no stone is lost or made");
        assert!(spilled - last <= 1, "one at a time");
        last = spilled;
    }
    assert_eq!(last, 5);
    let numbers = (bench.events.iter()).filter(|it| it.kind == EventKind::StoneSpilled);
    let numbers: Vec<f32> = numbers.map(|it| it.value).collect();
    assert_eq!(numbers, [0.0, 1.0, 2.0, 3.0, 4.0]);
    // A reset puts them back.
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    assert_eq!(in_place(&bench, |it| it.place == Place::Inside), 5);
}

/// With `Q N / V` of the module's documentation: a hole of 3 mm lets out a quarter of 20 ml/min,
/// which takes 0.5 stones a second along where 5 stones are in 0.83 ml of bile.
#[test]
fn stones_leave_as_often_as_their_share_of_the_outflow_says() {
    let anatomy = bag(FEW);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    perforate(&mut sim, &mut bench);
    let mut ticks = Vec::new();
    for tick in 0..12_000 {
        bench.next_at(&AWAY, NONE);
        let before = bench.events.len();
        sim.tick(&mut bench);
        let is_spill = |it: &Event| it.kind == EventKind::StoneSpilled;
        if bench.events[before..].iter().any(is_spill) {
            ticks.push(tick);
        }
    }
    let between_s = f64::from(ticks[ticks.len() - 1] - ticks[0]) * 1e-3 / (ticks.len() - 1) as f64;
    let leaks: Vec<f32> = (bench.events.iter())
        .filter(|it| it.kind == EventKind::Leak)
        .map(|it| it.value)
        .collect();
    let bile_m3 = 1.0e-6 - 5.0 * std::f64::consts::PI / 6.0 * 0.004f64.powi(3);
    let expected_s = bile_m3 / 5.0 / (20.0e-6 / 60.0 * f64::from(leaks[0]));
    assert!(
        (between_s / expected_s - 1.0).abs() < 0.01,
        "{between_s} s, expected {expected_s} s, {leaks:?}"
    );
}

#[test]
fn stones_wider_than_the_hole_stay_inside() {
    let anatomy = bag(Stones {
        count: 2,
        diameter_m: 0.005,
        ..FEW
    });
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    perforate(&mut sim, &mut bench);
    hold_tip(&mut sim, &mut bench, &AWAY, 12_000, NONE);
    assert_eq!(count(&bench, EventKind::StoneSpilled), 0);
}

#[test]
fn spilled_stones_come_to_rest_on_the_tissue_and_stay_there() {
    let anatomy = bag(FEW);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    perforate(&mut sim, &mut bench);
    hold_tip(&mut sim, &mut bench, &AWAY, 16_000, NONE);
    assert_eq!(in_place(&bench, at_rest), 5, "{:?}", bench.stones);
    // The skin passes through the centres of the outer spheres.
    let outer_m = anatomy.spheres[0].radius_m;
    let before = bench.stones.clone();
    for _ in 0..2000 {
        bench.next_at(&AWAY, NONE);
        sim.tick(&mut bench);
        let depth_m = sunk_m(&bench, &anatomy, 0.002) - outer_m;
        assert!(depth_m < 0.000_5, "a stone is {depth_m} m in the tissue");
    }
    for (now, before) in bench.stones.iter().zip(&before) {
        assert!(
            norm(&(now.at_m - before.at_m)) < 0.000_1,
            "{now:?} {before:?}"
        );
    }
    for (i, one) in bench.stones.iter().enumerate() {
        for other in &bench.stones[i + 1..] {
            let apart_m = norm(&(one.at_m - other.at_m));
            assert!(
                apart_m > 0.9 * 0.004,
                "two stones at one place: {apart_m} m"
            );
        }
    }
}

/// A bag whose first stone lies on tissue, and that stone's place.
fn one_spilled<'a>(sim: &mut Sim<'a>, bench: &mut Bench) -> Vec3 {
    perforate(sim, bench);
    hold_tip(sim, bench, &AWAY, 8500, NONE);
    let first = bench.stones[0];
    assert!(at_rest(&first), "{first:?}");
    first.at_m
}

/// Spills one stone and closes a grasper around it, 4 mm behind the end of its jaws. Returns the
/// grasper's tip.
fn one_grasped(sim: &mut Sim<'_>, bench: &mut Bench) -> Vec3 {
    let stone_m = one_spilled(sim, bench);
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Grasper));
    sim.tick(bench);
    let tip = stone_m - Vec3::new(0.0, 0.0, 0.002);
    move_tip(sim, bench, &AWAY, &tip, 1500, NONE);
    hold_tip(sim, bench, &tip, 200, Buttons::GRASP);
    tip
}

fn one() -> Stones {
    Stones { count: 1, ..FEW }
}

#[test]
fn jaws_hold_a_stone_carry_it_and_let_it_go() {
    let anatomy = bag(one());
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let tip = one_grasped(&mut sim, &mut bench);
    assert_eq!(
        count(&bench, EventKind::StoneHeld),
        1,
        "{:?} {tip}",
        bench.stones
    );
    assert_eq!(
        bench.grasped_count, 0,
        "a stone between the jaws, no tissue"
    );
    assert!(
        (0.1..0.5).contains(&bench.jaw),
        "the stone stops the jaws: {}",
        bench.jaw
    );
    let lifted = tip + Vec3::new(0.01, 0.0, 0.03);
    let before_m = bench.stones[0].at_m;
    move_tip(&mut sim, &mut bench, &tip, &lifted, 500, Buttons::GRASP);
    let moved_m = bench.stones[0].at_m - before_m;
    assert!(norm(&(moved_m - (lifted - tip))) < 0.003, "{moved_m}");
    hold_tip(&mut sim, &mut bench, &lifted, 1500, NONE);
    assert_eq!(count(&bench, EventKind::StoneDropped), 1);
    assert!(
        bench.stones[0].at_m.z < before_m.z + 0.01,
        "it fell: {:?}",
        bench.stones[0]
    );
    assert_eq!(count(&bench, EventKind::StoneRetrieved), 0);
}

#[test]
fn a_stone_drawn_through_the_port_or_out_with_the_grasper_is_retrieved() {
    for is_changed in [false, true] {
        let anatomy = bag(one());
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        let tip = one_grasped(&mut sim, &mut bench);
        if is_changed {
            let samples = bench.next_at(&tip, Buttons::GRASP);
            samples.command = Some(Command::Instrument(Instrument::Irrigator));
            sim.tick(&mut bench);
        } else {
            let out = Vec3::new(0.0, 0.0, 0.175);
            move_tip(&mut sim, &mut bench, &tip, &out, 1500, Buttons::GRASP);
        }
        assert_eq!(count(&bench, EventKind::StoneRetrieved), 1);
        assert_eq!(bench.stones[0].place, Place::Retrieved);
    }
}

#[test]
fn suction_takes_small_stones_and_leaves_large_ones() {
    for (diameter_m, taken) in [(0.003, 1), (0.004, 0)] {
        let anatomy = bag(Stones {
            diameter_m,
            ..one()
        });
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        let stone_m = one_spilled(&mut sim, &mut bench);
        bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Irrigator));
        sim.tick(&mut bench);
        let tip = stone_m + Vec3::new(0.0, 0.0, 0.005);
        move_tip(&mut sim, &mut bench, &AWAY, &tip, 1000, NONE);
        assert_eq!(
            count(&bench, EventKind::StoneRetrieved),
            0,
            "the pedal is up"
        );
        under_current(&mut sim, &mut bench, &tip, COAGULATE, 100);
        assert_eq!(count(&bench, EventKind::StoneRetrieved), taken);
    }
}

#[test]
fn equal_inputs_give_equal_stones_also_from_a_checkpoint() {
    let anatomy = bag(FEW);
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    perforate(&mut sim, &mut bench);
    let checkpoint = sim.checkpoint();
    let mut run = |bench: &mut Bench| {
        sim.go_back(&checkpoint);
        bench.samples.now_ns = 10_000_000_000;
        hold_tip(&mut sim, bench, &AWAY, 4000, NONE);
        (bench.stones.clone(), sim.state_hash())
    };
    assert_eq!(run(&mut bench), run(&mut bench));
    assert!(in_place(&bench, |it| it.place != Place::Inside) > 0);
}
