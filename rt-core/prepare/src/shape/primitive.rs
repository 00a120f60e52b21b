//! Bodies from which organs are made, and operations on their distances. Distances are in m,
//! negative inside.

use crate::Vec3;

/// Union of two bodies (smooth minimum). The seam is rounded over about `k` metres.
pub(super) fn join(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k / 4.0
}

/// Intersection of two bodies (smooth maximum). The edge is rounded over about `k` metres.
pub(super) fn meet(a: f64, b: f64, k: f64) -> f64 {
    -join(-a, -b, k)
}

/// Body `a` without body `b`. The edge is rounded over about `k` metres.
pub(super) fn carve(a: f64, b: f64, k: f64) -> f64 {
    meet(a, -b, k)
}

/// Body `a` without what is nearer than `gap` to the tube, as [`carve`] does it. Where the tube
/// changes nothing its distance is not computed.
pub(super) fn carve_tube(a: f64, tube: &Tube, gap: f64, k: f64, p: &Vec3) -> f64 {
    // From `a + b = k` on, `carve` returns `a`.
    carve(a, tube.distance_below(p, k - a + gap + ROUNDING_M) - gap, k)
}

/// Distance to an ellipsoid, exact to first order near the surface.
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

/// Distance to the half space on the inner side of a plane.
pub(super) fn half_space(p: &Vec3, point: [f64; 3], outward: [f64; 3]) -> f64 {
    (p - Vec3::from(point)).dot(&Vec3::from(outward).normalize())
}

/// A point of a centre line and the radius there.
pub(super) type Through = ([f64; 3], f64);

/// A tube along a Catmull–Rom curve through points that each have a radius, approximated by round
/// cones.
#[derive(Debug, Clone)]
pub(super) struct Tube {
    points: Vec<(Vec3, f64)>,
    /// Middle and radius of a ball around the whole tube.
    around: Ball,
    /// Groups of up to [`TOGETHER`] cones, each with a ball around the group. A group is skipped if
    /// its ball is farther away than the nearest cone found.
    parts: Vec<(Ball, Vec<Cone>)>,
}

type Ball = (Vec3, f64);

/// A round cone between two points of a tube.
#[derive(Debug, Clone)]
struct Cone {
    from: Vec3,
    radius: f64,
    along: Vec3,
    /// Square of the length of `along`, m².
    along_squared: f64,
    wider: f64,
}

/// Largest number of cones in a part of a tube.
const TOGETHER: usize = 6;
/// Largest error by which rounding makes the ball around a group too small, m.
pub(super) const ROUNDING_M: f64 = 1e-9;

/// A ball around points with radii. It also contains the cones between the points.
fn ball_around(points: &[(Vec3, f64)]) -> Ball {
    let middle = points.iter().map(|(p, _)| p).sum::<Vec3>() / points.len() as f64;
    let reach = points
        .iter()
        .map(|(p, r)| (p - middle).norm() + r)
        .fold(0.0, f64::max);
    (middle, reach)
}

/// Beyond this distance from a tube's ball, a lower bound of the distance is enough, m.
const FAR_M: f64 = 0.03;

impl Tube {
    /// A tube through these points with these radii, with `steps` cones from each to the next.
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
        let cone = |pair: &[(Vec3, f64)]| {
            let ((a, ra), (b, rb)) = (pair[0], pair[1]);
            Cone {
                from: a,
                radius: ra,
                along: b - a,
                along_squared: (b - a).norm_squared(),
                wider: rb - ra,
            }
        };
        let parts = (0..points.len() - 1).step_by(TOGETHER).map(|first| {
            let part = &points[first..(first + TOGETHER + 1).min(points.len())];
            (ball_around(part), part.windows(2).map(cone).collect())
        });
        Self {
            around: ball_around(&points),
            parts: parts.collect(),
            points,
        }
    }

    /// The box around the tube.
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

    /// Approximate distance to the tube: that of the nearest cone. A cone's distance is the
    /// distance to its axis less its radius at the nearest point of the axis. Farther than
    /// [`FAR_M`] from the tube's ball, the result is a lower bound.
    pub(super) fn distance(&self, p: &Vec3) -> f64 {
        self.distance_below(p, f64::INFINITY)
    }

    /// The result of [`Self::distance`] if that is below `limit_m`, else any number from `limit_m`
    /// upwards. Cones beyond the limit cost little.
    pub(super) fn distance_below(&self, p: &Vec3, limit_m: f64) -> f64 {
        let (middle, reach) = self.around;
        let at_least = (p - middle).norm() - reach;
        if at_least > FAR_M {
            return at_least;
        }
        if at_least - ROUNDING_M >= limit_m {
            return limit_m;
        }
        let at_least = |(middle, reach): &Ball| (p - middle).norm() - reach - ROUNDING_M;
        let nearest = |cones: &[Cone]| {
            let distances = cones.iter().map(|cone| cone.distance(p));
            distances.fold(f64::INFINITY, f64::min)
        };
        let mut first = (0, limit_m);
        for (number, (around, _)) in self.parts.iter().enumerate() {
            let near = at_least(around);
            if near < first.1 {
                first = (number, near);
            }
        }
        if first.1 >= limit_m {
            return limit_m;
        }
        let mut least = limit_m;
        if let Some((_, cones)) = self.parts.get(first.0) {
            least = least.min(nearest(cones));
        }
        for (number, (around, cones)) in self.parts.iter().enumerate() {
            if number != first.0 && at_least(around) < least {
                least = least.min(nearest(cones));
            }
        }
        least
    }
}

impl Cone {
    fn distance(&self, p: &Vec3) -> f64 {
        let t = ((p - self.from).dot(&self.along) / self.along_squared).clamp(0.0, 1.0);
        (p - self.from - self.along * t).norm() - (self.radius + self.wider * t)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Skipping groups gives the same bits as the distance to every cone.
        #[test]
        fn what_is_left_out_is_never_nearest(
            through in prop::collection::vec((prop::array::uniform3(-0.1f64..0.1), 0.001f64..0.03), 2..9),
            at in prop::array::uniform3(-0.15f64..0.15),
        ) {
            let tube = Tube::new(&through, 6);
            let p = Vec3::from(at);
            let cones = tube.parts.iter().flat_map(|(_, cones)| cones);
            let plain = cones.map(|cone| cone.distance(&p)).fold(f64::INFINITY, f64::min);
            let told = tube.distance(&p);
            let (middle, reach) = tube.around;
            let is_far = (p - middle).norm() - reach > FAR_M;
            prop_assert!(told.to_bits() == plain.to_bits() || is_far && told <= plain, "{told} {plain}");
        }

        /// A limit changes no distance below it, and no body from which the tube is carved.
        #[test]
        fn a_limit_changes_only_what_is_beyond_it(
            through in prop::collection::vec((prop::array::uniform3(-0.1f64..0.1), 0.001f64..0.03), 2..9),
            at in prop::array::uniform3(-0.15f64..0.15),
            limit_m in -0.02f64..0.05,
            a in -0.03f64..0.03,
            k in 0.001f64..0.03,
        ) {
            let tube = Tube::new(&through, 6);
            let p = Vec3::from(at);
            let (plain, told) = (tube.distance(&p), tube.distance_below(&p, limit_m));
            let is_same = told.to_bits() == plain.to_bits();
            prop_assert!(is_same || plain >= limit_m && told >= limit_m, "{told} {plain}");
            let (plain, told) = (carve(a, plain - 1e-3, k), carve_tube(a, &tube, 1e-3, k, &p));
            prop_assert!(told.to_bits() == plain.to_bits(), "{told} {plain}");
        }
    }
}
