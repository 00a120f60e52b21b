//! Low-pass filter for the pose of the camera. A tracker's noise of 0.1 mm makes a close-up picture
//! tremble. A fixed low pass strong enough to hide the tremble would lag behind the hand.
//!
//! Method: the 1 € filter of Casiez, Roussel and Vogel (CHI 2012), a low pass whose corner
//! frequency rises with speed.

use nalgebra::UnitQuaternion;
use rt_core::math::Vec3;
use rt_core::time::TimeNs;

use super::wire::Record;

/// Default corner frequency at rest, Hz.
pub(super) const REST_HZ: f32 = 3.0;
/// Increase of the corner frequency per speed, Hz per m/s. At 0.1 m/s the picture lags by 2 ms.
const HZ_PER_M_S: f32 = 700.0;
/// Increase of the corner frequency per turning speed, Hz per rad/s.
const HZ_PER_RAD_S: f32 = 70.0;
/// Corner frequency of the low pass that smooths the measured speeds, Hz.
const SPEED_HZ: f32 = 3.0;
/// Time between two records above which the filter restarts, ns.
const GAP_NS: u64 = 200_000_000;

/// The filter and its state.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    last: Option<State>,
    /// Corner frequency at rest, Hz; 0 turns the filter off.
    rest_hz: f32,
}

#[derive(Debug, Clone, Copy)]
struct State {
    position_m: Vec3,
    rotation: UnitQuaternion<f32>,
    raw: (Vec3, UnitQuaternion<f32>),
    velocity_m_s: Vec3,
    turning_rad_s: Vec3,
    at_ns: TimeNs,
}

impl Filter {
    pub(super) const fn new(rest_hz: f32) -> Self {
        Self {
            last: None,
            rest_hz,
        }
    }

    /// Takes a record that arrived at `at_ns` and returns the filtered record.
    pub(super) fn update(&mut self, record: &Record, at_ns: TimeNs) -> Record {
        let raw = (Vec3::from(record.position_m), record.rotation);
        let fresh = State {
            position_m: raw.0,
            rotation: raw.1,
            raw,
            velocity_m_s: Vec3::zeros(),
            turning_rad_s: Vec3::zeros(),
            at_ns,
        };
        let next = match self.last {
            Some(last) if self.rest_hz > 0.0 && at_ns.saturating_sub(last.at_ns) < GAP_NS => {
                last.updated(raw, at_ns, self.rest_hz)
            }
            _ => fresh,
        };
        self.last = Some(next);
        Record {
            position_m: next.position_m.into(),
            rotation: next.rotation,
        }
    }
}

impl State {
    fn updated(self, raw: (Vec3, UnitQuaternion<f32>), at_ns: TimeNs, rest_hz: f32) -> Self {
        // Records that are read in one batch have equal times. The filter assumes 1 ms between
        // them.
        let dt_s = (at_ns.saturating_sub(self.at_ns) as f32 * 1e-9).max(1e-3);
        let turned = (self.raw.1.inverse() * raw.1).scaled_axis();
        let speed_weight = low_pass_weight(SPEED_HZ, dt_s);
        let velocity_m_s =
            self.velocity_m_s + ((raw.0 - self.raw.0) / dt_s - self.velocity_m_s) * speed_weight;
        let turning_rad_s =
            self.turning_rad_s + (turned / dt_s - self.turning_rad_s) * speed_weight;
        let position_weight = low_pass_weight(rest_hz + HZ_PER_M_S * velocity_m_s.norm(), dt_s);
        let rotation_weight = low_pass_weight(rest_hz + HZ_PER_RAD_S * turning_rad_s.norm(), dt_s);
        let off = (self.rotation.inverse() * raw.1).scaled_axis();
        Self {
            position_m: self.position_m + (raw.0 - self.position_m) * position_weight,
            rotation: UnitQuaternion::new_normalize(
                (self.rotation * UnitQuaternion::from_scaled_axis(off * rotation_weight))
                    .into_inner(),
            ),
            raw,
            velocity_m_s,
            turning_rad_s,
            at_ns,
        }
    }
}

/// Weight of the new value in a low pass of this corner frequency, `dt_s` after the previous value.
fn low_pass_weight(corner_hz: f32, dt_s: f32) -> f32 {
    let turns = std::f32::consts::TAU * corner_hz * dt_s;
    turns / (1.0 + turns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulate::Random;
    use proptest::prelude::*;

    const PERIOD_NS: u64 = 10_000_000;

    fn at(x: f32, angle: f32) -> Record {
        Record {
            position_m: [x, 0.0, -0.2],
            rotation: UnitQuaternion::from_scaled_axis(Vec3::new(0.0, angle, 0.0)),
        }
    }

    #[test]
    fn the_filter_removes_three_quarters_of_a_resting_sensors_noise() {
        let (mut filter, mut random) = (Filter::new(REST_HZ), Random::new(1, 1));
        let (mut raw, mut shown) = (0.0, 0.0);
        let mut before = (0.0, 0.0);
        for step in 0..1000u64 {
            let noise = random.between(-1e-4, 1e-4);
            let out = filter.update(&at(noise, 0.0), step * PERIOD_NS).position_m[0];
            if step > 100 {
                // Visible noise is the change from picture to picture.
                raw += (noise - before.0).powi(2);
                shown += (out - before.1).powi(2);
            }
            before = (noise, out);
        }
        assert!(shown < 0.05 * raw, "{shown} {raw}");
    }

    #[test]
    fn a_moving_endoscope_has_little_delay() {
        let mut filter = Filter::new(REST_HZ);
        let (speed_m_s, turning_rad_s) = (0.1, 1.0);
        let mut behind = (0.0, 0.0);
        for step in 0..200u64 {
            let t = step as f32 * 0.01;
            let out = filter.update(&at(speed_m_s * t, turning_rad_s * t), step * PERIOD_NS);
            let angle = out.rotation.angle();
            behind = (t - out.position_m[0] / speed_m_s, t - angle / turning_rad_s);
        }
        assert!(behind.0 < 0.004 && behind.1 < 0.004, "{behind:?} s");
    }

    #[test]
    fn the_filter_converges_to_a_resting_sensor_and_restarts_after_a_gap() {
        let mut filter = Filter::new(REST_HZ);
        let mut out = at(0.0, 0.0);
        for step in 0..300u64 {
            out = filter.update(&at(if step < 5 { 0.0 } else { 0.1 }, 0.3), step * PERIOD_NS);
        }
        assert!(
            (out.position_m[0] - 0.1).abs() < 1e-5 && (out.rotation.angle() - 0.3).abs() < 1e-4
        );
        out = filter.update(&at(0.4, 0.0), 300 * PERIOD_NS + GAP_NS);
        assert!((out.position_m[0] - 0.4).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn the_filtered_position_stays_within_the_measured_range(
            xs in prop::collection::vec((-0.9..0.9f32, -3.0..3.0f32, 0u64..40_000_000), 1..200),
        ) {
            let mut filter = Filter::new(REST_HZ);
            let mut now_ns = 0;
            for &(x, angle, after_ns) in &xs {
                now_ns += after_ns;
                let out = filter.update(&at(x, angle), now_ns);
                prop_assert!(out.position_m[0].abs() <= 0.9001);
                prop_assert!((out.rotation.norm() - 1.0).abs() < 1e-4);
            }
        }
    }
}
