//! An instrument at work in whole scenes: the force on the hand has no step, and tissue comes to
//! rest.

use crate::support::hand::{Hand, Site, mm, s};
use crate::{prepared_built_in, prepared_triangle};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::tool::Instrument;
use scene_prepare::Prepared;

/// The target of a scene, and the instrument that the hand has at the start.
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

/// Largest step of the force from one tick to the next while a hand works slowly, N.
const STEP_N: f32 = 0.005;
/// Largest step while jaws close, N. The ends of the jaws move through tissue at 50 mm/s. Each step
/// must be similar to the one before.
const BITE_N: f32 = 0.008;

/// Force that the hand must feel at least once, N. A tool that touches nothing would have no step
/// either.
const FELT_N: f32 = 0.1;

fn assert_smooth(built: &Prepared, hand: &Hand) {
    let work = hand.work(built, &target(built));
    let most_n = work.legs.iter().map(|felt| felt.largest_n);
    let most_n = most_n.fold(0.0, f32::max);
    assert!(most_n > FELT_N, "{work:?}");
    for (number, felt) in work.legs.iter().enumerate() {
        println!("leg {number}: {felt:?}");
        let closes = felt.leg.buttons.contains(Buttons::GRASP);
        let most_n = if closes { BITE_N } else { STEP_N };
        assert!(felt.largest_step_n < most_n, "leg {number}: {felt:?}");
        assert!(felt.largest_knock_n < STEP_N, "leg {number}: {felt:?}");
    }
}

/// Deep in Calot's triangle, the shaft lies on the liver's edge and on the connective tissue next
/// to the liver.
#[test]
fn force_deep_in_the_triangle_has_no_step() {
    let hand = Hand::new()
        .press(mm(20.0), s(3.6))
        .rest(s(2.0))
        .slide(mm(8.0), s(1.5))
        .leave(s(3.6));
    assert_smooth(prepared_triangle(false), &hand);
}

/// The tip slides off the liver's edge and back.
#[test]
fn sliding_and_biting_in_the_triangle_have_no_step() {
    let hand = Hand::new()
        .press(mm(6.0), s(2.0))
        .slide(mm(8.0), s(0.75))
        .slide(mm(-8.0), s(1.5))
        .slide(mm(8.0), s(1.5))
        .slide(mm(-8.0), s(1.5))
        .slide(mm(0.0), s(1.5))
        .grasp(s(0.5))
        .lift(mm(4.0), s(2.0));
    assert_smooth(prepared_triangle(true), &hand);
}

#[test]
fn force_on_the_built_in_organs_has_no_step() {
    let hand = Hand::new()
        .press(mm(20.0), s(3.6))
        .slide(mm(8.0), s(1.5))
        .return_to_depth(mm(6.0), s(3.6))
        .grasp(s(0.5))
        .lift(mm(0.0), s(2.0));
    assert_smooth(prepared_built_in(), &hand);
}

/// A fast press is felt, and nothing is felt when the tool is gone.
#[test]
fn fast_press_leaves_no_force_behind() {
    let hand = Hand::new()
        .press(mm(20.0), s(0.1))
        .rest(s(0.5))
        .named("held deep")
        .lift(mm(40.0), s(0.1))
        .rest(s(0.5))
        .rest(s(0.5))
        .named("long away");
    let built = prepared_triangle(false);
    let work = hand.work(built, &target(built));
    let deep = work.leg("held deep");
    assert!(deep.largest_n > 0.1 && deep.awake > 0, "{work:?}");
    assert!(work.leg("long away").largest_n < 1.0e-6, "{work:?}");
}

/// Untouched organs come to rest, and then cost nothing.
#[test]
fn scenes_that_are_left_alone_sleep() {
    let hand = Hand::new().rest(s(4.0)).named("away");
    for built in [
        prepared_triangle(false),
        prepared_triangle(true),
        prepared_built_in(),
    ] {
        let work = hand.work(built, &target(built));
        assert_eq!(work.leg("away").awake, 0);
    }
}

/// A thin duct that a tool gently holds aside comes to rest. If the direction of the tool's push
/// followed the duct's turn at once, the duct would flutter.
#[test]
fn a_duct_under_a_tool_does_not_flutter() {
    let built = prepared_triangle(false);
    let duct = built
        .report
        .organs
        .iter()
        .position(|it| it.name == "cystic duct");
    let [first, count] = built.scene.organs[duct.expect("it has one")].spheres;
    let hand = Hand::new()
        .press(mm(8.0), s(2.6))
        .slide(mm(6.0), s(0.7))
        .rest(s(1.0))
        .rest(s(0.3))
        .named("held ahead")
        .slide(mm(-4.0), s(0.9))
        .rest(s(1.0))
        .rest(s(0.3))
        .named("held back");
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
            let work = hand.work(built, &site);
            for held in ["held ahead", "held back"] {
                let felt = work.leg(held);
                most_n = most_n.max(felt.largest_n);
                println!("{eighth} {instrument:?}: {felt:?}");
                // If the push turned at once, its whole force would come and go.
                assert!(
                    felt.largest_knock_n < 0.4 * felt.largest_n + 1.0e-4,
                    "{eighth} {instrument:?}: {felt:?}"
                );
            }
        }
    }
    assert!(most_n > 0.001, "{most_n}");
}
