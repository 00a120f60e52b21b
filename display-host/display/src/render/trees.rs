//! Vessels on gallbladder, stomach and intestine, grown at load as trees over the organs' skins. A
//! grid over each organ at rest stores the distance to the nearest vessel. The shader reads it at a
//! point's place at rest, so the vessels move with the tissue.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shared_mem::scene::{OrganKind, OrganRecord, SceneFile};

use super::noise::hash;
use crate::skinning::{RestVertex, SkinMesh};

/// Number of tree slots. Slot 0 means no tree; each other slot belongs to one organ. `light.wgsl`
/// has the same number.
pub(super) const SLOTS: usize = 16;
/// Largest number of vertices over which a tree grows. The search for a twig may visit all of them.
/// A larger skin uses representative vertices.
const NODES: usize = 8000;
/// Approximate largest number of voxels in an organ's grid, without the margin.
const VOXELS: f32 = 1.1e6;
/// Range of the stored distances on either side of a vessel's edge, voxels.
const BAND: f32 = 2.5;
/// Least radius of a twig, m.
const TWIG_M: f32 = 0.000_11;
/// Weight of the distance along the skin's normal. It is low, because the drawn triangles are flat
/// and run a little above or below a curved vessel. At full weight the vessel would fade there.
const ABOVE: f32 = 0.25;
/// Cost of a metre along a vessel; a metre of bare skin costs 0.6 to 1.7. The cost is above 0, so
/// that branches leave at acute angles.
const ALONG: f32 = 0.4;
/// Number of pieces of a curve between two vertices of the skin.
const STEPS: usize = 4;

/// `Tree` in `light.wgsl`: position of an organ's grid in the tissue and in the texture.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)] // explained in light.wgsl
pub struct Tree {
    pub origin: [f32; 4],
    pub scale: [f32; 4],
}

/// All trees of a scene, as texels and the grid of each organ. A texel has two bytes, for the
/// artery and the vein; x runs fastest.
#[derive(Debug, Clone)]
pub(super) struct Trees {
    pub(super) size: [u32; 3],
    pub(super) texels: Vec<[u8; 2]>,
    pub(super) slots: [Tree; SLOTS],
}

/// A segment of a vessel.
#[derive(Debug, Clone, Copy)]
struct Piece {
    ends: [Vec3; 2],
    radii_m: [f32; 2],
    /// Normal of the skin at the segment.
    normal: Vec3,
}

/// Blood supply of an organ.
struct Supply {
    /// Twigs per root.
    twigs: usize,
    /// Largest distance of skin from the nearest root, m. Skin farther away gets a root of its own.
    reach_m: f32,
    /// Radius of artery and vein at the root that feeds the most twigs, m.
    radii_m: [f32; 2],
}

fn supply(kind: u32) -> Option<Supply> {
    let is = |k: OrganKind| kind == k as u32;
    if is(OrganKind::Gallbladder) {
        Some(Supply {
            twigs: 90,
            reach_m: 0.15,
            radii_m: [0.000_55, 0.000_75],
        })
    } else if is(OrganKind::Stomach) {
        Some(Supply {
            twigs: 60,
            reach_m: 0.09,
            radii_m: [0.000_9, 0.001_2],
        })
    } else if is(OrganKind::Intestine) {
        Some(Supply {
            twigs: 36,
            reach_m: 0.05,
            radii_m: [0.000_7, 0.000_9],
        })
    } else {
        None
    }
}

/// Least number of vertices of a skin on which a tree grows.
const VERTICES_MIN: usize = 16;
/// Least drawn radius of a vessel, voxels: thinner vessels would break into dashes.
const DRAWN_VOXELS: f32 = 0.5;

/// Grows the trees of all organs with a supply and writes the slot into their vertices.
pub(super) fn grow(mesh: &mut SkinMesh, scene: &SceneFile) -> Trees {
    let mut grids = Vec::new();
    for organ in scene.organs() {
        let Some(supply) = supply(organ.kind).filter(|_| grids.len() + 1 < SLOTS) else {
            continue;
        };
        let own = organ.vertices[0] as usize..(organ.vertices[0] + organ.vertices[1]) as usize;
        if own.len() < VERTICES_MIN {
            continue;
        }
        let skin = Skin::new(mesh, own.clone());
        let pieces = [0, 1].map(|which| skin.tree(&skin.roots(scene, &supply), &supply, which));
        grids.push(Grid::new(&skin, &pieces));
        let slot = grids.len() as u32;
        for vertex in &mut mesh.vertices[own] {
            vertex.look |= slot << 8;
        }
    }
    stack(&grids)
}

/// An organ's skin as a graph of its vertices, or of representative ones.
struct Skin {
    count: usize,
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Neighbours of each node of the graph.
    next: Vec<Vec<usize>>,
    /// Bounds of all vertices.
    low: Vec3,
    high: Vec3,
}

impl Skin {
    fn new(mesh: &SkinMesh, own: Range<usize>) -> Self {
        let vertices = &mesh.vertices[own.clone()];
        let points = vertices.iter().map(|v| Vec3::from(v.position));
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = points.fold(none, |(low, high), p| (low.min(p), high.max(p)));
        // Vertices are merged in ever larger cubes until few enough representatives are left.
        let mut cell_m = (high - low).max_element() / 64.0;
        let (mut node_of, mut stands) = ((0..own.len()).collect::<Vec<_>>(), None);
        while stands.as_ref().map_or(own.len(), Vec::len) > NODES {
            let merged = merge(vertices, low, cell_m);
            (node_of, stands) = (merged.0, Some(merged.1));
            cell_m *= 1.25;
        }
        let stands = stands.unwrap_or_else(|| (0..own.len()).collect());
        let mut next = vec![Vec::new(); stands.len()];
        for (vertex, &node) in own.clone().zip(&node_of) {
            let [from, to] = [0, 1].map(|k| mesh.ring_first[vertex + k] as usize);
            let corners = mesh.ring[from..to]
                .iter()
                .flat_map(|&t| mesh.triangles[t as usize]);
            for corner in corners.map(|v| v as usize).filter(|v| own.contains(v)) {
                let other = node_of[corner - own.start];
                if other != node && !next[node].contains(&other) {
                    next[node].push(other);
                }
            }
        }
        Self {
            count: stands.len(),
            points: stands
                .iter()
                .map(|&i| vertices[i].position.into())
                .collect(),
            normals: stands.iter().map(|&i| vertices[i].normal.into()).collect(),
            next,
            low,
            high,
        }
    }

    fn at(&self, i: usize) -> Vec3 {
        self.points[i]
    }

    fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.next[i].iter().copied()
    }

    /// Roots of the supply. The first is the vertex nearest to an artery. Each further one is the
    /// vertex farthest from all roots so far. There are at most 40.
    fn roots(&self, scene: &SceneFile, supply: &Supply) -> Vec<usize> {
        let arteries: Vec<Vec3> = scene
            .organs()
            .iter()
            .filter(|o: &&OrganRecord| {
                o.kind == OrganKind::CysticArtery as u32 || o.kind == OrganKind::Vessel as u32
            })
            .flat_map(|o| &scene.spheres()[o.spheres[0] as usize..][..o.spheres[1] as usize])
            .map(|s| Vec3::from(s.center_m))
            .collect();
        let to_artery = |i: usize| {
            let far = arteries.iter().map(|a| a.distance_squared(self.at(i)));
            far.fold(f32::INFINITY, f32::min)
        };
        let first = (0..self.count).min_by(|&a, &b| to_artery(a).total_cmp(&to_artery(b)));
        let mut roots: Vec<usize> = first.into_iter().collect();
        let mut far = vec![f32::INFINITY; self.count];
        while let Some(&last) = roots.last() {
            for (i, far) in far.iter_mut().enumerate() {
                *far = far.min(self.at(i).distance(self.at(last)));
            }
            let next = (0..self.count).max_by(|&a, &b| far[a].total_cmp(&far[b]));
            match next {
                Some(next) if far[next] > supply.reach_m && roots.len() < 40 => roots.push(next),
                _ => break,
            }
        }
        roots
    }

    /// Grows a tree from the roots to twigs spread over the skin, as smooth segments. `which` is 0
    /// for the artery, 1 for the vein.
    fn tree(&self, roots: &[usize], supply: &Supply, which: usize) -> Vec<Piece> {
        const FREE: u32 = u32::MAX;
        let seed = 7 + 31 * which as u32;
        // Parent of each vertex in the tree. A root is its own parent.
        let mut parent = vec![FREE; self.count];
        // Length of the vessel from the root to each vertex, m.
        let mut along = vec![f32::INFINITY; self.count];
        // Squared distance of each vertex from the tree, m².
        let mut bare = vec![f32::INFINITY; self.count];
        // Vertices of the tree, in the order in which they joined it.
        let mut nodes: Vec<usize> = Vec::new();
        let take =
            |i: usize, from: usize, parent: &mut [u32], along: &mut [f32], bare: &mut [f32]| {
                parent[i] = from as u32;
                along[i] = if from == i {
                    0.0
                } else {
                    along[from] + self.at(i).distance(self.at(from))
                };
                for (j, bare) in bare.iter_mut().enumerate() {
                    *bare = bare.min(self.at(i).distance_squared(self.at(j)));
                }
            };
        for &root in roots {
            // The vein enters next to the artery, at most two edges away.
            let root = (0..2 * which).fold(root, |r, k| self.neighbours(r).nth(k).unwrap_or(r));
            if parent[root] == FREE {
                take(root, root, &mut parent, &mut along, &mut bare);
                nodes.push(root);
            }
        }
        for twig in 0..(supply.twigs * roots.len()) as u32 {
            // The target is the one of ten random vertices that is farthest from this tree.
            let place = |k| (hash(twig, k, seed) * self.count as f32) as usize % self.count;
            let target = (0..10u32)
                .map(place)
                .max_by(|&a, &b| bare[a].total_cmp(&bare[b]));
            let Some(target) = target.filter(|&t| parent[t] == FREE) else {
                continue;
            };
            let back = self.shortest(&nodes, &along, target, seed);
            let Some(path) = back else { continue };
            for pair in path.windows(2) {
                if parent[pair[1]] == FREE {
                    take(pair[1], pair[0], &mut parent, &mut along, &mut bare);
                    nodes.push(pair[1]);
                }
            }
        }
        self.pieces(&nodes, &parent, supply.radii_m[which])
    }

    /// Cheapest path from a tree to a vertex, starting at the tree.
    fn shortest(
        &self,
        nodes: &[usize],
        along: &[f32],
        target: usize,
        seed: u32,
    ) -> Option<Vec<usize>> {
        let mut cost = vec![f32::INFINITY; self.count];
        let mut from = vec![usize::MAX; self.count];
        let mut open = BinaryHeap::new();
        // Costs are not negative, so their bits sort in the same order as the costs.
        for &node in nodes {
            cost[node] = along[node] * ALONG;
            open.push(Reverse((cost[node].to_bits(), node)));
        }
        while let Some(Reverse((bits, i))) = open.pop() {
            if i == target {
                let mut path = vec![i];
                let mut at = i;
                while from[at] != usize::MAX {
                    at = from[at];
                    path.push(at);
                }
                path.reverse();
                return Some(path);
            }
            if bits > cost[i].to_bits() {
                continue;
            }
            for j in self.neighbours(i) {
                let rough = 0.6 + 1.1 * hash(i.min(j) as u32, i.max(j) as u32, seed);
                let reached = cost[i] + self.at(i).distance(self.at(j)) * rough;
                if reached < cost[j] {
                    cost[j] = reached;
                    from[j] = i;
                    open.push(Reverse((reached.to_bits(), j)));
                }
            }
        }
        None
    }

    /// Smooth curves along a tree's nodes. The radius grows with the number of twig ends that a
    /// node feeds, to the power 1 / 2.6. The exponent 2.6 lies between the optima for turbulent
    /// flow (7 / 3, Uylings 1977) and for laminar flow (3, Murray 1926).
    fn pieces(&self, nodes: &[usize], parent: &[u32], root_m: f32) -> Vec<Piece> {
        // For each node: the number of twig ends that it feeds, and the child that feeds the most.
        let mut fed = vec![0.0f32; self.count];
        let mut heir = vec![usize::MAX; self.count];
        // A node comes after its parent in `nodes`, so in reverse it comes first.
        for &i in nodes.iter().rev() {
            fed[i] = fed[i].max(1.0);
            let p = parent[i] as usize;
            if p != i {
                fed[p] += fed[i];
                if heir[p] == usize::MAX || fed[heir[p]] < fed[i] {
                    heir[p] = i;
                }
            }
        }
        let most = nodes.iter().map(|&i| fed[i]).fold(1.0, f32::max);
        let radius = |i: usize| (root_m * (fed[i] / most).powf(1.0 / 2.6)).max(TWIG_M);
        let mut at: Vec<Vec3> = (0..self.count).map(|i| self.at(i)).collect();
        for _ in 0..3 {
            let before = at.clone();
            for &i in nodes {
                let (p, h) = (parent[i] as usize, heir[i]);
                if p == i || h == usize::MAX {
                    continue;
                }
                let normal = self.normals[i];
                let moved = before[i] * 0.5 + (before[p] + before[h]) * 0.25;
                at[i] = moved - normal * (moved - self.at(i)).dot(normal);
            }
        }
        let mut pieces = Vec::with_capacity(nodes.len() * STEPS);
        for &i in nodes {
            let p = parent[i] as usize;
            if p == i {
                continue;
            }
            let before = at[parent[p] as usize];
            let after = if heir[i] == usize::MAX {
                at[i]
            } else {
                at[heir[i]]
            };
            let curve = super::solid::curve(&[before, at[p], at[i], after], STEPS);
            let radii = [radius(p).min(1.4 * radius(i)), radius(i)];
            for (k, ends) in curve[STEPS..=2 * STEPS].windows(2).enumerate() {
                let share = |k: usize| {
                    let t = k as f32 / STEPS as f32;
                    radii[0] + (radii[1] - radii[0]) * t
                };
                pieces.push(Piece {
                    ends: [ends[0], ends[1]],
                    radii_m: [share(k), share(k + 1)],
                    normal: self.normals[i],
                });
            }
        }
        pieces
    }
}

/// Number of each vertex's representative, and the list of representatives. A cube of edge `cell_m`
/// has a representative for each main direction of its normals, so that the two sides of a thin
/// wall stay separate.
fn merge(vertices: &[RestVertex], low: Vec3, cell_m: f32) -> (Vec<usize>, Vec<usize>) {
    let mut cells = HashMap::new();
    let mut stands = Vec::new();
    let node_of = vertices.iter().enumerate().map(|(i, vertex)| {
        let cell = ((Vec3::from(vertex.position) - low) / cell_m).as_ivec3();
        let normal = Vec3::from(vertex.normal);
        let axis = normal.abs().max_position();
        *cells
            .entry((cell, axis, normal[axis] > 0.0))
            .or_insert_with(|| {
                stands.push(i);
                stands.len() - 1
            })
    });
    (node_of.collect(), stands)
}

/// Distance grid of an organ.
struct Grid {
    size: [usize; 3],
    low: Vec3,
    voxel_m: f32,
    texels: Vec<[u8; 2]>,
}

impl Grid {
    fn new(skin: &Skin, pieces: &[Vec<Piece>; 2]) -> Self {
        let (low, high) = (skin.low, skin.high);
        let extent = (high - low).max(Vec3::splat(1e-3));
        let voxel_m = (extent.element_product() / VOXELS)
            .cbrt()
            .max(extent.max_element() / 220.0);
        let margin = (BAND.ceil() + 2.0) * voxel_m;
        let low = low - margin;
        let size = ((extent + 2.0 * margin) / voxel_m)
            .to_array()
            .map(|n| n.ceil() as usize + 1);
        let mut grid = Self {
            size,
            low,
            voxel_m,
            texels: vec![[0; 2]; size.iter().product()],
        };
        for (channel, pieces) in pieces.iter().enumerate() {
            pieces.iter().for_each(|piece| grid.draw(piece, channel));
        }
        grid
    }

    /// Writes the distances to a segment: 0 far outside, 255 far inside, 127 at the edge.
    fn draw(&mut self, piece: &Piece, channel: usize) {
        let [a, b] = piece.ends.map(|p| (p - self.low) / self.voxel_m);
        let [ra, rb] = piece.radii_m.map(|r| (r / self.voxel_m).max(DRAWN_VOXELS));
        let reach = Vec3::splat(ra.max(rb) + BAND);
        let from = (a.min(b) - reach)
            .max(Vec3::ZERO)
            .to_array()
            .map(|x| x as usize);
        let to = (a.max(b) + reach).to_array();
        let last: [usize; 3] = core::array::from_fn(|k| (to[k] as usize).min(self.size[k] - 1));
        let axis = b - a;
        for z in from[2]..=last[2] {
            for y in from[1]..=last[1] {
                for x in from[0]..=last[0] {
                    let p = Vec3::new(x as f32, y as f32, z as f32) + 0.5 - a;
                    let t = (p.dot(axis) / axis.length_squared().max(1e-9)).clamp(0.0, 1.0);
                    let away = p - axis * t;
                    let away = away - piece.normal * (away.dot(piece.normal) * (1.0 - ABOVE));
                    let off = away.length() - (ra + (rb - ra) * t);
                    let value = (0.5 - off / (2.0 * BAND)).clamp(0.0, 1.0) * 255.0;
                    let texel =
                        &mut self.texels[(z * self.size[1] + y) * self.size[0] + x][channel];
                    *texel = (*texel).max(value as u8);
                }
            }
        }
    }
}

/// Stacks grids in one texture.
fn stack(grids: &[Grid]) -> Trees {
    let most = |k: usize| grids.iter().map(|g| g.size[k]).max().unwrap_or(1);
    let (width, height) = (most(0), most(1));
    let depth: usize = grids.iter().map(|g| g.size[2]).sum::<usize>().max(1);
    let mut texels = vec![[0; 2]; width * height * depth];
    let mut slots = [Tree::default(); SLOTS];
    let mut start = 0;
    for (grid, slot) in grids.iter().zip(&mut slots[1..]) {
        for z in 0..grid.size[2] {
            for y in 0..grid.size[1] {
                let row = &grid.texels[(z * grid.size[1] + y) * grid.size[0]..][..grid.size[0]];
                let at = ((start + z) * height + y) * width;
                texels[at..at + row.len()].copy_from_slice(row);
            }
        }
        let voxel_cm = grid.voxel_m * 100.0;
        let scale = [width, height, depth].map(|n| 1.0 / (voxel_cm * n as f32));
        *slot = Tree {
            origin: (grid.low * 100.0).extend(BAND * voxel_cm).to_array(),
            scale: [scale[0], scale[1], scale[2], start as f32 / depth as f32],
        };
        start += grid.size[2];
    }
    Trees {
        size: [width, height, depth].map(|n| n as u32),
        texels,
        slots,
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    /// A ball of 10 cm diameter, whose skin has this many rings.
    fn ball(rings: usize) -> SkinMesh {
        let around = 2 * rings;
        let vertices = (0..rings * around).map(|i| {
            let [tilt, turn] = [
                ((i / around) as f32 + 0.5) / rings as f32 * std::f32::consts::PI,
                (i % around) as f32 / around as f32 * std::f32::consts::TAU,
            ];
            let normal = Vec3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos());
            RestVertex {
                position: (normal * 0.05).to_array(),
                normal: normal.to_array(),
                ..Zeroable::zeroed()
            }
        });
        let triangles = (0..(rings - 1) * around).flat_map(|i| {
            let beside = i / around * around + (i + 1) % around;
            let corners = [i, beside, i + around, beside + around].map(|v| v as u32);
            let [a, b, c, d] = corners;
            [[a, b, c], [b, d, c]]
        });
        let (vertices, triangles) = (vertices.collect::<Vec<_>>(), triangles.collect::<Vec<_>>());
        let mut around = vec![Vec::new(); vertices.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for &corner in triangle {
                around[corner as usize].push(t as u32);
            }
        }
        let mut ring_first = vec![0];
        for ring in &around {
            ring_first.push(ring_first.last().unwrap() + ring.len() as u32);
        }
        SkinMesh {
            skinned: vertices.len(),
            vertices,
            triangles,
            ring_first,
            ring: around.concat(),
            ..SkinMesh::default()
        }
    }

    #[test]
    fn a_tree_grows_over_a_bounded_part_of_a_fine_skin() {
        let supply = Supply {
            twigs: 12,
            reach_m: 1.0,
            radii_m: [0.001; 2],
        };
        for rings in [40, 200] {
            let mesh = ball(rings);
            let skin = Skin::new(&mesh, 0..mesh.vertices.len());
            assert_eq!(skin.count, skin.next.len());
            // A search visits each node once, so this bounds its time.
            assert!(skin.count <= NODES, "{rings}: {} nodes", skin.count);
            assert!(skin.count >= mesh.vertices.len().min(NODES / 4));
            let pieces = skin.tree(&[0], &supply, 0);
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for end in pieces.iter().flat_map(|piece| piece.ends) {
                assert!(
                    (end.length() - 0.05).abs() < 0.002,
                    "{end} is not on the skin"
                );
                (low, high) = (low.min(end), high.max(end));
            }
            assert!(
                (high - low).min_element() > 0.05,
                "{rings}: {low} to {high}"
            );
        }
    }

    #[test]
    fn both_sides_of_a_thin_wall_stay_apart() {
        let side = |z: f32| RestVertex {
            position: [0.0, 0.0, z * 1e-4],
            normal: [0.0, 0.0, z],
            ..Zeroable::zeroed()
        };
        let (node_of, stands) = merge(&[side(1.0), side(-1.0), side(1.0)], Vec3::ZERO, 0.01);
        assert_eq!((node_of, stands), (vec![0, 1, 0], vec![0, 1]));
    }
}
