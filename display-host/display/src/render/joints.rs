//! Junctions of ducts and vessels with other organs: a collar widens from the tube onto the organ
//! and hides the tube's cap and the seam. The collar looks like the tube at one end and like the
//! organ at the other, and follows the spheres of both.

use glam::{Quat, Vec3};
use shared_mem::scene::{OrganKind, OrganRecord, SceneFile, WEIGHT_SUM, WORLD};

use crate::skinning::{RestVertex, SkinMesh};

/// Number of points around a collar.
const AROUND: usize = 28;
/// Number of rows of a collar, from the tube to the organ.
const ROWS: usize = 16;
/// Distance before the tube's end at which a collar begins, in radii of the tube.
const BEFORE: f32 = 2.2;
/// Number of rounds that smooth the collar's foot: the ring of points that meets the organ.
const FOOT_ROUNDS: usize = 6;
/// A tube's end without attachments is free if it is farther than this from every other organ, m.
const REACH_M: f32 = 0.012;
/// Depth of the collar's rim below the organ's skin, m.
const SUNK_M: f32 = 0.0005;

/// An end of a tube.
struct End {
    at: Vec3,
    /// Outward direction along the tube.
    along: Vec3,
    radius_m: f32,
}

/// Adds a collar at every end of a tube that is near another organ.
pub(super) fn add(mesh: &mut SkinMesh, scene: &SceneFile) {
    for (number, organ) in scene.organs().iter().enumerate() {
        if !is_tube(organ.kind) {
            continue;
        }
        for end in ends(scene, organ) {
            let Some(other) = neighbour(scene, number, &end) else {
                continue;
            };
            if let Some((vertices, triangles)) = collar(mesh, organ, &scene.organs()[other], &end) {
                hide_cap(&mut mesh.vertices[range(organ.vertices)], &end);
                mesh.add_skinned(&vertices, &triangles);
            }
        }
    }
}

fn is_tube(kind: u32) -> bool {
    use OrganKind::{BileDuct, CysticArtery, CysticDuct, Vessel};
    [BileDuct, CysticArtery, CysticDuct, Vessel]
        .map(|k| k as u32)
        .contains(&kind)
}

fn range(pair: [u32; 2]) -> std::ops::Range<usize> {
    pair[0] as usize..(pair[0] + pair[1]) as usize
}

/// Both ends of a tube: the two spheres farthest apart along its links.
fn ends(scene: &SceneFile, organ: &OrganRecord) -> Vec<End> {
    let own = range(organ.spheres);
    let first = own.start;
    let spheres = &scene.spheres()[own];
    let links = &scene.links()[range(organ.links)];
    let at = |i: usize| Vec3::from(spheres[i].center_m);
    let away_from = |start: usize| {
        let mut far = vec![f32::INFINITY; spheres.len()];
        if let Some(far) = far.get_mut(start) {
            *far = 0.0;
        }
        // A round for each sphere is enough, and a tube has only a few dozen links.
        for _ in 0..spheres.len() {
            for link in links {
                let [a, b] = [link.a as usize - first, link.b as usize - first];
                let step = at(a).distance(at(b));
                far[a] = far[a].min(far[b] + step);
                far[b] = far[b].min(far[a] + step);
            }
        }
        far
    };
    let farthest = |far: &[f32]| {
        let known = far.iter().enumerate().filter(|(_, d)| d.is_finite());
        known
            .max_by(|a, b| a.1.total_cmp(b.1))
            .map_or(0, |(i, _)| i)
    };
    if spheres.len() < 4 {
        return Vec::new();
    }
    let one = farthest(&away_from(0));
    let far = away_from(one);
    let other = farthest(&far);
    let skin = &scene.vertices()[range(organ.vertices)];
    [one, other]
        .into_iter()
        .filter_map(|end| {
            let far = away_from(end);
            let size = spheres[end].radius_m;
            let inner = (0..spheres.len())
                .filter(|&i| far[i] > 2.0 * size)
                .min_by(|&a, &b| far[a].total_cmp(&far[b]))?;
            let along = (at(end) - at(inner)).normalize_or_zero();
            let wall = skin.iter().filter_map(|v| {
                let away = Vec3::from(v.position_m) - at(end);
                let is_near = away.length() < 4.0 * size && away.dot(along).abs() < 2.0 * size;
                // Vertices of the cap would give too small a radius.
                let is_wall = Vec3::from(v.normal).dot(along).abs() < 0.5;
                (is_near && is_wall).then(|| away.reject_from(along).length())
            });
            let mut wall: Vec<f32> = wall.collect();
            wall.sort_by(f32::total_cmp);
            let radius_m = *wall.get(wall.len() / 2)?;
            (wall.len() > 2 && along != Vec3::ZERO).then(|| End {
                at: at(end),
                along,
                radius_m,
            })
        })
        .collect()
}

/// Organ that a tube's end joins: the one with the most attachments there. Without attachments, it
/// is the nearest one within `REACH_M`. Fat and connective tissue do not count.
fn neighbour(scene: &SceneFile, tube: usize, end: &End) -> Option<usize> {
    let organs = scene.organs();
    let owner = |sphere: u32| {
        organs
            .iter()
            .position(|o| range(o.spheres).contains(&(sphere as usize)))
    };
    let takes = |other: usize| other != tube && may_join(organs[tube].kind, organs[other].kind);
    let mut ties = vec![0u32; organs.len()];
    for tie in scene.attachments().iter().filter(|tie| tie.b != WORLD) {
        for (own, other) in [(tie.a, tie.b), (tie.b, tie.a)] {
            let (Some(own_organ), Some(other)) = (owner(own), owner(other)) else {
                continue;
            };
            let at = Vec3::from(scene.spheres()[own as usize].center_m);
            if own_organ == tube && takes(other) && at.distance(end.at) < 5.0 * end.radius_m {
                ties[other] += 1;
            }
        }
    }
    let tied = (0..organs.len())
        .max_by_key(|&i| ties[i])
        .filter(|&i| ties[i] > 0);
    tied.or_else(|| {
        let nearest = |i: usize| {
            let skin = &scene.vertices()[range(organs[i].vertices)];
            let far = skin
                .iter()
                .map(|v| Vec3::from(v.position_m).distance(end.at));
            far.fold(f32::INFINITY, f32::min)
        };
        let found = (0..organs.len())
            .filter(|&i| takes(i))
            .map(|i| (nearest(i), i));
        let found = found.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (found.0 < REACH_M).then_some(found.1)
    })
}

/// True if a tube of this kind may end in an organ of the other kind. Arteries pass behind the
/// bowel and do not open into it.
fn may_join(tube: u32, other: u32) -> bool {
    use OrganKind::{ConnectiveTissue, CysticArtery, Fat, Intestine, Stomach, Vessel};
    let is_one_of = |kind: u32, of: [OrganKind; 2]| of.map(|it| it as u32).contains(&kind);
    let is_artery = is_one_of(tube, [Vessel, CysticArtery]);
    let is_soft = is_one_of(other, [Fat, ConnectiveTissue]);
    let is_passed = is_artery && is_one_of(other, [Stomach, Intestine]);
    !is_soft && !is_passed
}

/// Index of the nearest vertex.
fn nearest(vertices: &[RestVertex], to: Vec3) -> usize {
    let far = |v: &RestVertex| Vec3::from(v.position).distance_squared(to);
    let found = vertices
        .iter()
        .enumerate()
        .min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
    found.map_or(0, |(i, _)| i)
}

/// Vertices and triangles of the collar from the end of `tube` onto `other`. `None` if the skin of
/// `other` is too far away.
fn collar(
    mesh: &SkinMesh,
    tube: &OrganRecord,
    other: &OrganRecord,
    end: &End,
) -> Option<(Vec<RestVertex>, Vec<[u32; 3]>)> {
    let own = mesh
        .vertices
        .get(range(tube.vertices))
        .filter(|v| !v.is_empty())?;
    let onto = mesh
        .vertices
        .get(range(other.vertices))
        .filter(|v| !v.is_empty())?;
    let r = end.radius_m;
    // A junction of two tubes has less room than one of a tube and an organ.
    let wide = if is_tube(other.kind) { 1.5 } else { 2.1 } * r;
    let way = Way::new(end, onto)?;
    let side = end.along.any_orthonormal_vector();
    let up = end.along.cross(side);
    let mut rays = Vec::with_capacity(AROUND);
    for k in 0..AROUND {
        let turn = k as f32 / AROUND as f32 * core::f32::consts::TAU;
        let out = side * turn.cos() + up * turn.sin();
        let aim = way.ring(1.0, out, wide);
        let v = nearest(onto, aim);
        let (at, normal) = (Vec3::from(onto[v].position), Vec3::from(onto[v].normal));
        let foot = aim - normal * ((aim - at).dot(normal) + SUNK_M);
        if foot.distance(aim) > REACH_M.max(3.0 * wide) {
            return None;
        }
        let start = nearest(own, way.ring(0.0, out, r));
        rays.push((out, foot, v, start));
    }
    // On a narrow neck, neighbouring points of the foot may lie on different sides.
    for _ in 0..FOOT_ROUNDS {
        let feet: Vec<Vec3> = rays.iter().map(|ray| ray.1).collect();
        for (k, ray) in rays.iter_mut().enumerate() {
            let beside = feet[(k + 1) % AROUND] + feet[(k + AROUND - 1) % AROUND];
            ray.1 = feet[k] * 0.5 + beside * 0.25;
        }
    }
    let mut vertices = Vec::with_capacity(AROUND * (ROWS + 1));
    for row in 0..=ROWS {
        let t = row as f32 / ROWS as f32;
        // The rim moves with the other organ alone.
        let share = smooth((t - 0.1) / 0.75);
        let flare = smooth((t - 0.45) / 0.55).powi(2);
        for (out, foot, v, start) in &rays {
            // The collar begins inside the tube, so that no edge shows.
            let own_m = r * (0.9 + 0.13 * smooth(t / 0.25));
            let ring = way.ring(t, *out, own_m + (wide - own_m) * flare);
            let at = ring + (*foot - ring) * smooth((t - 0.6) / 0.4);
            // Near the organ's skin the collar looks like the organ.
            let skin = &onto[nearest(onto, at)];
            let above = (at - Vec3::from(skin.position)).dot(Vec3::from(skin.normal)) / r;
            let alike = share.max(1.0 - ((above - 0.1) / 1.1).clamp(0.0, 1.0));
            let look = own[*start].look & 15
                | (onto[*v].look & 15) << 4
                | ((alike * 65535.0) as u32) << 16;
            let (spheres, weights) = blended(&own[*start], &onto[*v], share);
            vertices.push(RestVertex {
                position: at.to_array(),
                look,
                normal: out.to_array(),
                ambient: 1.0,
                spheres,
                weights,
            });
        }
    }
    let n = AROUND as u32;
    let mut triangles = Vec::with_capacity(AROUND * ROWS * 2);
    for row in 0..ROWS as u32 {
        for k in 0..n {
            let [a, b] = [row * n + k, row * n + (k + 1) % n];
            triangles.push([a, b, b + n]);
            triangles.push([a, b + n, a + n]);
        }
    }
    face_outwards(&mut vertices, &mut triangles);
    Some((vertices, triangles))
}

/// The curved axis of the collar, from the tube into the other organ.
struct Way {
    /// Beginning of the axis, and its tangent there, m.
    from: Vec3,
    leave: Vec3,
    /// End of the axis, and its tangent there, m.
    to: Vec3,
    arrive: Vec3,
}

impl Way {
    /// Axis from the tube, over its end, into the skin `onto`. `None` if that skin is too far away.
    fn new(end: &End, onto: &[RestVertex]) -> Option<Self> {
        let r = end.radius_m;
        let skin = |near: Vec3| {
            let v = &onto[nearest(onto, near)];
            let (at, normal) = (Vec3::from(v.position), Vec3::from(v.normal));
            (near - normal * (near - at).dot(normal), normal)
        };
        let (_, normal) = skin(end.at);
        // A tube that runs along the organ's skin enters the skin up to one radius farther on.
        let (at, normal) = skin(end.at + end.along.reject_from(normal) * r);
        let from = end.at - end.along * (BEFORE * r);
        let to = at - normal * SUNK_M;
        let length = from.distance(to);
        (to.distance(end.at) < REACH_M.max(4.0 * r)).then_some(Self {
            from,
            leave: end.along * length,
            to,
            arrive: -normal * length,
        })
    }

    /// A point around the axis at the share `t` of its length. `out` is the point's direction off
    /// the axis at its start.
    fn ring(&self, t: f32, out: Vec3, radius_m: f32) -> Vec3 {
        let at = |t| hermite(t, self.from, self.leave, self.to, self.arrive);
        const AHEAD: f32 = 1e-3;
        let ahead = match t {
            t if t <= 0.0 => self.leave,
            t if t >= 1.0 => self.arrive,
            t => at(t + AHEAD) - at(t - AHEAD),
        };
        let first = self.leave.normalize_or(Vec3::X);
        let turn = Quat::from_rotation_arc(first, ahead.normalize_or(first));
        at(t) + turn * out * radius_m
    }
}

/// Smooth step from 0 to 1, level at both ends.
fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Moves the vertices of a tube's cap back into its collar, where nobody sees them.
fn hide_cap(own: &mut [RestVertex], end: &End) {
    let r = end.radius_m;
    for vertex in own {
        let away = Vec3::from(vertex.position) - end.at;
        let along = away.dot(end.along);
        let last = -(BEFORE - 0.8) * r;
        if along > last && away.length() < 4.0 * r {
            let across = away.reject_from(end.along) * 0.8;
            vertex.position = (end.at + end.along * last + across).to_array();
        }
    }
}

/// Point at the share `t` of a cubic curve from `p` to `q` with these tangents at its ends.
fn hermite(t: f32, p: Vec3, leave: Vec3, q: Vec3, arrive: Vec3) -> Vec3 {
    let (t2, t3) = (t * t, t * t * t);
    p * (2.0 * t3 - 3.0 * t2 + 1.0)
        + leave * (t3 - 2.0 * t2 + t)
        + q * (3.0 * t2 - 2.0 * t3)
        + arrive * (t3 - t2)
}

/// Turns all triangles over if most of them face against the normals of their vertices. Then the
/// triangles give the vertices new normals.
fn face_outwards(vertices: &mut [RestVertex], triangles: &mut [[u32; 3]]) {
    let areas = |vertices: &[RestVertex], triangles: &[[u32; 3]]| {
        let at = |i: u32| Vec3::from(vertices[i as usize].position);
        let area = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
        triangles.iter().map(area).collect::<Vec<Vec3>>()
    };
    let found = areas(vertices, triangles);
    let facing: f32 = triangles
        .iter()
        .zip(&found)
        .map(|(t, area)| area.dot(Vec3::from(vertices[t[0] as usize].normal)))
        .sum();
    if facing < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let mut sums = vec![Vec3::ZERO; vertices.len()];
    for (t, area) in triangles.iter().zip(areas(vertices, triangles)) {
        t.iter().for_each(|&v| sums[v as usize] += area);
    }
    for (vertex, sum) in vertices.iter_mut().zip(sums) {
        vertex.normal = sum.normalize_or(Vec3::from(vertex.normal)).to_array();
    }
}

/// Spheres and weights of a vertex that moves with two vertices: with `b` to this share, with `a`
/// to the rest. Only the eight spheres with the largest weights are kept.
fn blended(a: &RestVertex, b: &RestVertex, share: f32) -> ([u32; 4], [u32; 4]) {
    let mut all: Vec<(u32, f32)> = Vec::with_capacity(16);
    for (vertex, part) in [(a, 1.0 - share), (b, share)] {
        for (spheres, weights) in vertex.spheres.iter().zip(&vertex.weights) {
            for shift in [0, 16] {
                let weight = (weights >> shift & 0xffff) as f32 * part;
                if weight > 0.0 {
                    all.push((spheres >> shift & 0xffff, weight));
                }
            }
        }
    }
    all.sort_by(|x, y| y.1.total_cmp(&x.1));
    all.truncate(8);
    let sum: f32 = all.iter().map(|(_, weight)| weight).sum();
    let mut left = WEIGHT_SUM;
    let (mut spheres, mut weights) = ([0u32; 4], [0u32; 4]);
    let first = all.first().map_or(0, |(sphere, _)| *sphere);
    for slot in (0..8).rev() {
        let (sphere, weight) = all.get(slot).copied().unwrap_or((first, 0.0));
        // The rounding error goes to the heaviest sphere.
        let share = match slot {
            0 => left,
            _ => ((weight / sum.max(1e-9) * WEIGHT_SUM as f32) as u32).min(left),
        };
        left -= share;
        let shift = 16 * (slot as u32 % 2);
        spheres[slot / 2] |= sphere << shift;
        weights[slot / 2] |= share << shift;
    }
    (spheres, weights)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vertex(spheres: [u16; 8], weights: [u16; 8]) -> RestVertex {
        let pairs = |n: [u16; 8]| {
            core::array::from_fn(|i| u32::from(n[2 * i]) | u32::from(n[2 * i + 1]) << 16)
        };
        RestVertex {
            spheres: pairs(spheres),
            weights: pairs(weights),
            ..bytemuck::Zeroable::zeroed()
        }
    }

    fn weights(of: &[u32; 4]) -> Vec<u32> {
        of.iter()
            .flat_map(|pair| [pair & 0xffff, pair >> 16])
            .collect()
    }

    proptest! {
        #[test]
        fn blended_weights_sum_to_one_and_ends_are_the_vertices_own(
            a in any::<[u8; 8]>(), b in any::<[u8; 8]>(), share in 0.0f32..=1.0,
        ) {
            let whole = |raw: [u8; 8]| {
                let sum: u32 = raw.iter().map(|&x| u32::from(x) + 1).sum();
                let mut w = raw.map(|x| ((u32::from(x) + 1) * WEIGHT_SUM / sum) as u16);
                w[0] += (WEIGHT_SUM - w.iter().map(|&x| u32::from(x)).sum::<u32>()) as u16;
                w
            };
            let one = vertex([1, 2, 3, 4, 5, 6, 7, 8], whole(a));
            let two = vertex([11, 12, 13, 14, 15, 16, 17, 18], whole(b));
            let (_, mixed) = blended(&one, &two, share);
            prop_assert_eq!(weights(&mixed).iter().sum::<u32>(), WEIGHT_SUM);
            for (share, first) in [(0.0, 1..=8), (1.0, 11..=18)] {
                let (spheres, _) = blended(&one, &two, share);
                prop_assert!(weights(&spheres).iter().all(|s| first.contains(s)));
            }
        }
    }

    #[test]
    fn ducts_open_into_the_bowel_and_arteries_do_not() {
        use OrganKind::{BileDuct, CysticArtery, Fat, Gallbladder, Intestine, Stomach, Vessel};
        let joins = |tube: OrganKind, other: OrganKind| may_join(tube as u32, other as u32);
        assert!(joins(BileDuct, Intestine) && joins(CysticArtery, Gallbladder));
        assert!(joins(CysticArtery, Vessel));
        assert!(!joins(Vessel, Stomach) && !joins(CysticArtery, Intestine));
        assert!(!joins(BileDuct, Fat));
    }

    #[test]
    fn a_curve_starts_and_ends_at_its_points_and_leaves_along_its_tangent() {
        let (p, q) = (Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0));
        let at = |t| hermite(t, p, Vec3::X, q, Vec3::Y);
        assert_eq!((at(0.0), at(1.0)), (p, q));
        let leaves = (at(1e-3) - at(0.0)) / 1e-3;
        assert!(leaves.distance(Vec3::X) < 0.02, "{leaves}");
    }
}
