//! The paper's inner-sphere method: stretch constraints and fixed Laplacian vectors (paper Eq.
//! 3–8).

use super::{Env, Method, State};
use crate::body::{Body, V3};

/// The method's two dimensionless settings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PaperPbd {
    /// Share of each error that an iteration corrects (1 in the paper).
    pub(crate) stiffness: f32,
    /// Iterations in a step.
    pub(crate) iterations: usize,
}

/// Corrects the stretch of every edge by a share (Eq. 3–5).
pub(super) fn stretch(body: &Body, state: &mut State, stiffness: f32, dt_s: f32) {
    for edge in &body.edges {
        let [a, b] = edge.nodes;
        let weight = state.w_per_kg[a] + state.w_per_kg[b];
        let across = body.rest_m[b] - body.rest_m[a] + (state.now(b) - state.now(a));
        let length = across.norm();
        if weight > 0.0 && length > 0.0 {
            let impulse = across * (stiffness * (length - edge.length_m) / (length * weight));
            state.push(a, impulse, dt_s);
            state.push(b, -impulse, dt_s);
        }
    }
}

impl Method for PaperPbd {
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        state.predict(env);
        let n = body.rest_m.len();
        for _ in 0..self.iterations {
            stretch(body, state, self.stiffness, env.dt_s);
            // Eq. 6–8, for all spheres from the same positions: c' = mean(c'_n) + L means u =
            // mean(u_n).
            let mut sum = vec![(V3::zeros(), 0.0_f32); n];
            for edge in &body.edges {
                let [a, b] = edge.nodes;
                let (ua, ub) = (state.now(a), state.now(b));
                sum[a] = (sum[a].0 + ub, sum[a].1 + 1.0);
                sum[b] = (sum[b].0 + ua, sum[b].1 + 1.0);
            }
            for (i, (sum, count)) in sum.into_iter().enumerate() {
                if state.w_per_kg[i] > 0.0 && count > 0.0 {
                    let step = sum / count - state.now(i);
                    state.d_m[i] += step * self.stiffness;
                }
            }
        }
        state.advance(env);
    }
}
