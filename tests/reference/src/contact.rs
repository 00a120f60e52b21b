//! Frictionless contact between a rigid tool, made of round bars, and the body's boundary. The
//! method is the augmented Lagrangian of Alart and Curnier (1991). Contact is evaluated at the
//! points of a quadrature rule of degree 4 on each boundary triangle.

use nalgebra::Matrix3;

use crate::{Mesh, Vec3};

/// All points within a radius of the line between two points: a bar with round ends, or a ball if
/// the ends coincide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Ends of the bar's axis, world frame, m.
    pub ends_m: [Vec3; 2],
    /// The bar's radius, m.
    pub radius_m: f64,
}

/// A rigid tool that moves along a path without rotation.
pub struct Tool<'a> {
    /// Parts of the tool. Each exerts its own contact forces. Where two parts meet, as at the joint
    /// of jaws, both do.
    pub bars: Vec<Bar>,
    /// Unit vector back along the tool's path. A point on that side of a bar, within the bar's
    /// width, counts as inside the bar and is pushed out sideways. With `None`, an iteration could
    /// push a point through a thin bar and leave it behind the bar.
    pub behind: Option<Vec3>,
    /// Displacement of the tool at a share of the load from 0 to 1, world frame, m.
    pub shift_m: Box<dyn Fn(f64) -> Vec3 + 'a>,
    /// Boundary faces that the tool may touch.
    pub faces: Vec<u32>,
}

impl<'a> Tool<'a> {
    /// A ball whose centre moves along a path.
    #[must_use]
    pub fn ball(radius_m: f64, centre_m: impl Fn(f64) -> Vec3 + 'a, faces: Vec<u32>) -> Self {
        Self {
            bars: vec![Bar {
                ends_m: [Vec3::zeros(); 2],
                radius_m,
            }],
            behind: None,
            shift_m: Box::new(centre_m),
            faces,
        }
    }
}

/// Position of a point relative to a bar.
struct Separation {
    /// Distance to the bar's surface, m; negative inside.
    separation_m: f64,
    /// Unit vector away from the bar.
    normal: Vec3,
    /// Derivative of the normal with respect to the point's position, 1/m.
    normal_gradient: Matrix3<f64>,
}

impl Bar {
    fn separation(&self, x: &Vec3, behind: Option<&Vec3>) -> Option<Separation> {
        let [a, b] = self.ends_m;
        let (mut arm, mut axis) = (x - a, b - a);
        let mut across = Matrix3::identity();
        if let Some(back) = behind.filter(|back| Self::nearest(&arm, &axis).0.dot(back) > 0.0) {
            // Behind the bar, only the position perpendicular to the path counts. The component
            // along the path is removed.
            let flat = Matrix3::identity() - back * back.transpose();
            (arm, axis) = (flat * arm, flat * axis);
            across = flat;
        }
        let (arm, is_between) = Self::nearest(&arm, &axis);
        let distance = arm.norm();
        if distance <= 0.0 {
            return None;
        }
        let normal = arm / distance;
        across -= normal * normal.transpose();
        if is_between {
            across -= axis * axis.transpose() / axis.norm_squared();
        }
        Some(Separation {
            separation_m: distance - self.radius_m,
            normal,
            normal_gradient: across / distance,
        })
    }

    /// Vector to a point from the nearest point of an axis, and true if that nearest point lies
    /// between the axis's ends. `arm` is the vector to the point from the axis's start.
    fn nearest(arm: &Vec3, axis: &Vec3) -> (Vec3, bool) {
        let squared = axis.norm_squared();
        let along = if squared > f64::MIN_POSITIVE {
            arm.dot(axis) / squared
        } else {
            0.0
        };
        let is_between = 0.0 < along && along < 1.0;
        (arm - axis * along.clamp(0.0, 1.0), is_between)
    }
}

/// Barycentric coordinates of the rule's points (Dunavant 1985, degree 4) and their weights.
const RULE: [(f64, f64); 2] = [
    (0.445_948_490_915_965, 0.223_381_589_678_011),
    (0.091_576_213_509_771, 0.109_951_743_655_322),
];

/// One contact point and one bar.
pub(crate) struct ContactPoint {
    bar: Bar,
    nodes: [u32; 6],
    values: [f64; 6],
    area_m2: f64,
    /// Multiplier: pressure at the last augmentation, Pa.
    pressure_pa: f64,
}

/// Contact with one tool.
pub(crate) struct Contact {
    pub(crate) points: Vec<ContactPoint>,
    behind: Option<Vec3>,
    /// Penalty, Pa per metre of penetration.
    stiffness_pa_m: f64,
}

/// Force at an active contact point.
pub(crate) struct ContactForce {
    pub(crate) nodes: [u32; 6],
    pub(crate) shares: [f64; 6],
    /// Position of the point, world frame, m.
    pub(crate) at_m: Vec3,
    /// Force on the body, N.
    pub(crate) force_n: Vec3,
    /// Second derivative of the contact energy with respect to the point's position, N/m.
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

/// Area of a curved face, extrapolated from the area element at one of its points, m².
fn area(x: &[Vec3; 6], b: [f64; 3]) -> f64 {
    // Derivatives with respect to the first two barycentric coordinates.
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
        let mut points = Vec::new();
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
                    points.extend(tool.bars.iter().map(|bar| ContactPoint {
                        bar: *bar,
                        nodes,
                        values: face_shape(b),
                        area_m2,
                        pressure_pa: 0.0,
                    }));
                }
            }
        }
        let face_m = (total / tool.faces.len().max(1) as f64).sqrt();
        Self {
            points,
            behind: tool.behind,
            stiffness_pa_m: 30.0 * young_pa / face_m.max(f64::MIN_POSITIVE),
        }
    }

    fn at(point: &ContactPoint, rest: &[Vec3], u: &[Vec3]) -> Vec3 {
        let parts = point.nodes.iter().zip(point.values);
        parts
            .map(|(&n, s)| (rest[n as usize] + u[n as usize]) * s)
            .sum()
    }

    /// Position of a contact point relative to its bar; `None` on the bar's axis.
    fn separation(
        &self,
        point: &ContactPoint,
        rest: &[Vec3],
        u: &[Vec3],
        shift: &Vec3,
    ) -> Option<Separation> {
        let x = Self::at(point, rest, u) - shift;
        point.bar.separation(&x, self.behind.as_ref())
    }

    fn pressure(&self, point: &ContactPoint, separation: Option<&Separation>) -> f64 {
        let separation = separation.map_or(0.0, |b| b.separation_m);
        (point.pressure_pa - self.stiffness_pa_m * separation).max(0.0)
    }

    pub(crate) fn energy(&self, rest: &[Vec3], u: &[Vec3], shift: &Vec3) -> f64 {
        let one = |point: &ContactPoint| {
            let p = self.pressure(point, self.separation(point, rest, u, shift).as_ref());
            let before = point.pressure_pa;
            point.area_m2 * (p * p - before * before) / (2.0 * self.stiffness_pa_m)
        };
        self.points.iter().map(one).sum()
    }

    /// Forces at all active contact points. With `convex`, the stiffness omits the term of the
    /// tool's curvature, because that term is negative.
    pub(crate) fn contact_forces<'s>(
        &'s self,
        rest: &'s [Vec3],
        u: &'s [Vec3],
        shift: &'s Vec3,
        convex: bool,
    ) -> impl Iterator<Item = ContactForce> + 's {
        self.points.iter().filter_map(move |point| {
            let separation = self.separation(point, rest, u, shift)?;
            let pressure = self.pressure(point, Some(&separation));
            if pressure <= 0.0 {
                return None;
            }
            let normal = separation.normal;
            let mut stiffness = normal * normal.transpose() * self.stiffness_pa_m;
            if !convex {
                stiffness -= separation.normal_gradient * pressure;
            }
            Some(ContactForce {
                nodes: point.nodes,
                shares: point.values,
                at_m: Self::at(point, rest, u),
                force_n: normal * (pressure * point.area_m2),
                stiffness: stiffness * point.area_m2,
            })
        })
    }

    /// True if the pressures differ from their multipliers by at most `share` of the force in
    /// total. Otherwise the pressures become the new multipliers.
    pub(crate) fn converged_or_augment(
        &mut self,
        rest: &[Vec3],
        u: &[Vec3],
        shift: &Vec3,
        share: f64,
    ) -> bool {
        let now = |point: &ContactPoint| {
            self.pressure(point, self.separation(point, rest, u, shift).as_ref())
        };
        let pressures: Vec<f64> = self.points.iter().map(now).collect();
        let (mut change, mut force) = (0.0, 0.0);
        for (point, p) in self.points.iter().zip(&pressures) {
            change += point.area_m2 * (p - point.pressure_pa).abs();
            force += point.area_m2 * p;
        }
        let is_converged = change <= share * force;
        if !is_converged {
            self.restore(&pressures);
        }
        is_converged
    }

    pub(crate) fn pressures(&self) -> Vec<f64> {
        self.points.iter().map(|p| p.pressure_pa).collect()
    }

    pub(crate) fn restore(&mut self, pressures: &[f64]) {
        for (point, &p) in self.points.iter_mut().zip(pressures) {
            point.pressure_pa = p;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal and bend are the first and second derivative of the separation: beside the bar,
    /// beyond its ends, and behind it.
    #[test]
    fn normal_and_bend_of_a_bar_are_derivatives_of_its_separation() {
        let bar = Bar {
            ends_m: [Vec3::new(0.0, 0.0, 0.1), Vec3::new(0.2, 0.1, 0.0)],
            radius_m: 0.03,
        };
        let step = 1e-5;
        let back = Vec3::new(0.1, -0.2, 1.0).normalize();
        let places = [
            Vec3::new(0.1, 0.2, 0.1),
            Vec3::new(-0.1, 0.05, 0.2),
            Vec3::new(0.3, 0.1, -0.1),
            Vec3::new(0.12, 0.02, 0.15),
        ];
        for (x, behind) in places.iter().flat_map(|x| [(x, None), (x, Some(&back))]) {
            let here = bar.separation(x, behind).expect("off the axis");
            for axis in 0..3 {
                let mut by = Vec3::zeros();
                by[axis] = step;
                let (next, before) = (
                    bar.separation(&(x + by), behind),
                    bar.separation(&(x - by), behind),
                );
                let (next, before) = (next.expect("off"), before.expect("off"));
                let slope = (next.separation_m - before.separation_m) / (2.0 * step);
                assert!((slope - here.normal[axis]).abs() < 1e-6);
                let turn = (next.normal - before.normal) / (2.0 * step);
                assert!((turn - here.normal_gradient.column(axis)).norm() < 1e-4);
            }
        }
        let ball = Bar {
            ends_m: [Vec3::zeros(); 2],
            radius_m: 0.01,
        };
        let above = ball.separation(&(Vec3::z() * 0.03), None).expect("off");
        assert!((above.separation_m - 0.02).abs() < 1e-12);
    }

    /// A point above the bar is treated as if it were at the height of the axis, so it is pushed
    /// out sideways. Below the bar, `behind` changes nothing.
    #[test]
    fn a_point_above_a_bar_is_pushed_out_sideways() {
        let bar = Bar {
            ends_m: [-Vec3::x(), Vec3::x()],
            radius_m: 0.0015,
        };
        let separation = |x: Vec3| bar.separation(&x, Some(&Vec3::z())).expect("off the axis");
        let above = separation(Vec3::new(0.0, 1e-4, 0.004));
        assert!((above.separation_m - (1e-4 - 0.0015)).abs() < 1e-12);
        assert!((above.normal - Vec3::y()).norm() < 1e-9);
        let below = separation(Vec3::new(0.0, 1e-4, -0.004));
        let alone = bar.separation(&Vec3::new(0.0, 1e-4, -0.004), None);
        assert!((below.normal - alone.expect("off the axis").normal).norm() < 1e-12);
    }
}
