//! Tests of the gates that limit the force.

mod stiffness;

use proptest::prelude::*;
use rt_core::fault::{Fault, FaultSet};
use rt_core::haptics::output_limit::{Demand, OutputLimit};
use rt_core::math::{Vec3, is_finite, norm};
use rt_core::port::{DeviceCapabilities, ForceCommand, Opening};
use rt_core::words::Status;

const DEVICE: DeviceCapabilities = DeviceCapabilities {
    opening: Opening::NONE,
    force_max_n: 3.0,
    force_continuous_n: 1.0,
    torque_max_nm: 0.0,
    stiffness_max_n_m: 500.0,
    damping_max_n_s_m: 1.0,
    damping_n_s_m: 1.8,
    delay_s: 0.001,
    workspace_radius_m: 0.2,
    rate_hz: 1000.0,
};

const HALF_NEWTON: Demand = Demand {
    opening_n: 0.0,
    force_n: Vec3::new(0.0, 0.0, 0.5),
    torque_nm: Vec3::new(0.0, 0.0, 0.0),
    stiffness_n_m: 100.0,
    trocar_n: Vec3::new(0.0, 0.0, 0.0),
    trocar_n_m: 0.0,
    handle_m: None,
    speed_m_s: 0.0,
    device: Status::Live,
    device_fails: false,
    paused: false,
};

/// An enabled limit whose ramp takes one tick.
fn enabled_limit() -> OutputLimit {
    let mut limit = OutputLimit::new(&DEVICE, 0.0);
    limit.enable(true);
    limit
}

/// Applies `demand`. Returns the size of the force, and the faults raised.
fn apply(limit: &mut OutputLimit, demand: &Demand) -> (f32, FaultSet) {
    let mut faults = FaultSet::NONE;
    let out = limit.apply(demand, &mut faults);
    assert_eq!(out.torque_nm, Vec3::zeros(), "the device renders none");
    (norm(&out.force_n), faults)
}

/// Applies `demand` for `ticks` ticks.
fn repeat(limit: &mut OutputLimit, demand: &Demand, ticks: u32) {
    for _ in 0..ticks {
        apply(limit, demand);
    }
}

fn only_fault(fault: Fault) -> FaultSet {
    let mut set = FaultSet::NONE;
    set.raise(fault);
    set
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() < 1.0e-4
}

#[test]
fn a_small_force_passes_unchanged() {
    let mut faults = FaultSet::NONE;
    let force = enabled_limit().apply(&HALF_NEWTON, &mut faults).force_n;
    assert!(
        norm(&(force - HALF_NEWTON.force_n)) < 1.0e-6 && faults.is_empty(),
        "{force} {faults:?}"
    );
}

#[test]
fn closed_until_enabled_and_zero_at_once_when_cut() {
    let mut limit = OutputLimit::new(&DEVICE, 0.0);
    assert_eq!(
        apply(&mut limit, &HALF_NEWTON),
        (0.0, only_fault(Fault::NotEnabled))
    );
    let nothing = Demand {
        force_n: Vec3::zeros(),
        ..HALF_NEWTON
    };
    assert_eq!(
        apply(&mut limit, &nothing),
        (0.0, FaultSet::NONE),
        "nothing is held back"
    );
    limit.enable(true);
    assert!(near(apply(&mut limit, &HALF_NEWTON).0, 0.5));
    limit.enable(false);
    assert!(near(apply(&mut limit, &HALF_NEWTON).0, 0.0));
}

#[test]
fn force_rises_over_the_ramp_after_each_enable() {
    let mut limit = OutputLimit::new(&DEVICE, 2.0);
    for _ in 0..2 {
        limit.enable(true);
        let rise: Vec<f32> = (0..2500)
            .map(|_| apply(&mut limit, &HALF_NEWTON).0)
            .collect();
        assert!(near(rise[0], 0.5 / 2000.0) && near(rise[999], 0.25) && near(rise[2400], 0.5));
        assert!(rise.windows(2).all(|pair| pair[1] >= pair[0]));
    }
}

#[test]
fn nan_gives_zero_force() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut limit = enabled_limit();
        apply(&mut limit, &HALF_NEWTON);
        let demand = Demand {
            force_n: Vec3::new(bad, 0.0, 0.0),
            ..HALF_NEWTON
        };
        assert_eq!(
            apply(&mut limit, &demand),
            (0.0, only_fault(Fault::BadForce))
        );
    }
    let demand = Demand {
        stiffness_n_m: f32::NAN,
        ..HALF_NEWTON
    };
    assert_eq!(
        apply(&mut enabled_limit(), &demand),
        (0.0, only_fault(Fault::BadForce))
    );
}

#[test]
fn a_loop_that_makes_energy_is_damped_and_free_space_never_is() {
    let device = DeviceCapabilities {
        damping_n_s_m: 0.7, // with no delay, 490 N/m is within the limit
        delay_s: 0.0,
        ..DEVICE
    };
    let mut limit = OutputLimit::new(&device, 0.0);
    limit.enable(true);
    let mut damped = 0;
    for tick in 0..400 {
        // The samples arrive 6 ms late, so the force still pushes while the hand moves out.
        let at = |tick: i32| 0.002 * (0.2 * tick as f32).sin();
        let force_n = (-490.0 * at(tick - 6)).max(0.0);
        let demand = Demand {
            force_n: Vec3::new(0.0, 0.0, force_n),
            stiffness_n_m: 490.0,
            handle_m: Some(Vec3::new(0.0, 0.0, at(tick))),
            ..HALF_NEWTON
        };
        let (felt, faults) = apply(&mut limit, &demand);
        damped += u32::from(faults.contains(Fault::Damped));
        assert!(force_n > 0.0 || felt.to_bits() == 0, "{felt}");
    }
    assert!(damped > 20, "{damped}");
}

#[test]
fn too_strong_is_clamped_after_the_slew() {
    let mut limit = enabled_limit();
    let strong = Demand {
        force_n: Vec3::new(0.0, 9.0, 0.0),
        ..HALF_NEWTON
    };
    for expected in [1.0, 2.0, 3.0, 3.0] {
        let (force, faults) = apply(&mut limit, &strong);
        assert!(
            near(force, expected) && faults.contains(Fault::Clamped),
            "{force}"
        );
        assert_eq!(faults.contains(Fault::Slewed), expected < 3.0);
    }
    // The fall is as slow as the rise.
    let (force, faults) = apply(
        &mut limit,
        &Demand {
            force_n: Vec3::zeros(),
            ..HALF_NEWTON
        },
    );
    assert!(near(force, 2.0) && faults == only_fault(Fault::Slewed));
}

#[test]
fn the_force_on_the_fingers_passes_the_same_gates() {
    let device = DeviceCapabilities {
        opening: Opening {
            travel_m: 0.03,
            force_max_n: 5.0,
            stiffness_max_n_m: 1000.0,
        },
        ..DEVICE
    };
    let opened = |device: &DeviceCapabilities| {
        let mut limit = OutputLimit::new(device, 0.0);
        limit.enable(true);
        limit
    };
    let opens = Demand {
        opening_n: 9.0,
        ..HALF_NEWTON
    };
    let mut limit = opened(&device);
    let mut faults = FaultSet::NONE;
    // 0.3 of the peak a tick, up to the peak.
    for expected in [1.5, 3.0, 4.5, 5.0, 5.0] {
        let command = limit.apply(&opens, &mut faults);
        assert!(near(command.opening_n, expected), "{command:?}");
    }
    assert!(faults.contains(Fault::Clamped) && faults.contains(Fault::Slewed));
    for cut in [
        Demand {
            device: Status::Lost,
            ..opens
        },
        Demand {
            device_fails: true,
            ..opens
        },
        Demand {
            speed_m_s: 2.0,
            ..opens
        },
        Demand {
            opening_n: f32::NAN,
            ..HALF_NEWTON
        },
    ] {
        let command = limit.apply(&cut, &mut faults);
        assert_eq!(command, ForceCommand::default());
        limit = opened(&device);
        limit.apply(&opens, &mut faults);
    }
    // In a pause the force falls by the ramp.
    let paused = Demand {
        paused: true,
        ..opens
    };
    for _ in 0..5 {
        limit.apply(&opens, &mut faults);
    }
    let mut last = limit.apply(&opens, &mut faults).opening_n;
    for _ in 0..20 {
        let now = limit.apply(&paused, &mut faults).opening_n;
        assert!(now <= last);
        last = now;
    }
    assert!(last.abs() < 1.0e-6, "{last}");
    // A handle without a motor gets nothing, and that is no fault.
    let (mut none, mut faults) = (opened(&DEVICE), FaultSet::NONE);
    assert!(none.apply(&opens, &mut faults).opening_n.abs() < f32::MIN_POSITIVE);
    assert!(!faults.contains(Fault::Clamped));
}

#[test]
fn gates_act_in_order() {
    let strong = Demand {
        force_n: Vec3::new(0.0, 900.0, 0.0),
        stiffness_n_m: 1.0e4,
        ..HALF_NEWTON
    };
    // A cut comes first: no other gate acts.
    let nan = Demand {
        force_n: Vec3::new(0.0, 900.0, f32::NAN),
        ..strong
    };
    assert_eq!(
        apply(&mut enabled_limit(), &nan),
        (0.0, only_fault(Fault::BadForce))
    );
    let lost = Demand {
        device: Status::Lost,
        ..strong
    };
    assert_eq!(
        apply(&mut enabled_limit(), &lost),
        (0.0, only_fault(Fault::LostDevice))
    );
    let fast = Demand {
        speed_m_s: 2.0,
        ..strong
    };
    assert_eq!(
        apply(&mut enabled_limit(), &fast),
        (0.0, only_fault(Fault::SpeedTrip))
    );
    let mut closed = OutputLimit::new(&DEVICE, 0.0);
    assert_eq!(
        apply(&mut closed, &strong),
        (0.0, only_fault(Fault::NotEnabled))
    );

    // Stiffness is scaled before the clamp: half of 5 N passes it.
    let stiff = Demand {
        force_n: Vec3::new(0.0, 5.0, 0.0),
        stiffness_n_m: 2.0 * enabled_limit().stiffness_max_n_m(),
        ..HALF_NEWTON
    };
    let mut limit = enabled_limit();
    repeat(&mut limit, &stiff, 5);
    let (force_n, faults) = apply(&mut limit, &stiff);
    assert!(near(force_n, 2.5), "{force_n}");
    assert_eq!(faults, only_fault(Fault::StiffnessCapped));

    // The ramp also comes before the clamp: at its beginning the force is too weak to be clamped,
    // and the slew bounds the whole rise.
    let mut limit = OutputLimit::new(&DEVICE, 2.0);
    limit.enable(true);
    let soft = Demand {
        stiffness_n_m: 100.0,
        ..strong
    };
    let (first_n, faults) = apply(&mut limit, &soft);
    assert!(near(first_n, 0.45), "{first_n}");
    assert_eq!(faults, only_fault(Fault::Ramped));
    let mut last_n = first_n;
    for _ in 0..2000 {
        let (force_n, _) = apply(&mut limit, &soft);
        assert!(force_n <= 3.000_1 && (force_n - last_n).abs() <= 1.000_1);
        last_n = force_n;
    }
}

#[test]
fn warm_motors_come_down_to_the_continuous_force_without_a_step() {
    let mut limit = enabled_limit();
    let strong = Demand {
        force_n: Vec3::new(0.0, 3.0, 0.0),
        ..HALF_NEWTON
    };
    let forces: Vec<(f32, FaultSet)> = (0..120_000).map(|_| apply(&mut limit, &strong)).collect();
    assert!(near(forces[1000].0, 3.0), "a second at the peak is fine");
    let (last, faults) = forces[119_999];
    assert!(
        (1.0..1.1).contains(&last) && faults == only_fault(Fault::ThermalLimited),
        "{last}"
    );
    let steps = forces[10..]
        .windows(2)
        .map(|pair| (pair[1].0 - pair[0].0).abs());
    assert!(steps.fold(0.0, f32::max) < 0.01);
    // Without force they cool.
    let rest = Demand {
        force_n: Vec3::zeros(),
        ..HALF_NEWTON
    };
    repeat(&mut limit, &rest, 120_000);
    repeat(&mut limit, &strong, 3);
    assert!(near(apply(&mut limit, &strong).0, 3.0));
}

#[test]
fn stale_fades_in_20_ms_lost_is_zero_at_once_and_both_ramp_up_again() {
    let mut limit = OutputLimit::new(&DEVICE, 0.1);
    limit.enable(true);
    repeat(&mut limit, &HALF_NEWTON, 200);
    let stale = Demand {
        device: Status::Stale,
        ..HALF_NEWTON
    };
    let fall: Vec<_> = (0..21).map(|_| apply(&mut limit, &stale)).collect();
    assert!(fall[0].0 < 0.5 && near(fall[20].0, 0.0), "{fall:?}");
    assert!(
        fall.iter()
            .all(|(_, faults)| faults.contains(Fault::StaleDevice))
    );
    assert!(
        near(apply(&mut limit, &HALF_NEWTON).0, 0.005),
        "up again by the ramp"
    );
    repeat(&mut limit, &HALF_NEWTON, 200);
    let lost = Demand {
        device: Status::Lost,
        ..HALF_NEWTON
    };
    assert_eq!(
        apply(&mut limit, &lost),
        (0.0, only_fault(Fault::LostDevice))
    );
    assert!(near(apply(&mut limit, &HALF_NEWTON).0, 0.005));
    repeat(&mut limit, &HALF_NEWTON, 200);
    let failing = Demand {
        device_fails: true,
        ..HALF_NEWTON
    };
    assert!(near(apply(&mut limit, &failing).0, 0.0), "no ramp down");
    assert!(near(apply(&mut limit, &HALF_NEWTON).0, 0.005));
}

#[test]
fn a_device_whose_fault_is_known_is_not_called_late_too() {
    let mut limit = enabled_limit();
    let stale = Demand {
        device: Status::Stale,
        ..HALF_NEWTON
    };
    for known in [
        Fault::SilentDevice,
        Fault::FrozenDevice,
        Fault::DeviceClock,
        Fault::DeviceBundles,
        Fault::DeafDevice,
    ] {
        let mut faults = only_fault(known);
        limit.apply(&stale, &mut faults);
        assert!(!faults.contains(Fault::StaleDevice), "{known:?}");
    }
    for other in [Fault::DeviceLeap, Fault::LostPedal] {
        let mut faults = only_fault(other);
        limit.apply(&stale, &mut faults);
        assert!(faults.contains(Fault::StaleDevice), "{other:?}");
    }
}

#[test]
fn a_pause_fades_and_alarms_nobody() {
    let mut limit = enabled_limit();
    apply(&mut limit, &HALF_NEWTON);
    let paused = Demand {
        paused: true,
        ..HALF_NEWTON
    };
    let last = (0..21).map(|_| apply(&mut limit, &paused)).last();
    assert_eq!(last, Some((0.0, only_fault(Fault::Ramped))));
    assert!(!Fault::Ramped.is_alarm() && !Fault::NotEnabled.is_alarm());
}

#[test]
fn a_speed_trip_latches_until_a_person_enables() {
    for speed_m_s in [1.3, f32::NAN, f32::INFINITY] {
        let mut limit = enabled_limit();
        assert_eq!(
            apply(
                &mut limit,
                &Demand {
                    speed_m_s: 1.1,
                    ..HALF_NEWTON
                }
            )
            .1,
            FaultSet::NONE
        );
        let fast = Demand {
            speed_m_s,
            ..HALF_NEWTON
        };
        assert_eq!(
            apply(&mut limit, &fast),
            (0.0, only_fault(Fault::SpeedTrip))
        );
        assert_eq!(
            apply(&mut limit, &HALF_NEWTON),
            (0.0, FaultSet::NONE),
            "latched"
        );
        assert!(!limit.is_open());
        limit.enable(true);
        assert!(near(apply(&mut limit, &HALF_NEWTON).0, 0.5));
    }
}

#[test]
fn a_device_that_states_no_sane_limits_gets_no_force() {
    for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        for device in [
            DeviceCapabilities {
                force_max_n: bad,
                ..DEVICE
            },
            DeviceCapabilities {
                stiffness_max_n_m: bad,
                ..DEVICE
            },
        ] {
            let mut limit = OutputLimit::new(&device, 0.0);
            limit.enable(true);
            assert!(near(apply(&mut limit, &HALF_NEWTON).0, 0.0), "{device:?}");
        }
    }
}

#[test]
fn torque_passes_the_same_gates() {
    let device = DeviceCapabilities {
        torque_max_nm: 0.1,
        ..DEVICE
    };
    let mut limit = OutputLimit::new(&device, 0.0);
    limit.enable(true);
    let mut torque = |demand: &Demand| {
        let mut faults = FaultSet::NONE;
        (limit.apply(demand, &mut faults).torque_nm, faults)
    };
    let with = |x: f32| Demand {
        torque_nm: Vec3::new(x, 0.0, 0.0),
        ..HALF_NEWTON
    };
    assert_eq!(
        torque(&with(0.02)),
        (Vec3::new(0.02, 0.0, 0.0), FaultSet::NONE)
    );
    let (slewed, faults) = torque(&with(9.0));
    assert!(near(slewed.x, 0.05) && faults.contains(Fault::Slewed));
    assert!(near(torque(&with(9.0)).0.x, 0.08));
    let (clamped, faults) = torque(&with(9.0));
    assert!(near(clamped.x, 0.1) && faults == only_fault(Fault::Clamped));
    assert_eq!(
        torque(&with(f32::NAN)),
        (Vec3::zeros(), only_fault(Fault::BadForce))
    );
}

fn hostile() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -10.0f32..10.0,
        1 => any::<f32>(),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::MAX),
    ]
}

fn demand() -> impl Strategy<Value = Demand> {
    let status = prop_oneof![
        6 => Just(Status::Live),
        1 => Just(Status::Absent),
        1 => Just(Status::Stale),
        1 => Just(Status::Lost),
    ];
    let force = (hostile(), hostile(), hostile(), hostile());
    (force, hostile(), hostile(), status, any::<bool>()).prop_map(|(f, k, v, device, paused)| {
        Demand {
            opening_n: 0.0,
            force_n: Vec3::new(f.0, f.1, f.2),
            torque_nm: Vec3::new(f.3, f.0, 0.0),
            stiffness_n_m: k,
            trocar_n: Vec3::zeros(),
            trocar_n_m: 0.0,
            handle_m: device.eq(&Status::Live).then_some(Vec3::new(f.1, f.2, k)),
            speed_m_s: v,
            device,
            device_fails: false,
            paused,
        }
    })
}

#[test]
fn a_peak_too_small_to_square_lets_nothing_through() {
    let device = DeviceCapabilities {
        force_max_n: 1.544_981_9e-21,
        ..DEVICE
    };
    let mut limit = OutputLimit::new(&device, 0.0);
    limit.enable(true);
    let (force_n, _) = apply(&mut limit, &HALF_NEWTON);
    assert!(force_n <= 0.0, "{force_n:?}");
}

proptest! {
    /// For any demand and any device, the output is finite, within the device's peak, rises no
    /// faster than the slew limit, and is zero while the device is lost.
    #[test]
    fn output_is_bounded_on_any_input(
        demands in prop::collection::vec((demand(), any::<bool>()), 1..200),
        peak in hostile(), continuous in hostile(), stiffness in hostile(), ramp in hostile(),
    ) {
        let device = DeviceCapabilities {
            force_max_n: peak,
            force_continuous_n: continuous,
            stiffness_max_n_m: stiffness,
            torque_max_nm: 0.1,
            ..DEVICE
        };
        let mut limit = OutputLimit::new(&device, ramp);
        limit.enable(true);
        let allowed = if peak.is_finite() { peak.max(0.0) } else { 0.0 };
        let mut last = 0.0;
        for (demand, enable) in demands {
            if enable {
                limit.enable(true);
            }
            let mut faults = FaultSet::NONE;
            let out = limit.apply(&demand, &mut faults);
            prop_assert!(is_finite(&out.force_n) && is_finite(&out.torque_nm));
            prop_assert!(norm(&out.torque_nm) <= 0.100_001);
            let length = norm(&out.force_n);
            prop_assert!(length <= allowed * 1.000_01, "{length} of {allowed}");
            prop_assert!(length <= last * 1.000_01 + 1.0001, "{last} to {length}");
            prop_assert!(demand.device != Status::Lost || length <= 0.0);
            last = length;
        }
    }
}
