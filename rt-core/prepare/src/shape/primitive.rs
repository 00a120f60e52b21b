//! Pieces that organs are put together from. Distances are negative inside.

use crate::Vec3;

/// Smooth minimum: joins two bodies; the seam is rounded over about `k` metres.
pub(super) fn join(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k / 4.0
}

/// Smooth maximum: what two bodies have in common; the edge is rounded over about `k` metres.
pub(super) fn meet(a: f64, b: f64, k: f64) -> f64 {
    -join(-a, -b, k)
}

/// Takes `b` away from `a`.
pub(super) fn carve(a: f64, b: f64, k: f64) -> f64 {
    meet(a, -b, k)
}

/// About the distance to an ellipsoid (first order; exact on the surface).
pub(super) fn ellipsoid(p: &Vec3, center: [f64; 3], radii: [f64; 3]) -> f64 {
    let q = p - Vec3::from(center);
    let radii = Vec3::from(radii);
    let k0 = q.component_div(&radii).norm();
    let k1 = q.component_div(&radii.component_mul(&radii)).norm();
    if k1 < 1e-12 {
        -radii.min()
    } else {
        k0 * (k0 - 1.0) / k1
    }
}

/// Distance to a ball.
pub(super) fn ball(p: &Vec3, center: [f64; 3], radius: f64) -> f64 {
    (p - Vec3::from(center)).norm() - radius
}

/// Distance to the half space behind a plane.
pub(super) fn half_space(p: &Vec3, point: [f64; 3], outward: [f64; 3]) -> f64 {
    (p - Vec3::from(point)).dot(&Vec3::from(outward).normalize())
}

/// A point of a centre line and the radius there.
pub(super) type Through = ([f64; 3], f64);

/// A curve with a radius along it: Catmull–Rom through its points, drawn as round cones.
#[derive(Debug, Clone)]
pub(super) struct Tube {
    points: Vec<(Vec3, f64)>,
    /// A ball around all of it.
    around: (Vec3, f64),
}

/// Farther away than this from a tube, its exact distance does not matter, m.
const FAR_M: f64 = 0.03;

impl Tube {
    /// Through these points with these radii, `steps` cones between two of them.
    pub(super) fn new(through: &[Through], steps: usize) -> Self {
        let knot = |i: isize| {
            let i = i.clamp(0, through.len() as isize - 1) as usize;
            let (p, r) = through[i];
            nalgebra::Vector4::new(p[0], p[1], p[2], r)
        };
        let mut points = Vec::new();
        for i in 0..through.len() as isize - 1 {
            let [a, b, c, d] = [knot(i - 1), knot(i), knot(i + 1), knot(i + 2)];
            for step in 0..steps {
                let t = step as f64 / steps as f64;
                let q = (b * 2.0
                    + (c - a) * t
                    + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t)
                    + (b * 3.0 - a - c * 3.0 + d) * (t * t * t))
                    / 2.0;
                points.push((q.xyz(), q.w));
            }
        }
        let last = knot(through.len() as isize - 1);
        points.push((last.xyz(), last.w));
        let middle = points.iter().map(|(p, _)| p).sum::<Vec3>() / points.len() as f64;
        let reach = points
            .iter()
            .map(|(p, r)| (p - middle).norm() + r)
            .fold(0.0, f64::max);
        Self {
            points,
            around: (middle, reach),
        }
    }

    /// The box around it.
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        let low = self.points.iter().map(|(p, r)| p.add_scalar(-r));
        let high = self.points.iter().map(|(p, r)| p.add_scalar(*r));
        [
            low.reduce(|a, b| a.inf(&b)).unwrap_or_default(),
            high.reduce(|a, b| a.sup(&b)).unwrap_or_default(),
        ]
    }

    /// The largest radius.
    pub(super) fn widest(&self) -> f64 {
        self.points.iter().map(|(_, r)| *r).fold(0.0, f64::max)
    }

    /// About the distance to the tube: to the nearest cone, its radius taken at the foot of the
    /// perpendicular. Far away it is a lower bound.
    pub(super) fn distance(&self, p: &Vec3) -> f64 {
        let (middle, reach) = self.around;
        let at_least = (p - middle).norm() - reach;
        if at_least > FAR_M {
            return at_least;
        }
        let cone = |pair: &[(Vec3, f64)]| {
            let ((a, ra), (b, rb)) = (pair[0], pair[1]);
            let ab = b - a;
            let t = ((p - a).dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0);
            (p - a - ab * t).norm() - (ra + (rb - ra) * t)
        };
        self.points
            .windows(2)
            .map(cone)
            .fold(f64::INFINITY, f64::min)
    }
}
