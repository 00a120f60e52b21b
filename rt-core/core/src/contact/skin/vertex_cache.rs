//! Per-tick cache of skin vertex positions and normals.

use crate::math::{self, Vec3};
use crate::scene::{Skin, SkinVertex};
use crate::tissue::Bodies;
use crate::tissue::lanes::Lanes;

/// Rows of the cache. More rows cost memory and evict fewer vertices.
const ROWS: usize = 1024;

/// Position and normal of a vertex in one tick.
#[derive(Debug, Clone, Copy)]
struct CachedVertex {
    vertex: u16,
    has_normal: bool,
    /// Tick in which position and normal were computed.
    tick: u32,
    at_m: Vec3,
    normal: Vec3,
}

const EMPTY: CachedVertex = CachedVertex {
    vertex: 0,
    has_normal: false,
    tick: 0,
    at_m: Vec3::new(0.0, 0.0, 0.0),
    normal: Vec3::new(0.0, 0.0, 0.0),
};

/// Direct-mapped cache: vertices with equal low bits evict each other. A miss costs a sum over the
/// vertex's twelve spheres.
///
/// Call [`VertexCache::begin`] in each tick before the first lookup. Before the first `begin`, the
/// empty row 0 counts as a hit: vertex 0 would lie at the origin.
#[derive(Debug, Clone)]
pub(crate) struct VertexCache {
    rows: [CachedVertex; ROWS],
    tick: u32,
}

impl Default for VertexCache {
    fn default() -> Self {
        Self::new()
    }
}

impl VertexCache {
    pub(crate) const fn new() -> Self {
        Self {
            rows: [EMPTY; ROWS],
            tick: 0,
        }
    }

    /// Begins a tick: the spheres have moved, so all entries are invalid.
    pub(crate) fn begin(&mut self) {
        self.tick = self.tick.wrapping_add(1);
        if self.tick == 0 {
            self.rows.fill(EMPTY);
            self.tick = 1;
        }
    }

    #[inline(always)]
    fn row(&mut self, index: u16) -> &mut CachedVertex {
        &mut self.rows[usize::from(index) & (ROWS - 1)]
    }

    /// Position of a vertex, world frame, m. [`VertexCache::begin`] must have been called in this
    /// tick.
    #[inline]
    pub(crate) fn at_m(&mut self, index: u16, skin: &Skin<'_>, bodies: &Bodies) -> Option<Vec3> {
        let tick = self.tick;
        let row = self.row(index);
        if row.tick == tick && row.vertex == index {
            return Some(row.at_m);
        }
        let at_m = at_m(skin.vertex(index)?, bodies);
        *row = CachedVertex {
            vertex: index,
            has_normal: false,
            tick,
            at_m,
            normal: EMPTY.normal,
        };
        Some(at_m)
    }

    /// Outward normal of a vertex, its triangles weighted by area; zero where they cancel.
    pub(crate) fn normal(&mut self, index: u16, skin: &Skin<'_>, bodies: &Bodies) -> Option<Vec3> {
        let tick = self.tick;
        let row = self.row(index);
        if row.tick == tick && row.vertex == index && row.has_normal {
            return Some(row.normal);
        }
        let center_m = self.at_m(index, skin, bodies)?;
        let mut sum = Vec3::zeros();
        for &[b, c] in skin.fan(skin.vertex(index)?) {
            let b_m = self.at_m(b, skin, bodies)?;
            let c_m = self.at_m(c, skin, bodies)?;
            sum += (b_m - center_m).cross(&(c_m - center_m));
        }
        let normal = math::unit(&sum).unwrap_or_else(Vec3::zeros);
        // A corner of the vertex's fan may have taken this row meanwhile.
        *self.row(index) = CachedVertex {
            vertex: index,
            has_normal: true,
            tick,
            at_m: center_m,
            normal,
        };
        Some(normal)
    }
}

/// Position of a vertex from its spheres, world frame, m.
pub(crate) fn at_m(vertex: &SkinVertex, bodies: &Bodies) -> Vec3 {
    let mut at = Lanes::ZERO;
    for (sphere, weight) in vertex.spheres.iter().zip(vertex.weights) {
        let node = bodies.nodes.at(u32::from(*sphere));
        at = at + node.center() * Lanes::splat(weight);
    }
    at.vec3()
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use crate::scene::{SKIN_BINDINGS, Scene};
    use proptest::prelude::*;
    use std::boxed::Box;
    use std::vec::Vec as List;

    /// As [`VertexCache::normal`], but without the cache.
    fn plain_normal(index: u16, skin: &Skin<'_>, bodies: &Bodies) -> Vec3 {
        let vertex = skin.vertex(index).unwrap();
        let center_m = at_m(vertex, bodies);
        let corner = |i: u16| at_m(skin.vertex(i).unwrap(), bodies) - center_m;
        let crosses = skin.fan(vertex).iter();
        let sum: Vec3 = crosses.map(|&[b, c]| corner(b).cross(&corner(c))).sum();
        math::unit(&sum).unwrap_or_else(Vec3::zeros)
    }

    proptest! {
        /// The cache gives the position and normal of a fresh computation, after any earlier
        /// lookups. 3000 vertices with random fans share 1024 rows.
        #[test]
        fn cache_gives_the_values_of_a_fresh_computation(
            seed in 1u32..u32::MAX, asked in prop::collection::vec((0u16..3000, any::<bool>()), 1..200),
        ) {
            let mut seed = seed;
            let mut random = |below: u32| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 8) % below
            };
            let mut place = || Vec3::new(random(999) as f32, random(999) as f32, random(999) as f32);
            let spheres: List<_> = (0..40).map(|_| sphere(place() * 1.0e-4, 0.01)).collect();
            let vertices: List<_> = (0..3000).map(|i| SkinVertex {
                spheres: core::array::from_fn(|_| random(40) as u16),
                weights: [1.0 / SKIN_BINDINGS as f32; SKIN_BINDINGS],
                fan_start: i * 4,
                fan_count: 4,
                patch_m: 0.01,
                curvature_per_m: 0.0,
            }).collect();
            let fans: List<_> = (0..12_000).map(|_| [random(3000) as u16, random(3000) as u16]).collect();
            let nearest = [0u16; 40];
            let skin = Skin { vertices: &vertices, fans: &fans, nearest: &nearest };
            let organs = [organ(0, 40, 0, 0)];
            let scene = Scene::new(&organs, &spheres, &[], room()).unwrap();
            let mut bodies = Box::new(Bodies::new());
            bodies.load(&scene);
            let mut cache = Box::new(VertexCache::default());
            for round in 0..2 {
                cache.begin();
                for &(index, normal) in &asked {
                    if normal {
                        let cached = cache.normal(index, &skin, &bodies).unwrap();
                        prop_assert_eq!(cached, plain_normal(index, &skin, &bodies));
                    } else {
                        let cached = cache.at_m(index, &skin, &bodies).unwrap();
                        prop_assert_eq!(cached, at_m(&vertices[usize::from(index)], &bodies));
                    }
                }
                bodies.nodes.at_mut(round).move_by(&Vec3::new(0.001, 0.002, 0.003));
            }
        }
    }
}
