//! Capabilities of each model.
//!
//! The library reports no capabilities. Forces, torques and stiffness come from CHAI3D
//! (`CDeltaDevices.cpp`, 3.2). The peak force of a sigma.7 comes from its makers (Tobergte et al.,
//! "The sigma.7 haptic interface for MiroSurge", IROS 2011). They state twice the torque that this
//! table has. Neither source has a lambda, so it gets CHAI3D's figures for a sigma.7. The
//! workspace's radius is half the diagonal of the workspace in the maker's leaflets, plus a margin.
//!
//! A gripper opens by 25 mm and renders 8 N (leaflets of omega.7 and sigma.7); 1000 N/m is CHAI3D's
//! figure for grippers.
//!
//! For all models the device's own damping is assumed, and the delay is that of a Touch on USB.
//! CHAI3D's largest damping is meant for loops of 4 kHz, so this table has a third of it. No source
//! states a continuous force. The table assumes half of the peak; 60 % for a sigma.7, less than
//! half for a Falcon.

use rt_core::port::{DeviceCapabilities, Opening};

use super::library::Parts;

/// Rate of the thread that serves the device, Hz. The library permits up to 4000 Hz, but the tick
/// takes only 1000 samples per second.
pub(super) const RATE_HZ: f32 = 1000.0;

const OMEGA: DeviceCapabilities = DeviceCapabilities {
    opening: Opening::NONE,
    force_max_n: 12.0,
    force_continuous_n: 6.0,
    torque_max_nm: 0.0,
    stiffness_max_n_m: 5000.0,
    damping_max_n_s_m: 10.0,
    damping_n_s_m: 1.0,
    delay_s: 0.002,
    workspace_radius_m: 0.1, // a cylinder of 160 × 110 mm
    rate_hz: RATE_HZ,
};

const DELTA: DeviceCapabilities = DeviceCapabilities {
    force_max_n: 20.0,
    force_continuous_n: 10.0,
    workspace_radius_m: 0.24, // 400 × 260 mm
    ..OMEGA
};

const SIGMA: DeviceCapabilities = DeviceCapabilities {
    force_max_n: 20.0,
    force_continuous_n: 12.0,
    torque_max_nm: 0.2,
    stiffness_max_n_m: 4000.0,
    workspace_radius_m: 0.14, // 190 × 130 mm, which lie 22 mm beside the origin
    ..OMEGA
};

const LAMBDA: DeviceCapabilities = DeviceCapabilities {
    force_max_n: 12.0,
    force_continuous_n: 6.0,
    workspace_radius_m: 0.16, // 240 × 170 mm
    ..SIGMA
};

const FALCON: DeviceCapabilities = DeviceCapabilities {
    force_max_n: 8.0,
    force_continuous_n: 2.5,
    stiffness_max_n_m: 3000.0,
    damping_max_n_s_m: 7.0,
    workspace_radius_m: 0.09, // a cube of 4 inches
    ..OMEGA
};

/// Capabilities of a model that this table lacks. They are low until somebody adds its figures.
const UNKNOWN: DeviceCapabilities = DeviceCapabilities {
    force_max_n: 3.0,
    force_continuous_n: 1.0,
    stiffness_max_n_m: 500.0,
    damping_max_n_s_m: 2.0,
    damping_n_s_m: 0.5,
    workspace_radius_m: 0.25,
    ..OMEGA
};

/// Distance by which the fingers move from a shut gripper to a wide open one, m.
const GRIPPER_TRAVEL_M: f32 = 0.025;
/// Largest force of a gripper, N.
pub(super) const GRIPPER_MAX_N: f32 = 8.0;
const GRIPPER_N_M: f32 = 1000.0;

/// Capabilities of a model by its number in `dhdc.h`. A device without motors in its wrist renders
/// no torque, and a device without a motor in its gripper renders no force on the fingers.
pub(super) fn capabilities(number: i32, parts: Parts) -> DeviceCapabilities {
    let known = match number {
        33..=37 => OMEGA,
        63 => DELTA,
        104..=107 | 206 => SIGMA,
        108 | 109 | 203 => LAMBDA,
        60 => FALCON,
        _ => UNKNOWN,
    };
    DeviceCapabilities {
        opening: match (parts.has_gripper, parts.has_active_gripper) {
            (false, _) => Opening::NONE,
            (true, is_active) => Opening {
                travel_m: GRIPPER_TRAVEL_M,
                force_max_n: if is_active { GRIPPER_MAX_N } else { 0.0 },
                stiffness_max_n_m: if is_active { GRIPPER_N_M } else { 0.0 },
            },
        },
        torque_max_nm: if parts.has_active_wrist {
            known.torque_max_nm
        } else {
            0.0
        },
        ..known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Parts = Parts {
        has_wrist: true,
        has_active_wrist: true,
        has_gripper: true,
        has_active_gripper: true,
        is_left_handed: false,
    };
    const NO_MOTORS: Parts = Parts {
        has_active_wrist: false,
        has_active_gripper: false,
        ..ALL
    };

    #[test]
    fn every_model_has_plausible_figures() {
        for number in (0..300).chain([-1]) {
            let found = capabilities(number, ALL);
            let numbers = [
                found.force_continuous_n,
                found.stiffness_max_n_m,
                found.damping_max_n_s_m,
                found.damping_n_s_m,
                found.delay_s,
            ];
            assert!(numbers.iter().all(|number| *number > 0.0), "{number}");
            assert!(found.force_continuous_n <= found.force_max_n, "{number}");
            assert!((0.05..=0.3).contains(&found.workspace_radius_m), "{number}");
            assert!(
                !capabilities(number, NO_MOTORS).renders_torque(),
                "{number}"
            );
        }
    }

    #[test]
    fn an_unknown_model_has_less_force_than_any_known_one() {
        let unknown = capabilities(91, ALL);
        for number in [33, 35, 63, 104, 108, 60] {
            let known = capabilities(number, ALL);
            assert!(unknown.force_max_n < known.force_max_n, "{number}");
            assert!(unknown.stiffness_max_n_m < known.stiffness_max_n_m);
        }
        assert!(!unknown.renders_torque());
    }
}
