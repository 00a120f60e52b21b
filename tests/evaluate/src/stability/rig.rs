//! A body in a test rig. Tests hold it, move it, hit it and let it go.

use crate::body::{Body, V3};
use crate::methods::{Env, Method, State, Surroundings, Way};

/// Length of a tick, s.
pub(super) const TICK_S: f32 = 1e-3;
/// Rate at which the velocity decays, 1/s, unless a test sets another.
pub(super) const DAMPING_PER_S: f32 = 20.0;
/// A body has come back when no sphere is farther from its rest position than this, m.
const BACK_M: f32 = 5e-4;
/// Smallest number of ticks in which a body may come back.
const BACK_TICKS: usize = 6000;
/// Shortest time in which a body may come back, s.
const BACK_S: f32 = 6.0;

/// A body with its supports and loads.
#[derive(Debug, Clone)]
pub(super) struct Stand<'a> {
    pub(super) body: &'a Body,
    pub(super) held: Vec<bool>,
    pub(super) gravity_m_s2: V3,
    pub(super) damping_per_s: f32,
    pub(super) dt_s: f32,
}

impl<'a> Stand<'a> {
    /// A weightless body with these spheres held.
    pub(super) fn new(body: &'a Body, held: Vec<bool>) -> Self {
        Self {
            body,
            held,
            gravity_m_s2: V3::zeros(),
            damping_per_s: DAMPING_PER_S,
            dt_s: TICK_S,
        }
    }

    /// Runs a test on a fresh body; `None` if the method refuses the body.
    pub(super) fn run<T>(&self, way: Way, test: impl FnOnce(&mut Rig<'_>) -> T) -> Option<T> {
        let mut body = self.body.clone();
        let mut around = Surroundings {
            gravity_m_s2: self.gravity_m_s2,
            damping_per_s: self.damping_per_s,
        };
        let substeps = way.substeps();
        let mut dt_s = self.dt_s / substeps as f32;
        if matches!(way, Way::Ours | Way::Paper(..)) {
            // Calot's tick is always 1 ms. For another time step, stiffness, damping and gravity
            // are scaled instead, because only E dt², c dt (c is the damping) and g dt² matter. The
            // scene's check limits these values.
            let ratio = self.dt_s / TICK_S;
            body.tissue.young_pa *= f64::from(ratio * ratio);
            around.gravity_m_s2 *= ratio * ratio;
            around.damping_per_s *= ratio;
            dt_s = TICK_S;
        }
        let mut parts = way.parts(&body, None, &around).ok()?;
        let method = way.method(&body, &mut parts).ok()?;
        let state = State::at_rest(&body, &self.held);
        let mut rig = Rig {
            body: &body,
            method,
            state,
            substeps,
            back_ticks: BACK_TICKS.max((BACK_S / self.dt_s) as usize),
            env: Env {
                dt_s,
                gravity_m_s2: around.gravity_m_s2,
                damping_per_s: around.damping_per_s,
            },
            ball: None,
        };
        Some(test(&mut rig))
    }
}

/// A body in motion.
pub(super) struct Rig<'a> {
    pub(super) body: &'a Body,
    method: Box<dyn Method + 'a>,
    pub(super) state: State,
    substeps: usize,
    back_ticks: usize,
    env: Env,
    /// A rigid ball that no sphere's centre may enter: centre and radius, m.
    pub(super) ball: Option<(V3, f32)>,
}

impl Rig<'_> {
    /// Runs one tick. Returns [`Self::is_sound`].
    pub(super) fn tick(&mut self) -> bool {
        for _ in 0..self.substeps {
            self.method.step(self.body, &mut self.state, &self.env);
        }
        if let Some((centre, radius)) = self.ball {
            self.push_out(&centre, radius);
        }
        self.is_sound()
    }

    /// Runs this many ticks. Returns false, and stops, if one of them fails.
    pub(super) fn ticks(&mut self, count: usize) -> bool {
        (0..count).all(|_| self.tick())
    }

    fn push_out(&mut self, centre: &V3, radius: f32) {
        for i in 0..self.state.u_m.len() {
            let arm = self.body.rest_m[i] + self.state.u_m[i] - centre;
            let distance = arm.norm();
            if self.state.w_per_kg[i] > 0.0 && distance < radius {
                let way = if distance > 1e-6 {
                    arm / distance
                } else {
                    V3::z()
                };
                let step = way * (radius - distance);
                self.state.u_m[i] += step;
                self.state.v_m_s[i] += step / (self.env.dt_s * self.substeps as f32);
                self.state.is_edited = true;
            }
        }
    }

    /// True if every displacement is below 10 m and every speed below 10⁶ m/s.
    pub(super) fn is_sound(&self) -> bool {
        let within = |v: &V3, most: f32| v.iter().all(|c| c.abs() < most);
        let (u, v) = (&self.state.u_m, &self.state.v_m_s);
        u.iter().all(|u| within(u, 10.0)) && v.iter().all(|v| within(v, 1e6))
    }

    /// Largest distance of a sphere from its rest position, m.
    pub(super) fn farthest_m(&self) -> f32 {
        self.state.u_m.iter().map(|u| u.norm()).fold(0.0, f32::max)
    }

    /// Displaces every free sphere and stops it.
    pub(super) fn place(&mut self, displacement: impl Fn(usize, &V3) -> V3) {
        for i in 0..self.state.u_m.len() {
            if self.state.w_per_kg[i] > 0.0 {
                self.state.u_m[i] = displacement(i, &self.body.rest_m[i]);
                self.state.v_m_s[i] = V3::zeros();
            }
        }
        self.state.is_edited = true;
    }

    /// Holds spheres where they are, or lets them go.
    pub(super) fn hold(&mut self, spheres: &[usize], held: bool) {
        for &i in spheres {
            self.state.w_per_kg[i] = if held {
                0.0
            } else {
                1.0 / self.body.mass_kg[i]
            };
            self.state.target_m[i] = self.state.u_m[i];
        }
    }

    /// Leaves the body alone. Returns true if every sphere comes back to its rest position within
    /// 0.5 mm.
    pub(super) fn comes_back(&mut self) -> bool {
        self.ball = None;
        for i in 0..self.back_ticks {
            if !self.tick() {
                return false;
            }
            if i % 50 == 49 && self.farthest_m() < BACK_M {
                return true;
            }
        }
        false
    }
}
