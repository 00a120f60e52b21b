//! A Touch-class haptic device as a body: a handle with mass, friction and damping between the
//! motors and the hand that holds it.

use rt_core::math::Vec3;

/// Integration steps per millisecond.
const SUBSTEPS: u32 = 10;
/// Length of one step, s.
const STEP_S: f32 = 1e-3 / SUBSTEPS as f32;

/// Mechanical properties of the device.
#[derive(Debug, Clone, Copy)]
pub struct Body {
    /// Apparent mass at the tip, kg.
    pub mass_kg: f32,
    /// Dry friction, N.
    pub friction_n: f32,
    /// Damping of the mechanism, N s/m.
    pub damping_n_s_m: f32,
    /// Encoder step at the tip, m.
    pub encoder_step_m: f32,
    /// Distance of the mechanical stops from the base frame's origin, m.
    pub workspace_radius_m: f32,
    /// Peak force of the motors, N.
    pub force_max_n: f32,
    /// Continuous force of the motors, N.
    pub force_continuous_n: f32,
}

impl Body {
    /// Figures of the Touch's data sheet: 45 g, 0.26 N, 0.055 mm, 3.3 N, 0.88 N. The damping of the
    /// hinges is small.
    pub const TOUCH: Self = Self {
        mass_kg: 0.045,
        friction_n: 0.26,
        damping_n_s_m: 0.2,
        encoder_step_m: 0.055e-3,
        workspace_radius_m: 0.1,
        force_max_n: 3.3,
        force_continuous_n: 0.88,
    };
}

/// The hand on the handle: a spring and a damper to its target.
#[derive(Debug, Clone, Copy)]
pub struct Grip {
    /// Stiffness, N/m.
    pub stiffness_n_m: f32,
    /// Damping, N s/m.
    pub damping_n_s_m: f32,
}

impl Grip {
    /// A precision grip on a stylus: a few hundred N/m, a few N s/m.
    pub const STYLUS: Self = Self {
        stiffness_n_m: 400.0,
        damping_n_s_m: 4.0,
    };
    /// No hand.
    pub const NONE: Self = Self {
        stiffness_n_m: 0.0,
        damping_n_s_m: 0.0,
    };
}

/// Stiffness of the mechanical stops, N/m.
const STOP_STIFFNESS_N_M: f32 = 8000.0;
/// Thermal time constant of the motors, s.
const HEAT_TIME_S: f32 = 20.0;
/// Weight of the newest speed in the reported velocity, which is smoothed as in the vendor's
/// driver.
const VELOCITY_BLEND: f32 = 0.2;

/// The device in motion, in its base frame.
#[derive(Debug, Clone)]
pub struct Touch {
    body: Body,
    grip: Grip,
    position_m: Vec3,
    velocity_m_s: Vec3,
    measured_m: Vec3,
    measured_velocity_m_s: Vec3,
    /// Force that was commanded in the last millisecond. The motors respond one millisecond later.
    pending_n: Vec3,
    /// Low-pass filtered square of the force, N². It models the motors' heat.
    heat_n2: f32,
    /// Constant force on the handle, N.
    load_n: Vec3,
}

impl Touch {
    /// A device at rest at `position_m`.
    #[must_use]
    pub fn new(body: Body, grip: Grip, position_m: Vec3) -> Self {
        Self {
            body,
            grip,
            position_m,
            velocity_m_s: Vec3::zeros(),
            measured_m: quantise(position_m, body.encoder_step_m),
            measured_velocity_m_s: Vec3::zeros(),
            pending_n: Vec3::zeros(),
            heat_n2: 0.0,
            load_n: Vec3::zeros(),
        }
    }

    /// The device with a constant force on its handle, N, for example a weight that is not
    /// balanced.
    #[must_use]
    pub fn loaded(mut self, load_n: Vec3) -> Self {
        self.load_n = load_n;
        self
    }

    /// Advances one millisecond. The motors render `force_n`; the hand pulls towards `target_m`,
    /// which moves at `target_velocity_m_s`.
    pub fn step(&mut self, target_m: Vec3, target_velocity_m_s: Vec3, force_n: Vec3) {
        let asked_n = std::mem::replace(&mut self.pending_n, force_n);
        let motors_n = self.motors(asked_n);
        for _ in 0..SUBSTEPS {
            let hand_n = (target_m - self.position_m) * self.grip.stiffness_n_m
                + (target_velocity_m_s - self.velocity_m_s) * self.grip.damping_n_s_m;
            let held_n = hand_n + self.load_n;
            let mut sum_n = held_n + motors_n - self.velocity_m_s * self.body.damping_n_s_m;
            let outside_m = self.position_m.norm() - self.body.workspace_radius_m;
            if outside_m > 0.0 {
                sum_n -= self.position_m.normalize() * (outside_m * STOP_STIFFNESS_N_M);
            }
            self.velocity_m_s += sum_n * (STEP_S / self.body.mass_kg);
            // Dry friction reduces speed but never reverses it.
            let speed = self.velocity_m_s.norm();
            let braked = (speed - self.body.friction_n * STEP_S / self.body.mass_kg).max(0.0);
            self.velocity_m_s *= if speed > 0.0 { braked / speed } else { 0.0 };
            self.position_m += self.velocity_m_s * STEP_S;
        }
        let measured_m = quantise(self.position_m, self.body.encoder_step_m);
        let rate_m_s = (measured_m - self.measured_m) / (SUBSTEPS as f32 * STEP_S);
        self.measured_velocity_m_s += (rate_m_s - self.measured_velocity_m_s) * VELOCITY_BLEND;
        self.measured_m = measured_m;
    }

    fn motors(&mut self, asked_n: Vec3) -> Vec3 {
        let warm = self.heat_n2.sqrt() >= self.body.force_continuous_n;
        let limit_n = if warm {
            self.body.force_continuous_n
        } else {
            self.body.force_max_n
        };
        let norm = asked_n.norm();
        let force_n = if norm > limit_n {
            asked_n * (limit_n / norm)
        } else {
            asked_n
        };
        self.heat_n2 += (force_n.norm_squared() - self.heat_n2) * (1e-3 / HEAT_TIME_S);
        force_n
    }

    /// Position from the encoders, m.
    #[must_use]
    pub fn measured_m(&self) -> Vec3 {
        self.measured_m
    }

    /// Reported velocity, m/s: smoothed encoder steps.
    #[must_use]
    pub fn measured_velocity_m_s(&self) -> Vec3 {
        self.measured_velocity_m_s
    }

    /// True if heat limits the motors to their continuous force.
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.heat_n2.sqrt() >= self.body.force_continuous_n
    }
}

fn quantise(position_m: Vec3, step_m: f32) -> Vec3 {
    position_m.map(|part| (part / step_m).round() * step_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(touch: &mut Touch, target: Vec3, force: Vec3) -> Vec3 {
        for _ in 0..2000 {
            touch.step(target, Vec3::zeros(), force);
        }
        touch.measured_m()
    }

    #[test]
    fn a_force_moves_the_hand_by_its_stiffness_less_friction() {
        let mut touch = Touch::new(Body::TOUCH, Grip::STYLUS, Vec3::zeros());
        let force_n = 2.0;
        let x = settle(&mut touch, Vec3::zeros(), Vec3::new(force_n, 0.0, 0.0)).x;
        let free = force_n / Grip::STYLUS.stiffness_n_m;
        let stuck = Body::TOUCH.friction_n / Grip::STYLUS.stiffness_n_m;
        assert!((free - stuck - 1e-4..=free + stuck).contains(&x), "{x}");
    }

    #[test]
    fn friction_holds_a_small_force() {
        let mut touch = Touch::new(Body::TOUCH, Grip::STYLUS, Vec3::zeros());
        assert_eq!(
            settle(&mut touch, Vec3::zeros(), Vec3::new(0.2, 0.0, 0.0)),
            Vec3::zeros()
        );
    }

    #[test]
    fn the_stops_keep_the_handle_in_the_workspace() {
        let mut touch = Touch::new(Body::TOUCH, Grip::STYLUS, Vec3::zeros());
        let reached = settle(&mut touch, Vec3::new(0.2, 0.0, 0.0), Vec3::zeros());
        assert!(reached.x < 0.106, "{reached}");
    }

    #[test]
    fn positions_come_in_encoder_steps() {
        let mut touch = Touch::new(Body::TOUCH, Grip::STYLUS, Vec3::zeros());
        let x = settle(&mut touch, Vec3::new(0.0123, 0.0, 0.0), Vec3::zeros()).x;
        let steps = x / Body::TOUCH.encoder_step_m;
        assert!((steps - steps.round()).abs() < 1e-2, "{steps}");
    }

    #[test]
    fn the_device_limits_a_strong_force_of_long_duration() {
        let mut touch = Touch::new(Body::TOUCH, Grip::STYLUS, Vec3::zeros());
        let force = Vec3::new(3.3, 0.0, 0.0);
        settle(&mut touch, Vec3::zeros(), force);
        assert!(touch.is_limited());
        // At the continuous force, the heat stays near the limit.
        for _ in 0..20_000 {
            touch.step(Vec3::zeros(), Vec3::zeros(), force);
        }
        let x = touch.measured_m().x;
        let expected = Body::TOUCH.force_continuous_n / Grip::STYLUS.stiffness_n_m;
        assert!(x < 2.0 * expected, "{x} {expected}");
    }

    /// Peak-to-peak movement of the handle, m, after the hand has pressed it for a second into a
    /// wall of this stiffness.
    fn trembling_m(wall_n_m: f32) -> f32 {
        let mut touch = Touch::new(Body::TOUCH, Grip::STYLUS, Vec3::zeros());
        let pressed_m = Vec3::new(-0.005, 0.0, 0.0);
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for ms in 0..2000 {
            let depth_m = (-touch.measured_m().x).max(0.0);
            touch.step(
                pressed_m,
                Vec3::zeros(),
                Vec3::new(depth_m * wall_n_m, 0.0, 0.0),
            );
            if ms >= 1000 {
                low = low.min(touch.measured_m().x);
                high = high.max(touch.measured_m().x);
            }
        }
        high - low
    }

    #[test]
    fn a_wall_within_the_devices_limit_is_stable_and_one_far_beyond_oscillates() {
        let step_m = Body::TOUCH.encoder_step_m;
        let stiffness = 700.0;
        assert!(
            trembling_m(stiffness) < 1.5 * step_m,
            "{}",
            trembling_m(stiffness)
        );
        assert!(
            trembling_m(20.0 * stiffness) > 5.0 * step_m,
            "{}",
            trembling_m(20.0 * stiffness)
        );
    }
}
