//! Cuts polygons into triangles by clipping ears (Meisters 1975).
//!
//! Every corner of the polygon stays a corner of a triangle, even if it lies in a straight line
//! with its neighbours. Libraries such as earcut leave such corners out. The surface would then be
//! open where the next face uses them.

use robust::{Coord, orient2d};

use super::malformed;
use crate::Vec3;
use crate::error::MeshProblem;

/// Largest number of corners of a polygon. The work grows with the square of this number.
const CORNERS_MAX: usize = 10_000;

type Point = Coord<f64>;

/// Adds a polygon's triangles, with the polygon's orientation. A corner that is repeated at once
/// counts once. A polygon of fewer than three corners has no triangles.
///
/// # Errors
/// When the polygon has too many corners.
pub(super) fn push_polygon(
    triangles: &mut Vec<[u32; 3]>,
    polygon: &[u32],
    vertices: &[Vec3],
) -> Result<(), MeshProblem> {
    if let &[a, b, c] = polygon {
        triangles.push([a, b, c]);
        return Ok(());
    }
    let mut corners = polygon.to_vec();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    if corners.len() < 3 {
        return Ok(());
    }
    if corners.len() > CORNERS_MAX {
        let detail = format!(
            "a polygon has {} corners; allowed: at most {CORNERS_MAX}; triangulate it in the exporter",
            corners.len()
        );
        return Err(malformed("polygon", &detail));
    }
    match flat(&corners, vertices) {
        Some(points) => clip(triangles, &corners, &points),
        // A vertex does not exist, and mending refuses the mesh later; or the polygon has no area
        // and so no ears.
        None => fan(triangles, &corners),
    }
    Ok(())
}

fn fan(triangles: &mut Vec<[u32; 3]>, corners: &[u32]) {
    for pair in corners[1..].windows(2) {
        triangles.push([corners[0], pair[0], pair[1]]);
    }
}

/// The corners in two dimensions, anticlockwise: without the coordinate along the axis nearest to
/// the polygon's normal. The others are not rounded, so that the predicates are exact. `None` if
/// the polygon has no area, or a vertex does not exist.
fn flat(corners: &[u32], vertices: &[Vec3]) -> Option<Vec<Point>> {
    let points: Option<Vec<Vec3>> = corners
        .iter()
        .map(|&i| vertices.get(i as usize).copied())
        .collect();
    let points = points?;
    let from = points[0];
    let normal: Vec3 = (1..points.len() - 1)
        .map(|i| (points[i] - from).cross(&(points[i + 1] - from)))
        .sum();
    let axis = normal.iamax();
    if normal[axis] == 0.0 || !normal[axis].is_finite() {
        return None;
    }
    let (mut right, mut up) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        std::mem::swap(&mut right, &mut up);
    }
    let seen = |p: &Vec3| Point {
        x: p[right],
        y: p[up],
    };
    Some(points.iter().map(seen).collect())
}

/// Ring of the corners that are left. Corners are numbers of `points`.
struct Ring<'a> {
    points: &'a [Point],
    before: Vec<usize>,
    after: Vec<usize>,
    /// True for corners that are known to be ears. Clipping an ear may make others, which a new
    /// search finds.
    ear: Vec<bool>,
    left: usize,
}

/// Clips ears until one triangle is left. If no ear is left, as in a polygon that crosses itself,
/// any corner is clipped, so that every edge is used.
fn clip(triangles: &mut Vec<[u32; 3]>, corners: &[u32], points: &[Point]) {
    let count = corners.len();
    let mut ring = Ring {
        points,
        before: (0..count).map(|i| (i + count - 1) % count).collect(),
        after: (0..count).map(|i| (i + 1) % count).collect(),
        ear: vec![false; count],
        left: count,
    };
    let mut at = 0;
    ring.search(at);
    while ring.left > 3 {
        let Some(tip) = ring.next_ear(at) else {
            if !ring.search(at) {
                ring.ear[at] = true;
            }
            continue;
        };
        let (before, after) = (ring.before[tip], ring.after[tip]);
        triangles.push([corners[before], corners[tip], corners[after]]);
        ring.ear[tip] = false;
        ring.after[before] = after;
        ring.before[after] = before;
        ring.left -= 1;
        ring.ear[before] = ring.is_ear(before);
        ring.ear[after] = ring.is_ear(after);
        // Going on beyond the clipped ear avoids a fan of slivers.
        at = ring.after[after];
    }
    triangles.push([ring.before[at], at, ring.after[at]].map(|i| corners[i]));
}

impl Ring<'_> {
    /// The corners that are left, from `at` on.
    fn corners(&self, at: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(at), |&i| Some(self.after[i])).take(self.left)
    }

    fn next_ear(&self, at: usize) -> Option<usize> {
        self.corners(at).find(|&i| self.ear[i])
    }

    /// Looks for ears among all corners. Returns true if there is one.
    fn search(&mut self, at: usize) -> bool {
        let ears: Vec<usize> = self.corners(at).filter(|&i| self.is_ear(i)).collect();
        for &i in &ears {
            self.ear[i] = true;
        }
        !ears.is_empty()
    }

    /// True if the corner is convex and no other corner lies in its triangle or on the triangle's
    /// border.
    fn is_ear(&self, tip: usize) -> bool {
        let [a, b, c] = [self.before[tip], tip, self.after[tip]].map(|i| self.points[i]);
        if orient2d(a, b, c) <= 0.0 {
            return false;
        }
        let low = Point {
            x: a.x.min(b.x).min(c.x),
            y: a.y.min(b.y).min(c.y),
        };
        let high = Point {
            x: a.x.max(b.x).max(c.x),
            y: a.y.max(b.y).max(c.y),
        };
        let blocks = |i: usize| {
            let p = self.points[i];
            let near = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
            // A bridge connects a hole to the outline, and its corners occur twice.
            let corner = [a, b, c].contains(&p);
            near && !corner
                && orient2d(a, b, p) >= 0.0
                && orient2d(b, c, p) >= 0.0
                && orient2d(c, a, p) >= 0.0
        };
        !self
            .corners(self.after[self.after[tip]])
            .take(self.left - 3)
            .any(blocks)
    }
}
