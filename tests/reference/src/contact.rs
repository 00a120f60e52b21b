//! A rigid, frictionless ball against the body's boundary: augmented Lagrangian at the points of
//! a degree-4 rule on every boundary triangle (Alart and Curnier 1991, without friction).

use nalgebra::Matrix3;

use crate::{Mesh, Vec3};

/// A rigid ball that is moved along a path.
pub struct Tool<'a> {
    /// Its radius, m.
    pub radius_m: f64,
    /// Its centre at a share of the load from 0 to 1, world frame, m.
    pub centre_m: Box<dyn Fn(f64) -> Vec3 + 'a>,
    /// Boundary faces that it may touch.
    pub faces: Vec<u32>,
}

/// Barycentric coordinates of the rule (Dunavant 1985, degree 4) and their weights.
const RULE: [(f64, f64); 2] = [
    (0.445_948_490_915_965, 0.223_381_589_678_011),
    (0.091_576_213_509_771, 0.109_951_743_655_322),
];

/// One contact point.
pub(crate) struct Patch {
    nodes: [u32; 6],
    values: [f64; 6],
    area_m2: f64,
    /// Multiplier, Pa: pressure of the last converged state.
    pressure_pa: f64,
}

/// Contact with one tool.
pub(crate) struct Contact {
    pub(crate) patches: Vec<Patch>,
    radius_m: f64,
    /// Penalty, Pa per metre of penetration.
    stiffness_pa_m: f64,
}

/// A contact point that presses: its nodes with their shares, force and stiffness.
pub(crate) struct Press {
    pub(crate) nodes: [u32; 6],
    pub(crate) shares: [f64; 6],
    /// Force on the body, N.
    pub(crate) force_n: Vec3,
    /// Second derivative of the contact energy by the point's position, N/m.
    pub(crate) stiffness: Matrix3<f64>,
}

fn face_shape(b: [f64; 3]) -> [f64; 6] {
    let corner = b.map(|l| l * (2.0 * l - 1.0));
    let [p, q, r] = corner;
    [
        p,
        q,
        r,
        4.0 * b[0] * b[1],
        4.0 * b[1] * b[2],
        4.0 * b[2] * b[0],
    ]
}

/// Surface area per unit of the reference triangle at a point of a curved face, m².
fn area(x: &[Vec3; 6], b: [f64; 3]) -> f64 {
    // Derivatives by the first two barycentric coordinates.
    let slope = |k: usize| {
        let mut d = [0.0; 3];
        (d[k], d[2]) = (1.0, -1.0);
        let corner = |i: usize| d[i] * (4.0 * b[i] - 1.0);
        let middle = |i: usize, j: usize| 4.0 * (d[i] * b[j] + b[i] * d[j]);
        let n = [
            corner(0),
            corner(1),
            corner(2),
            middle(0, 1),
            middle(1, 2),
            middle(2, 0),
        ];
        x.iter().zip(n).map(|(x, n)| x * n).sum::<Vec3>()
    };
    0.5 * slope(0).cross(&slope(1)).norm()
}

impl Contact {
    pub(crate) fn new(mesh: &Mesh, tool: &Tool<'_>, young_pa: f64) -> Self {
        let mut patches = Vec::new();
        let mut total = 0.0;
        for &face in &tool.faces {
            let nodes = mesh.faces[face as usize];
            let x = nodes.map(|n| mesh.nodes[n as usize]);
            for (l, weight) in RULE {
                for far in 0..3 {
                    let mut b = [l; 3];
                    b[far] = 1.0 - 2.0 * l;
                    let area_m2 = weight * area(&x, b);
                    total += area_m2;
                    patches.push(Patch {
                        nodes,
                        values: face_shape(b),
                        area_m2,
                        pressure_pa: 0.0,
                    });
                }
            }
        }
        let face_m = (total / tool.faces.len().max(1) as f64).sqrt();
        Self {
            patches,
            radius_m: tool.radius_m,
            stiffness_pa_m: 30.0 * young_pa / face_m.max(f64::MIN_POSITIVE),
        }
    }

    fn at(patch: &Patch, rest: &[Vec3], u: &[Vec3]) -> Vec3 {
        let parts = patch.nodes.iter().zip(patch.values);
        parts
            .map(|(&n, s)| (rest[n as usize] + u[n as usize]) * s)
            .sum()
    }

    fn pressure(&self, patch: &Patch, distance_m: f64) -> f64 {
        let separation = distance_m - self.radius_m;
        (patch.pressure_pa - self.stiffness_pa_m * separation).max(0.0)
    }

    pub(crate) fn energy(&self, rest: &[Vec3], u: &[Vec3], centre: &Vec3) -> f64 {
        let one = |patch: &Patch| {
            let p = self.pressure(patch, (Self::at(patch, rest, u) - centre).norm());
            let before = patch.pressure_pa;
            patch.area_m2 * (p * p - before * before) / (2.0 * self.stiffness_pa_m)
        };
        self.patches.iter().map(one).sum()
    }

    /// All points that press. `convex` leaves out the ball's own curvature, which softens.
    pub(crate) fn presses<'s>(
        &'s self,
        rest: &'s [Vec3],
        u: &'s [Vec3],
        centre: &'s Vec3,
        convex: bool,
    ) -> impl Iterator<Item = Press> + 's {
        self.patches.iter().filter_map(move |patch| {
            let arm = Self::at(patch, rest, u) - centre;
            let distance = arm.norm();
            let pressure = self.pressure(patch, distance);
            if pressure <= 0.0 || distance <= 0.0 {
                return None;
            }
            let normal = arm / distance;
            let along = normal * normal.transpose();
            let mut stiffness = along * self.stiffness_pa_m;
            if !convex {
                stiffness -= (Matrix3::identity() - along) * (pressure / distance);
            }
            Some(Press {
                nodes: patch.nodes,
                shares: patch.values,
                force_n: normal * (pressure * patch.area_m2),
                stiffness: stiffness * patch.area_m2,
            })
        })
    }

    /// Whether the pressures differ from their multipliers by less than `share` of the force
    /// altogether; otherwise the multipliers take them over.
    pub(crate) fn settled(&mut self, rest: &[Vec3], u: &[Vec3], centre: &Vec3, share: f64) -> bool {
        let distance = |patch: &Patch| (Self::at(patch, rest, u) - centre).norm();
        let now = |patch: &Patch| self.pressure(patch, distance(patch));
        let pressures: Vec<f64> = self.patches.iter().map(now).collect();
        let (mut change, mut force) = (0.0, 0.0);
        for (patch, p) in self.patches.iter().zip(&pressures) {
            change += patch.area_m2 * (p - patch.pressure_pa).abs();
            force += patch.area_m2 * p;
        }
        let settled = change <= share * force;
        if !settled {
            self.restore(&pressures);
        }
        settled
    }

    pub(crate) fn pressures(&self) -> Vec<f64> {
        self.patches.iter().map(|p| p.pressure_pa).collect()
    }

    pub(crate) fn restore(&mut self, pressures: &[f64]) {
        for (patch, &p) in self.patches.iter_mut().zip(pressures) {
            patch.pressure_pa = p;
        }
    }
}
