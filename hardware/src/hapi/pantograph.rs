//! The linkage, which moves in a plane. Each of two motors turns a near arm. Two far arms join the
//! ends of the near arms at the handle.
//!
//! In the makers' frame, x points from motor 1 to motor 2, and y to the side of the handle. Near
//! arm 1 turns about (0, 0), near arm 2 about (`apart_m`, 0). The device lies on the table with its
//! motors away from the user. So the makers' x points to the user's left, and their y to the user.
//! In our frame x points right, y up and z to the user. The device neither measures nor renders
//! anything along our y.

use nalgebra::{Matrix2, Vector2};
use rt_core::math::Vec3;

use super::wire::{ARMS, Port};

/// Smallest sine of the angle between the far arms at which force is rendered. At a smaller angle,
/// the torques for a force exceed what the motors can render.
const SINE_MIN: f64 = 0.1;

/// Arms, encoders, drives and limits of one generation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pantograph {
    /// Length of the arms on the motors, m.
    pub near_m: f64,
    /// Length of the arms at the handle, m.
    pub far_m: f64,
    /// Distance between the motors, m.
    pub apart_m: f64,
    /// Angles of near arms 1 and 2 with the handle at home, degrees.
    pub home_deg: [f32; ARMS],
    /// Encoder counts per turn of the arm.
    pub counts_per_turn: f32,
    /// For arms 1 and 2: true if the board has to reverse the motor.
    pub motor_reversed: [bool; ARMS],
    /// For arms 1 and 2: true if the board has to reverse the encoder's count.
    pub encoder_reversed: [bool; ARMS],
    /// Torque to send to the board, divided by the torque at the arm.
    pub motor_share: f64,
    /// Torque limit of the board, N m.
    pub torque_max_nm: f64,
    /// Centre of the workspace in the makers' frame, m.
    pub origin_m: [f64; 2],
    /// Radius of the workspace, m.
    pub radius_m: f64,
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
    /// Sum of two delays, s: from a movement to its sample, and from a command to its force.
    pub delay_s: f64,
}

impl Pantograph {
    /// The second generation, both motors on one axis.
    ///
    /// Arms and encoders are as published. The gear is not published. The makers use two factors
    /// for the torque, 1 and 0.1, and Calot uses the lower one. So the force is too high only if
    /// the gear is above 10. Force, stiffness, damping and delay are not published either; low
    /// values are assumed.
    pub const GEN2: Self = Self {
        near_m: 0.07,
        far_m: 0.09,
        apart_m: 0.0,
        home_deg: [241.0, -61.0],
        counts_per_turn: 10_752.0,
        motor_reversed: [true, false],
        encoder_reversed: [true, false],
        motor_share: 0.1,
        torque_max_nm: 0.123,
        origin_m: [0.0, 0.095],
        radius_m: 0.05,
        force_max_n: 3.0,
        force_continuous_n: 0.6,
        stiffness_max_n_m: 500.0,
        damping_max_n_s_m: 4.0,
        damping_n_s_m: 0.2,
        delay_s: 0.002,
    };

    /// The third generation, motors side by side.
    pub const GEN3: Self = Self {
        apart_m: 0.038,
        home_deg: [180.0, 0.0],
        counts_per_turn: 4880.0,
        motor_reversed: [false, false],
        encoder_reversed: [true, true],
        origin_m: [0.019, 0.095],
        ..Self::GEN2
    };

    /// The revised third generation: another home position, motors reversed.
    pub const GEN3_1: Self = Self {
        home_deg: [168.0, 12.0],
        motor_reversed: [true, true],
        ..Self::GEN3
    };

    /// Generation with this name: `gen2`, `gen3` or `gen3.1`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "gen2" => Self::GEN2,
            "gen3" => Self::GEN3,
            "gen3.1" => Self::GEN3_1,
            _ => return None,
        })
    }

    /// Set-up of the board's ports with the arms at these angles. Arm 1 is at port 2.
    #[must_use]
    pub fn ports(&self, angles_deg: [f32; ARMS]) -> [Port; ARMS] {
        let arms: [Port; ARMS] = std::array::from_fn(|arm| Port {
            motor_reversed: self.motor_reversed[arm],
            encoder_reversed: self.encoder_reversed[arm],
            angle_deg: angles_deg[arm],
            counts_per_turn: self.counts_per_turn,
        });
        swapped(arms)
    }

    /// Position of the handle, base frame, m. `None` if the far arms do not meet at these angles.
    #[must_use]
    pub fn position_m(&self, angles_deg: [f32; ARMS]) -> Option<Vec3> {
        let joint = self.joint(&self.elbows(angles_deg))?;
        Some(self.ours(&joint))
    }

    /// Torques to send for arms 1 and 2, N m. They render the part of `force_n` (base frame) that
    /// lies in the plane. If one of them exceeds the board's limit, both are scaled down alike, so
    /// the force keeps its direction. `None` if the far arms are nearly in line or do not meet.
    #[must_use]
    pub fn torques_nm(&self, angles_deg: [f32; ARMS], force_n: Vec3) -> Option<[f32; ARMS]> {
        let makers_n = Vector2::new(-f64::from(force_n.x), f64::from(force_n.z));
        let torques = self.jacobian(angles_deg)?.transpose() * makers_n * self.motor_share;
        let most = torques.amax();
        let scale = if most > self.torque_max_nm {
            self.torque_max_nm / most
        } else {
            1.0
        };
        Some((torques * scale).cast().into())
    }

    /// Force that these torques render if the gear is as assumed, base frame, N. `None` if the far
    /// arms are nearly in line or do not meet.
    #[must_use]
    pub fn force_n(&self, angles_deg: [f32; ARMS], motor_torques_nm: [f32; ARMS]) -> Option<Vec3> {
        let arms_nm = Vector2::from(motor_torques_nm).cast::<f64>() / self.motor_share;
        let makers_n = self.jacobian(angles_deg)?.transpose().try_inverse()? * arms_nm;
        Some(Vec3::new(-makers_n.x as f32, 0.0, makers_n.y as f32))
    }

    /// Angles of arms 1 and 2, degrees, for a handle position in the base frame. The height of the
    /// position is ignored. If an arm cannot reach the position, its angle is computed for the
    /// nearest distance within its reach.
    #[must_use]
    pub fn angles_deg(&self, position_m: Vec3) -> [f32; ARMS] {
        let [x, y] = self.origin_m;
        let at = Vector2::new(x - f64::from(position_m.x), y + f64::from(position_m.z));
        let angle = |from: Vector2<f64>, side: f64| {
            let way = at - from;
            let distance = way.norm().clamp(
                (self.far_m - self.near_m).abs() + 1e-6,
                self.near_m + self.far_m - 1e-6,
            );
            let cos = (self.near_m * self.near_m + distance * distance - self.far_m * self.far_m)
                / (2.0 * self.near_m * distance);
            (way.y.atan2(way.x) + side * cos.clamp(-1.0, 1.0).acos()).to_degrees() as f32
        };
        let [one, two] = self.motors();
        [angle(one, 1.0), angle(two, -1.0)]
    }

    fn motors(&self) -> [Vector2<f64>; ARMS] {
        [Vector2::zeros(), Vector2::new(self.apart_m, 0.0)]
    }

    /// Ends of the near arms.
    fn elbows(&self, angles_deg: [f32; ARMS]) -> [Vector2<f64>; ARMS] {
        let motors = self.motors();
        std::array::from_fn(|arm| {
            let angle = f64::from(angles_deg[arm]).to_radians();
            motors[arm] + Vector2::new(angle.cos(), angle.sin()) * self.near_m
        })
    }

    /// Point at which the far arms meet, on the side of the handle. `None` if they do not meet.
    fn joint(&self, [one, two]: &[Vector2<f64>; ARMS]) -> Option<Vector2<f64>> {
        let between = two - one;
        let half = between.norm() / 2.0;
        if !(1e-6..self.far_m).contains(&half) {
            return None;
        }
        let height = (self.far_m * self.far_m - half * half).sqrt();
        let out = Vector2::new(-between.y, between.x) / (2.0 * half);
        Some((one + two) / 2.0 + out * height)
    }

    /// Velocity of the handle per turning speed of the arms, makers' frame, m/rad. A far arm keeps
    /// its length, so handle and elbow have the same velocity along that arm.
    fn jacobian(&self, angles_deg: [f32; ARMS]) -> Option<Matrix2<f64>> {
        let elbows = self.elbows(angles_deg);
        let joint = self.joint(&elbows)?;
        let motors = self.motors();
        let far: [Vector2<f64>; ARMS] = std::array::from_fn(|arm| joint - elbows[arm]);
        let along: [f64; ARMS] = std::array::from_fn(|arm| {
            let near = elbows[arm] - motors[arm];
            far[arm].dot(&Vector2::new(-near.y, near.x))
        });
        let [a, b] = far;
        if a.perp(&b).abs() < SINE_MIN * self.far_m * self.far_m {
            return None;
        }
        let rows = Matrix2::new(a.x, a.y, b.x, b.y);
        Some(rows.try_inverse()? * Matrix2::from_diagonal(&along.into()))
    }

    fn ours(&self, joint: &Vector2<f64>) -> Vec3 {
        let [x, y] = self.origin_m;
        Vec3::new((x - joint.x) as f32, 0.0, (joint.y - y) as f32)
    }
}

/// Reorders from arms to ports, and back.
#[must_use]
pub fn swapped<T>([one, two]: [T; ARMS]) -> [T; ARMS] {
    [two, one]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [Pantograph; 3] = [Pantograph::GEN2, Pantograph::GEN3, Pantograph::GEN3_1];

    #[test]
    fn handle_at_home_is_in_the_middle_and_near_the_motors() {
        for generation in ALL {
            let home = generation.position_m(generation.home_deg).unwrap();
            assert!(home.x.abs() < 1e-3 && home.z < -0.03, "{home}");
            assert!(home.y.abs() < 1e-9);
        }
        // By hand: at 180° and 0° each elbow is 89 mm to one side of the middle.
        let home = Pantograph::GEN3.position_m([180.0, 0.0]).unwrap();
        let height = (0.09f32.powi(2) - 0.089f32.powi(2)).sqrt();
        assert!((home.z - (height - 0.095)).abs() < 1e-6, "{home}");
    }

    #[test]
    fn the_force_is_limited_by_the_motors_and_has_no_part_out_of_the_plane() {
        let generation = Pantograph::GEN3;
        let angles = generation.angles_deg(Vec3::zeros());
        let force = Vec3::new(300.0, 40.0, -200.0);
        let torques = generation.torques_nm(angles, force).unwrap();
        assert!(
            torques.iter().all(|torque| torque.abs() <= 0.1231),
            "{torques:?}"
        );
        let rendered = generation.force_n(angles, torques).unwrap();
        assert!(rendered.y.abs() < 1e-9);
        let plane = Vec3::new(force.x, 0.0, force.z);
        assert!(rendered.normalize().dot(&plane.normalize()) > 0.9999);
        let up = generation
            .torques_nm(angles, Vec3::new(0.0, 3.0, 0.0))
            .unwrap();
        assert!(up.iter().all(|torque| torque.abs() < 1e-9));
    }

    #[test]
    fn arms_that_do_not_meet_have_no_position_and_stretched_arms_no_force() {
        let wide = Pantograph {
            apart_m: 0.1,
            ..Pantograph::GEN3
        };
        assert_eq!(wide.position_m([180.0, 0.0]), None);
        assert_eq!(wide.torques_nm([180.0, 0.0], Vec3::x()), None);
        let out = Pantograph::GEN2.angles_deg(Vec3::new(0.0, 0.0, 0.2));
        assert_eq!(Pantograph::GEN2.torques_nm(out, Vec3::x()), None);
    }

    #[test]
    fn each_arm_is_on_the_port_of_the_other_side() {
        let ports = Pantograph::GEN2.ports([241.0, -61.0]);
        assert!(ports[0].angle_deg < 0.0 && ports[1].angle_deg > 240.0);
        assert_eq!(ports.map(|port| port.motor_reversed), [false, true]);
    }

    fn place() -> impl Strategy<Value = Vec3> {
        (0.0..0.045f32, 0.0..std::f32::consts::TAU)
            .prop_map(|(radius, angle)| Vec3::new(radius * angle.cos(), 0.0, radius * angle.sin()))
    }

    proptest! {
        #[test]
        fn angles_and_places_agree(place in place(), which in 0usize..3) {
            let angles = ALL[which].angles_deg(place);
            let read = ALL[which].position_m(angles).unwrap();
            prop_assert!((read - place).norm() < 1e-6, "{read} {place}");
        }

        /// Virtual work: the work of the torques at the arms equals the work of the force at the
        /// handle.
        #[test]
        fn torques_render_the_force(
            place in place(),
            force in prop::array::uniform2(-1.0..1.0f32),
            turn in prop::array::uniform2(-0.05..0.05f32),
            which in 0usize..3,
        ) {
            let generation = ALL[which];
            let angles = generation.angles_deg(place);
            let force = Vec3::new(force[0], 0.0, force[1]);
            let torques = generation.torques_nm(angles, force).unwrap();
            let turned: [f32; 2] = std::array::from_fn(|arm| angles[arm] + turn[arm]);
            let back: [f32; 2] = std::array::from_fn(|arm| angles[arm] - turn[arm]);
            let moved = generation.position_m(turned).unwrap() - generation.position_m(back).unwrap();
            let work: f32 = (0..2)
                .map(|arm| torques[arm] / 0.1 * 2.0 * turn[arm].to_radians())
                .sum();
            prop_assert!((force.dot(&moved) - work).abs() < 2e-6, "{work}");
            let rendered = generation.force_n(angles, torques).unwrap();
            prop_assert!((rendered - force).norm() < 1e-4, "{rendered} {force}");
        }
    }
}
