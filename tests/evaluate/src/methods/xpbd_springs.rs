//! Compliant springs and tetrahedron volumes (XPBD, Macklin et al. 2016). E and ν determine the
//! stiffnesses.

use super::stretch_volume::volume;
use super::{Env, Method, State, edge_stiffness};
use crate::body::Body;

/// Springs resist shear; a network of springs has ν = 1/4. The volume constraints add the rest of
/// the resistance to compression. Each step makes one pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct XpbdSprings;

impl Method for XpbdSprings {
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        state.predict(env);
        let dt = env.dt_s;
        for edge in &body.edges {
            let compliance_m_n = 1.0 / edge_stiffness(body, edge);
            spring(body, state, edge.nodes, (edge.length_m, compliance_m_n), dt);
        }
        let kappa = (body.tissue.lame() - body.tissue.mu()).max(0.0);
        if kappa > 0.0 {
            volume(body, state, kappa as f32, dt);
        }
        state.advance(env);
    }
}

/// Solves one spring, given by its length at rest, m, and its compliance, m/N.
pub(super) fn spring(
    body: &Body,
    state: &mut State,
    [a, b]: [usize; 2],
    (length_m, compliance_m_n): (f32, f32),
    dt_s: f32,
) {
    let weight = state.w_per_kg[a] + state.w_per_kg[b] + compliance_m_n / (dt_s * dt_s);
    let across = body.rest_m[b] - body.rest_m[a] + (state.now(b) - state.now(a));
    let length = across.norm();
    if length > 0.0 {
        let impulse = across * ((length - length_m) / (length * weight));
        state.push(a, impulse, dt_s);
        state.push(b, -impulse, dt_s);
    }
}
