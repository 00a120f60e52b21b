//! The endoscope: direction of view, and light.

use glam::camera::rh::{proj::directx as projection, view};
use glam::{Mat4, Quat, Vec2, Vec3};
use shared_mem::message::{PoseMsg, ToolFrame};

use super::layout::{Frame, SHADING_CAPSULES, SHADING_STONES};

/// Nearest and farthest focus distance of the camera, m.
const FOCUS_M: [f32; 2] = [0.015, 0.3];
/// Factor by which one step of the focus ring changes the focus distance.
const FOCUS_STEP: f32 = 1.25;

/// Optics of a rigid endoscope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scope {
    /// Half angle of the circular picture, rad.
    pub half_angle: f32,
    /// Angle between view and shaft, rad: 0°, 30° or 45° in practice.
    pub angle: f32,
    /// Turn of the light cable about the shaft, rad. The inclined view turns with the cable, and at
    /// 0 it is inclined downwards. The picture stays upright, because the camera is held.
    pub turned: f32,
    /// Radius of the circular picture, in half heights: halves of the rectangle's height.
    pub circle: f32,
    /// Focus distance of the camera, m.
    pub focus_m: f32,
    /// True for an eye in the room instead of an endoscope's camera: everything is sharp.
    pub is_free_eye: bool,
    /// Position of the light's exit beside the lens, in the frame of the view, m.
    pub light_offset: Vec3,
    /// Strength of the light: irradiance at 1 m, in arbitrary units, because exposure is automatic.
    pub light_strength: f32,
    /// Half angle of the light cone, rad.
    pub light_half_angle: f32,
    /// Nearest visible distance, m.
    pub near_m: f32,
    /// Range of the shadow map, m.
    pub shadow_range_m: f32,
}

impl Default for Scope {
    fn default() -> Self {
        Self {
            half_angle: 0.61,
            angle: 0.0,
            turned: 0.0,
            circle: 1.12,
            focus_m: 0.07,
            is_free_eye: false,
            light_offset: Vec3::new(0.0015, 0.0055, 0.0005),
            light_strength: 0.01,
            light_half_angle: 0.95,
            near_m: 0.002,
            shadow_range_m: 0.45,
        }
    }
}

impl Scope {
    /// Turns the focus ring by this many steps, farther if positive.
    pub fn turn_focus(&mut self, steps: i8) {
        let [nearest, farthest] = FOCUS_M;
        self.focus_m = (self.focus_m * FOCUS_STEP.powi(steps.into())).clamp(nearest, farthest);
    }

    /// Pose of the view, which looks along −z with y up. `world_from_camera` of the tools is the
    /// pose of the scope's shaft.
    #[must_use]
    pub fn world_from_view(&self, tools: &ToolFrame) -> Mat4 {
        let turn = Quat::from_rotation_z(self.turned);
        let tilt = turn * Quat::from_rotation_x(-self.angle) * turn.inverse();
        matrix(&tools.world_from_camera) * Mat4::from_quat(tilt)
    }

    /// Distance from the picture's middle, in half heights, at which a point appears. The point
    /// lies at this angle (rad) off the direction of view.
    #[must_use]
    pub fn on_picture(&self, angle: f32) -> f32 {
        angle / self.half_angle * self.circle
    }

    /// Direction in the frame of the view that belongs to a place in the picture. The place is
    /// given from the picture's middle, in half heights, y up. `None` outside the circle.
    #[must_use]
    pub fn direction(&self, at: Vec2) -> Option<Vec3> {
        let angle = at.length() / self.circle * self.half_angle;
        let off = at.normalize_or_zero() * angle.sin();
        (angle < self.half_angle).then(|| off.extend(-angle.cos()))
    }

    /// Place in the picture at which a point in the frame of the view (m) appears. The place is
    /// given from the picture's middle, in half heights, y up. `None` outside the circle.
    #[must_use]
    pub fn project(&self, at: Vec3) -> Option<Vec2> {
        let off = Vec2::new(at.x, at.y);
        let angle = off.length().atan2(-at.z);
        (angle < self.half_angle).then(|| off.normalize_or_zero() * self.on_picture(angle))
    }
}

/// Exposure of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Share of the way to the desired exposure that one frame goes. With 1, one frame reaches it.
    pub adapt: f32,
    /// Desired mean brightness.
    pub key: f32,
    /// Least and largest gain.
    pub range: [f32; 2],
    /// Noise of the camera's sensor, as a share of white.
    pub grain: f32,
}

impl Default for Exposure {
    fn default() -> Self {
        Self {
            adapt: 1.0,
            key: 0.092,
            range: [0.2, 60.0],
            grain: 0.010,
        }
    }
}

/// Matrix of a pose. An invalid rotation becomes the identity.
#[must_use]
pub fn matrix(pose: &PoseMsg) -> Mat4 {
    let turn = Quat::from_array(pose.orientation);
    let turn = if turn.length_squared() > 0.5 {
        turn.normalize()
    } else {
        Quat::IDENTITY
    };
    Mat4::from_rotation_translation(turn, Vec3::from(pose.position_m))
}

/// Pose of a camera at `eye` that looks at `at`, with the world's y towards the picture's top.
#[must_use]
pub fn looking(eye: Vec3, at: Vec3) -> PoseMsg {
    upright(eye, at, Vec3::Y)
}

/// Pose of a camera at `eye` that looks at `at`, with `up` towards the picture's top.
#[must_use]
pub fn upright(eye: Vec3, at: Vec3, up: Vec3) -> PoseMsg {
    let back = (eye - at).normalize_or(Vec3::Z);
    let up = if back.dot(up).abs() > 0.999 {
        up.any_orthonormal_vector()
    } else {
        up
    };
    let right = up.cross(back).normalize();
    let turn = Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back));
    PoseMsg {
        position_m: eye.to_array(),
        orientation: turn.normalize().to_array(),
    }
}

/// Uniform of a frame. Depth is reversed: 1 at the near plane, 0 at infinity.
#[must_use]
pub fn frame(
    tools: &ToolFrame,
    scope: &Scope,
    exposure: &Exposure,
    size: [u32; 2],
    time_s: f32,
    number: u32,
) -> Frame {
    let world_from_camera = scope.world_from_view(tools);
    let [width, height] = size.map(|s| s as f32);
    let aspect = width / height;
    // This is the tangent of the angle of view at the picture's top edge, which a circle of radius
    // 1 touches.
    let tangent = (scope.half_angle / scope.circle.max(1.0)).tan();
    let clip_from_camera =
        projection::perspective_infinite_reverse(2.0 * tangent.atan(), aspect, scope.near_m);
    let direction = |v: Vec3| world_from_camera.transform_vector3(v);
    let eye = world_from_camera.transform_point3(Vec3::ZERO);
    let forward = direction(Vec3::NEG_Z);
    let up = direction(Vec3::Y);
    let light = world_from_camera.transform_point3(scope.light_offset);
    let shadow_from_light = projection::perspective(
        2.0 * (scope.half_angle + 0.12),
        1.0,
        0.010,
        scope.shadow_range_m,
    );
    let light_from_world = view::look_to_mat4(light, forward, up);
    let mut capsules = [[0.0; 4]; 2 * SHADING_CAPSULES];
    let used = tools.capsules().unwrap_or(&[]);
    for (slot, capsule) in capsules.chunks_exact_mut(2).zip(used) {
        slot[0] = Vec3::from(capsule.a_m).extend(capsule.radius_m).to_array();
        slot[1] = Vec3::from(capsule.b_m).extend(0.0).to_array();
    }
    Frame {
        clip_from_world: (clip_from_camera * world_from_camera.inverse()).to_cols_array_2d(),
        shadow_from_world: (shadow_from_light * light_from_world).to_cols_array_2d(),
        camera: eye.extend(time_s).to_array(),
        forward: forward.extend(tangent).to_array(),
        up: up.extend(aspect).to_array(),
        light: light.extend(scope.light_strength).to_array(),
        light_axis: forward.extend(scope.light_half_angle.cos()).to_array(),
        scope: [scope.half_angle, scope.circle, width, height],
        adapt: [
            exposure.adapt,
            exposure.key,
            exposure.range[0],
            exposure.range[1],
        ],
        film: [exposure.grain, 0.0, 0.0, 0.0],
        wear: [
            0.0,
            0.0,
            0.0,
            if scope.is_free_eye {
                0.0
            } else {
                scope.focus_m
            },
        ],
        counts: [used.len().min(SHADING_CAPSULES) as u32, number, 1, 0],
        capsules,
        stones: [[0.0; 4]; SHADING_STONES],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_in_the_picture_comes_back_from_its_direction() {
        let scope = Scope::default();
        for at in [Vec2::ZERO, Vec2::new(0.3, -0.7), Vec2::new(-1.0, 0.2)] {
            let direction = scope.direction(at).expect("inside the circle");
            let back = scope.project(direction * 0.08).expect("in view");
            assert!(back.distance(at) < 1e-4, "{at} {back}");
        }
        assert_eq!(scope.direction(Vec2::new(1.2, 0.0)), None);
    }
}
