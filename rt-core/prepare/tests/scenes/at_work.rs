//! An instrument at work in whole scenes: the force on the hand has no step, and tissue comes to
//! rest.

use crate::support::hand::{Felt, Leg, OPEN, Site, work_at};
use crate::{prepared_built_in, prepared_triangle};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::tool::Instrument;
use scene_prepare::Prepared;

/// The target of a scene, with the instrument with which the scene begins.
fn target(built: &Prepared) -> Site {
    let room = built.scene.room.expect("a room");
    let (target_m, normal) = (Vec3::from(room.target_m), Vec3::from(room.target_normal));
    let out_m = Vec3::from(room.instrument_port_m) - target_m;
    Site {
        target_m,
        normal,
        along: normal.cross(&out_m).normalize(),
        instrument: Instrument::default(),
    }
}

fn work(built: &Prepared, legs: &[Leg]) -> Vec<Felt> {
    work_at(built, &target(built), legs)
}

/// Largest step of the force from one tick to the next while a hand works slowly, N.
const STEP_N: f32 = 0.005;
/// Largest step while jaws close, N. Their ends go through tissue at 50 mm/s, and each tick's step
/// is like the one before.
const BITE_N: f32 = 0.008;

/// Least force that some leg must reach, N: a tool that feels nothing has no step either.
const FELT_N: f32 = 0.1;

fn assert_smooth(built: &Prepared, legs: &[Leg]) {
    let all = work(built, legs);
    let most_n = all.iter().map(|felt| felt.largest_n).fold(0.0, f32::max);
    assert!(most_n > FELT_N, "{all:?}");
    for (number, (felt, leg)) in all.iter().zip(legs).enumerate() {
        println!("leg {number}: {felt:?}");
        let closes = leg.2.contains(Buttons::GRASP);
        let most_n = if closes { BITE_N } else { STEP_N };
        assert!(felt.largest_step_n < most_n, "leg {number}: {felt:?}");
        assert!(felt.largest_knock_n < STEP_N, "leg {number}: {felt:?}");
    }
}

/// Deep in Calot's triangle the shaft lies on the liver's edge and on the layer beside it.
#[test]
fn deep_in_the_triangle_no_tick_has_a_step() {
    let legs = [
        Leg(3600, [-20.0, 0.0], OPEN),
        Leg(2000, [-20.0, 0.0], OPEN),
        Leg(1500, [-20.0, 8.0], OPEN),
        Leg(3600, [20.0, 0.0], OPEN),
    ];
    assert_smooth(prepared_triangle(false), &legs);
}

/// The tip slides off the liver's edge and back.
#[test]
fn sliding_and_biting_in_the_triangle_have_no_step() {
    let legs = [
        Leg(2000, [-6.0, 0.0], OPEN),
        Leg(750, [-6.0, 8.0], OPEN),
        Leg(1500, [-6.0, -8.0], OPEN),
        Leg(1500, [-6.0, 8.0], OPEN),
        Leg(1500, [-6.0, -8.0], OPEN),
        Leg(1500, [-6.0, 0.0], OPEN),
        Leg(500, [-6.0, 0.0], Buttons::GRASP),
        Leg(2000, [4.0, 0.0], Buttons::GRASP),
    ];
    assert_smooth(prepared_triangle(true), &legs);
}

#[test]
fn on_the_built_in_organs_no_tick_has_a_step() {
    let legs = [
        Leg(3600, [-20.0, 0.0], OPEN),
        Leg(1500, [-20.0, 8.0], OPEN),
        Leg(3600, [-6.0, 0.0], OPEN),
        Leg(500, [-6.0, 0.0], Buttons::GRASP),
        Leg(2000, [0.0, 0.0], Buttons::GRASP),
    ];
    assert_smooth(prepared_built_in(), &legs);
}

/// A fast press is felt. Nothing is felt when the tool has gone.
#[test]
fn after_a_fast_press_nothing_is_felt() {
    let legs = [
        Leg(100, [-20.0, 0.0], OPEN),
        Leg(500, [-20.0, 0.0], OPEN),
        Leg(100, [40.0, 0.0], OPEN),
        Leg(500, [40.0, 0.0], OPEN),
        Leg(500, [40.0, 0.0], OPEN),
    ];
    let felt = work(prepared_triangle(false), &legs);
    assert!(felt[1].largest_n > 0.1 && felt[1].awake > 0, "{felt:?}");
    assert!(felt[4].largest_n < 1.0e-6, "{felt:?}");
}

/// Untouched organs come to rest, and cost nothing from then on.
#[test]
fn scenes_that_are_left_alone_sleep() {
    let away = Leg(4000, [20.0, 0.0], OPEN);
    for built in [
        prepared_triangle(false),
        prepared_triangle(true),
        prepared_built_in(),
    ] {
        let all = work(built, std::slice::from_ref(&away));
        assert_eq!(all[0].awake, 0);
    }
}

/// A thin duct that a hand gently holds aside comes to rest. It would flutter if a push turned with
/// it at once.
#[test]
fn a_duct_under_a_tool_does_not_flutter() {
    let built = prepared_triangle(false);
    let duct = built
        .report
        .organs
        .iter()
        .position(|it| it.name == "cystic duct");
    let [first, count] = built.scene.organs[duct.expect("it has one")].spheres;
    let legs = [
        Leg(2600, [-8.0, 0.0], OPEN),
        Leg(700, [-8.0, 6.0], OPEN),
        Leg(1000, [-8.0, 6.0], OPEN),
        Leg(300, [-8.0, 6.0], OPEN),
        Leg(900, [-8.0, -4.0], OPEN),
        Leg(1000, [-8.0, -4.0], OPEN),
        Leg(300, [-8.0, -4.0], OPEN),
    ];
    let mut most_n = 0.0f32;
    for eighth in [3, 4] {
        for instrument in [Instrument::Hook, Instrument::ClipApplier] {
            let sphere = first + count * eighth / 8;
            let at_m = |i: u32| Vec3::from(built.scene.spheres[i as usize].center_m);
            let facing = Site::facing_port(built, sphere, instrument);
            let duct_m = at_m(sphere + 1) - at_m(sphere - 1);
            let site = Site {
                along: duct_m.cross(&facing.normal).normalize(),
                ..facing
            };
            let all = work_at(built, &site, &legs);
            for held in [3, 6] {
                most_n = most_n.max(all[held].largest_n);
                println!("{eighth} {instrument:?}: {:?}", all[held]);
                // A push that turns at once would come and go as a whole.
                assert!(
                    all[held].largest_knock_n < 0.4 * all[held].largest_n + 1.0e-4,
                    "{eighth} {instrument:?}: {:?}",
                    all[held]
                );
            }
        }
    }
    assert!(most_n > 0.001, "{most_n}");
}
