//! The methods on the chart, one module each. The published methods follow their equations in
//! single precision, on one thread, without hand-written vector instructions. `product` runs
//! Calot's own solvers.

mod hexahedra;
mod mass_spring;
mod neo_hookean;
mod paper_pbd;
mod product;
mod stretch_volume;
mod xpbd_springs;

pub(crate) use hexahedra::Hexahedra;
pub(crate) use mass_spring::MassSpring;
pub(crate) use neo_hookean::NeoHookean;
pub(crate) use paper_pbd::PaperPbd;
pub(crate) use product::Parts;
pub(crate) use stretch_volume::StretchVolume;
pub(crate) use xpbd_springs::XpbdSprings;

use scene_prepare::skin::ContactSkin;

use crate::body::{Body, Tissue, V3};

/// Moving state of a body.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// Displacement from rest, m.
    pub(crate) u_m: Vec<V3>,
    /// Velocity, m/s.
    pub(crate) v_m_s: Vec<V3>,
    /// This step's displacement so far, m.
    pub(crate) d_m: Vec<V3>,
    /// Inverse mass, 1/kg; 0 for held spheres.
    pub(crate) w_per_kg: Vec<f32>,
    /// Displacement of the held spheres from rest at the end of the step, m.
    pub(crate) target_m: Vec<V3>,
    /// Force of the method on each held sphere, N.
    pub(crate) pull_n: Vec<V3>,
    /// True if positions or velocities were changed from outside since the last step.
    pub(crate) is_edited: bool,
    /// Number of spheres that the method put back, because they were not finite or far away.
    pub(crate) put_back: u32,
    /// The pressing ball at the end of the step.
    pub(crate) ball: Option<Ball>,
    /// Force on the ball, as a running mean over steps, N.
    pub(crate) ball_force_n: V3,
}

/// A rigid, frictionless ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball {
    /// The ball's centre, m.
    pub(crate) center_m: V3,
    /// The ball's radius, m.
    pub(crate) radius_m: f32,
}

/// Weight of one step in [`State::ball_force_n`].
const FORCE_SHARE: f32 = 0.02;

impl Ball {
    /// Displacement that moves a sphere out of the ball, m; `None` if they do not touch.
    pub(crate) fn pushes(&self, center_m: &V3, radius_m: f32) -> Option<V3> {
        let arm = center_m - self.center_m;
        let distance = arm.norm();
        let depth = self.radius_m + radius_m - distance;
        (depth > 0.0 && distance > 0.0).then(|| arm * (depth / distance))
    }
}

/// Length of a step, and the loads in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Env {
    /// Length of the step, s.
    pub(crate) dt_s: f32,
    /// Gravity, m/s².
    pub gravity_m_s2: V3,
    /// Rate at which the velocity decays, 1/s.
    pub(crate) damping_per_s: f32,
}

/// Gravity and damping, which act on a body all the time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surroundings {
    /// Gravity, m/s².
    pub(crate) gravity_m_s2: V3,
    /// Rate at which the velocity decays, 1/s.
    pub(crate) damping_per_s: f32,
}

impl Surroundings {
    /// No gravity, and Calot's damping.
    pub(crate) fn weightless(tissue: &Tissue) -> Self {
        Self {
            gravity_m_s2: V3::zeros(),
            damping_per_s: tissue.damping_per_s() as f32,
        }
    }
}

/// A method that moves a body step by step.
pub(crate) trait Method {
    /// Moves the state by one step.
    fn step(&mut self, body: &Body, state: &mut State, env: &Env);
}

impl State {
    /// A body at rest. Spheres marked in `held` follow `target_m`.
    pub(crate) fn at_rest(body: &Body, held: &[bool]) -> Self {
        let n = body.rest_m.len();
        let weight = |(m, held): (&f32, &bool)| if *held { 0.0 } else { 1.0 / m };
        Self {
            u_m: vec![V3::zeros(); n],
            v_m_s: vec![V3::zeros(); n],
            d_m: vec![V3::zeros(); n],
            w_per_kg: body.mass_kg.iter().zip(held).map(weight).collect(),
            target_m: vec![V3::zeros(); n],
            pull_n: vec![V3::zeros(); n],
            is_edited: false,
            put_back: 0,
            ball: None,
            ball_force_n: V3::zeros(),
        }
    }

    /// Moves free spheres out of the ball, by position, as the last constraint of a step.
    pub(crate) fn touch(&mut self, body: &Body, dt_s: f32) {
        let Some(ball) = self.ball else { return };
        let mut force = V3::zeros();
        for i in (0..self.u_m.len()).filter(|&i| self.w_per_kg[i] > 0.0) {
            let center = body.rest_m[i] + self.u_m[i];
            if let Some(step) = ball.pushes(&center, body.radius_m[i]) {
                self.u_m[i] += step;
                self.v_m_s[i] += step / dt_s;
                force -= step * (body.mass_kg[i] / (dt_s * dt_s));
            }
        }
        self.feel(&force);
    }

    /// Adds the force of a step on the ball to its mean, N.
    pub(crate) fn feel(&mut self, force_n: &V3) {
        self.ball_force_n += (force_n - self.ball_force_n) * FORCE_SHARE;
    }

    /// Displacement of a sphere from rest, as predicted and corrected so far, m.
    #[inline]
    fn now(&self, i: usize) -> V3 {
        self.u_m[i] + self.d_m[i]
    }

    /// Moves a sphere by `impulse` (kg m) times its inverse mass. If the sphere is held, the
    /// impulse is added to the force on it.
    #[inline]
    fn push(&mut self, i: usize, impulse: V3, dt_s: f32) {
        self.d_m[i] += impulse * self.w_per_kg[i];
        if self.w_per_kg[i] <= 0.0 {
            self.pull_n[i] += impulse / (dt_s * dt_s);
        }
    }

    /// First half of a step of position-based dynamics: moves the spheres without constraints.
    fn predict(&mut self, env: &Env) {
        let keep = 1.0 - env.damping_per_s * env.dt_s;
        for i in 0..self.u_m.len() {
            self.pull_n[i] = V3::zeros();
            self.d_m[i] = if self.w_per_kg[i] > 0.0 {
                (self.v_m_s[i] * keep + env.gravity_m_s2 * env.dt_s) * env.dt_s
            } else {
                self.target_m[i] - self.u_m[i]
            };
        }
    }

    /// Second half of such a step: computes the velocities from the displacements.
    fn advance(&mut self, env: &Env) {
        for i in 0..self.u_m.len() {
            self.v_m_s[i] = self.d_m[i] / env.dt_s;
            self.u_m[i] += self.d_m[i];
        }
    }
}

/// Stiffness of an edge, chosen so that the edges alone resist shear as the tissue does, N/m.
pub(crate) fn edge_stiffness(body: &Body, edge: &crate::body::Edge) -> f32 {
    15.0 * body.tissue.mu() as f32 * edge.volume_m3 / (edge.length_m * edge.length_m)
}

/// A method with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Way {
    /// Springs on every edge, explicit Euler.
    ExplicitSprings,
    /// Springs on every edge, semi-implicit Euler.
    Springs,
    /// The paper's inner spheres as Calot computes them: stiffness and iterations.
    Paper(f32, u32),
    /// Position-based dynamics: stretch of the edges, of which each step corrects this share, and
    /// volumes of the tetrahedra.
    StretchVolume(f32),
    /// Compliant springs and volumes.
    XpbdSprings,
    /// Calot's neo-Hookean solid.
    Ours,
    /// Calot's tetrahedra, each projected once per step, starting from zero multipliers.
    FromZero,
    /// Implicit corotational hexahedra, on a body of their own.
    Hexahedra,
}

impl Way {
    /// Name of the method without its settings.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::ExplicitSprings => "mass-spring, explicit Euler (paper's)",
            Self::Springs => "mass-spring, semi-implicit",
            Self::Paper(k, _) if k >= 1.0 => "inner spheres (paper's), k = 1",
            Self::Paper(..) => "inner spheres (paper's), k fitted",
            Self::StretchVolume(k) if k >= 1.0 => "PBD stretch + volume (paper's), k = 1",
            Self::StretchVolume(_) => "PBD stretch + volume (paper's), k fitted",
            Self::XpbdSprings => "XPBD springs + volume",
            Self::Ours => "Calot",
            Self::FromZero => "neo-Hookean XPBD, one pass from zero",
            Self::Hexahedra => "corotational hexahedra (paper's FEM)",
        }
    }

    /// True if a method of this program has this name. Other names are those of competitors.
    pub(crate) fn is_named(name: &str) -> bool {
        [
            Self::ExplicitSprings,
            Self::Springs,
            Self::Paper(1.0, 1),
            Self::Paper(0.5, 1),
            Self::StretchVolume(1.0),
            Self::StretchVolume(0.5),
            Self::XpbdSprings,
            Self::Ours,
            Self::FromZero,
            Self::Hexahedra,
        ]
        .iter()
        .any(|way| way.name() == name)
    }

    /// Settings of the method in words; empty if the material determines everything.
    pub(crate) fn setting(self) -> String {
        match self {
            Self::Paper(k, n) => format!("k = {k:.4}, {n} iterations"),
            Self::StretchVolume(k) => format!("k = {k:.4}"),
            _ => String::new(),
        }
    }

    /// True if the method's own step moves spheres out of the ball.
    pub(crate) fn touches(self) -> bool {
        matches!(self, Self::Ours | Self::Paper(..))
    }

    /// Steps in a tick.
    pub(crate) fn substeps(self) -> usize {
        match self {
            Self::ExplicitSprings | Self::Springs => 4,
            _ => 1,
        }
    }

    /// Parts that the method borrows, if it borrows any. Only Calot's method uses the contact skin.
    ///
    /// # Errors
    /// Calot's message if it refuses the scene.
    pub(crate) fn parts(
        self,
        body: &Body,
        skin: Option<&ContactSkin>,
        around: &Surroundings,
    ) -> Result<Option<Parts>, String> {
        let paper = match self {
            Self::Paper(k, iterations) => Some((k, iterations)),
            Self::Ours => None,
            _ => return Ok(None),
        };
        let parts = Parts::new(body, around, paper).map_err(|e| e.to_string())?;
        Ok(Some(match skin.filter(|_| self == Self::Ours) {
            Some(skin) => parts.with_skin(skin.clone()),
            None => parts,
        }))
    }

    /// The method, ready for its first step.
    ///
    /// # Errors
    /// Calot's message if it refuses the scene.
    pub(crate) fn method<'a>(
        self,
        body: &Body,
        parts: &'a mut Option<Parts>,
    ) -> Result<Box<dyn Method + 'a>, String> {
        Ok(match (self, parts) {
            (_, Some(parts)) => Box::new(parts.tissue().map_err(|e| e.to_string())?),
            (Self::ExplicitSprings, _) => Box::new(MassSpring { explicit: true }),
            (Self::Springs, _) => Box::new(MassSpring { explicit: false }),
            (Self::Paper(stiffness, n), _) => Box::new(PaperPbd {
                stiffness,
                iterations: n as usize,
            }),
            (Self::StretchVolume(stiffness), _) => Box::new(StretchVolume { stiffness }),
            (Self::XpbdSprings, _) => Box::new(XpbdSprings),
            (Self::Ours | Self::FromZero, _) => Box::new(NeoHookean),
            (Self::Hexahedra, _) => Box::new(Hexahedra::new(body)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar() -> Body {
        let mesh = fem_reference::block(
            nalgebra::Vector3::zeros(),
            nalgebra::Vector3::new(0.08, 0.02, 0.02),
            [8, 2, 2],
        );
        let corners: usize = 9 * 3 * 3;
        let mut share = vec![0.0; corners];
        let tets: Vec<_> = mesh
            .tets
            .iter()
            .map(|t| {
                let n = [0, 1, 2, 3].map(|i| t[i] as usize);
                let p = n.map(|i| mesh.nodes[i]);
                let volume = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0])) / 6.0;
                for i in n {
                    share[i] += volume / 4.0;
                }
                (n, volume)
            })
            .collect();
        let tissue = Tissue {
            young_pa: 5000.0,
            poisson: 0.45,
            density_kg_m3: 1060.0,
        };
        Body::new(&mesh.nodes[..corners], &share, &tets, tissue)
    }

    fn all() -> Vec<(&'static str, Box<dyn Method>)> {
        vec![
            ("mass-spring", Box::new(MassSpring { explicit: false })),
            (
                "paper",
                Box::new(PaperPbd {
                    stiffness: 0.05,
                    iterations: 2,
                }),
            ),
            (
                "stretch+volume",
                Box::new(StretchVolume { stiffness: 0.05 }),
            ),
            ("springs", Box::new(XpbdSprings)),
            ("neo-Hookean", Box::new(NeoHookean)),
        ]
    }

    const STILL: Env = Env {
        dt_s: 1e-3,
        gravity_m_s2: V3::new(0.0, 0.0, 0.0),
        damping_per_s: 0.0,
    };

    #[test]
    fn every_method_rests_at_rest() {
        let body = bar();
        for (name, mut method) in all() {
            let mut state = State::at_rest(&body, &vec![false; body.rest_m.len()]);
            for _ in 0..100 {
                method.step(&body, &mut state, &STILL);
            }
            let worst = state.u_m.iter().map(|u| u.norm()).fold(0.0, f32::max);
            assert!(worst < 1e-6, "{name} moved by {worst} m");
        }
    }

    #[test]
    fn all_but_the_papers_conserve_momentum_and_the_papers_does_not() {
        let body = bar();
        for (name, mut method) in all() {
            let mut state = State::at_rest(&body, &vec![false; body.rest_m.len()]);
            for (v, x) in state.v_m_s.iter_mut().zip(&body.rest_m) {
                *v = V3::new(0.1 * x.x / 0.08, 0.2 * x.y / 0.02 * x.x / 0.08, 0.0);
            }
            let momentum =
                |s: &State| -> V3 { s.v_m_s.iter().zip(&body.mass_kg).map(|(v, m)| v * *m).sum() };
            let before = momentum(&state);
            for _ in 0..20 {
                method.step(&body, &mut state, &STILL);
            }
            let lost = (momentum(&state) - before).norm() / before.norm();
            if name == "paper" {
                assert!(lost > 1e-3, "its known fault: {lost}");
            } else {
                assert!(lost < 1e-4, "{name} lost {lost}");
            }
        }
    }

    #[test]
    fn a_turned_body_rests_except_with_the_papers_fixed_vector() {
        let body = bar();
        let turn = nalgebra::Rotation3::from_axis_angle(&V3::z_axis(), 1.2);
        for (name, mut method) in all() {
            let mut state = State::at_rest(&body, &vec![false; body.rest_m.len()]);
            let turned = |x: &V3| turn * x - x;
            state.u_m = body.rest_m.iter().map(turned).collect();
            for _ in 0..20 {
                method.step(&body, &mut state, &STILL);
            }
            let errors = state
                .u_m
                .iter()
                .zip(&body.rest_m)
                .map(|(u, x)| (u - turned(x)).norm());
            let worst = errors.fold(0.0, f32::max);
            if name == "paper" {
                assert!(worst > 1e-3, "its known fault: {worst} m");
            } else {
                assert!(worst < 1e-5, "{name} moved by {worst} m");
            }
        }
    }

    /// A bar is stretched by 30 % between its ends. Its force and its volume are compared with the
    /// closed form.
    #[test]
    fn neo_hookean_pulls_with_the_closed_forms_force() {
        let body = bar();
        let held: Vec<bool> = body
            .rest_m
            .iter()
            .map(|x| x.x < 1e-6 || x.x > 0.08 - 1e-6)
            .collect();
        let material = fem_reference::Material::new(5000.0, 0.45, 1060.0).expect("valid");
        let (lateral, stress) = material.uniaxial(1.3);
        let mut state = State::at_rest(&body, &held);
        let env = Env {
            damping_per_s: 20.0,
            ..STILL
        };
        for tick in 0..3000 {
            let t = (tick as f32 / 500.0).min(1.0);
            for (target, x) in state.target_m.iter_mut().zip(&body.rest_m) {
                let side = (lateral as f32 - 1.0) * (x - V3::new(0.0, 0.01, 0.01));
                *target = V3::new(0.3 * x.x, side.y, side.z) * t;
            }
            NeoHookean.step(&body, &mut state, &env);
        }
        let end = |i: &usize| body.rest_m[*i].x > 0.08 - 1e-6;
        let force: f32 = (0..held.len())
            .filter(end)
            .map(|i| -state.pull_n[i].x)
            .sum();
        let share = f64::from(rt_core::tissue::neo_hookean::STIFFNESS_SHARE);
        let ratio = f64::from(force) / (stress * share * 4e-4);
        assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
        let growth = 1.3 * lateral * lateral - 1.0;
        assert!((body.growth(&state.u_m) - growth).abs() < 0.01);
    }

    /// Explicit Euler, with which the paper compares its method, gains energy and becomes unstable.
    #[test]
    fn explicit_euler_blows_up_where_the_semi_implicit_one_does_not() {
        let body = bar();
        let speed = |explicit| {
            let mut method = MassSpring { explicit };
            let mut state = State::at_rest(&body, &vec![false; body.rest_m.len()]);
            state.v_m_s[0] = V3::new(0.1, 0.0, 0.0);
            for _ in 0..1000 {
                method.step(&body, &mut state, &STILL);
            }
            state.v_m_s.iter().map(|v| v.norm()).fold(0.0, |a: f32, b| {
                if b.is_finite() {
                    a.max(b)
                } else {
                    f32::INFINITY
                }
            })
        };
        assert!(speed(false) < 0.2);
        assert!(speed(true) > 1.0);
    }
}
