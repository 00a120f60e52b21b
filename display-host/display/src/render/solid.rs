//! Construction of rigid solids: lofts, turned parts and swept wires, with sharp edges at sharp
//! bends.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec2, Vec3};

/// A vertex of an instrument: 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct RigidVertex {
    /// Position in the part's frame, m.
    pub(super) position: [f32; 3],
    /// Row of the material table.
    pub(super) look: u32,
    /// Unit normal.
    pub(super) normal: [f32; 3],
    /// Index of the part that the vertex belongs to.
    pub(super) part: u32,
}

/// A solid under construction: triangles, each with a material and a part.
#[derive(Debug, Clone, Default)]
pub(super) struct Solid {
    points: Vec<Vec3>,
    triangles: Vec<([u32; 3], u32, u32)>,
}

/// Material and part of new triangles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Finish {
    /// Row of the material table.
    pub(super) look: u32,
    /// Index of the part.
    pub(super) part: u32,
}

impl Solid {
    /// Joins rings with equal numbers of points to a closed skin with flat ends. The points of a
    /// ring must run counter-clockwise for a viewer at the path's end who looks back along it.
    pub(super) fn loft(&mut self, rings: &[Vec<Vec3>], finish: Finish) {
        let Some(around) = rings.first().map(Vec::len).filter(|&n| n >= 3) else {
            return;
        };
        let base = self.points.len() as u32;
        let n = around as u32;
        for ring in rings {
            self.points.extend_from_slice(&ring[..around]);
        }
        let mut add = |t: [u32; 3]| self.triangles.push((t, finish.look, finish.part));
        for k in 0..rings.len() as u32 - 1 {
            for i in 0..n {
                let j = (i + 1) % n;
                let [a, b] = [base + k * n + i, base + k * n + j];
                add([a, b, b + n]);
                add([a, b + n, a + n]);
            }
        }
        let last = base + (rings.len() as u32 - 1) * n;
        for ring in [0, rings.len() - 1] {
            let centre = rings[ring].iter().sum::<Vec3>() / around as f32;
            self.points.push(centre);
            let centre = self.points.len() as u32 - 1;
            for i in 0..n {
                let j = (i + 1) % n;
                if ring == 0 {
                    self.triangles
                        .push(([base + j, base + i, centre], finish.look, finish.part));
                } else {
                    self.triangles
                        .push(([last + i, last + j, centre], finish.look, finish.part));
                }
            }
        }
    }

    /// Adds a turned part. `profile` gives pairs of distance along `axis` from `from`, and radius.
    pub(super) fn turned(
        &mut self,
        from: Vec3,
        axis: Vec3,
        profile: &[[f32; 2]],
        around: usize,
        finish: Finish,
    ) {
        let turn = Quat::from_rotation_arc(Vec3::Z, axis.normalize());
        let rings: Vec<Vec<Vec3>> = profile
            .iter()
            .map(|&[along, radius]| {
                circle(around)
                    .map(|c| from + turn * (c * radius).extend(along))
                    .collect()
            })
            .collect();
        self.loft(&rings, finish);
    }

    /// Adds a wire along a path. `section` gives the outline in the wire's frame at a share of the
    /// path from 0 to 1. The frame does not twist.
    pub(super) fn swept(
        &mut self,
        path: &[Vec3],
        section: impl Fn(f32) -> Vec<Vec2>,
        finish: Finish,
    ) {
        if path.len() < 2 {
            return;
        }
        let mut along = (path[1] - path[0]).normalize();
        let mut side = along.any_orthonormal_vector();
        let mut rings = Vec::with_capacity(path.len());
        for (k, &at) in path.iter().enumerate() {
            let before = path[k.saturating_sub(1)];
            let after = path[(k + 1).min(path.len() - 1)];
            let now = (after - before).normalize_or(along);
            side = (Quat::from_rotation_arc(along, now) * side).normalize();
            along = now;
            let up = along.cross(side);
            let outline = section(k as f32 / (path.len() - 1) as f32);
            rings.push(outline.iter().map(|p| at + side * p.x + up * p.y).collect());
        }
        self.loft(&rings, finish);
    }

    /// Vertices and triangles. Faces that meet at less than `crease` (rad) share their normals.
    #[must_use]
    pub(super) fn finish(&self, crease: f32) -> (Vec<RigidVertex>, Vec<[u32; 3]>) {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.points[i as usize]);
            (b - a).cross(c - a)
        };
        let areas: Vec<Vec3> = self.triangles.iter().map(|(t, ..)| area(t)).collect();
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for (k, (t, ..)) in self.triangles.iter().enumerate() {
            for &i in t {
                around[i as usize].push(k as u32);
            }
        }
        let limit = crease.cos();
        let mut vertices = Vec::new();
        let mut triangles = Vec::with_capacity(self.triangles.len());
        let mut known: HashMap<(u32, [i32; 3], u32, u32), u32> = HashMap::new();
        for (k, &(t, look, part)) in self.triangles.iter().enumerate() {
            let own = areas[k].normalize_or_zero();
            if own == Vec3::ZERO {
                continue;
            }
            let corners = t.map(|i| {
                let normal: Vec3 = around[i as usize]
                    .iter()
                    .map(|&f| areas[f as usize])
                    .filter(|area| area.normalize_or_zero().dot(own) >= limit)
                    .sum();
                let normal = normal.normalize_or(own);
                let key = normal.to_array().map(|x| (x * 4096.0).round() as i32);
                *known.entry((i, key, look, part)).or_insert_with(|| {
                    vertices.push(RigidVertex {
                        position: self.points[i as usize].to_array(),
                        look,
                        normal: normal.to_array(),
                        part,
                    });
                    vertices.len() as u32 - 1
                })
            });
            triangles.push(corners);
        }
        (vertices, triangles)
    }
}

/// Directions and triangles of a unit sphere: an icosahedron whose triangles are divided into four
/// this many times. The triangles face outwards.
pub(super) fn sphere(fineness: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let long = 0.5 + 0.5 * 5.0f32.sqrt();
    let mut points: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, long), (1.0, long), (-1.0, -long), (1.0, -long)] {
        points.extend([
            Vec3::new(a, b, 0.0),
            Vec3::new(0.0, a, b),
            Vec3::new(b, 0.0, a),
        ]);
    }
    points.iter_mut().for_each(|it| *it = it.normalize());
    // The faces are the triples of corners at an edge's length from each other.
    let edge2 = 1.2;
    let near = |a: usize, b: usize| points[a].distance_squared(points[b]) < edge2;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let up = (points[b] - points[a]).cross(points[c] - points[a]);
                    let is_out = up.dot(points[a]) > 0.0;
                    let [b, c] = if is_out { [b, c] } else { [c, b] };
                    faces.push([a, b, c].map(|i| i as u32));
                }
            }
        }
    }
    for _ in 0..fineness {
        let mut between: HashMap<[u32; 2], u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *between.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let sum = points[a as usize] + points[b as usize];
                points.push(sum.normalize());
                points.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(4 * faces.len());
        for [a, b, c] in faces {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = finer;
    }
    (points, faces)
}

/// Points of the unit circle, counter-clockwise.
pub(super) fn circle(around: usize) -> impl Iterator<Item = Vec2> {
    (0..around).map(move |i| Vec2::from_angle(i as f32 / around as f32 * core::f32::consts::TAU))
}

/// A smooth curve through points (Catmull-Rom), with `steps` pieces between two points.
#[must_use]
pub(super) fn curve(points: &[Vec3], steps: usize) -> Vec<Vec3> {
    let mut path = Vec::new();
    for i in 0..points.len().saturating_sub(1) {
        let at = |k: isize| points[(i as isize + k).clamp(0, points.len() as isize - 1) as usize];
        let [p0, p1, p2, p3] = [at(-1), at(0), at(1), at(2)];
        for s in 0..steps {
            let t = s as f32 / steps as f32;
            path.push(
                0.5 * (2.0 * p1
                    + (p2 - p0) * t
                    + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t * t
                    + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t * t * t),
            );
        }
    }
    path.extend(points.last());
    path
}

const _: () = assert!(size_of::<RigidVertex>() == 32);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_part_is_closed_and_faces_outwards() {
        let mut solid = Solid::default();
        let finish = Finish { look: 3, part: 1 };
        solid.turned(Vec3::ONE, Vec3::X, &[[0.0, 1.0], [2.0, 1.0]], 24, finish);
        let (vertices, triangles) = solid.finish(0.6);
        // By the divergence theorem this is the volume of a closed surface that faces outwards.
        let at = |i: u32| Vec3::from(vertices[i as usize].position);
        let volume: f32 = triangles
            .iter()
            .map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0)
            .sum();
        assert!(
            (volume - 2.0 * core::f32::consts::PI).abs() < 0.1,
            "{volume}"
        );
        // The rim is sharp: side and ends keep their own normals.
        let sharp = vertices.iter().all(|v| {
            let n = Vec3::from(v.normal);
            n.x.abs() < 1e-3 || n.x.abs() > 0.999
        });
        assert!(sharp);
    }

    #[test]
    fn sphere_is_closed_and_faces_outwards() {
        let (points, faces) = sphere(2);
        assert_eq!((points.len(), faces.len()), (162, 320));
        let at = |i: u32| points[i as usize];
        let volume: f32 = faces
            .iter()
            .map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0)
            .sum();
        let whole = 4.0 / 3.0 * core::f32::consts::PI;
        assert!(volume < whole && volume > 0.94 * whole, "{volume}");
    }

    #[test]
    fn curve_passes_through_its_points() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let path = curve(&points, 8);
        assert_eq!(path.len(), 25);
        for (k, point) in points.iter().enumerate() {
            assert!(path[k * 8].distance(*point) < 1e-6);
        }
    }
}
