//! The quadratic tetrahedron: shape functions, quadrature, internal forces and stiffness.

use nalgebra::{Matrix3, SMatrix};

use crate::{FemError, Material, Vec3};

/// The two corners of each edge. The middle of edge `k` is node `4 + k` of the tetrahedron.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Stiffness of one element, ordered by node and then by axis.
pub(crate) type Stiffness30 = SMatrix<f64, 30, 30>;
/// Forces of one element, N.
pub(crate) type Force30 = SMatrix<f64, 30, 1>;

const NEAR: f64 = 0.138_196_601_125_010_5;
const FAR: f64 = 0.585_410_196_624_968_5;

/// Integration points of the element, in the last three barycentric coordinates.
const POINTS: [[f64; 3]; 4] = [
    [NEAR, NEAR, NEAR],
    [FAR, NEAR, NEAR],
    [NEAR, FAR, NEAR],
    [NEAR, NEAR, FAR],
];

/// Values of the ten shape functions at `xi` (the last three barycentric coordinates).
pub(crate) fn shape(xi: &Vec3) -> [f64; 10] {
    let b = [1.0 - xi.x - xi.y - xi.z, xi.x, xi.y, xi.z];
    let mut n = [0.0; 10];
    for i in 0..4 {
        n[i] = b[i] * (2.0 * b[i] - 1.0);
    }
    for (k, [i, j]) in EDGES.into_iter().enumerate() {
        n[4 + k] = 4.0 * b[i] * b[j];
    }
    n
}

/// Derivatives of the shape functions with respect to `xi`.
pub(crate) fn shape_gradients(xi: &Vec3) -> [Vec3; 10] {
    let b = [1.0 - xi.x - xi.y - xi.z, xi.x, xi.y, xi.z];
    let slope = [Vec3::repeat(-1.0), Vec3::x(), Vec3::y(), Vec3::z()];
    let mut n = [Vec3::zeros(); 10];
    for i in 0..4 {
        n[i] = slope[i] * (4.0 * b[i] - 1.0);
    }
    for (k, [i, j]) in EDGES.into_iter().enumerate() {
        n[4 + k] = (slope[i] * b[j] + slope[j] * b[i]) * 4.0;
    }
    n
}

/// Derivative of the position with respect to `xi`, `∂X/∂ξ`.
pub(crate) fn jacobian(x: &[Vec3; 10], slopes: &[Vec3; 10]) -> Matrix3<f64> {
    x.iter().zip(slopes).map(|(x, s)| x * s.transpose()).sum()
}

/// Smallest determinant of the Jacobian over corners and quadrature points, m³.
pub(crate) fn smallest_jacobian(x: &[Vec3; 10]) -> f64 {
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let inner = POINTS.map(Vec3::from);
    let at = |xi: &Vec3| jacobian(x, &shape_gradients(xi)).determinant();
    corners
        .iter()
        .chain(&inner)
        .map(at)
        .fold(f64::INFINITY, f64::min)
}

/// Determinant of the Jacobian of the tetrahedron with straight edges, m³.
pub(crate) fn straight_jacobian(x: &[Vec3; 10]) -> f64 {
    Matrix3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]]).determinant()
}

/// One quadrature point of one element at rest.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    /// Derivatives of the shape functions with respect to the rest position, 1/m.
    pub(crate) slopes: [Vec3; 10],
    /// Values of the shape functions.
    pub(crate) values: [f64; 10],
    /// Quadrature weight: the volume that the point represents, m³.
    pub(crate) weight_m3: f64,
}

impl Point {
    /// Deformation gradient under a displacement field.
    pub(crate) fn gradient(&self, nodes: &[u32; 10], u: &[Vec3]) -> Matrix3<f64> {
        let mut f = Matrix3::identity();
        for (&n, s) in nodes.iter().zip(&self.slopes) {
            f += u[n as usize] * s.transpose();
        }
        f
    }
}

/// Quadrature points of one element.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub(crate) points: [Point; 4],
}

/// Computes the quadrature points of each element. `nodes` has the rest positions, m.
pub(crate) fn prepare(nodes: &[Vec3], tets: &[[u32; 10]]) -> Result<Vec<Element>, FemError> {
    let mut elements = Vec::with_capacity(tets.len());
    for (e, t) in tets.iter().enumerate() {
        let x = t.map(|n| nodes[n as usize]);
        let mut smallest = f64::INFINITY;
        let points = POINTS.map(|xi| {
            let xi = Vec3::from(xi);
            let slopes = shape_gradients(&xi);
            let j = jacobian(&x, &slopes);
            let determinant = j.determinant();
            smallest = smallest.min(determinant);
            let inverse = j.try_inverse().unwrap_or_else(Matrix3::zeros);
            Point {
                slopes: slopes.map(|s| inverse.transpose() * s),
                values: shape(&xi),
                weight_m3: determinant / 24.0,
            }
        });
        if smallest.is_nan() || smallest <= 0.0 {
            return Err(FemError::Element {
                element: e,
                jacobian: smallest,
            });
        }
        elements.push(Element { points });
    }
    Ok(elements)
}

impl Element {
    /// Elastic energy, J.
    pub(crate) fn energy(&self, m: &Material, nodes: &[u32; 10], u: &[Vec3]) -> f64 {
        let at = |p: &Point| p.weight_m3 * m.energy(&p.gradient(nodes, u));
        self.points.iter().map(at).sum()
    }

    /// Gradient of the energy: the nodal forces that keep the element in this deformation, N.
    pub(crate) fn force(&self, m: &Material, nodes: &[u32; 10], u: &[Vec3]) -> Force30 {
        let mut force = Force30::zeros();
        for p in &self.points {
            let stress = m.stress(&p.gradient(nodes, u)) * p.weight_m3;
            for (a, slope) in p.slopes.iter().enumerate() {
                let pull = stress * slope;
                for i in 0..3 {
                    force[3 * a + i] += pull[i];
                }
            }
        }
        force
    }

    /// Second derivative of the energy, N/m. With `project`, negative eigenvalues of the material
    /// stiffness become zero.
    pub(crate) fn stiffness(
        &self,
        m: &Material,
        nodes: &[u32; 10],
        u: &[Vec3],
        project: bool,
    ) -> Stiffness30 {
        let mut k = Stiffness30::zeros();
        for p in &self.points {
            let c = m.stiffness(&p.gradient(nodes, u), project) * p.weight_m3;
            for (b, slope_b) in p.slopes.iter().enumerate() {
                // Derivative of the stress with respect to the displacement of node b: 9 × 3.
                let t = c.fixed_view::<9, 3>(0, 0) * slope_b.x
                    + c.fixed_view::<9, 3>(0, 3) * slope_b.y
                    + c.fixed_view::<9, 3>(0, 6) * slope_b.z;
                for (a, slope_a) in p.slopes.iter().enumerate().skip(b) {
                    let block = t.fixed_view::<3, 3>(0, 0) * slope_a.x
                        + t.fixed_view::<3, 3>(3, 0) * slope_a.y
                        + t.fixed_view::<3, 3>(6, 0) * slope_a.z;
                    let mut place = k.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                    place += block;
                }
            }
        }
        for b in 0..10 {
            for a in b + 1..10 {
                let block = k.fixed_view::<3, 3>(3 * a, 3 * b).transpose();
                k.fixed_view_mut::<3, 3>(3 * b, 3 * a).copy_from(&block);
            }
        }
        k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block;

    #[test]
    fn shape_functions_are_one_at_their_node_and_sum_to_one() {
        let xi = Vec3::new(0.2, 0.5, 0.1);
        assert!((shape(&xi).iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(shape_gradients(&xi).iter().sum::<Vec3>().norm() < 1e-14);
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        for (i, corner) in corners.iter().enumerate() {
            assert!((shape(corner)[i] - 1.0).abs() < 1e-14);
        }
        for (k, [i, j]) in EDGES.into_iter().enumerate() {
            let middle = (corners[i] + corners[j]) / 2.0;
            assert!((shape(&middle)[4 + k] - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn force_and_stiffness_are_the_energys_derivatives() {
        let mesh = block(Vec3::zeros(), Vec3::repeat(0.01), [1, 1, 1]);
        let m = Material::new(5000.0, 0.45, 1060.0).expect("valid");
        let elements = prepare(&mesh.nodes, &mesh.tets).expect("sound");
        let mut u: Vec<Vec3> = mesh.nodes.iter().map(|x| x.yzx() * 0.2 + x * 0.1).collect();
        u[3].x += 0.001;
        let (nodes, e) = (&mesh.tets[0], &elements[0]);
        let (force, stiffness) = (e.force(&m, nodes, &u), e.stiffness(&m, nodes, &u, false));
        let step = 1e-8;
        for dof in 0..30 {
            let (n, i) = (nodes[dof / 3] as usize, dof % 3);
            let old = u[n][i];
            u[n][i] = old + step;
            let (e1, f1) = (e.energy(&m, nodes, &u), e.force(&m, nodes, &u));
            u[n][i] = old - step;
            let (e0, f0) = (e.energy(&m, nodes, &u), e.force(&m, nodes, &u));
            u[n][i] = old;
            assert!(((e1 - e0) / (2.0 * step) - force[dof]).abs() < 1e-5 * force.amax());
            let column = (f1 - f0) / (2.0 * step) - stiffness.column(dof);
            assert!(column.amax() < 1e-5 * stiffness.amax());
        }
    }
}
