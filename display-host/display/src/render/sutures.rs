//! Sutures that suspend an organ from the abdominal wall: doubled threads, from the organ's skin to
//! the wall. A taut suture is straight, a slack one sags, and the ends of a cut one hang down.

use bytemuck::{Zeroable, cast_slice};
use glam::Vec3;
use shared_mem::message::{SphereState, SutureMsg};
use shared_mem::scene::{AttachmentRecord, SceneFile, SphereRecord, VertexRecord, WORLD};

use super::carried::{Buffers, carried};
use super::fibre::{SIDES, triangles, tube};
use super::gpu::Gpu;
use super::look::INSULATION;
use crate::skinning::motion::Motion;
use crate::skinning::{RestVertex, SkinnedVertex, pairs};

/// Radius of a 3-0 thread, m.
const RADIUS_M: f32 = 0.000_12;
/// Distance between the points at which the two strands leave the organ, m.
const BITE_M: f32 = 0.006;
/// Depth below the skin at which a strand begins, m.
const UNDER_M: f32 = 0.000_6;
/// Length of a strand beyond its attachment point, m. The wall lies somewhere behind that point.
const BEYOND_M: f32 = 0.12;
/// Length of the tail at the organ and at the wall after a cut, m.
const TAIL_M: f32 = 0.014;
const NOWHERE_M: [f32; 3] = [10.0; 3];
/// Points along each half of a strand.
const POINTS: usize = 8;
/// Number of halves: two strands of two halves.
const HALVES: usize = 4;
const CORNERS: usize = HALVES * POINTS * SIDES;

/// Sutures that tie an organ to the world, as the scene gives them.
pub(crate) fn given(scene: &SceneFile) -> Vec<SutureMsg> {
    let is_suture = |tie: &&AttachmentRecord| tie.is_thread != 0 && tie.b == WORLD;
    let suture = |tie: &AttachmentRecord| SutureMsg {
        sphere: tie.a,
        placed: SutureMsg::HUNG,
        at_m: tie.anchor_m,
        length_m: tie.rest_length_m,
    };
    let all = scene.attachments().iter().filter(is_suture);
    all.map(suture).collect()
}

/// A suspended organ.
struct Organ {
    kind: u32,
    first_sphere: u32,
    spheres: Vec<SphereRecord>,
    skin: Vec<VertexRecord>,
}

impl Organ {
    fn of(scene: &SceneFile, sphere: u32) -> Option<Self> {
        let owns = |[first, count]: [u32; 2]| (first..first + count).contains(&sphere);
        let organ = scene.organs().iter().find(|it| owns(it.spheres))?;
        let range = |[first, count]: [u32; 2]| first as usize..(first + count) as usize;
        Some(Self {
            kind: organ.kind,
            first_sphere: organ.spheres[0],
            spheres: scene.spheres().get(range(organ.spheres))?.to_vec(),
            skin: scene.vertices().get(range(organ.vertices))?.to_vec(),
        })
    }

    /// Points at which the two strands leave the skin. `None` if the organ has no skin, or the
    /// suture's sphere belongs to another organ.
    fn leaves(&self, suture: &SutureMsg) -> Option<[RestVertex; 2]> {
        let own = suture.sphere.checked_sub(self.first_sphere)?;
        let sphere = self.spheres.get(own as usize)?;
        let center = Vec3::from(sphere.center_m);
        let out = (Vec3::from(suture.at_m) - center).normalize_or(Vec3::Y);
        let aside = out.any_orthonormal_vector() * (0.5 * BITE_M);
        let leaves = |side: Vec3| {
            let at = center + out * sphere.radius_m + side;
            let far = |v: &&VertexRecord| Vec3::from(v.position_m).distance_squared(at);
            let nearest = (self.skin.iter()).min_by(|a, b| far(a).total_cmp(&far(b)))?;
            let under = Vec3::from(nearest.position_m) - Vec3::from(nearest.normal) * UNDER_M;
            Some(RestVertex {
                position: under.to_array(),
                look: self.kind,
                normal: nearest.normal,
                ambient: 1.0,
                spheres: pairs(nearest.spheres),
                weights: pairs(nearest.weights),
            })
        };
        Some([leaves(aside)?, leaves(-aside)?])
    }
}

struct Suture {
    organ: Organ,
    given: SutureMsg,
    now: SutureMsg,
    leaves: [RestVertex; 2],
}

/// A scene's sutures that tie an organ to the world.
pub(super) struct Sutures {
    /// `None` for a suture without a visible organ.
    sutures: Vec<Option<Suture>>,
    up: Vec3,
    now: Vec<SkinnedVertex>,
    pub(super) buffers: Option<Buffers>,
}

impl Sutures {
    pub(super) fn of(gpu: &Gpu, scene: &SceneFile) -> Self {
        let sutures: Vec<Option<Suture>> = (given(scene).into_iter())
            .map(|given| Suture::of(Organ::of(scene, given.sphere)?, given))
            .collect();
        let mut rest: Vec<RestVertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        for suture in sutures.iter().flatten() {
            for half in 0..HALVES {
                indices.extend(triangles(rest.len() as u32, POINTS));
                // A thread is part of no tissue. Its place at rest is so far away that no stain
                // reaches it.
                let painted = RestVertex {
                    position: NOWHERE_M,
                    look: INSULATION,
                    ambient: 0.8,
                    ..suture.leaves[half % 2]
                };
                rest.extend([painted; POINTS * SIDES]);
            }
        }
        let buffers = (!rest.is_empty()).then(|| {
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
            buffers,
        }
    }

    /// Sets the present sutures; `None`: the scene's own.
    pub(super) fn set(&mut self, present: Option<&[SutureMsg]>) {
        for (number, suture) in self.sutures.iter_mut().enumerate() {
            if let Some(suture) = suture {
                let now = present.and_then(|all| all.get(number));
                suture.set(*now.unwrap_or(&suture.given));
            }
        }
    }

    /// Moves the sutures with the tissue that they hold.
    pub(super) fn follow(&mut self, gpu: &Gpu, spheres: &[SphereState], motions: &[Motion]) {
        let Some(buffers) = &self.buffers else {
            return;
        };
        let all = self.sutures.iter().flatten();
        for (suture, now) in all.zip(self.now.chunks_mut(CORNERS)) {
            let state = &suture.now;
            let center = spheres.get(state.sphere as usize);
            let center = center.map_or(Vec3::from(state.at_m), |it| it.center_m.into());
            let leaves = suture.leaves.map(|it| carried(&it, motions));
            let halves = course(state, center, leaves, self.up);
            for (path, now) in halves.iter().zip(now.chunks_mut(POINTS * SIDES)) {
                tube(path, RADIUS_M, now);
            }
        }
        gpu.queue
            .write_buffer(&buffers.now, 0, cast_slice(&self.now));
    }
}

impl Suture {
    fn of(organ: Organ, given: SutureMsg) -> Option<Self> {
        Some(Self {
            leaves: organ.leaves(&given)?,
            organ,
            given,
            now: given,
        })
    }

    fn set(&mut self, now: SutureMsg) {
        let course = |it: &SutureMsg| (it.placed, it.sphere, it.at_m.map(f32::to_bits));
        let (was, is) = (course(&self.now), course(&now));
        // While a tip leads the suture, its points in the skin stay. Otherwise they would jump.
        let is_led = now.placed == SutureMsg::AT_HAND && (was.0, was.1) == (is.0, is.1);
        if was != is && !is_led {
            self.leaves = self.organ.leaves(&now).unwrap_or(self.leaves);
        }
        self.now = now;
    }
}

/// Paths of the suture's strands: first the halves at the organ, then the halves at the wall.
fn course(
    suture: &SutureMsg,
    center: Vec3,
    leaves: [Vec3; 2],
    up: Vec3,
) -> [[Vec3; POINTS]; HALVES] {
    let (anchor, is_cut) = (Vec3::from(suture.at_m), suture.placed == SutureMsg::CUT);
    let way = anchor - center;
    let out = way.normalize_or(up);
    let wall = match suture.placed {
        SutureMsg::AT_HAND => anchor,
        _ => anchor + out * BEYOND_M,
    };
    let slack_m = match suture.placed {
        SutureMsg::HUNG => (suture.length_m - way.length()).max(0.0),
        _ => 0.0,
    };
    // A shallow parabola sags by this much if it is longer than its chord by the slack.
    let sag_m = (0.375 * way.length() * slack_m).sqrt();
    core::array::from_fn(|half| {
        let from = match suture.placed {
            SutureMsg::AWAY => Vec3::from(NOWHERE_M),
            _ => leaves[half % 2],
        };
        let is_at_wall = half >= 2;
        core::array::from_fn(|point| {
            let share = point as f32 / (POINTS - 1) as f32;
            if suture.placed == SutureMsg::AWAY {
                return from + up * (TAIL_M * share);
            }
            if is_cut {
                let tail_m = TAIL_M * share;
                return match is_at_wall {
                    // The tail first keeps the suture's direction and then turns down.
                    false => from + (out * (1.0 - share) - up * share) * tail_m,
                    true => wall.lerp(anchor, share) - up * (tail_m * share),
                };
            }
            let along = 0.5 * (share + f32::from(u8::from(is_at_wall)));
            from.lerp(wall, along) - up * (4.0 * sag_m * along * (1.0 - along))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suture(placed: u32) -> SutureMsg {
        SutureMsg {
            sphere: 0,
            placed,
            at_m: [0.0, 0.1, 0.0],
            length_m: 0.1,
        }
    }

    #[test]
    fn a_taut_suture_is_straight_and_a_slack_one_sags() {
        let leaves = [Vec3::X * 0.003, Vec3::X * -0.003];
        let hung = suture(SutureMsg::HUNG);
        let [a, _, b, _] = course(&hung, Vec3::ZERO, leaves, Vec3::Z);
        assert!(a[0].distance(leaves[0]) < 1e-6 && a[POINTS - 1].distance(b[0]) < 1e-6);
        assert!(a.iter().chain(&b).all(|it| it.z.abs() < 1e-6));
        assert!(b[POINTS - 1].y > 0.2, "through the wall: {}", b[POINTS - 1]);
        // The organ is nearer to the wall than the suture is long, by 10 mm.
        let [a, _, b, _] = course(&hung, Vec3::Y * 0.01, leaves, Vec3::Z);
        assert!(a[POINTS - 1].z < -0.01 && b[POINTS - 1].z.abs() < 1e-6);
    }

    #[test]
    fn a_led_suture_ends_at_the_tip_and_an_absent_one_is_out_of_sight() {
        let leaves = [Vec3::X * 0.003, Vec3::X * -0.003];
        let led = course(&suture(SutureMsg::AT_HAND), Vec3::ZERO, leaves, Vec3::Z);
        for half in &led[2..] {
            assert!(half[POINTS - 1].distance(Vec3::Y * 0.1) < 1e-6);
        }
        assert!(led[0][0].distance(leaves[0]) < 1e-6);
        let away = course(&suture(SutureMsg::AWAY), Vec3::ZERO, leaves, Vec3::Z);
        assert!(away.as_flattened().iter().all(|it| it.length() > 10.0));
    }

    #[test]
    fn a_cut_suture_hangs_at_both_ends_and_holds_nothing() {
        let leaves = [Vec3::ZERO; 2];
        let halves = course(&suture(SutureMsg::CUT), Vec3::ZERO, leaves, Vec3::Z);
        let ends = halves.map(|it| it[POINTS - 1]);
        assert!(ends.iter().all(|it| it.z < -0.01), "{ends:?}");
        assert!(ends[0].distance(ends[2]) > 0.05);
        assert!(halves.as_flattened().iter().all(|it| it.is_finite()));
    }
}
