//! The paper's packing: spheres on an approximate medial axis, which touch the surface from inside
//! (Eq. 1), and further spheres in the gaps between neighbours (Eq. 2).

use super::{Ball, Interior};
use crate::Vec3;

/// Share of the spheres that lie on the medial axis. The others fill gaps.
const AXIS_SHARE: f64 = 0.5;
/// A new centre on the medial axis is farther from each earlier sphere's centre than this share of
/// the earlier sphere's radius.
const AXIS_SPACING: f64 = 0.6;
/// Number of neighbours of each sphere towards which gaps are filled.
const NEIGHBOURS: usize = 6;

/// Paper Eq. 2: the sphere in the middle of the gap between two spheres, on the line of their
/// centres, which are `d` apart. Its centre is `c = c1 + (c2 − c1)·(d + r1 − r2)/(2d)`, its radius
/// `depth(c)`. `None` if the two centres coincide.
pub fn filling_sphere(a: &Ball, b: &Ball, depth: impl Fn(&Vec3) -> f64) -> Option<Ball> {
    let between = b.center - a.center;
    let d = between.norm();
    if d <= 0.0 {
        return None;
    }
    let center = a.center + between * ((d + a.radius_m - b.radius_m) / (2.0 * d));
    let radius_m = depth(&center);
    Some(Ball { center, radius_m })
}

/// Packs up to this many spheres as the paper does.
#[must_use]
pub fn pack_as_paper(interior: &Interior<'_>, count: usize) -> Vec<Ball> {
    let mut balls = medial_axis(interior, (count as f64 * AXIS_SHARE).ceil() as usize);
    fill(interior, &mut balls, count);
    balls
}

/// Takes inscribed spheres, the largest first. A sphere whose centre lies too close to an earlier
/// one's is left out ([`AXIS_SPACING`]).
fn medial_axis(interior: &Interior<'_>, count: usize) -> Vec<Ball> {
    let field = &interior.field;
    let mut deepest: Vec<u32> = interior.points.clone();
    deepest.sort_by(|a, b| {
        let depth = |i: &u32| field.distance_m[*i as usize];
        depth(a).total_cmp(&depth(b)).then(a.cmp(b))
    });
    let mut balls: Vec<Ball> = Vec::new();
    for point in deepest {
        if balls.len() == count {
            break;
        }
        let center = interior.position(point);
        let free = |b: &Ball| (b.center - center).norm() > AXIS_SPACING * b.radius_m;
        if balls.iter().all(free) {
            // The radius (Eq. 1) is the exact distance from the surface, not the grid's.
            balls.push(interior.inscribed(center, f64::INFINITY));
        }
    }
    balls
}

/// Fills gaps between neighbours, widest first, until there are `count` spheres.
fn fill(interior: &Interior<'_>, balls: &mut Vec<Ball>, count: usize) {
    let smallest = 0.15 * interior.spacing_m;
    while balls.len() < count {
        let mut offers: Vec<(f64, Ball)> = Vec::new();
        for (i, a) in balls.iter().enumerate() {
            let mut near: Vec<(f64, usize)> = balls
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(j, b)| ((b.center - a.center).norm() - a.radius_m - b.radius_m, j))
                .collect();
            near.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            for &(_, j) in near.iter().take(NEIGHBOURS).filter(|(_, j)| *j > i) {
                let offer = filling_sphere(a, &balls[j], |c| interior.depth(c));
                if let Some(new) = offer.filter(|new| new.radius_m > smallest) {
                    // Depth of the new sphere's centre below an old sphere's surface.
                    let inside = |b: &Ball| b.radius_m - (b.center - new.center).norm();
                    let hidden = balls.iter().map(inside).fold(f64::NEG_INFINITY, f64::max);
                    offers.push((new.radius_m - hidden, new));
                }
            }
        }
        offers.sort_by(|a, b| b.0.total_cmp(&a.0));
        let before = balls.len();
        let room = (count - before).min(1 + before / 4);
        for (gain, new) in offers {
            if balls.len() == before + room || gain <= 0.1 * interior.spacing_m {
                break;
            }
            // Of offers for one gap, take the first.
            let apart = |b: &Ball| (b.center - new.center).norm() > 0.3 * interior.spacing_m;
            if balls[before..].iter().all(apart) {
                balls.push(new);
            }
        }
        if balls.len() == before {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The centres of two balls of radius 1 and 2 are 6 apart. From the first centre, the gap
    /// reaches from 1 to 4, and its middle is at 2.5.
    #[test]
    fn equation_2_puts_the_new_sphere_into_the_middle_of_the_gap() {
        let a = Ball {
            center: Vec3::new(1.0, 0.0, 0.0),
            radius_m: 1.0,
        };
        let b = Ball {
            center: Vec3::new(7.0, 0.0, 0.0),
            radius_m: 2.0,
        };
        let new = filling_sphere(&a, &b, |c| c.x).unwrap();
        assert!((new.center - Vec3::new(3.5, 0.0, 0.0)).norm() < 1e-12);
        assert!((new.radius_m - 3.5).abs() < 1e-12, "radius is D(c)");
        let same = filling_sphere(&b, &a, |c| c.x).unwrap();
        assert!(
            (same.center - new.center).norm() < 1e-12,
            "order does not matter"
        );
        assert!(filling_sphere(&a, &a, |_| 1.0).is_none());
    }
}
