//! Free view of a replay: the camera orbits a point in front of the endoscope.

use glam::{Mat4, Quat, Vec3};
use shared_mem::message::{PoseMsg, ToolFrame};

use crate::render::camera::matrix;
use crate::ui::FreeView;

/// Distance of the orbit's centre from the lens, m: the usual distance of tissue.
const AHEAD_M: f32 = 0.08;
/// Turn per point of pointer motion, rad.
const RAD_POINT: f32 = 0.006;
/// Relative change of the camera's distance per point of wheel motion.
const SHARE_POINT: f32 = 0.002;
/// Least and largest distance of the camera from the orbit's centre, m.
const DISTANCES_M: [f32; 2] = [0.02, 0.4];
/// Largest pitch, rad, so that the camera never passes over the top.
const PITCH_MAX_RAD: f32 = 1.5;

/// The free camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FreeCamera {
    /// Pose of the endoscope when the camera left it.
    from: PoseMsg,
    yaw: f32,
    pitch: f32,
    distance_m: f32,
}

impl FreeCamera {
    /// A free camera at the endoscope's present pose.
    pub(super) fn at(tools: &ToolFrame) -> Self {
        Self {
            from: tools.world_from_camera,
            yaw: 0.0,
            pitch: 0.0,
            distance_m: AHEAD_M,
        }
    }

    /// Moves the camera with pointer and wheel.
    pub(super) fn turn(&mut self, by: FreeView) {
        self.yaw = (self.yaw - f32::from(by.right) * RAD_POINT) % core::f32::consts::TAU;
        let pitch = self.pitch - f32::from(by.down) * RAD_POINT;
        self.pitch = pitch.clamp(-PITCH_MAX_RAD, PITCH_MAX_RAD);
        let distance_m = self.distance_m * (1.0 - f32::from(by.nearer) * SHARE_POINT).max(0.1);
        self.distance_m = distance_m.clamp(DISTANCES_M[0], DISTANCES_M[1]);
    }

    /// The tools with this camera in place of the endoscope's.
    pub(super) fn seen(&self, tools: &ToolFrame) -> ToolFrame {
        let turn = Quat::from_rotation_y(self.yaw) * Quat::from_rotation_x(self.pitch);
        let pivot = Mat4::from_translation(Vec3::new(0.0, 0.0, -AHEAD_M));
        let back = Mat4::from_translation(Vec3::new(0.0, 0.0, self.distance_m));
        let camera = matrix(&self.from) * pivot * Mat4::from_quat(turn) * back;
        let (_, rotation, at) = camera.to_scale_rotation_translation();
        ToolFrame {
            world_from_camera: PoseMsg {
                position_m: at.into(),
                orientation: rotation.normalize().into(),
            },
            ..*tools
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tools() -> ToolFrame {
        let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
        let turn = Quat::from_rotation_x(0.4) * Quat::from_rotation_z(0.2);
        tools.world_from_camera = PoseMsg {
            position_m: [0.1, -0.2, 0.05],
            orientation: turn.into(),
        };
        tools
    }

    fn looked_at(camera: &FreeCamera) -> Vec3 {
        let seen = matrix(&camera.seen(&tools()).world_from_camera);
        seen.transform_point3(Vec3::new(0.0, 0.0, -camera.distance_m))
    }

    #[test]
    fn free_view_begins_at_the_endoscope_and_goes_around_its_target() {
        let mut camera = FreeCamera::at(&tools());
        let start = looked_at(&camera);
        let seen = camera.seen(&tools()).world_from_camera;
        let apart = Vec3::from(seen.position_m) - Vec3::from(tools().world_from_camera.position_m);
        assert!(apart.length() < 1e-6, "{apart}");
        for (right, down, nearer) in [(100, 30, 0), (-500, 700, 90), (1, -2000, -2000)] {
            camera.turn(FreeView {
                right,
                down,
                nearer,
            });
            assert!(camera.seen(&tools()).world_from_camera.is_sane());
            assert!((looked_at(&camera) - start).length() < 1e-5);
            assert!((DISTANCES_M[0]..=DISTANCES_M[1]).contains(&camera.distance_m));
        }
    }
}
