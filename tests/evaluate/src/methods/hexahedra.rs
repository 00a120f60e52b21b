//! Corotational linear hexahedra, stepped by implicit Euler with conjugate gradients. The paper
//! compares its method with such a method under the name "FEM, hexahedra".

use nalgebra::{Matrix3, Quaternion, SMatrix, UnitQuaternion};

use super::{Env, Method, State};
use crate::body::{Body, V3};

type Stiffness = SMatrix<f32, 24, 24>;

/// Largest number of iterations of the linear solver in a step.
const ITERATIONS_MAX: usize = 30;
/// The solver stops when the residual's norm is at most this share of the right-hand side's norm.
const TOLERANCE: f32 = 1e-3;

/// The method's state. All cells are equal cubes, so they have the same stiffness matrix.
pub(crate) struct Hexahedra {
    stiffness: Stiffness,
    /// Derivatives of the shape functions in the middle of a cell, 1/m.
    slopes: [V3; 8],
    /// Rotation of each cell from rest.
    turned: Vec<UnitQuaternion<f32>>,
}

/// Corner `i` of the cube, each coordinate ±1.
fn corner(i: usize) -> V3 {
    let side = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    V3::new(side(0), side(1), side(2))
}

/// Derivatives of the eight shape functions with respect to position, 1/m, at the point `at`. The
/// coordinates of `at` run from −1 to 1 in the cube.
fn slopes(at: &V3, edge_m: f32) -> [V3; 8] {
    std::array::from_fn(|i| {
        let c = corner(i);
        let f = V3::new(1.0, 1.0, 1.0) + c.component_mul(at);
        V3::new(c.x * f.y * f.z, c.y * f.x * f.z, c.z * f.x * f.y) / (4.0 * edge_m)
    })
}

impl Hexahedra {
    pub(crate) fn new(body: &Body) -> Self {
        let (mu, lame) = (body.tissue.mu() as f32, body.tissue.lame() as f32);
        let edge_m = body.cell_m;
        let mut stiffness = Stiffness::zeros();
        let point = 1.0 / 3.0_f32.sqrt();
        for q in 0..8 {
            let slopes = slopes(&(corner(q) * point), edge_m);
            let weight = edge_m.powi(3) / 8.0;
            for (a, ga) in slopes.iter().enumerate() {
                for (b, gb) in slopes.iter().enumerate() {
                    // Linear elasticity: λ ga gbᵀ + μ (gb gaᵀ + ga·gb I).
                    let block = ga * gb.transpose() * lame
                        + gb * ga.transpose() * mu
                        + Matrix3::identity() * (mu * ga.dot(gb));
                    let mut place = stiffness.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                    place += block * weight;
                }
            }
        }
        Self {
            stiffness,
            slopes: slopes(&V3::zeros(), edge_m),
            turned: vec![UnitQuaternion::identity(); body.cells.len()],
        }
    }

    /// Writes to `out` the product of the stiffness and a field, summed at the nodes. The stiffness
    /// of each cell rotates with the cell.
    fn apply(&self, body: &Body, field: &[V3], out: &mut [V3]) {
        out.fill(V3::zeros());
        for (cell, turn) in body.cells.iter().zip(&self.turned) {
            let turn = turn.to_rotation_matrix();
            let mut local = SMatrix::<f32, 24, 1>::zeros();
            for (a, &n) in cell.iter().enumerate() {
                let back = turn.inverse() * field[n];
                local.fixed_rows_mut::<3>(3 * a).copy_from(&back);
            }
            let force = self.stiffness * local;
            for (a, &n) in cell.iter().enumerate() {
                out[n] += turn * V3::from(force.fixed_rows::<3>(3 * a));
            }
        }
    }

    /// Elastic force on every node, N.
    fn force(&self, body: &Body, u: &[V3]) -> Vec<V3> {
        let mut out = vec![V3::zeros(); u.len()];
        for (cell, turn) in body.cells.iter().zip(&self.turned) {
            let turn = turn.to_rotation_matrix();
            let mut local = SMatrix::<f32, 24, 1>::zeros();
            for (a, &n) in cell.iter().enumerate() {
                let rest = body.rest_m[n];
                let strain = turn.inverse() * (rest + u[n]) - rest;
                local.fixed_rows_mut::<3>(3 * a).copy_from(&strain);
            }
            let force = self.stiffness * local;
            for (a, &n) in cell.iter().enumerate() {
                out[n] -= turn * V3::from(force.fixed_rows::<3>(3 * a));
            }
        }
        out
    }

    /// Updates each cell's rotation, starting from its last rotation.
    fn turn(&mut self, body: &Body, u: &[V3]) {
        for (cell, turn) in body.cells.iter().zip(&mut self.turned) {
            let mut f = Matrix3::identity();
            for (slope, &n) in self.slopes.iter().zip(cell) {
                f += u[n] * slope.transpose();
            }
            // Müller et al. 2016: a few Newton steps from the last rotation are enough.
            for _ in 0..4 {
                let r = turn.to_rotation_matrix();
                let (mut axis, mut sum) = (V3::zeros(), 0.0);
                for i in 0..3 {
                    let (column, wanted) = (r.matrix().column(i), f.column(i));
                    axis += V3::from(column.cross(&wanted));
                    sum += column.dot(&wanted);
                }
                let step = axis / (sum.abs() + 1e-9);
                if step.norm_squared() < 1e-12 || !step.iter().all(|c| c.is_finite()) {
                    break;
                }
                *turn = UnitQuaternion::from_scaled_axis(step) * *turn;
                *turn = UnitQuaternion::from_quaternion(Quaternion::from(turn.coords));
            }
        }
    }
}

fn dot(a: &[V3], b: &[V3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

impl Method for Hexahedra {
    /// Solves `(M + dt² K) Δv = dt (f(u + dt v) + M g)` for the free nodes. `v` is the damped
    /// velocity, `K` the stiffness of the rotated cells, and `M` the masses.
    fn step(&mut self, body: &Body, state: &mut State, env: &Env) {
        let (n, dt) = (body.rest_m.len(), env.dt_s);
        self.turn(body, &state.u_m);
        let keep = 1.0 - env.damping_per_s * dt;
        let mut ahead = state.u_m.clone();
        for (i, ahead) in ahead.iter_mut().enumerate() {
            if state.w_per_kg[i] > 0.0 {
                state.v_m_s[i] *= keep;
                *ahead += state.v_m_s[i] * dt;
            } else {
                state.v_m_s[i] = (state.target_m[i] - state.u_m[i]) / dt;
                *ahead = state.target_m[i];
            }
        }
        let mut residual = self.force(body, &ahead);
        for (i, r) in residual.iter_mut().enumerate() {
            if state.w_per_kg[i] > 0.0 {
                *r = (*r + env.gravity_m_s2 * body.mass_kg[i]) * dt;
            } else {
                state.pull_n[i] = *r;
                *r = V3::zeros();
            }
        }
        let mut change = vec![V3::zeros(); n];
        let mut search = residual.clone();
        let mut product = vec![V3::zeros(); n];
        let mut rr = dot(&residual, &residual);
        let enough = rr * TOLERANCE * TOLERANCE;
        for _ in 0..ITERATIONS_MAX {
            if rr <= enough || rr <= f32::MIN_POSITIVE {
                break;
            }
            self.apply(body, &search, &mut product);
            for i in 0..n {
                product[i] = if state.w_per_kg[i] > 0.0 {
                    product[i] * (dt * dt) + search[i] * body.mass_kg[i]
                } else {
                    V3::zeros()
                };
            }
            let step = rr / dot(&search, &product);
            for i in 0..n {
                change[i] += search[i] * step;
                residual[i] -= product[i] * step;
            }
            let next = dot(&residual, &residual);
            for i in 0..n {
                search[i] = residual[i] + search[i] * (next / rr);
            }
            rr = next;
        }
        for (i, change) in change.into_iter().enumerate() {
            state.v_m_s[i] += change;
            state.u_m[i] += state.v_m_s[i] * dt;
        }
    }
}
