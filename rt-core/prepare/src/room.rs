//! The room around the organs: ports, camera, devices, and the target of the scripted hand.
//!
//! The defaults suit a patient on her back, head a little up. The instrument enters at the
//! patient's left, towards her feet from the organs. The endoscope enters from the pelvis and looks
//! at the gallbladder.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use shared_mem::message::PoseMsg;
use shared_mem::scene::{OrganKind, RoomRecord, TrocarRecord, name_from_str};

use crate::Vec3;
use crate::error::PrepareError;
use crate::field::Nearest;
use crate::mesh::Mesh;
use crate::recipe::{Frame, OrganPlan, Recipe, TrocarPlan};

/// Lengths of the shaft outside of the body with which a hand can work, m.
const OUTSIDE_M: std::ops::RangeInclusive<f64> = 0.08..=0.20;
/// Least cosine between the camera's axis and the direction to the target. It keeps the target in
/// the picture.
const PICTURE_EDGE: f64 = 0.93;
/// Least thickness of the tissue under the target, m.
const TISSUE_M: f64 = 0.016;
/// Free space before the target, m.
const APPROACH_M: f64 = 0.03;
/// Wanted distance of the target from the point in the middle of the picture, m, if the recipe
/// names no place for the target.
const TARGET_OFFSET_M: f64 = 0.035;

/// If no vertex of the skin is suitable, points of the skin about this far apart are tried, m.
const SKIN_STEP_M: f64 = 0.008;
/// Largest number of such points along a side of one triangle.
const SKIN_STEPS_MAX: usize = 40;
/// Largest number of such points altogether.
const SKIN_POINTS_MAX: usize = 50_000;

/// Default instrument port relative to the point in the middle of the picture, m: to the left,
/// towards the feet, to the front.
const INSTRUMENT_PORT_FROM_VIEW: [f64; 3] = [0.095, -0.135, 0.115];
/// Default endoscope port relative to the point in the middle of the picture, m: mostly towards the
/// feet.
const ENDOSCOPE_PORT_FROM_VIEW: [f64; 3] = [0.035, -0.330, 0.030];
/// Default length of the instrument from handle to tip, m.
const INSTRUMENT_LENGTH_M: f64 = 0.33;
/// Default distance of the camera from the point in the middle of the picture, m.
const CAMERA_DISTANCE_M: f64 = 0.105;
/// Share of the way from the middle of the picture to the target. The camera turns to the point
/// there, so that the target is near the middle and its surroundings are in the picture.
const TOWARDS_TARGET: f64 = 0.55;
/// When the camera turns towards the target, its distance is multiplied by this factor.
const CLOSER: f64 = 0.95;

/// Gravity of a patient on her back, head 20° up, m/s².
#[must_use]
pub fn default_gravity() -> Vec3 {
    let tilt = 20f64.to_radians();
    Vec3::new(0.0, -libm::sin(tilt), -libm::cos(tilt)) * 9.81
}

/// The room as the recipe gives it. Missing values have defaults or follow from the organs' skins.
/// If the recipe names neither ports nor a place for the target, and no point of the target organ
/// is suitable, a warning comes with the room.
///
/// # Errors
/// When the recipe names a port or a place for the target, and no point of the target organ is
/// suitable. When the endoscope's port is the point in the middle of the picture.
pub fn place(
    recipe: &Recipe,
    skins: &[Mesh],
) -> Result<(RoomRecord, Option<String>), PrepareError> {
    let plan = &recipe.room;
    let organs: Vec<(&OrganPlan, &Mesh)> = recipe.organs.iter().zip(skins).collect();
    let gravity = plan.gravity_m_s2.unwrap_or_else(default_gravity);
    let target_organ = plan.target_organ.unwrap_or_else(|| {
        let liver = recipe
            .organs
            .iter()
            .position(|o| o.kind == OrganKind::Liver);
        liver.unwrap_or(0)
    });
    let look_at = plan.look_at_m.unwrap_or_else(|| middle_of_view(&organs));
    let endoscope_port = plan
        .endoscope_port_m
        .unwrap_or_else(|| look_at + Vec3::from(ENDOSCOPE_PORT_FROM_VIEW));
    let instrument_port = plan
        .instrument_port_m
        .unwrap_or_else(|| look_at + Vec3::from(INSTRUMENT_PORT_FROM_VIEW));
    let length = plan.instrument_length_m.unwrap_or(INSTRUMENT_LENGTH_M);

    let forward = (look_at - endoscope_port)
        .try_normalize(1e-6)
        .ok_or_else(|| {
            PrepareError::Room("room: endoscope_port_m and look_at_m are the same point".into())
        })?;
    let camera = look_at - forward * plan.camera_distance_m.unwrap_or(CAMERA_DISTANCE_M);
    let upright = -gravity.try_normalize(1e-6).unwrap_or(-Vec3::z());
    let up = plan.up.unwrap_or(upright);

    let sight = Sight {
        instrument_port,
        length,
        camera,
        forward,
    };
    let is_default = plan.instrument_port_m.is_none()
        && plan.endoscope_port_m.is_none()
        && plan.target_near_m.is_none();
    let found = find_target(
        &sight,
        &organs,
        target_organ,
        plan.target_near_m.unwrap_or(look_at),
        plan.target_near_m.is_some(),
    );
    let ((target, normal), warning) = match found {
        Ok(target) => (target, None),
        Err(reason) if is_default => {
            let target = sight.fairest(organs[target_organ].1, look_at);
            let target = target.ok_or_else(|| PrepareError::Room(reason.clone()))?;
            (
                target,
                Some(format!(
                    "{reason}; until then the scripted hand may miss it"
                )),
            )
        }
        Err(reason) => return Err(PrepareError::Room(reason)),
    };
    let (camera, forward) = aim(
        plan.look_at_m,
        look_at,
        target,
        endoscope_port,
        &organs,
        camera,
    );
    let device = match plan.device {
        Some(frame) => pose_of(&frame),
        None => {
            let inside = target - instrument_port;
            let handle = instrument_port - inside.normalize() * (length - inside.norm());
            pose(handle, facing(&forward, &upright))
        }
    };
    let tracker = match plan.tracker {
        Some(frame) => pose_of(&frame),
        None => pose(endoscope_port, facing(&forward, &upright)),
    };
    let point = |p: Vec3| p.map(|x| x as f32).into();
    let room = RoomRecord {
        name: name_from_str(&recipe.name),
        gravity_m_s2: point(gravity),
        world_from_device: device,
        world_from_tracker: tracker,
        instrument_port_m: point(instrument_port),
        instrument_length_m: length as f32,
        endoscope_port_m: point(endoscope_port),
        world_from_camera: pose(camera, looking(&forward, &up)),
        target_m: point(target),
        target_normal: point(normal),
        target_organ: target_organ as u32,
        breath_s: plan.breath_s.unwrap_or(0.0) as f32,
    };
    Ok((room, warning))
}

/// The trocar's record.
pub(crate) fn trocar(plan: &TrocarPlan) -> TrocarRecord {
    TrocarRecord {
        sliding_n: plan.sliding_n as f32,
        breakaway_n: plan.breakaway_n as f32,
        wall_nm_rad: plan.wall_nm_rad as f32,
    }
}

/// Place of the camera and direction of view, with the `target` near the middle of the picture. The
/// camera stays at `camera` if the recipe says where to look (`wish`), or if an organ would hide
/// the target.
fn aim(
    wish: Option<Vec3>,
    look_at: Vec3,
    target: Vec3,
    port: Vec3,
    organs: &[(&OrganPlan, &Mesh)],
    camera: Vec3,
) -> (Vec3, Vec3) {
    let before = (camera, (look_at - port).normalize());
    let at = look_at.lerp(&target, TOWARDS_TARGET);
    let Some(forward) = (at - port).try_normalize(1e-6).filter(|_| wish.is_none()) else {
        return before;
    };
    let eye = at - forward * ((look_at - camera).norm() * CLOSER);
    let from = target + (eye - target) * 0.05;
    let hidden = organs
        .iter()
        .filter_map(|(_, mesh)| Nearest::new(mesh))
        .any(|mesh| mesh.blocks(&from, &eye));
    if hidden { before } else { (eye, forward) }
}

fn middle_of_view(organs: &[(&OrganPlan, &Mesh)]) -> Vec3 {
    let gallbladder = organs
        .iter()
        .find(|(o, _)| o.kind == OrganKind::Gallbladder);
    let chosen = gallbladder.or(organs.first());
    chosen.map_or_else(Vec3::zeros, |(_, mesh)| {
        let [min, max] = mesh.bounds();
        (min + max) / 2.0
    })
}

/// Orientation of a frame that looks along `forward`: −z is forward, y is up.
fn looking(forward: &Vec3, up: &Vec3) -> UnitQuaternion<f64> {
    let right = forward.cross(up).try_normalize(1e-6).unwrap_or_else(|| {
        // Looking straight up or down: any right will do.
        forward.cross(&forward.yzx()).normalize()
    });
    let up = right.cross(forward);
    let axes = Matrix3::from_columns(&[right, up, -forward]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

/// Orientation of a frame that stands upright and faces the way the camera looks. In this frame, a
/// hand that moves to the right moves the instrument to the right in the picture.
fn facing(forward: &Vec3, upright: &Vec3) -> UnitQuaternion<f64> {
    let level = forward - upright * forward.dot(upright);
    looking(&level.try_normalize(1e-6).unwrap_or_else(Vec3::y), upright)
}

fn pose(position: Vec3, orientation: UnitQuaternion<f64>) -> PoseMsg {
    PoseMsg {
        position_m: position.map(|x| x as f32).into(),
        orientation: orientation.coords.map(|x| x as f32).into(),
    }
}

fn pose_of(frame: &Frame) -> PoseMsg {
    PoseMsg {
        position_m: frame.position_m.map(|x| x as f32).into(),
        orientation: frame.orientation.map(|x| x as f32),
    }
}

struct Sight {
    instrument_port: Vec3,
    length: f64,
    camera: Vec3,
    forward: Vec3,
}

impl Sight {
    /// Cosines between the skin's outward normal at a point and the directions to the instrument's
    /// port and to the camera. At 1 the instrument comes in steeply, and the camera sees the point
    /// squarely.
    fn faces(&self, point: &Vec3, normal: &Vec3) -> [f64; 2] {
        [self.instrument_port, self.camera].map(|from| -(point - from).normalize().dot(normal))
    }

    /// The vertex close to `near` that faces instrument and camera best, with its normal. The
    /// instrument may not reach this vertex, and the camera may not see it.
    fn fairest(&self, mesh: &Mesh, near: Vec3) -> Option<(Vec3, Vec3)> {
        let points = mesh.vertices.iter().copied().zip(mesh.vertex_normals());
        let rated = points.map(|(point, normal)| {
            let [steep, seen] = self.faces(&point, &normal);
            let off = (point - near).norm();
            (steep + 0.5 * seen - 20.0 * off, point, normal)
        });
        let sound = rated.filter(|(rating, ..)| rating.is_finite());
        let best = sound.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((best.1, best.2))
    }
}

/// The best point of the organ's skin for the scripted hand, with its normal. The instrument
/// reaches the point and comes in steeply, the camera sees the point, tissue lies behind it and
/// free space before it. If `exactly`, the point is wanted at `near`, else [`TARGET_OFFSET_M`] away
/// from `near`.
fn find_target(
    sight: &Sight,
    organs: &[(&OrganPlan, &Mesh)],
    target_organ: usize,
    near: Vec3,
    exactly: bool,
) -> Result<(Vec3, Vec3), String> {
    let (plan, mesh) = organs[target_organ];
    let inside: Vec<Nearest<'_>> = organs.iter().filter_map(|(_, m)| Nearest::new(m)).collect();
    let own = Nearest::new(mesh);
    let mut in_sight = 0;
    let mut best = |points: &[(Vec3, Vec3)]| {
        let mut candidates: Vec<(f64, usize)> = Vec::new();
        for (i, (p, n)) in points.iter().enumerate() {
            let shaft = p - sight.instrument_port;
            let view = p - sight.camera;
            let [steep, seen] = sight.faces(p, n);
            let centred = view.normalize().dot(&sight.forward);
            let reached = OUTSIDE_M.contains(&(sight.length - shaft.norm()));
            if reached && steep > 0.35 && seen > 0.2 && centred > PICTURE_EDGE {
                let wanted = if exactly { 0.0 } else { TARGET_OFFSET_M };
                let off = ((p - near).norm() - wanted).abs();
                candidates.push((steep + 0.5 * seen - 20.0 * off, i));
            }
        }
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        in_sight += candidates.len();
        candidates.iter().map(|&(_, i)| points[i]).find(|&(p, n)| {
            let before = p + n * 0.002;
            let start = p + n * APPROACH_M;
            let free = |from: &Vec3, to: &Vec3| !inside.iter().any(|m| m.blocks(from, to));
            let thick = own.as_ref().is_some_and(|own| {
                own.distance(&(p - n * (TISSUE_M / 2.0))) > 0.4 * TISSUE_M
                    && !own.blocks(&(p - n * 0.001), &(p - n * TISSUE_M))
            });
            thick
                && free(&before, &start)
                && free(&before, &sight.instrument_port)
                && free(&start, &sight.instrument_port)
                && free(&before, &sight.camera)
        })
    };
    let normals = mesh.vertex_normals();
    let vertices: Vec<(Vec3, Vec3)> = mesh.vertices.iter().copied().zip(normals).collect();
    let mut tried = vertices.len();
    let found = best(&vertices).or_else(|| {
        let between = between_vertices(mesh);
        tried += between.len();
        best(&between)
    });
    found.ok_or_else(|| {
        format!(
            "room: no point of '{}' can be reached and seen: from instrument_port_m {:.3?} the \
             shaft must keep {:.2} to {:.2} m of its {:.2} m outside and the camera at {:.3?} must see \
             it; {} of {} skin points lie in reach and in the picture; in a recipe's [room], \
             move the ports or give target.near_m",
            plan.name,
            sight.instrument_port.as_slice(),
            OUTSIDE_M.start(),
            OUTSIDE_M.end(),
            sight.length,
            sight.camera.as_slice(),
            in_sight,
            tried,
        )
    })
}

/// Points of the skin between its vertices, with their normals. A coarse mesh has few vertices.
fn between_vertices(mesh: &Mesh) -> Vec<(Vec3, Vec3)> {
    let mut points = Vec::new();
    for &t in &mesh.triangles {
        let [a, b, c] = mesh.corners(t);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
            continue;
        };
        let longest_m = [b - a, c - b, a - c].map(|side| side.norm());
        let longest_m = longest_m.into_iter().fold(0.0, f64::max);
        let steps = ((longest_m / SKIN_STEP_M) as usize).min(SKIN_STEPS_MAX);
        for i in 1..steps {
            for j in 1..steps - i {
                if points.len() == SKIN_POINTS_MAX {
                    return points;
                }
                let share = |k: usize| k as f64 / steps as f64;
                points.push((a + (b - a) * share(i) + (c - a) * share(j), normal));
            }
        }
    }
    points
}
