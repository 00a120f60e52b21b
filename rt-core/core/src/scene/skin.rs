//! Contact skin: the closed triangle surface of an organ against which tools collide. It is coarser
//! than the drawn surface.

use crate::capacity::{MAX_SKIN_VERTICES, MAX_SPHERES};
use crate::math::Vec3;
use crate::scene::{Scene, SceneError};

/// Largest number of spheres that carry one vertex of the contact skin.
pub const SKIN_BINDINGS: usize = 12;

/// Index that stands for no vertex.
pub const NO_VERTEX: u16 = u16::MAX;

/// A vertex of the contact skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinVertex {
    /// Spheres of its organ that carry the vertex; an unused place repeats another sphere with
    /// weight 0.
    pub spheres: [u16; SKIN_BINDINGS],
    /// Weights w of the spheres, with `Σ w = 1`. With the rest positions X of the spheres, `Σ w X`
    /// is the rest position of the vertex, so the vertex follows every affine motion exactly.
    pub weights: [f32; SKIN_BINDINGS],
    /// Index in `Skin::fans` of the first triangle around the vertex. All triangles around it are
    /// its fan.
    pub fan_start: u32,
    /// Number of triangles around the vertex.
    pub fan_count: u32,
    /// Width A of the Gaussian `exp(−r²/A²)` over which a force on this vertex is spread on the
    /// skin, m.
    pub patch_m: f32,
    /// Mean curvature of the skin at rest, 1/m: positive where it bulges outwards.
    pub curvature_per_m: f32,
}

/// Contact skins of all organs. Organs without tetrahedra have no skin: tools collide with their
/// beads.
#[derive(Debug, Clone, Copy, Default)]
pub struct Skin<'a> {
    /// Vertices.
    pub vertices: &'a [SkinVertex],
    /// The two other corners of every triangle around each vertex, anticlockwise seen from
    /// outside.
    pub fans: &'a [[u16; 2]],
    /// The vertex nearest to each sphere of the scene, or [`NO_VERTEX`].
    pub nearest: &'a [u16],
}

impl<'a> Skin<'a> {
    /// The vertex with this index.
    pub(crate) fn vertex(&self, index: u16) -> Option<&'a SkinVertex> {
        self.vertices.get(usize::from(index))
    }

    /// The triangles around a vertex: their two other corners.
    pub(crate) fn fan(&self, vertex: &SkinVertex) -> &'a [[u16; 2]] {
        let start = vertex.fan_start as usize;
        self.fans
            .get(start..start.saturating_add(vertex.fan_count as usize))
            .unwrap_or(&[])
    }

    /// Skin vertex nearest to a sphere.
    pub(crate) fn near_sphere(&self, sphere: u32) -> Option<u16> {
        let vertex = self.nearest.get(sphere as usize).copied();
        vertex.filter(|vertex| *vertex != NO_VERTEX)
    }
}

impl<'a> Scene<'a> {
    /// Adds the organs' contact skins.
    ///
    /// # Errors
    /// If there are too many vertices, a vertex names a sphere or vertex of another organ, or a
    /// value is out of range.
    pub fn with_skin(mut self, skin: Skin<'a>) -> Result<Self, SceneError> {
        let too_many = |what, count, limit| SceneError::TooMany { what, count, limit };
        let count = skin.vertices.len();
        if count > MAX_SKIN_VERTICES {
            return Err(too_many(
                "vertices of the contact skin",
                count,
                MAX_SKIN_VERTICES,
            ));
        }
        if skin.nearest.len() > MAX_SPHERES {
            return Err(too_many(
                "nearest vertices",
                skin.nearest.len(),
                MAX_SPHERES,
            ));
        }
        for (i, vertex) in skin.vertices.iter().enumerate() {
            self.check_vertex(i, vertex, &skin)?;
        }
        for (i, vertex) in skin.nearest.iter().enumerate() {
            let organ = self.organ_of(i as u32);
            let is_valid = match skin.vertex(*vertex) {
                Some(v) => organ.is_some() && organ == self.organ_of(u32::from(v.spheres[0])),
                None => *vertex == NO_VERTEX,
            };
            if !is_valid {
                return Err(foreign("nearest vertex", i, u32::from(*vertex)));
            }
        }
        self.skin = skin;
        Ok(self)
    }

    fn check_vertex(
        &self,
        index: usize,
        vertex: &SkinVertex,
        skin: &Skin<'_>,
    ) -> Result<(), SceneError> {
        let what = "vertex of the contact skin";
        let organ = self.organ_of(u32::from(vertex.spheres[0]));
        let foreign_sphere = vertex
            .spheres
            .iter()
            .find(|s| organ.is_none() || self.organ_of(u32::from(**s)) != organ);
        if let Some(sphere) = foreign_sphere {
            return Err(foreign(what, index, u32::from(*sphere)));
        }
        let (fan, count) = (skin.fan(vertex), vertex.fan_count as usize);
        if fan.len() != count || !(3..=FAN_MAX).contains(&count) {
            return Err(value(what, index, count as f32, "3 to 32 triangles"));
        }
        for corner in fan.as_flattened() {
            let other = skin.vertex(*corner).map(|v| u32::from(v.spheres[0]));
            if other.is_none_or(|sphere| self.organ_of(sphere) != organ) {
                return Err(foreign(
                    "triangle of the contact skin",
                    index,
                    u32::from(*corner),
                ));
            }
        }
        let sum: f32 = vertex.weights.iter().sum();
        if !vertex.weights.iter().all(|w| w.abs() <= WEIGHT_MAX) || (sum - 1.0).abs() > 1.0e-3 {
            return Err(value(what, index, sum, "weights of -8 to 8 that sum to 1"));
        }
        if !(1.0e-4..=1.0).contains(&vertex.patch_m) {
            return Err(value(what, index, vertex.patch_m, "a patch of 1e-4 to 1 m"));
        }
        let curvature = vertex.curvature_per_m;
        if !(-1.0e4..=1.0e4).contains(&curvature) {
            return Err(value(
                what,
                index,
                curvature,
                "a curvature of -1e4 to 1e4 per m",
            ));
        }
        Ok(())
    }

    /// The organ of a sphere.
    fn organ_of(&self, sphere: u32) -> Option<usize> {
        self.organs.iter().position(|organ| {
            (organ.sphere_start..organ.sphere_start + organ.sphere_count).contains(&sphere)
        })
    }

    /// Rest position of a vertex, m.
    #[must_use]
    pub fn skin_at_rest_m(&self, vertex: &SkinVertex) -> Vec3 {
        let mut at = Vec3::zeros();
        for (sphere, weight) in vertex.spheres.iter().zip(vertex.weights) {
            let rest = self.spheres.get(usize::from(*sphere));
            at += rest.map_or_else(Vec3::zeros, |s| s.center_m) * weight;
        }
        at
    }
}

/// Largest number of triangles around a vertex.
const FAN_MAX: usize = 32;
/// Largest weight of a sphere. A larger weight would make a vertex oscillate.
const WEIGHT_MAX: f32 = 8.0;

fn foreign(what: &'static str, index: usize, sphere: u32) -> SceneError {
    SceneError::Foreign {
        what,
        index,
        sphere,
    }
}

fn value(what: &'static str, index: usize, value: f32, allowed: &'static str) -> SceneError {
    SceneError::Value {
        what,
        index,
        value,
        allowed,
    }
}
