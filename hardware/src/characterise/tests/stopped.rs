//! Every reason to stop: the force is zero afterwards, and the message names the next step.

use rt_core::fault::Fault;
use rt_core::math::Vec3;

use super::super::{Halt, Options, measure};
use super::X;
use super::simulated::{FaultyDriver, HandLaw, Watch, nobody, simulated};
use crate::HardwareError;
use crate::emulate::{Body, HapticModel, SimulatedBody};

const TOUCH: HapticModel = HapticModel::TouchRig;

/// A disturbance of a measurement.
struct Disturbance {
    of: SimulatedBody,
    hand: HandLaw,
    options: Options,
    change: Box<dyn FnOnce(&mut FaultyDriver)>,
    /// Called after each millisecond of simulated time; false ends the clock.
    watch: Box<Watch>,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self {
            of: SimulatedBody::free(TOUCH),
            hand: nobody(),
            options: X,
            change: Box::new(|_| {}),
            watch: Box::new(|_, _| true),
        }
    }
}

/// The reason, and the message as a user sees it. Checks that no force remains.
fn halted(spoiled: Disturbance) -> (Halt, String) {
    let (device, mut clock) = simulated(TOUCH, spoiled.of, spoiled.hand);
    let mut device = FaultyDriver::new(device, 0);
    (spoiled.change)(&mut device);
    clock.watch = spoiled.watch;
    let sent = device.sent.clone();
    let halt = measure(&mut device, &mut clock, &spoiled.options, &mut |_| {}).unwrap_err();
    assert_eq!(sent.borrow().1.to_bits(), 0, "{halt}: no force remains");
    let error = HardwareError::from(halt.clone());
    assert!(matches!(error, HardwareError::Halted(_)), "{error}");
    assert_eq!(error.to_string(), halt.to_string());
    (halt, error.to_string())
}

#[test]
fn a_device_that_pushes_the_wrong_way_is_stopped_within_two_centimetres() {
    for axis in 0..3 {
        let (device, mut clock) = simulated(TOUCH, SimulatedBody::free(TOUCH), nobody());
        let simulated = clock.simulated.clone();
        let mut device = FaultyDriver::new(device, 0);
        device.factors[axis] = -1.0;
        let halt = measure(&mut device, &mut clock, &X, &mut |_| {}).unwrap_err();
        assert!(matches!(halt, Halt::Backwards { .. }), "{halt}");
        let said = halt.to_string();
        assert!(said.contains("Run `calot devices feel` first"), "{said}");
        // Without force the handle comes to rest.
        for _ in 0..500 {
            simulated.advance(Vec3::zeros());
        }
        let moved_m = simulated.measured_m().norm();
        assert!(moved_m < 0.02, "{moved_m}");
    }
}

#[test]
fn a_force_along_another_axis_is_named() {
    let (_, said) = halted(Disturbance {
        change: Box::new(|device| device.swaps_xy = true),
        ..Disturbance::default()
    });
    assert!(
        said.contains("direction or axis of the force is wrong"),
        "{said}"
    );
    assert!(said.contains("to +x moved the handle by ["), "{said}");
}

#[test]
fn unplugged_device_ends_every_experiment() {
    for at_s in [0.3, 3.0, 8.5, 13.0] {
        let (halt, said) = halted(Disturbance {
            watch: Box::new(move |now_s, simulated| {
                if now_s >= at_s {
                    simulated.unplug();
                }
                true
            }),
            ..Disturbance::default()
        });
        assert_eq!(halt, Halt::Lost);
        assert!(said.contains("Plug it in and start again"), "{said}");
    }
}

#[test]
fn a_person_can_stop_the_measurement_at_any_time() {
    for at_s in [0.0, 0.5, 7.0, 9.0] {
        let (halt, said) = halted(Disturbance {
            watch: Box::new(move |now_s, _| now_s < at_s),
            ..Disturbance::default()
        });
        assert_eq!(halt, Halt::Asked);
        assert!(said.contains("The force is zero"), "{said}");
    }
}

#[test]
fn a_fault_or_silence_ends_the_measurement() {
    let (_, said) = halted(Disturbance {
        change: Box::new(|device| device.findings.faults.raise(Fault::DeviceClock)),
        ..Disturbance::default()
    });
    assert!(said.contains("(device_clock), allowed is none"), "{said}");
    let (halt, said) = halted(Disturbance {
        change: Box::new(|device| device.polls_left = 700),
        ..Disturbance::default()
    });
    assert!(matches!(halt, Halt::Silent { .. }), "{halt}");
    assert!(said.contains("ms, allowed are 300 ms"), "{said}");
}

#[test]
fn a_handle_outside_the_middle_is_refused_without_force() {
    let (halt, said) = halted(Disturbance {
        of: SimulatedBody {
            start_m: Vec3::new(0.0, 0.07, 0.0),
            ..SimulatedBody::free(TOUCH)
        },
        ..Disturbance::default()
    });
    assert!(matches!(halt, Halt::Outside { .. }), "{halt}");
    assert!(
        said.contains("70 mm from the middle of the workspace, allowed are 60 mm"),
        "{said}"
    );
}

#[test]
fn a_weight_or_friction_beyond_the_force_ends_the_measurement() {
    let (halt, said) = halted(Disturbance {
        of: SimulatedBody {
            load_n: Vec3::new(0.0, -1.5, 0.0),
            ..SimulatedBody::free(TOUCH)
        },
        ..Disturbance::default()
    });
    assert!(
        matches!(halt, Halt::Away { .. } | Halt::Fast { .. }),
        "{halt}"
    );
    assert!(said.contains("allowed are"), "{said}");
    let free = SimulatedBody::free(TOUCH);
    let (halt, said) = halted(Disturbance {
        of: SimulatedBody {
            start_m: Vec3::new(0.025, 0.0, 0.0),
            body: Body {
                friction_n: 1.2,
                ..free.body
            },
            ..free
        },
        ..Disturbance::default()
    });
    assert!(matches!(halt, Halt::Unheld { .. }), "{halt}");
    assert!(
        said.contains("0.88 N do not hold the handle within"),
        "{said}"
    );
}

#[test]
fn a_force_that_the_device_may_not_give_is_refused() {
    for force_n in [0.9, 0.01, f64::NAN, -1.0] {
        let (halt, said) = halted(Disturbance {
            options: Options {
                force_n: Some(force_n),
                ..X
            },
            ..Disturbance::default()
        });
        assert!(matches!(halt, Halt::Force { .. }), "{halt}");
        assert!(said.contains("allowed is 0.05 to 0.88 N"), "{said}");
    }
}
