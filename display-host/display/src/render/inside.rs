//! View of the model: spheres, and links drawn as springs, inside translucent skins. The display
//! uses it, and so do the pictures of a prepared scene.

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::{Mat3, Quat, Vec3};
use shared_mem::message::{PoseMsg, SphereState, StateFrame, ToolFrame};
use shared_mem::scene::{SceneFile, SphereRecord};
use wgpu::util::DeviceExt;

use super::gpu::Gpu;
use super::pipeline::{InsidePipelines, Layouts};
use super::resource::bind;
use super::{Quality, Renderer};
use crate::DisplayError;

/// Number of vertices of a ball, as in `inside.wgsl`.
const BALL_VERTICES: u32 = 14 * 7 * 6;
/// Number of vertices of a spring, as in `inside.wgsl`.
const SPRING_VERTICES: u32 = 6;

/// Parts shown in the view of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inside {
    /// Radius of a ball, as a multiple of its sphere's radius.
    pub ball_scale: f32,
    /// Show the springs between the spheres.
    pub springs: bool,
    /// Show the cavity behind the organs.
    pub cavity: bool,
}

impl Inside {
    /// Parts for the view through the endoscope. The balls are small enough to show the springs
    /// between them.
    pub const VIEW: Self = Self {
        ball_scale: 0.35,
        springs: true,
        cavity: true,
    };
}

/// `Ball` in `inside.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Ball {
    at: [f32; 4],
    colour: [f32; 4],
}

/// Buffers and pipelines of the view of the model.
pub(super) struct Model {
    balls: wgpu::Buffer,
    group: wgpu::BindGroup,
    pipelines: InsidePipelines,
    rest: Vec<SphereRecord>,
    springs: u32,
}

impl Model {
    pub(super) fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        quality: &Quality,
        rest: &[SphereRecord],
        springs: &[[u32; 2]],
    ) -> Self {
        let buffer = |label, contents: &[u8], usage| {
            gpu.device
                .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some(label),
                    contents,
                    usage: usage | wgpu::BufferUsages::STORAGE,
                })
        };
        let none = vec![Ball::zeroed(); rest.len().max(1)];
        let balls = buffer("balls", cast_slice(&none), wgpu::BufferUsages::COPY_DST);
        // A binding must not be empty.
        let drawn = springs.len() as u32;
        let springs = if springs.is_empty() {
            &[[0; 2]]
        } else {
            springs
        };
        let springs = buffer("springs", cast_slice(springs), wgpu::BufferUsages::empty());
        let group = bind(
            &gpu.device,
            &layouts.inside,
            &[balls.as_entire_binding(), springs.as_entire_binding()],
        );
        Self {
            pipelines: InsidePipelines::new(&gpu.device, layouts, quality),
            balls,
            group,
            rest: rest.to_vec(),
            springs: drawn,
        }
    }

    /// Takes the spheres' positions.
    pub(super) fn upload(&self, gpu: &Gpu, spheres: &[SphereState], inside: &Inside) {
        let balls: Vec<Ball> = self
            .rest
            .iter()
            .enumerate()
            .map(|(i, rest)| {
                let now = spheres.get(i);
                let [x, y, z] = now.map_or(rest.center_m, |s| s.center_m);
                Ball {
                    at: [x, y, z, rest.radius_m * inside.ball_scale],
                    colour: colour(now.map_or(0, |s| s.bits), rest.held != 0),
                }
            })
            .collect();
        gpu.queue.write_buffer(&self.balls, 0, cast_slice(&balls));
    }

    /// Draws balls and springs. The scene's bindings must be set already.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, inside: &Inside) {
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_pipeline(&self.pipelines.balls);
        pass.draw(0..BALL_VERTICES, 0..self.rest.len() as u32);
        if inside.springs {
            pass.set_pipeline(&self.pipelines.springs);
            pass.draw(0..SPRING_VERTICES, 0..self.springs);
        }
    }

    /// Selects the pipeline that draws the skin as glass.
    pub(super) fn set_glass(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_pipeline(&self.pipelines.glass);
    }
}

/// Linear colour of a sphere, by the same states as its mark in the engineering view.
fn colour(bits: u32, held: bool) -> [f32; 4] {
    let has = |bit: u32| bits & bit != 0;
    if has(SphereState::GRASPED) {
        [1.0, 0.16, 0.51, 1.0]
    } else if has(SphereState::CONTACT) {
        [1.0, 0.35, 0.02, 1.0]
    } else if held {
        [0.9, 0.9, 0.9, 1.0]
    } else if has(SphereState::AWAKE) {
        [0.19, 0.46, 1.0, 1.0]
    } else {
        [0.32, 0.32, 0.32, 1.0]
    }
}

/// A front view of a prepared scene: on the left its spheres, on the right the links between them,
/// both inside translucent skins. Free spheres are blue, held spheres white.
///
/// # Errors
/// [`DisplayError`]: no graphics adapter, a scene too large for it, or a size out of range.
pub fn picture(
    scene: &SceneFile,
    [width, height]: [u32; 2],
) -> Result<image::RgbaImage, DisplayError> {
    let gpu = Gpu::open()?;
    let half = [width / 2, height];
    let quality = Quality {
        size: half,
        shadow_side: None,
        bloom: false,
        ..Quality::for_adapter(&gpu)
    };
    let mut renderer = Renderer::new(&gpu, scene, quality)?;
    renderer.exposure_mut().grain = 0.0;
    let scope = renderer.scope_mut();
    // The edge of the scope's circle lies outside the picture. The angle of view is small, which
    // avoids foreshortening.
    scope.circle = 4.0;
    scope.half_angle = 0.8;
    let sees = scope.half_angle / scope.circle;
    let tools = portrait(scene, sees, half[0] as f32 / half[1] as f32);
    let state = awake(scene);
    let spheres = state.spheres().unwrap_or(&[]);
    let mut picture = image::RgbaImage::new(half[0] * 2, height);
    for (k, (ball_scale, springs)) in [(1.0, false), (0.3, true)].into_iter().enumerate() {
        let inside = Inside {
            ball_scale,
            springs,
            cavity: false,
        };
        renderer.set_inside(&gpu, Some(inside));
        renderer.render(&gpu, spheres, &tools, 0.0);
        let side = renderer.read(&gpu)?;
        image::imageops::replace(&mut picture, &side, i64::from(half[0]) * k as i64, 0);
    }
    Ok(picture)
}

/// The scene at rest, all organs awake.
fn awake(scene: &SceneFile) -> Box<StateFrame> {
    let mut state = crate::headless::at_rest(scene);
    for sphere in &mut state.spheres {
        sphere.bits = SphereState::AWAKE;
    }
    state
}

/// Tools with a camera in front of the patient, slightly above and to the side, and no instrument.
/// `half_angle` (rad) is half of the picture's vertical angle of view. The camera is so far away
/// that all organs are in the picture.
fn portrait(scene: &SceneFile, half_angle: f32, aspect: f32) -> ToolFrame {
    let points = scene.vertices().iter().map(|v| Vec3::from(v.position_m));
    let (low, high) = points
        .clone()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
    let middle = if low.is_finite() {
        (low + high) / 2.0
    } else {
        Vec3::ZERO
    };
    let back = Vec3::new(0.25, 0.2, 1.0).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    // The camera is far enough away to show every point, with a margin.
    let room = half_angle.tan() * 0.92;
    let far = points
        .map(|p| {
            let d = p - middle;
            d.dot(back) + (d.dot(up).abs() / room).max(d.dot(right).abs() / (room * aspect))
        })
        .fold(0.01, f32::max);
    let away = PoseMsg {
        position_m: (middle + back * 1e2).to_array(),
        ..PoseMsg::IDENTITY
    };
    ToolFrame {
        world_from_camera: PoseMsg {
            position_m: (middle + back * far).to_array(),
            orientation: Quat::from_mat3(&Mat3::from_cols(right, up, back)).to_array(),
        },
        world_from_instrument: away,
        world_from_handle: away,
        ..Zeroable::zeroed()
    }
}
