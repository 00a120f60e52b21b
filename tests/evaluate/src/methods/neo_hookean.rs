//! Stable neo-Hookean tetrahedra (Macklin and Müller 2021). Volume and shear are solved together,
//! in one pass per step that starts from zero multipliers. Calot starts each step from the impulses
//! of the last step instead.

use rt_core::tissue::neo_hookean::STIFFNESS_SHARE;

use super::xpbd_springs::spring;
use super::{Env, Method, State};
use crate::body::{Body, V3, cofactor};

/// The method has no settings: E, ν, the step and Calot's share of E determine everything.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NeoHookean;

impl Method for NeoHookean {
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        state.predict(env);
        let mu = STIFFNESS_SHARE * body.tissue.mu() as f32;
        let lambda = STIFFNESS_SHARE * body.tissue.lame() as f32 + mu;
        let gamma = 1.0 + mu / lambda;
        let squared = env.dt_s * env.dt_s;
        for link in &body.springs {
            let ends = [link.a as usize, link.b as usize];
            let bar = (link.rest_length_m, link.compliance_m_n);
            spring(body, state, ends, bar, env.dt_s);
        }
        for tet in &body.tets {
            let f = Body::gradient(tet, |n| state.now(n));
            let cofactor = cofactor(&f);
            let norm = f.norm().max(1e-6);
            let volume_value = f.determinant() - gamma;
            let g: [V3; 3] = tet.slopes.map(|s| cofactor * s);
            let h: [V3; 3] = tet.slopes.map(|s| f * s / norm);
            let g = [-(g[0] + g[1] + g[2]), g[0], g[1], g[2]];
            let h = [-(h[0] + h[1] + h[2]), h[0], h[1], h[2]];
            let mut m11 = 1.0 / (lambda * tet.volume_m3 * squared);
            let mut m22 = 1.0 / (mu * tet.volume_m3 * squared);
            let mut m12 = 0.0;
            for (i, &n) in tet.nodes.iter().enumerate() {
                let w = state.w_per_kg[n];
                m11 += w * g[i].norm_squared();
                m12 += w * g[i].dot(&h[i]);
                m22 += w * h[i].norm_squared();
            }
            let draw = 0.1_f32.min(-10.0 * f.determinant());
            if draw > 0.0 {
                // The tetrahedron is inverted, so its corners are moved towards their centre.
                let mean = tet.nodes.iter().map(|&n| state.now(n)).sum::<V3>() / 4.0;
                let weights = tet.nodes.map(|n| state.w_per_kg[n]);
                let lightest = weights.into_iter().fold(1e-6, f32::max);
                let drawn = tet.nodes.map(|n| mean - state.now(n));
                for ((&n, w), drawn) in tet.nodes.iter().zip(weights).zip(drawn) {
                    state.d_m[n] += drawn * (draw * w / lightest);
                }
            }
            let determinant = m11 * m22 - m12 * m12;
            let first = (m12 * norm - m22 * volume_value) / determinant;
            let second = (m12 * volume_value - m11 * norm) / determinant;
            for (i, &n) in tet.nodes.iter().enumerate() {
                state.push(n, g[i] * first + h[i] * second, env.dt_s);
            }
        }
        state.advance(env);
    }
}
