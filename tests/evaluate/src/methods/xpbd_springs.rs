//! Compliant springs and tetrahedron volumes (XPBD, Macklin et al. 2016). Stiffnesses follow from E
//! and ν.

use super::stretch_volume::volume;
use super::{Env, Method, State, edge_stiffness};
use crate::body::Body;

/// Springs resist shear (a network of springs has ν = 1/4), volumes resist the rest. Each step
/// makes one pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct XpbdSprings;

impl Method for XpbdSprings {
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        state.predict(env);
        let dt = env.dt_s;
        for edge in &body.edges {
            let [a, b] = edge.nodes;
            let compliance = 1.0 / (edge_stiffness(body, edge) * dt * dt);
            let weight = state.w_per_kg[a] + state.w_per_kg[b] + compliance;
            let across = body.rest_m[b] - body.rest_m[a] + (state.now(b) - state.now(a));
            let length = across.norm();
            if length > 0.0 {
                let impulse = across * ((length - edge.length_m) / (length * weight));
                state.push(a, impulse, dt);
                state.push(b, -impulse, dt);
            }
        }
        let kappa = (body.tissue.lame() - body.tissue.mu()).max(0.0);
        if kappa > 0.0 {
            volume(body, state, kappa as f32, dt);
        }
        state.advance(env);
    }
}
