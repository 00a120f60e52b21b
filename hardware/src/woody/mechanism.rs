//! The linkage: converts encoder counts to the handle's position, and a force to motor currents.
//!
//! Body A turns about the vertical; bodies B and C are the two links of a parallelogram. In the
//! makers' frame (x to the user, y to the right, z up), with angles tA, tB, tC:
//!
//! ```text
//! x = cos tA (Lb sin tB + Lc sin tC)
//! y = sin tA (Lb sin tB + Lc sin tC)
//! z = La + Lb cos tB − Lc cos tC
//! ```
//!
//! Our frame is x right, y up, z to the user. Source of structure and figures: WoodenHaptics'
//! CHAI3D driver and Haptikfabriken's API.

use nalgebra::{Matrix3, Vector3};
use rt_core::math::Vec3;

/// Geometry, drives and limits of one device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mechanism {
    /// Diameter of each motor's capstan, m.
    pub capstan_m: [f64; 3],
    /// Diameter of each body's drum, m.
    pub drum_m: [f64; 3],
    /// Lengths of the bodies A, B, C, m.
    pub length_m: [f64; 3],
    /// Centre of the workspace in the makers' frame, m.
    pub origin_m: [f64; 3],
    /// Radius of the workspace, m.
    pub radius_m: f64,
    /// Torque constant of each motor, N m/A.
    pub torque_constant_nm_a: [f64; 3],
    /// Counts per turn of each motor's encoder, all four edges.
    pub counts_per_turn: [f64; 3],
    /// Direction of each body with (1) or against (−1) its encoder.
    pub encoder_sign: [f64; 3],
    /// Direction of each body with (1) or against (−1) its current.
    pub motor_sign: [f64; 3],
    /// Angles of the bodies at count zero, rad.
    pub home_rad: [f64; 3],
    /// Largest current of a motor and its amplifier, A.
    pub current_max_a: f64,
    /// Peak force, N.
    pub force_max_n: f64,
    /// Continuous force, N.
    pub force_continuous_n: f64,
    /// Largest stable stiffness, N/m.
    pub stiffness_max_n_m: f64,
    /// Largest damping, N s/m.
    pub damping_max_n_s_m: f64,
    /// Damping of the device itself, N s/m.
    pub damping_n_s_m: f64,
    /// Delay from a movement to its sample plus delay from a command to its force, s.
    pub delay_s: f64,
}

impl Mechanism {
    /// The device as published. The continuous force is not published; a fifth of the peak is
    /// assumed. Damping and delay are not published either, so this table has those of the emulated
    /// device: the equivalent damping of its friction for a tremor of 0.2 m/s, and a delay of 1 ms
    /// each way.
    pub const WOODY: Self = Self {
        capstan_m: [0.010; 3],
        drum_m: [0.160, 0.120, 0.120],
        length_m: [0.080, 0.205, 0.245],
        origin_m: [0.220, 0.0, 0.080],
        radius_m: 0.100,
        torque_constant_nm_a: [0.0259; 3],
        counts_per_turn: [2000.0; 3],
        encoder_sign: [-1.0, -1.0, -1.0],
        motor_sign: [1.0, -1.0, -1.0],
        home_rad: [0.0, 0.0, std::f64::consts::FRAC_PI_2],
        current_max_a: 3.0,
        force_max_n: 5.0,
        force_continuous_n: 1.0,
        stiffness_max_n_m: 1000.0,
        damping_max_n_s_m: 8.0,
        damping_n_s_m: 0.84,
        delay_s: 0.002,
    };

    fn gear(&self, axis: usize) -> f64 {
        self.capstan_m[axis] / self.drum_m[axis]
    }

    /// Angles of the bodies, rad.
    #[must_use]
    pub fn angles_rad(&self, counts: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let motor_rad =
                std::f64::consts::TAU * f64::from(counts[axis]) / self.counts_per_turn[axis];
            self.home_rad[axis] + self.encoder_sign[axis] * motor_rad * self.gear(axis)
        })
    }

    /// Position of the handle, base frame, m.
    #[must_use]
    pub fn position_m(&self, angles_rad: [f64; 3]) -> Vec3 {
        let [a, b, c] = angles_rad;
        let [la, lb, lc] = self.length_m;
        let reach = lb * b.sin() + lc * c.sin();
        let makers = Vector3::new(
            a.cos() * reach,
            a.sin() * reach,
            la + lb * b.cos() - lc * c.cos(),
        ) - Vector3::from(self.origin_m);
        ours(makers).cast()
    }

    /// Currents that render `force_n` (base frame) at these angles, mA. If a motor cannot bear its
    /// current, all currents are scaled down together.
    #[must_use]
    pub fn currents_ma(&self, angles_rad: [f64; 3], force_n: Vec3) -> [i32; 3] {
        let torque = self.jacobian(angles_rad).transpose() * makers(force_n.cast());
        let currents_a: [f64; 3] = std::array::from_fn(|axis| {
            self.motor_sign[axis] * torque[axis] * self.gear(axis) / self.torque_constant_nm_a[axis]
        });
        let most = currents_a
            .iter()
            .fold(0.0f64, |most, current| most.max(current.abs()));
        let scale = if most > self.current_max_a {
            self.current_max_a / most
        } else {
            1.0
        };
        currents_a.map(|current| (current * scale * 1e3) as i32)
    }

    /// Force that these currents render at these angles, base frame, N. `None` if the links are in
    /// line.
    #[must_use]
    pub fn force_n(&self, angles_rad: [f64; 3], currents_ma: [i32; 3]) -> Option<Vec3> {
        let torque = Vector3::from_fn(|axis, _| {
            self.motor_sign[axis]
                * f64::from(currents_ma[axis])
                * 1e-3
                * self.torque_constant_nm_a[axis]
                / self.gear(axis)
        });
        let force = self.jacobian(angles_rad).transpose().try_inverse()? * torque;
        Some(ours(force).cast())
    }

    /// Encoder counts with the handle at `position_m`, base frame. If that position is out of
    /// reach, the counts are those of the nearest reachable position.
    #[must_use]
    pub fn counts(&self, position_m: Vec3) -> [i32; 3] {
        let at = makers(position_m.cast()) + Vector3::from(self.origin_m);
        let [la, lb, lc] = self.length_m;
        let (reach, height) = (at.x.hypot(at.y), at.z - la);
        let distance = reach.hypot(height).clamp((lb - lc).abs() + 1e-9, lb + lc);
        let cos = (lb * lb + distance * distance - lc * lc) / (2.0 * lb * distance);
        let b = reach.atan2(height) - cos.clamp(-1.0, 1.0).acos();
        let (sin_c, cos_c) = (reach - lb * b.sin(), -(height - lb * b.cos()));
        let angles = [at.y.atan2(at.x), b, sin_c.atan2(cos_c)];
        std::array::from_fn(|axis| {
            let motor_rad =
                (angles[axis] - self.home_rad[axis]) / (self.encoder_sign[axis] * self.gear(axis));
            (motor_rad / std::f64::consts::TAU * self.counts_per_turn[axis]).round() as i32
        })
    }

    /// Velocity of the handle per turning speed of each body, makers' frame, m/rad.
    fn jacobian(&self, angles_rad: [f64; 3]) -> Matrix3<f64> {
        let [a, b, c] = angles_rad;
        let [_, lb, lc] = self.length_m;
        let reach = lb * b.sin() + lc * c.sin();
        Matrix3::new(
            -a.sin() * reach,
            lb * a.cos() * b.cos(),
            lc * a.cos() * c.cos(),
            a.cos() * reach,
            lb * a.sin() * b.cos(),
            lc * a.sin() * c.cos(),
            0.0,
            -lb * b.sin(),
            lc * c.sin(),
        )
    }
}

/// Converts from the makers' axes (to the user, right, up) to ours (right, up, to the user).
fn ours(makers: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(makers.y, makers.z, makers.x)
}

/// Converts from our axes to the makers'.
fn makers(ours: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(ours.z, ours.x, ours.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WOODY: Mechanism = Mechanism::WOODY;

    #[test]
    fn links_at_home_are_perpendicular() {
        // tB = 0 and tC = 90°: B stands upright, C points to the user.
        let position = WOODY.position_m(WOODY.angles_rad([0; 3]));
        let expected = Vec3::new(0.0, 0.080 + 0.205 - 0.080, 0.245 - 0.220);
        assert!((position - expected).norm() < 1e-6, "{position}");
    }

    #[test]
    fn currents_are_limited_in_proportion() {
        let angles = WOODY.angles_rad(WOODY.counts(Vec3::zeros()));
        let force = Vec3::new(40.0, -20.0, 30.0);
        let currents = WOODY.currents_ma(angles, force);
        assert!(currents.iter().all(|current| current.abs() <= 3000));
        let rendered = WOODY.force_n(angles, currents).unwrap();
        assert!(rendered.normalize().dot(&force.normalize()) > 0.9999);
    }

    proptest! {
        #[test]
        fn encoder_counts_and_positions_agree(direction in prop::array::uniform3(-1.0..1.0f32),
                                      radius_m in 0.0..0.1f32) {
            let direction = Vec3::from(direction);
            prop_assume!(direction.norm() > 0.1);
            let sent = direction.normalize() * radius_m;
            let read = WOODY.position_m(WOODY.angles_rad(WOODY.counts(sent)));
            // Half a count of each encoder: at most 0.04 mm.
            prop_assert!((read - sent).norm() < 1e-4, "{read} {sent}");
        }

        /// Virtual work: the currents render the wanted force.
        #[test]
        fn currents_render_the_force(position in prop::array::uniform3(-0.05..0.05f32),
                                     force in prop::array::uniform3(-2.0..2.0f32)) {
            let angles = WOODY.angles_rad(WOODY.counts(position.into()));
            let force = Vec3::from(force);
            let rendered = WOODY.force_n(angles, WOODY.currents_ma(angles, force)).unwrap();
            prop_assert!((rendered - force).norm() < 0.02, "{rendered} {force}");
        }

        #[test]
        fn the_jacobian_is_the_slope_of_the_position(counts in prop::array::uniform3(-800..800i32)) {
            let angles = WOODY.angles_rad(counts);
            for axis in 0..3 {
                let mut moved = angles;
                moved[axis] += 1e-3;
                let slope: Vector3<f64> =
                    (WOODY.position_m(moved) - WOODY.position_m(angles)).cast() / 1e-3;
                let column = ours(WOODY.jacobian(angles).column(axis).into_owned());
                prop_assert!((slope - column).norm() < 1e-3, "{slope} {column}");
            }
        }
    }
}
