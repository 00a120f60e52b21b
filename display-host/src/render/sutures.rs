//! Sutures that hang an organ on the abdominal wall: doubled threads, from where they go through the organ's skin
//! to where they leave through the wall. Taut they are straight, slack they sag; cut through, their ends hang.

use bytemuck::{Zeroable, cast_slice};
use glam::Vec3;
use shared_mem::message::SphereState;
use shared_mem::scene::{AttachmentRecord, SceneFile, VertexRecord, WORLD};

use super::cells::{Buffers, carried};
use super::fibre::{SIDES, triangles, tube};
use super::gpu::Gpu;
use super::look::INSULATION;
use crate::skinning::motion::Motion;
use crate::skinning::{RestVertex, SkinnedVertex, pairs};

/// Radius of a 3-0 thread, m.
const RADIUS_M: f32 = 0.000_12;
/// Width of the bite that it takes of the organ, m.
const BITE_M: f32 = 0.006;
/// It begins so far under the skin, m.
const UNDER_M: f32 = 0.000_6;
/// The wall lies somewhere behind the place in the world that it is tied to: it is drawn so much farther, m.
const BEYOND_M: f32 = 0.12;
/// What hangs of it at the organ and at the wall when it is cut, m.
const TAIL_M: f32 = 0.014;
const NOWHERE_M: [f32; 3] = [10.0; 3];
/// Points along each half of a strand.
const POINTS: usize = 8;
/// Two strands of two halves.
const HALVES: usize = 4;
const CORNERS: usize = HALVES * POINTS * SIDES;
/// More are not told when they are cut (`StateFrame::cut_sutures`), and not drawn.
const MOST: usize = 32;

struct Suture {
    /// Which bit tells that it is cut.
    bit: usize,
    sphere: usize,
    /// Where its two strands leave the organ's skin.
    leaves: [RestVertex; 2],
    anchor: Vec3,
    length_m: f32,
}

/// A scene's sutures to the world.
pub(super) struct Sutures {
    sutures: Vec<Suture>,
    up: Vec3,
    cut: u32,
    now: Vec<SkinnedVertex>,
    pub(super) buffers: Option<Buffers>,
}

impl Sutures {
    pub(super) fn of(gpu: &Gpu, scene: &SceneFile) -> Self {
        let threads = scene.attachments().iter().filter(|tie| tie.is_thread != 0);
        let threads = threads.enumerate().take(MOST);
        let to_wall = threads.filter(|(_, tie)| tie.b == WORLD);
        let sutures: Vec<Suture> = to_wall
            .filter_map(|(bit, tie)| Suture::of(scene, bit, tie))
            .collect();
        let mut rest: Vec<RestVertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        for suture in &sutures {
            for half in 0..HALVES {
                indices.extend(triangles(rest.len() as u32, POINTS));
                // It has no place in any tissue, and nothing that lies on one lies on it.
                let painted = RestVertex {
                    position: NOWHERE_M,
                    look: INSULATION,
                    ambient: 0.8,
                    ..suture.leaves[half % 2]
                };
                rest.extend([painted; POINTS * SIDES]);
            }
        }
        let buffers = (!sutures.is_empty()).then(|| {
            let mut buffers = Buffers::new(gpu, "sutures", rest.len(), indices.len());
            buffers.count = indices.len() as u32;
            gpu.queue.write_buffer(&buffers.rest, 0, cast_slice(&rest));
            gpu.queue
                .write_buffer(&buffers.indices, 0, cast_slice(&indices));
            buffers
        });
        Self {
            now: vec![SkinnedVertex::zeroed(); rest.len()],
            sutures,
            up: (-Vec3::from(scene.room().gravity_m_s2)).normalize_or(Vec3::Y),
            cut: 0,
            buffers,
        }
    }

    /// Takes which of them are cut through (`StateFrame::cut_sutures`).
    pub(super) fn set_cut(&mut self, cut: u32) {
        self.cut = cut;
    }

    /// Moves them with what they hold.
    pub(super) fn follow(&mut self, gpu: &Gpu, spheres: &[SphereState], motions: &[Motion]) {
        let Some(buffers) = &self.buffers else {
            return;
        };
        for (suture, now) in self.sutures.iter().zip(self.now.chunks_mut(CORNERS)) {
            let center = spheres.get(suture.sphere).map(|it| it.center_m.into());
            let leaves = suture.leaves.map(|it| carried(&it, motions));
            let is_cut = self.cut >> suture.bit & 1 != 0;
            let center = center.unwrap_or(suture.anchor);
            let halves = suture.course(center, leaves, self.up, is_cut);
            for (path, now) in halves.iter().zip(now.chunks_mut(POINTS * SIDES)) {
                tube(path, RADIUS_M, now);
            }
        }
        gpu.queue
            .write_buffer(&buffers.now, 0, cast_slice(&self.now));
    }
}

impl Suture {
    /// `None` if it is tied to no organ's skin.
    fn of(scene: &SceneFile, bit: usize, tie: &AttachmentRecord) -> Option<Self> {
        let owns = |[first, count]: [u32; 2]| (first..first + count).contains(&tie.a);
        let organ = scene.organs().iter().find(|it| owns(it.spheres))?;
        let [first, count] = organ.vertices.map(|it| it as usize);
        let skin = scene.vertices().get(first..first + count)?;
        let sphere = scene.spheres().get(tie.a as usize)?;
        let (center, anchor) = (Vec3::from(sphere.center_m), Vec3::from(tie.anchor_m));
        let out = (anchor - center).normalize_or(Vec3::Y);
        let aside = out.any_orthonormal_vector() * (0.5 * BITE_M);
        let leaves = |side: Vec3| {
            let at = center + out * sphere.radius_m + side;
            let far = |v: &&VertexRecord| Vec3::from(v.position_m).distance_squared(at);
            let nearest = skin.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
            let under = Vec3::from(nearest.position_m) - Vec3::from(nearest.normal) * UNDER_M;
            Some(RestVertex {
                position: under.to_array(),
                look: organ.kind,
                normal: nearest.normal,
                ambient: 1.0,
                spheres: pairs(nearest.spheres),
                weights: pairs(nearest.weights),
            })
        };
        Some(Self {
            bit,
            sphere: tie.a as usize,
            leaves: [leaves(aside)?, leaves(-aside)?],
            anchor,
            length_m: tie.rest_length_m,
        })
    }

    /// Where its strands run: of each the half at the organ, then of each the half at the wall.
    fn course(
        &self,
        center: Vec3,
        leaves: [Vec3; 2],
        up: Vec3,
        is_cut: bool,
    ) -> [[Vec3; POINTS]; HALVES] {
        let way = self.anchor - center;
        let out = way.normalize_or(up);
        let wall = self.anchor + out * BEYOND_M;
        let slack_m = (self.length_m - way.length()).max(0.0);
        // A flat parabola that is so much longer than its chord.
        let sag_m = (0.375 * way.length() * slack_m).sqrt();
        core::array::from_fn(|half| {
            let from = leaves[half % 2];
            let is_at_wall = half >= 2;
            core::array::from_fn(|point| {
                let share = point as f32 / (POINTS - 1) as f32;
                if is_cut {
                    let tail_m = TAIL_M * share;
                    return match is_at_wall {
                        // First the way that it went, then down.
                        false => from + (out * (1.0 - share) - up * share) * tail_m,
                        true => wall.lerp(self.anchor, share) - up * (tail_m * share),
                    };
                }
                let along = 0.5 * (share + f32::from(u8::from(is_at_wall)));
                from.lerp(wall, along) - up * (4.0 * sag_m * along * (1.0 - along))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suture() -> Suture {
        Suture {
            bit: 0,
            sphere: 0,
            leaves: [RestVertex::zeroed(); 2],
            anchor: Vec3::Y * 0.1,
            length_m: 0.1,
        }
    }

    #[test]
    fn a_taut_suture_is_straight_and_a_slack_one_sags() {
        let leaves = [Vec3::X * 0.003, Vec3::X * -0.003];
        let [a, _, b, _] = suture().course(Vec3::ZERO, leaves, Vec3::Z, false);
        assert!(a[0].distance(leaves[0]) < 1e-6 && a[POINTS - 1].distance(b[0]) < 1e-6);
        assert!(a.iter().chain(&b).all(|it| it.z.abs() < 1e-6));
        assert!(b[POINTS - 1].y > 0.2, "through the wall: {}", b[POINTS - 1]);
        // 10 mm nearer to the wall than it is long.
        let [a, _, b, _] = suture().course(Vec3::Y * 0.01, leaves, Vec3::Z, false);
        assert!(a[POINTS - 1].z < -0.01 && b[POINTS - 1].z.abs() < 1e-6);
    }

    #[test]
    fn a_cut_suture_hangs_at_both_ends_and_holds_nothing() {
        let leaves = [Vec3::ZERO; 2];
        let halves = suture().course(Vec3::ZERO, leaves, Vec3::Z, true);
        let ends = halves.map(|it| it[POINTS - 1]);
        assert!(ends.iter().all(|it| it.z < -0.01), "{ends:?}");
        assert!(ends[0].distance(ends[2]) > 0.05);
        assert!(halves.as_flattened().iter().all(|it| it.is_finite()));
    }
}
