//! Vessels on the organs, as trees: grown over each skin at load from where blood comes in, and kept
//! as distance to the nearest vessel in a grid of the tissue at rest, so that they stick to it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shared_mem::scene::{OrganKind, OrganRecord, SceneFile};

use super::noise::hash;
use crate::skinning::SkinMesh;

/// Organs that have trees, at most; slot 0 has none. Also in `tissue.wgsl`.
pub(super) const SLOTS: usize = 16;
/// Voxels of an organ's grid, about.
const VOXELS: f32 = 1.1e6;
/// Distances are kept up to so many voxels on either side of a vessel's edge.
const BAND: f32 = 2.5;
/// A twig is no thinner, m.
const TWIG_M: f32 = 0.000_11;
/// How much of the way to a vessel counts where it lies above or below the skin: skin is flat between
/// its vertices, and a vessel is not to come and go with them.
const ABOVE: f32 = 0.25;
/// Going along a vessel costs this share of going over bare skin: branches leave at sharp angles.
const ALONG: f32 = 0.4;
/// Points of a curve between two vertices of the skin.
const STEPS: usize = 4;

/// `Tree` in `tissue.wgsl`: where an organ's grid lies in the tissue and in the texture.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)] // explained in tissue.wgsl
pub struct Tree {
    pub origin: [f32; 4],
    pub scale: [f32; 4],
}

/// All trees of a scene: texels of two bytes (artery, vein), x fastest, and where each organ's are.
#[derive(Debug, Clone)]
pub(super) struct Trees {
    pub(super) size: [u32; 3],
    pub(super) texels: Vec<[u8; 2]>,
    pub(super) slots: [Tree; SLOTS],
}

/// A piece of a vessel.
#[derive(Debug, Clone, Copy)]
struct Piece {
    ends: [Vec3; 2],
    radii_m: [f32; 2],
    /// Of the skin there.
    normal: Vec3,
}

/// How an organ is supplied.
struct Supply {
    /// Twigs for each root.
    twigs: usize,
    /// A root supplies skin up to this far, m.
    reach_m: f32,
    /// Radius of artery and vein at a root, m.
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

/// Vertices of a skin on which trees are grown: the time goes with their square, seconds at 20 000.
const SIZES: std::ops::RangeInclusive<usize> = 16..=8000;

/// Grows the trees of every organ that has some, and tells its vertices their slot.
pub(super) fn grow(mesh: &mut SkinMesh, scene: &SceneFile) -> Trees {
    let mut grids = Vec::new();
    for organ in scene.organs() {
        let Some(supply) = supply(organ.kind).filter(|_| grids.len() + 1 < SLOTS) else {
            continue;
        };
        let own = organ.vertices[0] as usize..(organ.vertices[0] + organ.vertices[1]) as usize;
        if !SIZES.contains(&own.len()) {
            continue;
        }
        let skin = Skin {
            mesh,
            first: own.start,
            count: own.len(),
        };
        let pieces = [0, 1].map(|which| skin.tree(&skin.roots(scene, &supply), &supply, which));
        grids.push(Grid::new(&skin, &pieces));
        let slot = grids.len() as u32;
        for vertex in &mut mesh.vertices[own] {
            vertex.look |= slot << 8;
        }
    }
    stack(&grids)
}

/// An organ's skin as a graph.
struct Skin<'a> {
    mesh: &'a SkinMesh,
    first: usize,
    count: usize,
}

impl Skin<'_> {
    fn at(&self, i: usize) -> Vec3 {
        Vec3::from(self.mesh.vertices[self.first + i].position)
    }

    fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let mesh = self.mesh;
        let [from, to] = [0, 1].map(|k| mesh.ring_first[self.first + i + k] as usize);
        let corners = mesh.ring[from..to]
            .iter()
            .flat_map(|&t| mesh.triangles[t as usize]);
        corners.filter_map(move |v| {
            let j = (v as usize).checked_sub(self.first)?;
            (j != i && j < self.count).then_some(j)
        })
    }

    /// Where blood comes in: nearest to an artery first, then wherever none is near.
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

    /// A tree from the roots to twigs spread over the skin, as smooth pieces.
    fn tree(&self, roots: &[usize], supply: &Supply, which: usize) -> Vec<Piece> {
        const FREE: u32 = u32::MAX;
        let seed = 7 + 31 * which as u32;
        let mut parent = vec![FREE; self.count];
        let mut along = vec![f32::INFINITY; self.count];
        let mut bare = vec![f32::INFINITY; self.count];
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
            // The vein comes in beside the artery.
            let root = (0..2 * which).fold(root, |r, k| self.neighbours(r).nth(k).unwrap_or(r));
            if parent[root] == FREE {
                take(root, root, &mut parent, &mut along, &mut bare);
                nodes.push(root);
            }
        }
        for twig in 0..(supply.twigs * roots.len()) as u32 {
            // Of a few places the one with the least blood.
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

    /// The cheapest way from a tree to a vertex, from the tree on.
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
        // Costs are not negative: their bits are in order.
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

    /// Curves through a tree's nodes; as many twigs as a vessel feeds, so thick it is (Murray 1926).
    fn pieces(&self, nodes: &[usize], parent: &[u32], root_m: f32) -> Vec<Piece> {
        let mut fed = vec![0.0f32; self.count];
        let mut heir = vec![usize::MAX; self.count];
        // A node comes after its parent in `nodes`.
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
                let vertex = &self.mesh.vertices[self.first + i];
                let normal = Vec3::from(vertex.normal);
                let moved = before[i] * 0.5 + (before[p] + before[h]) * 0.25;
                at[i] = moved - normal * (moved - Vec3::from(vertex.position)).dot(normal);
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
                    normal: Vec3::from(self.mesh.vertices[self.first + i].normal),
                });
            }
        }
        pieces
    }
}

/// An organ's grid of distances.
struct Grid {
    size: [usize; 3],
    low: Vec3,
    voxel_m: f32,
    texels: Vec<[u8; 2]>,
}

impl Grid {
    fn new(skin: &Skin<'_>, pieces: &[Vec<Piece>; 2]) -> Self {
        let (low, high) = (0..skin.count)
            .map(|i| skin.at(i))
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
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

    /// 0 far outside, 255 far inside, the edge between.
    fn draw(&mut self, piece: &Piece, channel: usize) {
        let [a, b] = piece.ends.map(|p| (p - self.low) / self.voxel_m);
        let [ra, rb] = piece.radii_m.map(|r| r / self.voxel_m);
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

/// Grids above each other in one texture.
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
