//! The abdomen below the organs, in which stones that miss them come to rest: the lower half of an
//! ellipsoid around the organs and the eye.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, UnitQuaternion};
use shared_mem::message::PoseMsg;
use shared_mem::scene::{RoomRecord, SphereRecord, StonesRecord};

use crate::Vec3;
use crate::pack::Ball;
use crate::recipe::StonesPlan;

/// Radii to the right and to the back in half extents of the organs and the eye, and what is added
/// to them, m. They are those of the abdominal wall that displays draw.
const WIDER: f64 = 1.45;
const ADDED_M: [f64; 2] = [0.035, 0.02];
/// Depth below the middle in half extents, and what is added to it, m. No source: in a patient the
/// bowl lies as deep as the duodenum, and the instrument still reaches it
/// (`a_spilled_stone_is_picked_up` of the surgeon).
const DEEPER: f64 = 0.75;
const ADDED_BELOW_M: f64 = 0.01;

/// The stones' record, with the bowl under these organs.
pub(crate) fn stones(
    plan: &StonesPlan,
    room: &RoomRecord,
    organs: &[SphereRecord],
) -> StonesRecord {
    let up = -Vec3::from(room.gravity_m_s2.map(f64::from));
    let up = up.try_normalize(1e-6).unwrap_or_else(Vec3::y);
    let balls: Vec<Ball> = organs
        .iter()
        .map(|it| Ball {
            center: Vec3::from(it.center_m.map(f64::from)),
            radius_m: f64::from(it.radius_m),
        })
        .collect();
    let (world_from_bowl, bowl_radii_m) = bowl(&up, &isometry(&room.world_from_camera), &balls);
    StonesRecord {
        count: plan.count,
        diameter_m: plan.diameter_m as f32,
        room_m3: plan.room_m3 as f32,
        world_from_bowl,
        bowl_radii_m,
    }
}

/// Pose and radii, m, of the bowl under these balls.
fn bowl(up: &Vec3, camera: &Isometry3<f64>, balls: &[Ball]) -> (PoseMsg, [f32; 3]) {
    let look = camera.rotation * -Vec3::z();
    let level = up * up.dot(&look) - look;
    let back = level.try_normalize(1e-6).unwrap_or_else(|| across(up));
    let axes = [up.cross(&back), *up, back];
    let eye_m = camera.translation.vector;
    let extents = axes.map(|axis| {
        let eye = axis.dot(&eye_m);
        balls.iter().fold([eye; 2], |[low, high], ball| {
            let at = axis.dot(&ball.center);
            [low.min(at - ball.radius_m), high.max(at + ball.radius_m)]
        })
    });
    let middle = axes.iter().zip(&extents);
    let middle = middle.fold(Vec3::zeros(), |sum, (axis, [low, high])| {
        sum + axis * (0.5 * (low + high))
    });
    let [right, upward, backward] = extents.map(|[low, high]| 0.5 * (high - low));
    let radii_m = [
        WIDER * right + ADDED_M[0],
        DEEPER * upward + ADDED_BELOW_M,
        WIDER * backward + ADDED_M[1],
    ];
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&axes));
    let turn = UnitQuaternion::from_rotation_matrix(&turn);
    let pose = PoseMsg {
        position_m: middle.map(|x| x as f32).into(),
        orientation: turn.coords.map(|x| x as f32).into(),
    };
    (pose, radii_m.map(|x| x as f32))
}

fn isometry(pose: &PoseMsg) -> Isometry3<f64> {
    let [x, y, z, w] = pose.orientation.map(f64::from);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let at = Vec3::from(pose.position_m.map(f64::from));
    Isometry3::from_parts(at.into(), turn)
}

/// A unit vector across another one.
fn across(axis: &Vec3) -> Vec3 {
    axis.cross(&axis.yzx())
        .try_normalize(1e-6)
        .unwrap_or_else(Vec3::x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bowl_stands_upright_around_organs_and_eye() {
        let ball = |x, y, z| Ball {
            center: Vec3::new(x, y, z),
            radius_m: 0.01,
        };
        // Looks along +y: x is right, z is up.
        let turn = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
        let camera = Isometry3::from_parts(Vec3::new(0.0, -0.1, 0.02).into(), turn);
        let balls = [ball(-0.04, 0.0, -0.03), ball(0.06, 0.09, 0.05)];
        let (pose, radii_m) = bowl(&Vec3::z(), &camera, &balls);
        let found = isometry(&pose);
        for (got, want) in [
            (found.rotation * Vec3::x(), Vec3::x()),
            (found.rotation * Vec3::y(), Vec3::z()),
            (found.rotation * Vec3::z(), -Vec3::y()),
            (found.translation.vector, Vec3::new(0.01, 0.0, 0.01)),
        ] {
            assert!((got - want).norm() < 1e-6, "{got:?} {want:?}");
        }
        let want = [1.45 * 0.06 + 0.035, 0.75 * 0.05 + 0.01, 1.45 * 0.1 + 0.02];
        for (got, want) in radii_m.into_iter().zip(want) {
            assert!((f64::from(got) - want).abs() < 1e-6, "{radii_m:?}");
        }
    }
}
