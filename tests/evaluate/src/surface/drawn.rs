//! The skin that the display draws, and its faults in a frame.

use std::collections::BTreeMap;

use display_host::render;
use display_host::skinning::motion::{Follow, Motions};
use display_host::skinning::parts::Pieces;
use display_host::skinning::{SkinMesh, SkinnedVertex, Touch};
use glam::Vec3;
use shared_mem::message::{DentMsg, EventMsg, StateFrame, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};
use shared_mem::words::EventKind;

use super::ends::{End, ends};
use super::walls::opposites;

/// An edge that is longer than this multiple of its length at rest counts as stretched.
const STRETCHED: f32 = 2.5;
/// Edges that are shorter than this at rest never count as stretched, m, because their ends differ
/// only by rounding.
const EDGE_MIN_M: f32 = 2e-4;
/// Neighbours count as folded if the cosine of the angle between their normals is below this
/// (120°).
const FOLDED: f32 = -0.5;
/// Neighbours whose normals have a smaller cosine at rest are not tested for folds.
const SHARP_AT_REST: f32 = 0.0;
/// Area of a triangle below which its normal is ignored, m²: sides of 0.2 mm. In a picture with a
/// field of view of 70° from 5 cm, such a triangle is about two pixels wide.
const AREA_MIN_M2: f32 = 2e-8;
/// Depth from which opposite walls count as having passed through each other, m.
const PASSED_M: f32 = 2e-4;
/// Distance from a cut or tear within which faults of the tissue do not count, m.
const CUT_M: f32 = 0.015;
/// Search radius around a dent's middle, m. Half of the dent's length is added.
const NEAR_M: f32 = 0.012;

/// Faults of one organ in one frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Faults {
    pub(crate) edges_stretched: usize,
    pub(crate) triangles_folded: usize,
    pub(crate) in_tool_m: f32,
    pub(crate) off_tool_m: f32,
    pub(crate) ends_loose_m: f32,
}

impl Faults {
    /// A number for the comparison of frames. Each edge and each triangle adds 1. Each length adds
    /// its ratio to its limit.
    pub(crate) fn weight(&self) -> f32 {
        let lengths = [
            self.in_tool_m / 5e-4,
            self.off_tool_m / 5e-4,
            self.ends_loose_m / 2e-3,
        ];
        (self.edges_stretched + self.triangles_folded) as f32 + lengths.iter().sum::<f32>()
    }

    /// Maximum of each fault.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            edges_stretched: self.edges_stretched.max(other.edges_stretched),
            triangles_folded: self.triangles_folded.max(other.triangles_folded),
            in_tool_m: self.in_tool_m.max(other.in_tool_m),
            off_tool_m: self.off_tool_m.max(other.off_tool_m),
            ends_loose_m: self.ends_loose_m.max(other.ends_loose_m),
        }
    }
}

/// An edge of an organ's skin, with the triangles on both sides.
struct Edge {
    ends: [u32; 2],
    rest_m: f32,
    /// The triangles around it.
    around: Vec<u32>,
    /// The two triangles, if the edge is not sharp at rest.
    sides: Option<[u32; 2]>,
}

/// An organ's part of the skin.
struct Organ {
    vertices: Vec<u32>,
    triangles: Vec<u32>,
    edges: Vec<Edge>,
    /// Pairs of vertices on opposite walls.
    walls: Vec<[u32; 2]>,
    ends: Vec<End>,
}

/// The drawn skin of a scene, updated frame by frame.
pub(crate) struct Drawn<'a> {
    scene: &'a SceneFile,
    mesh: SkinMesh,
    motions: Motions,
    pieces: Pieces,
    now: Vec<SkinnedVertex>,
    organs: Vec<Organ>,
    /// Cuts and tears: index of the organ, and rest position of the nearest vertex, m.
    cuts: Vec<(usize, Vec3)>,
}

impl<'a> Drawn<'a> {
    pub(crate) fn new(scene: &'a SceneFile) -> Self {
        let mesh = render::organs(scene);
        let of_vertex = owners(scene, &mesh);
        let organs = (0..scene.organs().len())
            .map(|organ| Organ::of(scene, &mesh, &of_vertex, organ))
            .collect();
        Self {
            scene,
            now: mesh.at_rest(),
            motions: Motions::new(scene, Follow::Deform),
            pieces: Pieces::of(scene, &mesh),
            mesh,
            organs,
            cuts: Vec::new(),
        }
    }

    /// Notes cuts and tears. From now on, faults near them do not count. A reset clears them.
    pub(crate) fn note(&mut self, events: &[EventMsg]) {
        for event in events {
            let kind = EventKind::try_from(event.kind);
            match kind {
                Ok(EventKind::Reset) => self.cuts.clear(),
                Ok(
                    EventKind::Cut
                    | EventKind::Tear
                    | EventKind::Divided
                    | EventKind::Perforation
                    | EventKind::Crush,
                ) => self.note_cut(event),
                _ => {}
            }
        }
    }

    fn note_cut(&mut self, event: &EventMsg) {
        let Some(organ) = self.organs.get(event.organ as usize) else {
            return;
        };
        let at = Vec3::from(event.at_m);
        let place = |v: &u32| self.place(*v).distance(at);
        let nearest = (organ.vertices.iter()).min_by(|a, b| place(a).total_cmp(&place(b)));
        if let Some(vertex) = nearest {
            let rest = Vec3::from(self.mesh.vertices[*vertex as usize].position);
            self.cuts.push((event.organ as usize, rest));
        }
    }

    fn place(&self, vertex: u32) -> Vec3 {
        Vec3::from_slice(&self.now[vertex as usize].position[..3])
    }

    fn rest(&self, vertex: u32) -> Vec3 {
        self.mesh.vertices[vertex as usize].position.into()
    }

    /// Draws a frame's skin and judges each organ.
    pub(crate) fn judge(&mut self, state: &StateFrame, tools: &ToolFrame) -> Vec<Faults> {
        let spheres = state.spheres().unwrap_or(&[]);
        let parted = state.parted().into_iter().flatten();
        if self.pieces.set(parted, &mut self.mesh) {
            let severed: Vec<[u32; 2]> = self.pieces.severed().collect();
            self.motions.sever(&severed);
        }
        self.motions.update(spheres);
        let touch = Touch::of(
            &self.mesh,
            self.scene.organs(),
            spheres,
            self.motions.now(),
            tools,
        );
        self.mesh.skin(self.motions.now(), &touch, &mut self.now);
        let dents = tools.dents().unwrap_or(&[]);
        (0..self.organs.len())
            .map(|organ| self.judge_organ(organ, dents, spheres))
            .collect()
    }

    fn judge_organ(
        &self,
        number: usize,
        dents: &[DentMsg],
        spheres: &[shared_mem::message::SphereState],
    ) -> Faults {
        let organ = &self.organs[number];
        let cuts: Vec<Vec3> = (self.cuts.iter().filter(|cut| cut.0 == number))
            .map(|cut| cut.1)
            .collect();
        let is_cut = |v: u32| cuts.iter().any(|cut| cut.distance(self.rest(v)) < CUT_M);
        let mut faults = Faults::default();
        for edge in &organ.edges {
            let [a, b] = edge.ends;
            let length_m = self.place(a).distance(self.place(b));
            let is_stretched = length_m > STRETCHED * edge.rest_m && edge.rest_m > EDGE_MIN_M;
            let is_folded = edge.sides.is_some_and(|sides| {
                let [one, other] = sides.map(|t| self.twice_area(t));
                let least_m2 = one.length().min(other.length()) / 2.0;
                least_m2 > AREA_MIN_M2 && one.normalize().dot(other.normalize()) < FOLDED
            });
            if !edge.around.iter().any(|t| self.is_drawn(*t)) {
                continue;
            }
            if (is_stretched || is_folded) && !is_cut(a) {
                faults.edges_stretched += usize::from(is_stretched);
                faults.triangles_folded += usize::from(is_folded);
            }
        }
        let normal = |v: u32| Vec3::from_slice(&self.now[v as usize].normal[..3]);
        for &[a, b] in &organ.walls {
            let apart = self.place(a) - self.place(b);
            let passed = apart.dot(normal(a)) < -PASSED_M && apart.dot(normal(b)) > PASSED_M;
            if passed && !is_cut(a) {
                faults.triangles_folded += 1;
            }
        }
        for dent in dents.iter().filter(|dent| dent.organ as usize == number) {
            if let Some(gap_m) = self.gap_m(organ, dent) {
                faults.in_tool_m = faults.in_tool_m.max(-gap_m);
                faults.off_tool_m = faults.off_tool_m.max(gap_m);
            }
        }
        // After a cut, tear or crush of this organ its ends are not judged.
        if cuts.is_empty() {
            let sphere = |i: u32| spheres.get(i as usize).map(|s| Vec3::from(s.center_m));
            for end in &organ.ends {
                let Some(at) = sphere(end.sphere) else {
                    continue;
                };
                let away_m = at.distance(self.place(end.vertex)) - end.rest_m;
                faults.ends_loose_m = faults.ends_loose_m.max(away_m);
            }
        }
        faults
    }

    /// Normal of a triangle; its length is twice the triangle's area, m².
    fn twice_area(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.mesh.triangles[triangle as usize].map(|v| self.place(v));
        (b - a).cross(c - a)
    }

    /// True unless the triangle lies between two pieces of a severed tube.
    fn is_drawn(&self, triangle: u32) -> bool {
        let [a, b, c] = self.mesh.triangles[triangle as usize];
        a != b && b != c
    }

    /// Distance from the tool's surface to the organ's skin at a dent, m; negative if the skin is
    /// inside the tool.
    fn gap_m(&self, organ: &Organ, dent: &DentMsg) -> Option<f32> {
        let (center, half) = (Vec3::from(dent.center_m), Vec3::from(dent.half_m));
        let near = |t: &&u32| {
            let corners = self.mesh.triangles[**t as usize];
            corners
                .iter()
                .any(|v| self.place(*v).distance(center) < NEAR_M + half.length())
        };
        let mut least: Option<(f32, f32)> = None;
        for &t in organ.triangles.iter().filter(near) {
            let corners = self.mesh.triangles[t as usize].map(|v| self.place(v));
            for share in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                let from = center + half * share;
                let on = nearest_on(corners, from);
                let away = from - on;
                if least.is_none_or(|(length, _)| away.length() < length) {
                    least = Some((away.length(), away.dot(Vec3::from(dent.normal))));
                }
            }
        }
        least.map(|(length, height)| length.copysign(height) - dent.radius_m)
    }
}

impl Organ {
    fn of(scene: &SceneFile, mesh: &SkinMesh, of_vertex: &[usize], organ: usize) -> Self {
        let own = |t: &&[u32; 3]| of_vertex[t[0] as usize] == organ;
        let triangles: Vec<u32> = (0u32..)
            .zip(&mesh.triangles)
            .filter(|(_, t)| own(t))
            .map(|(number, _)| number)
            .collect();
        let vertices: Vec<u32> = (0..mesh.vertices.len() as u32)
            .filter(|v| of_vertex[*v as usize] == organ)
            .collect();
        let is_soft = [OrganKind::Fat, OrganKind::ConnectiveTissue]
            .iter()
            .any(|kind| scene.organs()[organ].kind == *kind as u32);
        Self {
            edges: edges(mesh, &triangles),
            walls: opposites(mesh, &vertices),
            ends: if is_soft {
                Vec::new()
            } else {
                ends(scene, organ)
            },
            vertices,
            triangles,
        }
    }
}

/// For each skinned vertex, the organ with the largest weight.
fn owners(scene: &SceneFile, mesh: &SkinMesh) -> Vec<usize> {
    let organ_of = |sphere: u32| {
        let holds = |o: &shared_mem::scene::OrganRecord| {
            (o.spheres[0]..o.spheres[0] + o.spheres[1]).contains(&sphere)
        };
        scene.organs().iter().position(holds).unwrap_or(0)
    };
    let of_sphere: Vec<usize> = (0..scene.spheres().len() as u32).map(organ_of).collect();
    let owner = |vertex: &display_host::skinning::RestVertex| {
        let mut weights = vec![0u32; scene.organs().len()];
        for (pair, weight) in vertex.spheres.iter().zip(&vertex.weights) {
            for shift in [0, 16] {
                let sphere = (pair >> shift & 0xffff) as usize;
                weights[of_sphere[sphere]] += weight >> shift & 0xffff;
            }
        }
        let most = weights.iter().max().copied().unwrap_or(0);
        weights.iter().position(|w| *w == most).unwrap_or(0)
    };
    mesh.vertices[..mesh.skinned].iter().map(owner).collect()
}

fn edges(mesh: &SkinMesh, triangles: &[u32]) -> Vec<Edge> {
    let mut sides: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for &t in triangles {
        let [a, b, c] = mesh.triangles[t as usize];
        for [a, b] in [[a, b], [b, c], [c, a]] {
            sides.entry([a.min(b), a.max(b)]).or_default().push(t);
        }
    }
    let at = |v: u32| Vec3::from(mesh.vertices[v as usize].position);
    let normal = |t: u32| {
        let [a, b, c] = mesh.triangles[t as usize].map(at);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let edge = |(ends, sides): ([u32; 2], Vec<u32>)| Edge {
        ends,
        rest_m: at(ends[0]).distance(at(ends[1])),
        sides: match sides[..] {
            [one, other] if normal(one).dot(normal(other)) > SHARP_AT_REST => Some([one, other]),
            _ => None,
        },
        around: sides,
    };
    sides.into_iter().map(edge).collect()
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
fn nearest_on([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3).max(1e-20));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6).max(1e-20));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6)).max(1e-20);
        return b + (c - b) * share;
    }
    let sum = (va + vb + vc).max(1e-30);
    a + ab * (vb / sum) + ac * (vc / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_hand::Seeded;

    #[test]
    fn no_point_of_a_triangle_is_nearer_than_the_nearest() {
        let mut seeded = Seeded::new(7);
        for _ in 0..2000 {
            let mut point = || Vec3::from_array([0; 3].map(|_| 2.0 * seeded.share() - 1.0));
            let (corners, p) = ([point(), point(), point()], point());
            let nearest = nearest_on(corners, p);
            let [u, v] = [seeded.share(), seeded.share()];
            let [u, v] = if u + v > 1.0 {
                [1.0 - u, 1.0 - v]
            } else {
                [u, v]
            };
            let other = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
            let [least, found] = [nearest, other].map(|at| at.distance(p));
            assert!(
                least <= found + 1e-5,
                "{corners:?} {p}: {least} and {found}"
            );
        }
    }
}
