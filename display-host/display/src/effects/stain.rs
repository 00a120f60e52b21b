//! What lies on the skin: blood, bile, char. Kept by place on the tissue at rest, so that it sticks
//! to the tissue however that moves.

use glam::Vec3;
use shared_mem::message::SphereState;
use shared_mem::scene::SphereRecord;

use super::Kind;
use crate::skinning::SkinMesh;
use crate::skinning::motion::Motion;

/// Stains at most; also in `tissue.wgsl`.
pub const STAINS: usize = 64;
/// A drop meets skin when it is this near to a sphere's surface, m.
const SKIN_M: f32 = 0.0015;
/// What is farther from the skin than this is on no skin, m.
const REACH_M: f32 = 0.012;
/// A full current chars so fast, and so far, m/s and m.
const CHAR_M_S: f32 = 0.003;
const CHAR_MOST_M: f32 = 0.004;
/// Stains of one kind that are this near, in their radii, are one.
const SAME: f32 = 0.7;

/// A stain. Lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stain {
    /// Of what.
    pub kind: Kind,
    /// Middle, on the skin at rest.
    pub rest_m: Vec3,
    /// Radius.
    pub radius_m: f32,
}

/// The skin as effects see it.
#[derive(Debug, Clone, Copy)]
pub struct Skin<'a> {
    mesh: &'a SkinMesh,
    rest: &'a [SphereRecord],
    now: &'a [SphereState],
    motions: &'a [Motion],
}

impl<'a> Skin<'a> {
    /// The skin of this moment.
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

    fn at_rest(&self, vertex: usize) -> Vec3 {
        self.mesh
            .vertices
            .get(vertex)
            .map_or(Vec3::ZERO, |v| v.position.into())
    }

    /// Away from the tissue, at rest.
    pub(super) fn normal(&self, vertex: usize) -> Vec3 {
        self.mesh
            .vertices
            .get(vertex)
            .map_or(Vec3::ZERO, |v| v.normal.into())
    }

    /// The vertex of the skin near a place in the world, if there is one.
    pub(super) fn nearest(&self, at_m: Vec3) -> Option<usize> {
        let spheres = self.rest.iter().zip(self.now);
        let far = |center: [f32; 3]| Vec3::from(center).distance_squared(at_m);
        let (rest, now) = spheres.min_by(|a, b| far(a.1.center_m).total_cmp(&far(b.1.center_m)))?;
        // Where it would lie if the tissue there were at rest.
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

    /// The vertex that a drop at this place has struck.
    pub(super) fn struck(&self, at_m: Vec3) -> Option<usize> {
        let hit = self.rest.iter().zip(self.now).any(|(rest, now)| {
            let reach = rest.radius_m + SKIN_M;
            Vec3::from(now.center_m).distance_squared(at_m) < reach * reach
        });
        if hit { self.nearest(at_m) } else { None }
    }

    /// The neighbour that lies lowest now, if one lies lower.
    pub(super) fn downhill(&self, vertex: usize, up: Vec3) -> Option<usize> {
        let height = |i: usize| self.mesh.place(i, self.motions).dot(up);
        let ring = self.mesh.ring_first.get(vertex..vertex + 2)?;
        let triangles = self.mesh.ring.get(ring[0] as usize..ring[1] as usize)?;
        let corners = triangles
            .iter()
            .flat_map(|&t| self.mesh.triangles[t as usize]);
        let corners = corners
            .map(|v| v as usize)
            .filter(|&v| v < self.mesh.skinned);
        let lowest = corners.min_by(|&a, &b| height(a).total_cmp(&height(b)))?;
        (height(lowest) < height(vertex) - 1e-5).then_some(lowest)
    }
}

/// Adds a stain, or makes one that is there already larger by `grow_m`, up to `most_m`.
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
        // The smallest is missed least.
        let smallest =
            (0..STAINS).min_by(|&a, &b| stains[a].radius_m.total_cmp(&stains[b].radius_m));
        stains.remove(smallest.unwrap_or(0));
    }
    stains.push(stain);
}

/// A pool that grows.
pub(super) fn pool(
    stains: &mut Vec<Stain>,
    skin: &Skin<'_>,
    vertex: usize,
    kind: Kind,
    grow_m: f32,
    most_m: f32,
) {
    let stain = Stain {
        kind,
        rest_m: skin.at_rest(vertex),
        radius_m: 0.0012,
    };
    add(stains, stain, grow_m, most_m);
}

/// A mark of what runs down.
pub(super) fn run(stains: &mut Vec<Stain>, skin: &Skin<'_>, vertex: usize, kind: Kind) {
    let stain = Stain {
        kind,
        rest_m: skin.at_rest(vertex),
        radius_m: 0.0022,
    };
    add(stains, stain, 0.0002, 0.004);
}

/// A drop that fell.
pub(super) fn splash(stains: &mut Vec<Stain>, skin: &Skin<'_>, vertex: usize, kind: Kind) {
    let stain = Stain {
        kind,
        rest_m: skin.at_rest(vertex),
        radius_m: 0.0014,
    };
    add(stains, stain, 0.0003, 0.005);
}

/// Char: the longer the current, the wider, whatever the frame rate. `current_s` is its time
/// multiplied by its strength.
pub(super) fn char(stains: &mut Vec<Stain>, skin: &Skin<'_>, vertex: usize, current_s: f32) {
    let grow_m = CHAR_M_S * current_s;
    let stain = Stain {
        kind: Kind::Char,
        rest_m: skin.at_rest(vertex),
        radius_m: (0.0012 + grow_m).min(CHAR_MOST_M),
    };
    add(stains, stain, grow_m, CHAR_MOST_M);
}
