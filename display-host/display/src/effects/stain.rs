//! Stains on the skin: char. A stain is stored at its place on the tissue at rest, so that it moves
//! with the tissue.

use glam::Vec3;
use shared_mem::message::SphereState;
use shared_mem::scene::SphereRecord;

use super::Kind;
use crate::skinning::SkinMesh;
use crate::skinning::motion::Motion;

/// Largest number of stains; the same number is in `light.wgsl` and `tissue.wgsl`.
pub const STAINS: usize = 64;
/// Distance from a sphere's surface at which a drop meets skin, m.
const SKIN_M: f32 = 0.0015;
/// Distance from the nearest vertex of the skin, m, below which a point counts as on the skin.
const REACH_M: f32 = 0.012;
/// Speed at which the radius of char grows under a full current, m/s.
const CHAR_M_S: f32 = 0.003;
/// Largest radius of char, m.
const CHAR_MOST_M: f32 = 0.004;
/// Two stains of one kind are merged if their distance is less than this share of the larger
/// radius.
const SAME: f32 = 0.7;

/// A stain. Lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stain {
    /// Kind of the effect that made the stain.
    pub kind: Kind,
    /// Centre, on the skin at rest.
    pub rest_m: Vec3,
    /// Radius.
    pub radius_m: f32,
}

/// The skin, as the effects use it.
#[derive(Debug, Clone, Copy)]
pub struct Skin<'a> {
    mesh: &'a SkinMesh,
    rest: &'a [SphereRecord],
    now: &'a [SphereState],
    motions: &'a [Motion],
}

impl<'a> Skin<'a> {
    /// The skin at this moment.
    #[must_use]
    pub fn new(
        mesh: &'a SkinMesh,
        rest: &'a [SphereRecord],
        now: &'a [SphereState],
        motions: &'a [Motion],
    ) -> Self {
        Self {
            mesh,
            rest,
            now,
            motions,
        }
    }

    pub(super) fn triangles(&self) -> &'a [[u32; 3]] {
        &self.mesh.triangles
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.mesh.vertices.len()
    }

    /// Present position of a vertex, m.
    pub(super) fn place(&self, vertex: usize) -> Vec3 {
        self.mesh.place(vertex, self.motions)
    }

    /// A drawn triangle at a vertex, and the weights of its corners at this place: 1 for the
    /// vertex, 0 for the others.
    pub(super) fn place_at(&self, vertex: usize) -> Option<(u32, [f32; 3])> {
        let ring = self.mesh.ring_first.get(vertex..vertex + 2)?;
        let around = self.mesh.ring.get(ring[0] as usize..ring[1] as usize)?;
        let whole = around.iter().find(|t| {
            let corners = self.mesh.triangles[**t as usize];
            corners[0] != corners[1] && corners[1] != corners[2]
        })?;
        let corners = self.mesh.triangles[*whole as usize];
        Some((
            *whole,
            corners.map(|v| f32::from(u8::from(v as usize == vertex))),
        ))
    }

    /// Position of a vertex in the tissue at rest, m.
    pub(super) fn at_rest(&self, vertex: usize) -> Vec3 {
        self.mesh
            .vertices
            .get(vertex)
            .map_or(Vec3::ZERO, |v| v.position.into())
    }

    /// Outward normal at rest.
    pub(super) fn normal(&self, vertex: usize) -> Vec3 {
        self.mesh
            .vertices
            .get(vertex)
            .map_or(Vec3::ZERO, |v| v.normal.into())
    }

    /// The vertex of the skin nearest to a position in the world, if it is within `REACH_M`.
    pub(super) fn nearest(&self, at_m: Vec3) -> Option<usize> {
        let spheres = self.rest.iter().zip(self.now);
        let far = |center: [f32; 3]| Vec3::from(center).distance_squared(at_m);
        let (rest, now) = spheres.min_by(|a, b| far(a.1.center_m).total_cmp(&far(b.1.center_m)))?;
        // The displacement of the nearest sphere gives the point's position in the tissue at rest.
        let at = at_m - Vec3::from(now.center_m) + Vec3::from(rest.center_m);
        let vertices = self
            .mesh
            .vertices
            .iter()
            .take(self.mesh.skinned)
            .enumerate();
        let (vertex, far) = vertices
            .map(|(i, v)| (i, Vec3::from(v.position).distance(at)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        (far < REACH_M).then_some(vertex)
    }

    /// Vertex hit by a drop at this position.
    pub(super) fn struck(&self, at_m: Vec3) -> Option<usize> {
        let hit = self.rest.iter().zip(self.now).any(|(rest, now)| {
            let reach = rest.radius_m + SKIN_M;
            Vec3::from(now.center_m).distance_squared(at_m) < reach * reach
        });
        if hit { self.nearest(at_m) } else { None }
    }
}

/// Adds a stain. If a stain of its kind is there already, that stain grows by `grow_m` instead, up
/// to the radius `most_m`.
fn add(stains: &mut Vec<Stain>, stain: Stain, grow_m: f32, most_m: f32) {
    let same = |s: &&mut Stain| {
        s.kind == stain.kind
            && s.rest_m.distance(stain.rest_m) < SAME * s.radius_m.max(stain.radius_m)
    };
    if let Some(there) = stains.iter_mut().find(same) {
        if there.radius_m < most_m {
            there.radius_m = (there.radius_m + grow_m).min(most_m);
        }
        return;
    }
    if stains.len() == STAINS {
        // The smallest stain is replaced, because it is the least conspicuous one.
        let smallest =
            (0..STAINS).min_by(|&a, &b| stains[a].radius_m.total_cmp(&stains[b].radius_m));
        stains.remove(smallest.unwrap_or(0));
    }
    stains.push(stain);
}

/// Adds char. `current_s` is the duration of the current times its strength. The growth depends on
/// this product alone, so the frame rate does not matter.
pub(super) fn char(stains: &mut Vec<Stain>, skin: &Skin<'_>, vertex: usize, current_s: f32) {
    let grow_m = CHAR_M_S * current_s;
    let stain = Stain {
        kind: Kind::Char,
        rest_m: skin.at_rest(vertex),
        radius_m: (0.0012 + grow_m).min(CHAR_MOST_M),
    };
    add(stains, stain, grow_m, CHAR_MOST_M);
}
