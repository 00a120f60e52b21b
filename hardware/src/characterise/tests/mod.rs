//! The experiments in simulated time, on devices whose true properties are known.

mod opened;
mod simulated;
mod stopped;
mod verdicts;
mod walls;

use rt_core::math::Vec3;

use self::simulated::{FaultyDriver, nobody, simulated};
use super::{Axis, Characterised, Options, measure};
use crate::emulate::{Body, HapticModel, SimulatedBody};

/// Largest error allowed, as a share of the true value.
const ALLOWED: f64 = 0.1;
/// Delay of the emulated Touch, s: its motors answer a millisecond later.
const TOUCH_S: f64 = 0.001;
/// Delay of the emulated WoodenHaptics device, s: its motors are a millisecond late, and its
/// samples a millisecond old.
const WOODY_S: f64 = 0.002;
const X: Options = Options {
    axes: [true, false, false],
    opening: false,
    force_n: None,
    repetitions: 2,
    let_go_s: 0.0,
};

fn measured(
    model: HapticModel,
    of: SimulatedBody,
    late_ms: usize,
    options: &Options,
) -> Characterised {
    let (device, mut clock) = simulated(model, of, nobody());
    let mut device = FaultyDriver::new(device, late_ms);
    let sent = device.sent.clone();
    let records = measure(&mut device, &mut clock, options, &mut |_| {}).unwrap();
    let found = records.analyse();
    let (most_n, last_n) = *sent.borrow();
    let can = found.declared;
    assert!(f64::from(most_n) <= found.force_n + 1e-6, "{most_n}");
    assert!(most_n <= can.force_continuous_n.min(0.5 * can.force_max_n));
    assert_eq!(last_n.to_bits(), 0, "no force remains");
    found
}

#[test]
fn an_axis_takes_a_quarter_of_a_minute() {
    let of = SimulatedBody::free(HapticModel::TouchRig);
    let (mut device, mut clock) = simulated(HapticModel::TouchRig, of, nobody());
    let from_ns = clock.simulated.now_ns();
    let options = Options::default();
    measure(device.as_mut(), &mut clock, &options, &mut |_| {}).unwrap();
    // The command and the guide state this time.
    let seconds = (clock.simulated.now_ns() - from_ns) as f64 * 1e-9;
    assert!((30.0..60.0).contains(&seconds), "{seconds}");
}

fn assert_recovers(axis: &Axis, body: &Body, delay_s: f64) {
    let near = |name: &str, found: f64, truth: f64| {
        let error = (found - truth) / truth;
        assert!(error.abs() <= ALLOWED, "{name} {found}, true {truth}");
    };
    near("mass", axis.mass_kg.value, body.mass_kg.into());
    near(
        "damping",
        axis.damping_n_s_m.value,
        body.damping_n_s_m.into(),
    );
    near("friction", axis.friction_n.value, body.friction_n.into());
    near(
        "break-away",
        axis.break_away_n.value,
        body.friction_n.into(),
    );
    near("delay", axis.delay_s.value, delay_s);
    let tremor = body.damping_n_s_m + 4.0 * body.friction_n / (std::f32::consts::PI * 0.2);
    near("tremor", axis.tremor_damping_n_s_m().value, tremor.into());
}

#[test]
fn all_axes_of_the_emulated_touch_are_recovered() {
    let of = SimulatedBody {
        start_m: Vec3::new(0.003, -0.002, 0.001),
        ..SimulatedBody::free(HapticModel::TouchRig)
    };
    let found = measured(HapticModel::TouchRig, of, 0, &Options::default());
    assert_eq!(found.measured().count(), 3, "{:?}", found.axes);
    for (_, axis) in found.measured() {
        assert_recovers(axis, &Body::TOUCH, TOUCH_S);
        assert!(axis.carries_n.value.abs() < 0.01, "{:?}", axis.carries_n);
        // The remaining error is the encoder's rounding: 0.055 mm / √12.
        assert!(axis.rms_m < 0.03e-3, "{}", axis.rms_m);
        assert!(axis.friction_curve.len() > 10);
        let fast = axis.friction_curve.iter().filter(|it| it[0].abs() > 0.05);
        for [v_m_s, friction_n] in fast {
            let truth_n = 0.2 * v_m_s + 0.26 * v_m_s.signum();
            assert!((friction_n - truth_n).abs() < 0.05, "{v_m_s} {friction_n}");
        }
        let trace = &axis.run_out;
        let off = trace.measured_m.iter().zip(&trace.fitted_m);
        let worst_m = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(trace.at_s.len() > 20 && worst_m < 0.2e-3, "{worst_m}");
        assert!(axis.chirp.iter().all(|it| it.at_s.len() > 50));
    }
}

#[test]
fn encoder_steps_and_starting_places_do_not_matter() {
    for (seed, step_m) in [(1u32, 0.02e-3), (2, 0.055e-3), (3, 0.1e-3)] {
        let part = |shift: u32| ((seed * 7919) >> shift) as f32 % 13.0 * 1e-3 - 6e-3;
        let free = SimulatedBody::free(HapticModel::TouchRig);
        let of = SimulatedBody {
            body: Body {
                encoder_step_m: step_m,
                ..free.body
            },
            start_m: Vec3::new(part(0), part(2), part(4)),
            ..free
        };
        let found = measured(HapticModel::TouchRig, of, 0, &X);
        assert_recovers(found.measured().next().unwrap().1, &of.body, TOUCH_S);
    }
}

#[test]
fn pauses_of_the_computer_do_not_matter() {
    let of = SimulatedBody::free(HapticModel::TouchRig);
    let (device, mut clock) = simulated(HapticModel::TouchRig, of, nobody());
    let mut device = FaultyDriver::new(device, 0);
    // In every second this computer pauses for 30 ms, while time goes on for the device.
    clock.stalls = true;
    let records = measure(&mut device, &mut clock, &X, &mut |_| {}).unwrap();
    let found = records.analyse();
    assert_recovers(found.measured().next().unwrap().1, &of.body, TOUCH_S);
}

#[test]
fn another_body_and_a_longer_delay_are_recovered() {
    let free = SimulatedBody::free(HapticModel::TouchRig);
    let body = Body {
        mass_kg: 0.2,
        friction_n: 0.1,
        damping_n_s_m: 1.0,
        ..free.body
    };
    let found = measured(HapticModel::TouchRig, SimulatedBody { body, ..free }, 6, &X);
    assert_recovers(found.measured().next().unwrap().1, &body, TOUCH_S + 0.006);
    let said = found.verdicts().join("\n");
    assert!(
        said.contains("declares 2.0 ms delay") && said.contains("may buzz"),
        "{said}"
    );
}

#[test]
fn all_axes_of_the_emulated_woody_are_recovered() {
    let of = SimulatedBody::free(HapticModel::Woody);
    let options = Options {
        repetitions: 2,
        ..Options::default()
    };
    let found = measured(HapticModel::Woody, of, 0, &options);
    assert_eq!(found.measured().count(), 3, "{:?}", found.axes);
    for (_, axis) in found.measured() {
        assert_recovers(axis, &of.body, WOODY_S);
    }
    let said = found.verdicts().join("\n");
    assert!(said.contains("2.0 ms: they agree"), "{said}");
}

#[test]
fn a_falling_handle_is_supported_and_its_weight_is_found() {
    // The weight exceeds friction, so the handle falls without force.
    let weight_n = 0.35;
    let of = SimulatedBody {
        load_n: Vec3::new(0.0, -weight_n, 0.0),
        ..SimulatedBody::free(HapticModel::TouchRig)
    };
    let options = Options {
        axes: [true, true, false],
        let_go_s: 1.0,
        ..X
    };
    let found = measured(HapticModel::TouchRig, of, 0, &options);
    for (at, axis) in found.measured() {
        assert_recovers(axis, &of.body, TOUCH_S);
        let truth_n = if at == 1 { f64::from(weight_n) } else { 0.0 };
        let carries_n = axis.carries_n.value;
        assert!((carries_n - truth_n).abs() < 0.02, "{at}: {carries_n}");
    }
    assert_eq!(found.measured().count(), 2, "{:?}", found.axes);
}

#[test]
fn an_axis_without_a_motor_is_named_and_the_others_are_measured() {
    let found = measured(
        HapticModel::Hapi,
        SimulatedBody::free(HapticModel::Hapi),
        0,
        &Options {
            axes: [true, true, false],
            ..X
        },
    );
    let flat = found.axes[1].as_ref().unwrap().as_ref().unwrap_err();
    assert!(flat.contains("no motor along y"), "{flat}");
    assert!(found.axes[2].is_none());

    let (device, mut clock) = simulated(
        HapticModel::TouchRig,
        SimulatedBody::free(HapticModel::TouchRig),
        nobody(),
    );
    let mut device = FaultyDriver::new(device, 0);
    device.factors.y = 0.0;
    let options = Options {
        axes: [false, true, false],
        ..X
    };
    let records = measure(&mut device, &mut clock, &options, &mut |_| {}).unwrap();
    let found = records.analyse();
    let said = found.axes[1].as_ref().unwrap().as_ref().unwrap_err();
    assert!(said.contains("0.88 N do not move the handle"), "{said}");
}

#[test]
fn a_heavy_handle_is_refused_where_too_little_force_is_left() {
    let free = SimulatedBody::free(HapticModel::TouchRig);
    let of = SimulatedBody {
        load_n: Vec3::new(-0.3, 0.0, 0.0),
        body: Body {
            friction_n: 0.55,
            ..free.body
        },
        ..free
    };
    let found = measured(HapticModel::TouchRig, of, 0, &X);
    let said = found.axes[0].as_ref().unwrap().as_ref().unwrap_err();
    assert!(said.contains("allow more with --force"), "{said}");
}
