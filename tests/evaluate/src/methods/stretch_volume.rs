//! Position-based dynamics with edge stretch and tetrahedron volumes. The paper compares its method
//! with this one.

use super::paper_pbd::stretch;
use super::{Env, Method, State};
use crate::body::{Body, V3, cofactor};

/// The method's dimensionless stiffness. Volumes are corrected in full, as usual.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StretchVolume {
    /// Share of each edge's error that an iteration corrects.
    pub(crate) stiffness: f32,
}

/// Runs one pass over all tetrahedra of the constraint `det F = 1` with compliance `1 / (κ V)`.
/// With infinite κ the pass corrects each volume in full.
pub(super) fn volume(body: &Body, state: &mut State, kappa_pa: f32, dt_s: f32) {
    for tet in &body.tets {
        let f = Body::gradient(tet, |n| state.now(n));
        let cofactor = cofactor(&f);
        let g: [V3; 3] = tet.slopes.map(|s| cofactor * s);
        let first = -(g[0] + g[1] + g[2]);
        let all = [first, g[0], g[1], g[2]];
        let mut weight = 1.0 / (kappa_pa * tet.volume_m3 * dt_s * dt_s);
        for (&n, g) in tet.nodes.iter().zip(&all) {
            weight += state.w_per_kg[n] * g.norm_squared();
        }
        if weight > 0.0 {
            let multiplier = -(f.determinant() - 1.0) / weight;
            for (&n, g) in tet.nodes.iter().zip(&all) {
                state.push(n, g * multiplier, dt_s);
            }
        }
    }
}

impl Method for StretchVolume {
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        state.predict(env);
        stretch(body, state, self.stiffness, env.dt_s);
        volume(body, state, f32::INFINITY, env.dt_s);
        state.advance(env);
    }
}
