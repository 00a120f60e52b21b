//! Mass-spring: forces along the edges, integrated explicitly or semi-implicitly.

use super::{Env, Method, State, edge_stiffness};
use crate::body::{Body, V3};

/// Springs on every edge. Together they are as stiff in shear as the tissue.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MassSpring {
    /// True for explicit Euler, with which the paper compares. Otherwise the new velocity moves the
    /// position (semi-implicit).
    pub(crate) explicit: bool,
}

impl Method for MassSpring {
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        let mut force = vec![V3::zeros(); body.rest_m.len()];
        for i in 0..force.len() {
            if state.w_per_kg[i] <= 0.0 {
                state.u_m[i] = state.target_m[i];
            }
        }
        for edge in &body.edges {
            let [a, b] = edge.nodes;
            let across = body.rest_m[b] - body.rest_m[a] + (state.u_m[b] - state.u_m[a]);
            let length = across.norm().max(1e-9);
            let pull = across * (edge_stiffness(body, edge) * (length - edge.length_m) / length);
            force[a] += pull;
            force[b] -= pull;
        }
        let keep = 1.0 - env.damping_per_s * env.dt_s;
        for (i, force) in force.into_iter().enumerate() {
            let w = state.w_per_kg[i];
            if w <= 0.0 {
                state.pull_n[i] = force;
                state.v_m_s[i] = V3::zeros();
                continue;
            }
            let before = state.v_m_s[i];
            state.v_m_s[i] = (before + (force * w + env.gravity_m_s2) * env.dt_s) * keep;
            let velocity = if self.explicit {
                before
            } else {
                state.v_m_s[i]
            };
            state.u_m[i] += velocity * env.dt_s;
        }
    }
}
