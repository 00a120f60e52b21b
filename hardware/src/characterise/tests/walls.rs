//! Compares the stiffness limit that the virtual wall finds under a hand with that of a plain
//! simulation.

use rt_core::math::Vec3;

use super::super::buzz::SWING_M;
use super::super::{Halt, Place, Wall, wall};
use super::simulated::{FaultyDriver, HandLaw, simulated};
use crate::emulate::{Body, Grip, HapticModel, SimulatedBody, Touch, pressing_m};

/// Two fingers that hardly hold the handle, as in `evaluate haptics`.
const RELAXED: Grip = Grip {
    stiffness_n_m: 30.0,
    damping_n_s_m: 0.2,
};
/// Delay in addition to the emulated device's own millisecond, ms.
const LATE_MS: usize = 2;

/// Two fingers that tap and press, again and again.
fn presses() -> HandLaw {
    Box::new(pressing_m)
}

fn held(body: Body) -> SimulatedBody {
    SimulatedBody {
        body,
        grip: RELAXED,
        start_m: Vec3::new(0.0, 0.008, 0.0),
        ..SimulatedBody::free(HapticModel::TouchRig)
    }
}

/// Swing of the handle, m, when the same hand presses the same device into Hooke's wall. The second
/// press is measured, because the first one begins at rest and is softer.
fn swing_m(body: Body, stiffness_n_m: f32) -> f32 {
    let mut touch = Touch::new(body, RELAXED, Vec3::new(0.0, 0.008, 0.0));
    let mut late = std::collections::VecDeque::from(vec![Vec3::zeros(); LATE_MS]);
    let (mut low, mut high) = (f32::MAX, f32::MIN);
    let mut hand = presses();
    for ms in 0..6600 {
        let depth_m = (-touch.measured_m().y).max(0.0);
        late.push_back(Vec3::y() * (stiffness_n_m * depth_m).min(0.88));
        let force_n = late.pop_front().unwrap_or_default();
        touch.step(hand(f64::from(ms) * 1e-3), Vec3::zeros(), force_n);
        if ms >= 5600 {
            low = low.min(touch.measured_m().y);
            high = high.max(touch.measured_m().y);
        }
    }
    high - low
}

fn pressed(body: Body, hand: HandLaw) -> Result<(Wall, Vec<String>), Halt> {
    let (device, mut clock) = simulated(HapticModel::TouchRig, held(body), hand);
    let mut device = FaultyDriver::new(device, LATE_MS);
    let sent = device.sent.clone();
    let mut lines = Vec::new();
    let walls = wall(
        &mut device,
        &mut clock,
        Place::Workspace,
        None,
        &mut |line| {
            lines.push(line.to_owned());
        },
    );
    assert!(sent.borrow().0 <= 0.88 + 1e-6, "{:?}", sent.borrow());
    assert_eq!(sent.borrow().1.to_bits(), 0, "no force remains");
    walls.map(|it| (it, lines))
}

#[test]
fn the_stiffest_stable_wall_is_that_of_a_simple_simulation() {
    for friction_n in [0.05, 0.1] {
        let body = Body {
            friction_n,
            ..Body::TOUCH
        };
        let stiffnesses = (0..80).map(|i| 100.0 * 1.05f32.powi(i));
        let mut buzzing = stiffnesses.filter(|k| swing_m(body, *k) > SWING_M as f32);
        let truth_n_m = f64::from(buzzing.next().unwrap());
        let (walls, lines) = pressed(body, presses()).unwrap();
        let (still, buzzes) = (walls.still_n_m.unwrap(), walls.buzzes_n_m.unwrap());
        assert!(!walls.was_left, "{lines:?}");
        assert!(buzzes <= 1.11 * still, "{walls:?}");
        let ratio = (still * buzzes).sqrt() / truth_n_m;
        assert!(
            (0.8..1.25).contains(&ratio),
            "{still} {buzzes}, true {truth_n_m}"
        );
        let buzz = walls.trials.iter().find_map(|trial| trial.buzz).unwrap();
        assert!((10.0..300.0).contains(&buzz.0), "{buzz:?}");
        assert!(
            lines.iter().any(|line| line.contains("buzzes with")),
            "{lines:?}"
        );
    }
}

#[test]
fn a_wall_that_nobody_presses_gets_no_result() {
    let (walls, lines) = pressed(Body::TOUCH, Box::new(|_| Vec3::y() * 0.008)).unwrap();
    assert!(walls.was_left && walls.trials.is_empty());
    assert!(
        lines.iter().any(|line| line.contains("Tap the wall")),
        "{lines:?}"
    );
    let (walls, lines) = pressed(Body::TOUCH, Box::new(|_| Vec3::y() * -0.01)).unwrap();
    assert!(walls.was_left, "{walls:?}");
    assert!(lines[0].contains("Lift the handle"), "{lines:?}");
}

#[test]
fn a_fast_hand_ends_the_search() {
    let throws: HandLaw = Box::new(|at_s| Vec3::y() * (0.008 + 4.0 * (at_s - 0.5).max(0.0) as f32));
    let halt = pressed(Body::TOUCH, throws).unwrap_err();
    assert!(matches!(halt, Halt::Fast { .. }), "{halt}");
    let said = halt.to_string();
    assert!(said.contains("m/s, allowed are 0.5 m/s"), "{said}");
}

#[test]
fn a_hand_that_leaves_the_middle_ends_the_search() {
    let leaves: HandLaw = Box::new(|at_s| Vec3::y() * (0.008 + 0.1 * at_s as f32).min(0.09));
    let halt = pressed(Body::TOUCH, leaves).unwrap_err();
    assert!(matches!(halt, Halt::Outside { .. }), "{halt}");
}
