//! The opening of an emulated handle, whose ring has known properties.

use super::super::{Options, Place, measure, wall};
use super::simulated::{FaultyDriver, nobody, simulated};
use super::{ALLOWED, Axis, Characterised, TOUCH_S, assert_recovers};
use crate::emulate::{Body, Grip, HapticModel, SimulatedBody, pressing_m};

const HANDLE: HapticModel = HapticModel::HandleRig;
const ALONE: Options = Options {
    axes: [false; 3],
    opening: true,
    ..super::X
};

/// Result of a handle with this ring, after `change` has spoilt its driver.
fn found(ring: Body, options: &Options, change: impl FnOnce(&mut FaultyDriver)) -> Characterised {
    let of = SimulatedBody {
        ring,
        ..SimulatedBody::free(HANDLE)
    };
    let (device, mut clock) = simulated(HANDLE, of, nobody());
    let mut device = FaultyDriver::new(device, 0);
    change(&mut device);
    let records = measure(&mut device, &mut clock, options, &mut |_| {}).unwrap();
    assert!(clock.simulated.opening_n().abs() < 1e-6, "no force remains");
    records.analyse()
}

fn ring() -> Body {
    SimulatedBody::free(HANDLE).ring
}

fn along(found: &Characterised) -> &Axis {
    &found.opening.as_ref().unwrap().as_ref().unwrap().axis
}

#[test]
fn the_opening_of_the_emulated_handle_is_recovered() {
    let found = found(ring(), &ALONE, |_| {});
    let opened = found.opening.as_ref().unwrap().as_ref().unwrap();
    assert_recovers(&opened.axis, &ring(), TOUCH_S);
    assert!(
        opened.range[0] < 0.01 && opened.range[1] > 0.99,
        "{:?}",
        opened.range
    );
    assert!(opened.given.len() > 1, "{:?}", opened.given);
    for [asked_n, share] in &opened.given {
        assert!((share - 1.0).abs() < ALLOWED, "{asked_n} N: {share}");
    }
    assert!(opened.largest().unwrap().1 > 0.9, "{:?}", opened.given);
    let said = found.verdicts().join("\n");
    assert!(said.contains("30.0 mm of the declared 30.0 mm"), "{said}");
    assert!(
        said.contains("are as large as small ones promise"),
        "{said}"
    );
    assert_eq!(
        found.station_lines(),
        "",
        "no line of the station file is about it"
    );
}

#[test]
fn another_ring_is_recovered() {
    let other = Body {
        mass_kg: 0.035,
        friction_n: 0.12,
        damping_n_s_m: 0.4,
        ..ring()
    };
    assert_recovers(along(&found(other, &ALONE, |_| {})), &other, TOUCH_S);
}

#[test]
fn the_other_axes_are_measured_too() {
    let options = Options {
        axes: [true, false, false],
        ..ALONE
    };
    let found = found(ring(), &options, |_| {});
    assert_recovers(along(&found), &ring(), TOUCH_S);
    assert_recovers(found.measured().next().unwrap().1, &Body::TOUCH, TOUCH_S);
}

#[test]
fn a_saturating_motor_is_reported() {
    let found = found(ring(), &ALONE, |device| device.opens_most_n = 0.4);
    let said = found.verdicts().join("\n");
    assert!(
        said.contains("the motor does not reach the declared 5.0 N"),
        "{said}"
    );
}

#[test]
fn a_ring_that_sticks_in_the_middle_is_reported() {
    let short = SimulatedBody::free(HANDLE);
    let found = found(short.ring, &ALONE, |device| {
        device.opening = |it| 0.2 + 0.6 * it;
    });
    let said = found.verdicts().join("\n");
    assert!(said.contains("0.20 shut and 0.80 wide open"), "{said}");
    assert!(said.contains("ends or travel are wrong"), "{said}");
}

#[test]
fn an_opening_that_cannot_be_measured_gives_a_reason_and_does_not_affect_the_rest() {
    let options = Options {
        axes: [true, false, false],
        ..ALONE
    };
    for opens_by in [-1.0, 0.0] {
        let found = found(ring(), &options, |device| device.opens_by = opens_by);
        let said = found.opening.as_ref().unwrap().as_ref().unwrap_err();
        assert!(
            said.contains("the motor is off or pushes the wrong way"),
            "{opens_by}: {said}"
        );
        assert_eq!(found.measured().count(), 1);
    }
}

#[test]
fn a_device_without_an_opening_gets_no_opening_result() {
    let of = SimulatedBody::free(HapticModel::TouchRig);
    let (mut device, mut clock) = simulated(HapticModel::TouchRig, of, nobody());
    let records = measure(device.as_mut(), &mut clock, &ALONE, &mut |_| {}).unwrap();
    assert!(records.analyse().opening.is_none());
}

#[test]
fn a_wall_along_the_opening_is_found_under_fingers() {
    let soft = Grip {
        stiffness_n_m: 30.0,
        damping_n_s_m: 0.2,
    };
    let of = SimulatedBody {
        grip: soft,
        ..SimulatedBody::free(HANDLE)
    };
    let (device, mut clock) = simulated(HANDLE, of, Box::new(pressing_m));
    clock.squeezes = true;
    let mut device = FaultyDriver::new(device, 2);
    let mut lines = Vec::new();
    let walls = wall(&mut device, &mut clock, Place::Opening, None, &mut |line| {
        lines.push(line.to_owned());
    });
    let walls = walls.unwrap();
    let (still, buzzes) = (walls.still_n_m.unwrap(), walls.buzzes_n_m.unwrap());
    assert!(!walls.was_left && buzzes <= 1.11 * still, "{lines:?}");
}
