//! Closest point of a moving skin, found by a walk over its triangles.

use heapless::Vec;

use crate::contact::law;
use crate::contact::patch::{Patch, PatchBuilder};
use crate::contact::skin::vertex_cache::VertexCache;
use crate::math::{self, Vec3};
use crate::scene::{Scene, Skin};
use crate::tissue::Bodies;

/// Directions, in the plane of the skin, from the middle of a wide patch to six places around it
/// (the ring).
const RING_DIRECTIONS: [[f32; 2]; 6] = [
    [1.0, 0.0],
    [0.5, 0.866_025_4],
    [-0.5, 0.866_025_4],
    [-1.0, 0.0],
    [-0.5, -0.866_025_4],
    [0.5, -0.866_025_4],
];
/// Shares of a wide patch's force: of its middle, and of each place of the ring.
const RING_SHARES: [f32; 2] = [0.25, 0.125];
/// Largest number of steps of a walk. A tool at 3 m/s crosses one vertex in a tick.
const WALK_STEPS_MAX: u32 = 12;

/// The skin's closest point to a tool point.
#[derive(Debug, Clone)]
pub(crate) struct ClosestPoint {
    /// Spheres that carry the point.
    pub(crate) patch: Patch,
    /// Corners of the triangle that holds the point.
    corners: [u16; 3],
    /// Barycentric coordinates of the point in the triangle.
    shares: [f32; 3],
    /// Outward unit normal, blended from the corners.
    pub(crate) normal: Vec3,
    /// Position on the curved skin, world frame, m.
    pub(crate) at_m: Vec3,
    /// Corner at which the next walk starts.
    pub(crate) vertex: u16,
    /// Width A of the Gaussian patch, m.
    pub(crate) patch_width_m: f32,
    /// Mean curvature at rest, 1/m.
    pub(crate) curvature_per_m: f32,
}

impl ClosestPoint {
    /// Depth by which the skin has sunk because tissue under it was removed, m.
    pub(crate) fn sunk_m(&self, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
        let mut sum_m = 0.0;
        for (corner, share) in self.corners.iter().zip(self.shares) {
            sum_m += bodies.cells.sunk_m(*corner, scene) * share;
        }
        sum_m
    }

    /// Spreads the patch by a Gaussian `exp(−r²/B²)` of width B, m. A tip wider than the spacing of
    /// the spheres presses on all spheres under it.
    pub(crate) fn spread(
        &mut self,
        width_m: f32,
        skin: &Skin<'_>,
        bodies: &Bodies,
        cache: &mut VertexCache,
    ) {
        let [middle, each_in_ring] = RING_SHARES;
        // Middle and ring together have the mean square distance of the Gaussian.
        let radius_m = width_m / math::sqrt(1.0 - middle);
        let x = math::perpendicular(&self.normal);
        let y = self.normal.cross(&x);
        let mut weights = VertexWeights::default();
        weights.add(self.corners, self.shares, middle);
        for [along_x, along_y] in RING_DIRECTIONS {
            let place_m = self.at_m + (x * along_x + y * along_y) * radius_m;
            let found = nearest(&place_m, self.vertex, skin, bodies, cache);
            let (corners, shares) = found.map_or((self.corners, self.shares), |found| {
                (found.corners, found.shares)
            });
            weights.add(corners, shares, each_in_ring);
        }
        self.patch = weights.patch(skin);
        // The separation is measured at the middle. The middle sinks under its own share of the
        // force and by the influence of the ring. A single patch of the width computed here sinks
        // as much.
        let ring_influence = law::mesh_influence(radius_m, self.patch_width_m);
        self.patch_width_m /= middle + (1.0 - middle) * ring_influence;
    }
}

/// Vertices of a skin, each once, and their weights.
#[derive(Debug, Default)]
struct VertexWeights(Vec<(u16, f32), { 3 * (RING_DIRECTIONS.len() + 1) }>);

impl VertexWeights {
    /// Adds a point of a triangle with this weight; `shares` are its barycentric coordinates.
    fn add(&mut self, corners: [u16; 3], shares: [f32; 3], weight: f32) {
        for (corner, share) in corners.into_iter().zip(shares) {
            match self.0.iter_mut().find(|(own, _)| *own == corner) {
                Some((_, sum)) => *sum += share * weight,
                None => {
                    let _ = self.0.push((corner, share * weight)); // room for middle and ring
                }
            }
        }
    }

    fn patch(&self, skin: &Skin<'_>) -> Patch {
        let mut patch = PatchBuilder::default();
        for (vertex, share) in &self.0 {
            let Some(vertex) = skin.vertex(*vertex) else {
                continue;
            };
            for (sphere, weight) in vertex.spheres.into_iter().zip(vertex.weights) {
                patch.add(sphere, weight * share);
            }
        }
        patch.patch
    }
}

/// State of a walk: the best point so far.
struct Nearest {
    squared_m2: f32,
    corners: [u16; 3],
    shares: [f32; 3],
}

/// Closest point that a walk from vertex `from` reaches; every step of the walk reduces the
/// distance. The result is a local minimum, so a tool that went in on one side stays on that side.
pub(crate) fn walk(
    place_m: &Vec3,
    from: u16,
    skin: &Skin<'_>,
    bodies: &Bodies,
    cache: &mut VertexCache,
) -> Option<ClosestPoint> {
    let found = nearest(place_m, from, skin, bodies, cache)?;
    interpolate(&found, skin, bodies, cache)
}

fn nearest(
    place_m: &Vec3,
    from: u16,
    skin: &Skin<'_>,
    bodies: &Bodies,
    cache: &mut VertexCache,
) -> Option<Nearest> {
    let mut vertex = from;
    let mut best: Option<Nearest> = None;
    for _ in 0..WALK_STEPS_MAX {
        let found = nearest_in_fan(place_m, vertex, skin, bodies, cache)?;
        let is_nearer = best
            .as_ref()
            .is_none_or(|best| found.squared_m2 < best.squared_m2);
        if !is_nearer {
            break;
        }
        let next = found.corner();
        best = Some(found);
        if next == vertex {
            break;
        }
        vertex = next;
    }
    best
}

impl Nearest {
    /// The corner with the largest share.
    fn corner(&self) -> u16 {
        let [a, b, c] = self.shares;
        let [i, j, k] = self.corners;
        if a >= b && a >= c {
            i
        } else if b >= c {
            j
        } else {
            k
        }
    }
}

/// Closest point of the triangles around a vertex.
fn nearest_in_fan(
    place_m: &Vec3,
    vertex: u16,
    skin: &Skin<'_>,
    bodies: &Bodies,
    cache: &mut VertexCache,
) -> Option<Nearest> {
    let center_m = cache.at_m(vertex, skin, bodies)?;
    let mut best: Option<Nearest> = None;
    let mut last: Option<(u16, Vec3)> = None;
    for &[b, c] in skin.fan(skin.vertex(vertex)?) {
        // Neighbouring triangles of a fan share a corner, which was just looked up.
        let b_m = match last {
            Some((own, at)) if own == b => at,
            _ => cache.at_m(b, skin, bodies)?,
        };
        let c_m = cache.at_m(c, skin, bodies)?;
        last = Some((c, c_m));
        let shares = closest_on_triangle(place_m, &center_m, &b_m, &c_m);
        let [s, t, u] = shares;
        let squared_m2 = (center_m * s + b_m * t + c_m * u - place_m).norm_squared();
        if best
            .as_ref()
            .is_none_or(|best| squared_m2 < best.squared_m2)
        {
            best = Some(Nearest {
                squared_m2,
                corners: [vertex, b, c],
                shares,
            });
        }
    }
    best
}

/// Position, normal, patch and curvature of a point of a triangle, from the triangle's corners.
fn interpolate(
    found: &Nearest,
    skin: &Skin<'_>,
    bodies: &Bodies,
    cache: &mut VertexCache,
) -> Option<ClosestPoint> {
    let [i, j, k] = found.corners;
    let mut corner = |index: u16| {
        let vertex = skin.vertex(index)?;
        let normal = cache.normal(index, skin, bodies)?;
        Some((cache.at_m(index, skin, bodies)?, normal, vertex))
    };
    let corners = [corner(i)?, corner(j)?, corner(k)?];
    let mut flat_m = Vec3::zeros();
    let (mut blended, mut patch_width_m, mut curvature_per_m) = (Vec3::zeros(), 0.0, 0.0);
    for ((at_m, normal, vertex), share) in corners.iter().zip(found.shares) {
        flat_m += at_m * share;
        blended += normal * share;
        patch_width_m += vertex.patch_m * share;
        curvature_per_m += vertex.curvature_per_m * share;
    }
    let normal = math::unit(&blended)?;
    // Half of Phong tessellation (Boubekeur and Alexa 2008). On a sphere this is the height of the
    // arc.
    let mut bulge_m = 0.0;
    for ((at_m, own, _), share) in corners.iter().zip(found.shares) {
        bulge_m += 0.5 * share * (at_m - flat_m).dot(own) * own.dot(&normal);
    }
    let mut weights = VertexWeights::default();
    weights.add(found.corners, found.shares, 1.0);
    Some(ClosestPoint {
        patch: weights.patch(skin),
        corners: found.corners,
        shares: found.shares,
        normal,
        at_m: flat_m + normal * bulge_m,
        vertex: found.corner(),
        patch_width_m,
        curvature_per_m,
    })
}

/// Barycentric shares of the point of a triangle closest to `p` (Ericson 2004, section 5.1.5).
fn closest_on_triangle(p: &Vec3, a: &Vec3, b: &Vec3, c: &Vec3) -> [f32; 3] {
    let (ab, ac) = (b - a, c - a);
    let ap = p - a;
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = share(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = share(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = share(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    let (v, w) = (share(vb, sum), share(vc, sum));
    [1.0 - v - w, v, w]
}

/// `part / whole`, or zero where `whole` is not positive.
fn share(part: f32, whole: f32) -> f32 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::vector;
    use proptest::prelude::*;

    proptest! {
        /// No point of the triangle is closer than the closest point.
        #[test]
        fn no_point_of_the_triangle_is_closer(p in vector(2.0), a in vector(1.0), b in vector(1.0), c in vector(1.0),
                          u in 0.0f32..1.0, v in 0.0f32..1.0) {
            let [r, s, t] = closest_on_triangle(&p, &a, &b, &c);
            prop_assert!(r >= -1.0e-5 && s >= -1.0e-5 && t >= -1.0e-5);
            prop_assert!((r + s + t - 1.0).abs() < 1.0e-5);
            let found = math::norm(&(a * r + b * s + c * t - p));
            let (v, w) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let other = math::norm(&(a + (b - a) * v + (c - a) * w - p));
            prop_assert!(found <= other + 1.0e-3, "{found} {other}");
        }
    }
}
