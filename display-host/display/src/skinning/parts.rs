//! Severed tubes: each piece of a duct or vessel follows its own spheres only.
//!
//! A vertex near a cut is bound to spheres on both sides of it. After the cut, the vertex belongs
//! to the piece of the sphere with the largest weight. The weights of the spheres of other pieces
//! are spread over its remaining spheres, in proportion. Triangles between two pieces are not
//! drawn. A collar joins the end of one tube to another tube; the joined pieces count as one.

use std::ops::Range;

use shared_mem::scene::{OrganKind, OrganRecord, SceneFile, WEIGHT_SUM};

use super::SkinMesh;

/// Pieces of the tubes, and the whole skin from which they are cut.
#[derive(Debug, Clone)]
pub struct Pieces {
    /// The elastic links of all organs without tetrahedra, in the order of `StateFrame::parted`.
    links: Vec<[u32; 2]>,
    /// Links that are severed at present.
    parted: Vec<bool>,
    /// Pairs of spheres of two tubes that a collar joins.
    joints: Vec<[u32; 2]>,
    /// Vertices that follow spheres of tubes, with their weights before any cut.
    vertices: Vec<(u32, [u32; 4])>,
    /// Triangles of such vertices, with their corners before any cut.
    triangles: Vec<(u32, [u32; 3])>,
    /// Number of the piece of each sphere of the scene; `NONE` for a sphere of another organ.
    piece_of: Vec<u32>,
}

/// The piece of spheres that belong to no tube.
const NONE: u32 = u32::MAX;

impl Pieces {
    /// Pieces of a scene before any cut: each tube is one piece.
    #[must_use]
    pub fn of(scene: &SceneFile, mesh: &SkinMesh) -> Self {
        let is_listed = |organ: &&OrganRecord| organ.tetrahedra[1] == 0 && organ.elastic_links > 0;
        let kinds = [
            OrganKind::BileDuct,
            OrganKind::CysticArtery,
            OrganKind::CysticDuct,
            OrganKind::Vessel,
        ]
        .map(|kind| kind as u32);
        let mut is_of_tube = vec![false; scene.spheres().len()];
        let mut tube_of = vec![NONE; scene.spheres().len()];
        let mut links = Vec::new();
        for (number, tube) in (0u32..).zip(scene.organs().iter().filter(is_listed)) {
            let first = tube.links[0] as usize;
            let own = &scene.links()[first..first + tube.elastic_links as usize];
            links.extend(own.iter().map(|link| [link.a, link.b]));
            let first = tube.spheres[0] as usize;
            let is_tube = kinds.contains(&tube.kind);
            let own = first..first + tube.spheres[1] as usize;
            is_of_tube[own.clone()].fill(is_tube);
            tube_of[own].fill(if is_tube { number } else { NONE });
        }
        let follows = |vertex: usize| {
            let vertex = &mesh.vertices[vertex];
            let mut bound = vertex.bound();
            bound.any(|(sphere, weight)| weight > 0 && is_of_tube[sphere as usize])
        };
        let vertices: Vec<(u32, [u32; 4])> = (0..mesh.skinned)
            .filter(|vertex| follows(*vertex))
            .map(|vertex| (vertex as u32, mesh.vertices[vertex].weights))
            .collect();
        let mut is_near = vec![false; mesh.vertices.len()];
        for (vertex, _) in &vertices {
            is_near[*vertex as usize] = true;
        }
        let near = |t: &[u32; 3]| t.iter().any(|v| is_near[*v as usize]);
        let triangles = (0u32..).zip(mesh.triangles.iter().copied());
        let mut pieces = Self {
            parted: vec![false; links.len()],
            links,
            joints: joints(mesh, &tube_of),
            triangles: triangles.filter(|(_, t)| near(t)).collect(),
            vertices,
            piece_of: vec![NONE; scene.spheres().len()],
        };
        pieces.number();
        pieces
    }

    /// The links that are severed.
    pub fn severed(&self) -> impl Iterator<Item = [u32; 2]> {
        let both = self.links.iter().zip(&self.parted);
        both.filter(|(_, is_parted)| **is_parted)
            .map(|(link, _)| *link)
    }

    /// Ranges of the tubes' vertices in the skin.
    pub(super) fn vertex_runs(&self) -> Vec<Range<usize>> {
        runs(self.vertices.iter().map(|(vertex, _)| *vertex))
    }

    /// Ranges of the tubes' triangles in the skin.
    pub(super) fn triangle_runs(&self) -> Vec<Range<usize>> {
        runs(self.triangles.iter().map(|(triangle, _)| *triangle))
    }

    /// Cuts the skin where these links are severed, and closes it where they are whole again.
    /// Returns true if something changed.
    pub fn set(&mut self, parted: impl Iterator<Item = bool>, mesh: &mut SkinMesh) -> bool {
        let mut changed = false;
        for (before, now) in self.parted.iter_mut().zip(parted) {
            changed |= *before != now;
            *before = now;
        }
        if !changed {
            return false;
        }
        self.number();
        let mut own = vec![NONE; mesh.vertices.len()];
        for (vertex, weights) in &self.vertices {
            let rest = &mut mesh.vertices[*vertex as usize];
            rest.weights = *weights;
            let piece = |sphere: u32| self.piece_of.get(sphere as usize).copied().unwrap_or(NONE);
            let heaviest = rest.bound().max_by_key(|(_, weight)| *weight);
            let home = heaviest.map_or(NONE, |(sphere, _)| piece(sphere));
            own[*vertex as usize] = home;
            if home != NONE {
                rest.keep(|sphere| piece(sphere) == home || piece(sphere) == NONE);
            }
        }
        for (triangle, corners) in &self.triangles {
            let mut pieces = corners
                .iter()
                .map(|v| own[*v as usize])
                .filter(|p| *p != NONE);
            let first = pieces.next();
            let is_whole = pieces.all(|piece| Some(piece) == first);
            let [a, ..] = *corners;
            mesh.triangles[*triangle as usize] = if is_whole { *corners } else { [a; 3] };
        }
        true
    }

    /// Numbers the pieces: each sphere gets the least index among the spheres that whole links or
    /// collars join to it.
    fn number(&mut self) {
        for [a, b] in &self.links {
            self.piece_of[*a as usize] = *a;
            self.piece_of[*b as usize] = *b;
        }
        let mut changed = true;
        while std::mem::take(&mut changed) {
            let whole = self.links.iter().zip(&self.parted);
            let whole = whole.filter(|(_, is_parted)| !**is_parted);
            for [a, b] in whole.map(|(link, _)| link).chain(&self.joints) {
                let pair = [self.piece_of[*a as usize], self.piece_of[*b as usize]];
                let least = pair[0].min(pair[1]);
                if pair[0] != pair[1] {
                    self.piece_of[*a as usize] = least;
                    self.piece_of[*b as usize] = least;
                    changed = true;
                }
            }
        }
    }
}

/// Pairs of spheres of two tubes. One vertex follows both spheres of a pair, because a collar joins
/// the tubes there. `tube_of` has the tube of each sphere of the scene.
fn joints(mesh: &SkinMesh, tube_of: &[u32]) -> Vec<[u32; 2]> {
    let tube = |sphere: u32| tube_of.get(sphere as usize).copied().unwrap_or(NONE);
    let joint = |vertex: &super::RestVertex| {
        let of_tubes = || {
            let bound = vertex.bound();
            bound.filter(|it| it.1 > 0 && tube(it.0) != NONE)
        };
        let heaviest = of_tubes().max_by_key(|it| it.1)?.0;
        let others = of_tubes().filter(|it| tube(it.0) != tube(heaviest));
        Some([heaviest, others.max_by_key(|it| it.1)?.0])
    };
    let mut joints: Vec<_> = mesh.vertices[..mesh.skinned]
        .iter()
        .filter_map(joint)
        .collect();
    joints.sort_unstable();
    joints.dedup();
    joints
}

/// Runs of consecutive numbers in a rising list of numbers.
fn runs(numbers: impl Iterator<Item = u32>) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for number in numbers {
        let number = number as usize;
        match runs.last_mut().filter(|run| run.end == number) {
            Some(run) => run.end += 1,
            None => runs.push(number..number + 1),
        }
    }
    runs
}

impl super::RestVertex {
    /// The spheres that the vertex is bound to, with their weights of [`WEIGHT_SUM`].
    pub(crate) fn bound(&self) -> impl Iterator<Item = (u32, u32)> {
        let pairs = self.spheres.into_iter().zip(self.weights);
        pairs.flat_map(|(spheres, weights)| {
            [0, 16].map(|shift| (spheres >> shift & 0xffff, weights >> shift & 0xffff))
        })
    }

    /// Keeps the weights of the spheres for which `keeps` is true. The other weights are spread
    /// over these spheres, in proportion.
    fn keep(&mut self, keeps: impl Fn(u32) -> bool) {
        let kept: u32 = self.bound().filter(|it| keeps(it.0)).map(|it| it.1).sum();
        if kept == 0 || kept == WEIGHT_SUM {
            return;
        }
        let mut left = WEIGHT_SUM;
        let mut heaviest = (0, 0);
        let mut weights = [0; 8];
        for (slot, (sphere, weight)) in self.bound().enumerate() {
            if keeps(sphere) {
                weights[slot] =
                    (u64::from(weight) * u64::from(WEIGHT_SUM) / u64::from(kept)) as u32;
                left -= weights[slot];
                heaviest = heaviest.max((weight, slot));
            }
        }
        weights[heaviest.1] += left; // the remainders of the divisions
        self.weights = core::array::from_fn(|i| weights[2 * i] | weights[2 * i + 1] << 16);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skinning::{RestVertex, pairs};

    /// A tube of four spheres, and a strip of skin whose vertices follow their nearest two.
    fn tube() -> (Pieces, SkinMesh) {
        let vertex = |i: u16| RestVertex {
            spheres: pairs([i / 2, (i / 2 + 1).min(3), 0, 0, 0, 0, 0, 0]),
            weights: pairs([40_000, 25_535, 0, 0, 0, 0, 0, 0]),
            ..bytemuck::Zeroable::zeroed()
        };
        let mesh = SkinMesh {
            vertices: (0..8).map(vertex).collect(),
            triangles: (0..6).map(|i| [i, i + 1, i + 2]).collect(),
            skinned: 8,
            ..SkinMesh::default()
        };
        let mut pieces = Pieces {
            links: vec![[0, 1], [1, 2], [2, 3], [0, 2], [1, 3]],
            parted: vec![false; 5],
            joints: Vec::new(),
            vertices: (0..8)
                .map(|v| (v, mesh.vertices[v as usize].weights))
                .collect(),
            triangles: (0..6).map(|t| (t, mesh.triangles[t as usize])).collect(),
            piece_of: vec![NONE; 4],
        };
        pieces.number();
        (pieces, mesh)
    }

    #[test]
    fn a_cut_tube_falls_in_two_pieces_that_share_no_sphere_and_heals() {
        let (mut pieces, mut mesh) = tube();
        let whole = mesh.clone();
        // One severed link of three across the middle leaves the tube whole.
        let cut = |links: [bool; 5]| links.into_iter();
        assert!(pieces.set(cut([false, true, false, false, false]), &mut mesh));
        assert_eq!(mesh.vertices, whole.vertices);
        assert!(pieces.set(cut([false, true, false, true, true]), &mut mesh));
        for (number, vertex) in mesh.vertices.iter().enumerate() {
            let bound: Vec<(u32, u32)> = vertex.bound().filter(|it| it.1 > 0).collect();
            let is_left = number < 4;
            assert!(bound.iter().all(|it| (it.0 < 2) == is_left), "{bound:?}");
            assert_eq!(bound.iter().map(|it| it.1).sum::<u32>(), WEIGHT_SUM);
        }
        let is_hidden = |t: &[u32; 3]| t[0] == t[1];
        let hidden: Vec<bool> = mesh.triangles.iter().map(is_hidden).collect();
        assert_eq!(hidden, [false, false, true, true, false, false]);
        assert_eq!(pieces.severed().count(), 3);
        assert!(!pieces.set(cut([false, true, false, true, true]), &mut mesh));
        assert!(pieces.set(cut([false; 5]), &mut mesh));
        assert_eq!(mesh.vertices, whole.vertices);
        assert_eq!(mesh.triangles, whole.triangles);
    }

    /// A cut in one tube leaves its collar on another tube as it is.
    #[test]
    fn tubes_that_a_collar_joins_stay_joined() {
        let (_, mut mesh) = tube();
        let before = mesh.clone();
        let tube_of = [0, 0, 1, 1];
        let joints = joints(&mesh, &tube_of);
        assert_eq!(joints, [[1, 2]], "vertices 2 and 3 follow both");
        let mut pieces = Pieces {
            links: vec![[0, 1], [2, 3]],
            parted: vec![false; 2],
            joints,
            vertices: (0..8)
                .map(|v| (v, mesh.vertices[v as usize].weights))
                .collect(),
            triangles: (0..6).map(|t| (t, mesh.triangles[t as usize])).collect(),
            piece_of: vec![NONE; 4],
        };
        assert!(pieces.set([false, true].into_iter(), &mut mesh));
        assert_eq!(mesh.triangles[..2], before.triangles[..2]);
        assert_eq!(mesh.vertices[2..4], before.vertices[2..4]);
        assert_ne!(mesh.triangles[2..], before.triangles[2..]);
    }

    #[test]
    fn runs_join_consecutive_numbers() {
        assert_eq!(
            runs([3, 4, 5, 9, 11, 12].into_iter()),
            [3..6, 9..10, 11..13]
        );
        assert!(runs([].into_iter()).is_empty());
    }
}
