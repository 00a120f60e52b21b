//! Skinning: every vertex follows the spheres to which it is bound.
//!
//! The paper (Eq. 9–12) shows a vertex at a fixed offset from the weighted mean of its spheres'
//! centres. The offset does not turn with the tissue: a liver bent by 90° has an overall error of
//! 5.5 mm. Here each sphere carries the deformation of the tissue around it ([`motion`]), and a
//! vertex follows its spheres by the same weights: `v' = v + Σ w_i (G_i v + t_i)`. The error is 0.6
//! mm at twice the time. `examples/skinning.rs` measures this and the other methods that were
//! tried. Normals are gathered: every vertex sums the area-weighted normals of its triangles, in a
//! fixed order, without atomics. Then the dents that tools make are drawn ([`dent`]). Where a duct
//! or vessel is severed, the skin parts ([`parts`]).
//!
//! There are two implementations, which a test compares: [`SkinMesh::skin`] on the CPU (14 to 40
//! times faster where the "graphics device" is a CPU), and [`gpu::GpuSkinning`].

pub mod dent;
pub mod gpu;
pub mod motion;
pub mod organs;
pub mod parts;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shared_mem::message::{DentMsg, MAX_DENTS, SphereState, ToolFrame};
use shared_mem::scene::{OrganRecord, SceneFile, WEIGHT_SUM};

use self::dent::{Dent, dented};
use self::motion::{Motion, moved};

/// Assumed ratio of two distances from a vertex to its neighbours: the largest one and the root
/// mean square. `skinning.wgsl` has the same number.
const FARTHEST: f32 = 1.2;

/// Distance between a dent and a sphere's centre, m, below which the sphere's vertices may lie
/// under the tool. It is the radius of the largest spheres plus the tool's radius.
const NEAR_M: f32 = 0.015;

/// The tools' effect on skin, in the layout of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Touch {
    /// Number of dents; the other numbers are unused.
    pub count: [u32; 4],
    /// The dents of the tools.
    pub dents: [Dent; MAX_DENTS],
}

impl Default for Touch {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Touch {
    /// The tools' effect on these organs at this moment. `motions` are those of the scene's
    /// spheres.
    #[must_use]
    pub fn of(
        mesh: &SkinMesh,
        organs: &[OrganRecord],
        spheres: &[SphereState],
        motions: &[Motion],
        tools: &ToolFrame,
    ) -> Self {
        let dents = tools.dents().unwrap_or(&[]);
        let depth_m = |dent: &DentMsg| {
            let near = mesh.near(dent, organs, spheres);
            let places = near.map(|vertex| mesh.place(vertex as usize, motions));
            dent::depth_m(dent, places)
        };
        Self {
            count: [dents.len() as u32, 0, 0, 0],
            dents: dent::dents(dents, organs, depth_m),
        }
    }

    /// The dents in use.
    fn dents(&self) -> &[Dent] {
        &self.dents[..self.dents.len().min(self.count[0] as usize)]
    }
}

/// A vertex at rest, in the layout of the shaders: 64 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RestVertex {
    /// Position in the world frame, m.
    pub position: [f32; 3],
    /// Look. Bits 0 to 3: row of the material table; 4 to 7: a second row; 8 to 11: slot of the
    /// vessel tree; 16 to 31: share of the second row, of 65535.
    pub look: u32,
    /// Outward unit normal.
    pub normal: [f32; 3],
    /// Ambient light at rest, 0 to 1.
    pub ambient: f32,
    /// Indices of its spheres: eight `u16`.
    pub spheres: [u32; 4],
    /// Weights of its spheres: eight `u16`, with sum 65535.
    pub weights: [u32; 4],
}

impl RestVertex {
    /// Share of the vertex's weight that lies on a range of spheres. The first number is the
    /// range's first sphere, and the second is the first sphere after the range.
    fn share(&self, [first, end, ..]: [u32; 4]) -> f32 {
        let own = self.bound().filter(|it| (first..end).contains(&it.0));
        let sum: u32 = own.map(|it| it.1).sum();
        sum as f32 / WEIGHT_SUM as f32
    }
}

/// A vertex in its present position: 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SkinnedVertex {
    /// Position in the world frame, m. The fourth number is the length by which tools displace the
    /// skin, m. For a fibre or thread it is the negated radius, m.
    pub position: [f32; 4],
    /// Unit normal. The fourth number is the curvature added since rest, 1/m, above 0 in a hollow.
    pub normal: [f32; 4],
}

/// Vertices moved by spheres, with the triangles around each.
#[derive(Debug, Clone, Default)]
pub struct SkinMesh {
    /// Vertices at rest. The vertices from `skinned` on never move.
    pub vertices: Vec<RestVertex>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Number of vertices that follow spheres.
    pub skinned: usize,
    /// Index in `ring` at which the triangles of each vertex begin. The triangles of vertex `i` are
    /// `ring[ring_first[i]..ring_first[i + 1]]`.
    pub ring_first: Vec<u32>,
    /// Indices of the triangles around each vertex, one vertex after the other.
    pub ring: Vec<u32>,
    /// For each sphere: the vertices in which its weight is the largest.
    pub of_sphere: Vec<Vec<u32>>,
    /// For each vertex at rest: height of its neighbours' mean above the vertex (m), and 2 divided
    /// by the neighbours' mean squared distance (1/m²).
    pub ring_rest: Vec<[f32; 2]>,
}

impl SkinMesh {
    /// The organs' skins, with full ambient light and the organ's kind as look.
    #[must_use]
    pub fn from_scene(scene: &SceneFile) -> Self {
        let mut vertices: Vec<RestVertex> = Vec::with_capacity(scene.vertices().len());
        for organ in scene.organs() {
            let [first, count] = organ.vertices.map(|x| x as usize);
            vertices.extend(
                scene.vertices()[first..first + count]
                    .iter()
                    .map(|v| RestVertex {
                        position: v.position_m,
                        look: organ.kind,
                        normal: v.normal,
                        ambient: 1.0,
                        spheres: pairs(v.spheres),
                        weights: pairs(v.weights),
                    }),
            );
        }
        let mut mesh = Self {
            skinned: vertices.len(),
            vertices,
            triangles: scene.triangles().to_vec(),
            ..Self::default()
        };
        mesh.find_rings();
        mesh.of_sphere = vec![Vec::new(); scene.spheres().len()];
        for (number, vertex) in (0u32..).zip(scene.vertices()) {
            let bound = vertex.spheres.iter().zip(&vertex.weights);
            if let Some((sphere, _)) = bound.max_by_key(|(_, weight)| **weight) {
                mesh.of_sphere[usize::from(*sphere)].push(number);
            }
        }
        mesh
    }

    /// Vertices of a dent's organ near the dent.
    fn near<'a>(
        &'a self,
        dent: &DentMsg,
        organs: &[OrganRecord],
        spheres: &'a [SphereState],
    ) -> impl Iterator<Item = u32> + use<'a> {
        let own = organs
            .get(dent.organ as usize)
            .map_or([0; 2], |it| it.spheres);
        let center = Vec3::from(dent.center_m);
        let reach_m = NEAR_M + Vec3::from(dent.half_m).length() + dent.depth_m;
        (own[0]..own[0] + own[1])
            .filter(move |sphere| {
                let at = spheres.get(*sphere as usize);
                at.is_some_and(|at| Vec3::from(at.center_m).distance(center) < reach_m)
            })
            .filter_map(|sphere| self.of_sphere.get(sphere as usize))
            .flatten()
            .copied()
    }

    /// Adds vertices that follow spheres. Call it before `add_fixed`. The indices in `triangles`
    /// count from the first new vertex.
    pub fn add_skinned(&mut self, vertices: &[RestVertex], triangles: &[[u32; 3]]) {
        debug_assert_eq!(self.skinned, self.vertices.len(), "fixed ones come last");
        self.add_fixed(vertices, triangles);
        self.skinned = self.vertices.len();
    }

    /// Adds vertices that never move. The indices in `triangles` count from the first new vertex.
    pub fn add_fixed(&mut self, vertices: &[RestVertex], triangles: &[[u32; 3]]) {
        let base = self.vertices.len() as u32;
        self.vertices.extend_from_slice(vertices);
        let moved = triangles.iter().map(|t| t.map(|i| i + base));
        self.triangles.extend(moved);
        self.find_rings();
    }

    /// The vertices at rest.
    #[must_use]
    pub fn at_rest(&self) -> Vec<SkinnedVertex> {
        let rest = self.vertices.iter().map(|v| SkinnedVertex {
            position: [v.position[0], v.position[1], v.position[2], 0.0],
            normal: [v.normal[0], v.normal[1], v.normal[2], 0.0],
        });
        rest.collect()
    }

    /// Moves the skinned vertices with their spheres, and into the dents of the tools.
    /// Twin of `skinning.wgsl`. `out` holds every vertex; only the skinned ones are written.
    pub fn skin(&self, motions: &[Motion], touch: &Touch, out: &mut [SkinnedVertex]) {
        let rest = self.vertices[..self.skinned].iter().zip(&self.ring_rest);
        for ((vertex, ring), now) in rest.zip(out.iter_mut()) {
            let mut motion = Motion::default();
            for (pair, weights) in vertex.spheres.iter().zip(&vertex.weights) {
                for shift in [0, 16] {
                    let sphere = &motions[(pair >> shift & 0xffff) as usize];
                    let weight = (weights >> shift & 0xffff) as f32 / WEIGHT_SUM as f32;
                    for (sum, x) in motion
                        .as_flattened_mut()
                        .iter_mut()
                        .zip(sphere.as_flattened())
                    {
                        *sum += x * weight;
                    }
                }
            }
            let position = moved(&motion, vertex.position.into());
            let around_m = FARTHEST * (2.0 / ring[1].max(1e-6)).sqrt();
            let share = |spheres| vertex.share(spheres);
            let push = dented(touch.dents(), position, around_m, share);
            now.position = (position + push).extend(push.length()).to_array();
        }
        for i in 0..self.skinned {
            let (normal, lift) = self.gather(i, |v| Vec3::from_slice(&out[v].position));
            let [rest_lift, per_area] = self.ring_rest[i];
            out[i].normal = normal.extend((lift - rest_lift) * per_area).to_array();
        }
    }

    /// Position of a vertex before any press, m.
    #[must_use]
    pub fn place(&self, vertex: usize, motions: &[Motion]) -> Vec3 {
        let Some(rest) = self.vertices.get(vertex) else {
            return Vec3::ZERO;
        };
        let mut at = Vec3::from(rest.position);
        if vertex < self.skinned {
            let home = at;
            for (pair, weights) in rest.spheres.iter().zip(&rest.weights) {
                for shift in [0, 16] {
                    let weight = (weights >> shift & 0xffff) as f32 / WEIGHT_SUM as f32;
                    if let Some(motion) = motions.get((pair >> shift & 0xffff) as usize) {
                        at += (moved(motion, home) - home) * weight;
                    }
                }
            }
        }
        at
    }

    /// Normal of vertex `i`, and height of its neighbours' mean above the vertex, m.
    fn gather(&self, i: usize, at: impl Fn(usize) -> Vec3) -> (Vec3, f32) {
        let ring = &self.ring[self.ring_first[i] as usize..self.ring_first[i + 1] as usize];
        let here = at(i);
        let (mut normal, mut lean) = (Vec3::ZERO, Vec3::ZERO);
        for &triangle in ring {
            let [a, b, c] = self.triangles[triangle as usize].map(|v| at(v as usize));
            normal += (b - a).cross(c - a);
            lean += (a - here) + (b - here) + (c - here);
        }
        let length = normal.length();
        if length <= 1e-20 {
            return (Vec3::from(self.vertices[i].normal), 0.0);
        }
        let normal = normal / length;
        // Every neighbour occurs twice, in two triangles.
        (normal, lean.dot(normal) / (2 * ring.len()) as f32)
    }

    fn find_rings(&mut self) {
        let mut first = vec![0u32; self.vertices.len() + 1];
        for &v in self.triangles.as_flattened() {
            first[v as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut ring = vec![0u32; self.triangles.len() * 3];
        for (t, triangle) in self.triangles.iter().enumerate() {
            for &v in triangle {
                ring[next[v as usize] as usize] = t as u32;
                next[v as usize] += 1;
            }
        }
        self.ring_first = first;
        self.ring = ring;
        let at = |v: usize| Vec3::from(self.vertices[v].position);
        self.ring_rest = (0..self.vertices.len())
            .map(|i| {
                let (_, lift) = self.gather(i, at);
                let ring = &self.ring[self.ring_first[i] as usize..self.ring_first[i + 1] as usize];
                let corners = ring.iter().flat_map(|&t| self.triangles[t as usize]);
                let reach2: f32 = corners
                    .map(|v| at(v as usize).distance_squared(at(i)))
                    .sum();
                // A paraboloid of curvature k lifts the neighbours' mean by k/2 times their mean
                // squared distance.
                let mean2 = reach2 / (2 * ring.len()).max(1) as f32;
                [lift, if mean2 > 1e-12 { 2.0 / mean2 } else { 0.0 }]
            })
            .collect();
    }
}

/// Packs eight numbers in four, as shaders read them.
pub(crate) fn pairs(numbers: [u16; 8]) -> [u32; 4] {
    core::array::from_fn(|i| u32::from(numbers[2 * i]) | u32::from(numbers[2 * i + 1]) << 16)
}

const _: () = assert!(size_of::<RestVertex>() == 64 && size_of::<SkinnedVertex>() == 32);
