//! Rendering of a frame: skin, shadow, scene, exposure, glare, lens. The inputs are plain data: a
//! checked scene, a state and a tool frame.
//!
//! ```text
//! state ─ skinning ─► vertices ─► shadow map ─► light (f16) ─► exposure, glare ─► lens ─► picture
//!                                 tools ────────┘ (behind the scope's mask)
//! ```
//!
//! # The picture
//!
//! When a scene loads, the display adds what no recipe of a scene has: collars at the junctions of
//! ducts and vessels with organs (`joints`), vessel trees on gallbladder, stomach and intestine
//! (`trees`), ambient light, and the cavity.
//!
//! `world_from_camera` is the pose of the endoscope's shaft. The display itself decides how far an
//! angled endoscope looks off the shaft and where its camera is focused (`camera::Scope`). The
//! alpha of the light texture holds the distance of each pixel's surface in front of the camera.
//! From it `lens.wgsl` computes the blur. The direction of view is recorded
//! (`EntryContent::Sight`), because the assessment judges what the picture shows.
//!
//! Strands of connective tissue (`strands`) and sutures (`sutures`) are thin tubes (`fibre`) that
//! the shader widens to a pixel. Strands form a net along the sides of a gap, with films in the
//! net's forks. Fat has fewer strands. Faces of cells are drawn where the skin over them is hidden
//! (`cells`).
//!
//! Effects begin with a plain list of `Effect`s. Smoke, steam, sparks and drops are particles.
//! Stains lie on the skin and are stored by their place on the tissue at rest. Smoke that has
//! spread is one number, a haze over the whole cavity. It settles slowly, or is evacuated. Char,
//! blood and bile stay on the instrument (`wear`) until it is exchanged. The controller reports
//! leaks. Torn or cut tissue, except fat and connective tissue, also bleeds or leaks bile for some
//! seconds. A reset or a new controller clears everything.
//!
//! The graphics device times each pass (`timing`), and `governor` chooses the quality from these
//! times. The quality falls after 40 frames that cost too much. It rises only after many cheap
//! frames, and each rise that was wrong doubles their number. If the device has no clock, the time
//! from frame to frame decides. If the graphics device is lost, it is reopened in a new window, and
//! the run goes on.
//!
//! A press is drawn deeper than the spheres go (`skinning::dent`). Inner spheres are too coarse to
//! show the dent of a tip. The controller's contact law knows the rest of the depth and publishes
//! it.

mod ambient;
pub mod camera;
mod carried;
mod cavity;
mod cells;
mod clips;
pub mod cost;
mod fibre;
pub mod governor;
pub mod gpu;
mod hexahedron;
pub mod inside;
mod instrument;
mod joints;
pub mod layout;
pub mod lens;
mod look;
mod noise;
mod particles;
mod passes;
mod pipeline;
mod quality;
mod resource;
mod solid;
mod strands;
pub(crate) mod sutures;
mod targets;
pub mod timing;
mod trees;

use std::ops::Range;

use bytemuck::{Zeroable as _, bytes_of, cast_slice};
use glam::{Mat4, Vec3};
use shared_mem::message::{ClipMsg, MAX_CLIPPED, SphereState, SutureMsg, ToolFrame};
use shared_mem::scene::{OrganRecord, SceneFile, SphereRecord};
use shared_mem::words::Instrument;
use wgpu::util::DeviceExt;

use self::camera::{Exposure, Scope};
use self::gpu::Gpu;
use self::inside::Inside;
use self::lens::Lens;
use self::pipeline::{DEPTH, Layouts, Pipelines};
pub use self::quality::Quality;
use self::resource::{bind, cells_texture, noise_texture, sampler, target, volume};
use self::sutures::Sutures;
use self::targets::Targets;
use self::timing::{PassTimes, Timing};
use crate::DisplayError;
use crate::effects::{Effect, Effects, Skin};
use crate::skinning::gpu::GpuSkinning;
use crate::skinning::motion::{Follow, Motions};
use crate::skinning::parts::Pieces;
use crate::skinning::{SkinMesh, SkinnedVertex, Touch};

/// Draws a scene into a texture.
pub struct Renderer {
    quality: Quality,
    scope: Scope,
    exposure: Exposure,
    organs: Vec<OrganRecord>,
    rest: Vec<SphereRecord>,
    springs: Vec<[u32; 2]>,
    /// Number of indices of the organs' skins. The cavity's indices follow them.
    organ_corners: u32,
    /// Range of the indices of each organ's skin.
    organ_ranges: Vec<Range<u32>>,
    shown: Shown,
    inside: Option<Inside>,
    /// Made when first needed.
    inside_model: Option<inside::Model>,
    mesh: SkinMesh,
    skinning: GpuSkinning,
    cells: cells::Cells,
    sutures: Sutures,
    motions: Motions,
    pieces: Pieces,
    effects: Effects,
    discs: particles::Discs,
    stains: wgpu::Buffer,
    lens: Lens,
    eye: Vec3,
    timing: Timing,
    skinned: Vec<SkinnedVertex>,
    layouts: Layouts,
    pipelines: Pipelines,
    /// The instruments, the trocar, and the clips.
    instruments: [Drawable; 6],
    clips: [Mat4; MAX_CLIPPED],
    port: Vec3,
    frame: wgpu::Buffer,
    parts: wgpu::Buffer,
    exposure_value: wgpu::Buffer,
    filter: wgpu::Sampler,
    shadow: wgpu::TextureView,
    materials: Materials,
    scene_group: wgpu::BindGroup,
    parts_group: wgpu::BindGroup,
    frame_group: wgpu::BindGroup,
    targets: Targets,
    number: u32,
}

/// Selection of drawn tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shown {
    /// All tissue.
    #[default]
    Everything,
    /// One organ on black, by its index in the scene.
    Organ(usize),
}

/// Index of the trocar among the instruments.
const TROCAR: usize = 4;
/// Index of the clips among the instruments.
const CLIPS: usize = 5;

/// Textures and buffers of the scene's shaders, except the shadow map.
struct Materials {
    frame: wgpu::Buffer,
    looks: wgpu::Buffer,
    noise: wgpu::TextureView,
    cells: wgpu::TextureView,
    vessels: wgpu::TextureView,
    tree_slots: wgpu::Buffer,
    stains: wgpu::Buffer,
}

impl Materials {
    fn group(
        &self,
        device: &wgpu::Device,
        layouts: &Layouts,
        shadow: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        use wgpu::AddressMode::{ClampToEdge, Repeat};
        let nearer = Some(wgpu::CompareFunction::LessEqual);
        bind(
            device,
            &layouts.scene,
            &[
                self.frame.as_entire_binding(),
                self.looks.as_entire_binding(),
                wgpu::BindingResource::TextureView(&self.noise),
                wgpu::BindingResource::Sampler(&sampler(device, Repeat, None)),
                wgpu::BindingResource::TextureView(shadow),
                wgpu::BindingResource::Sampler(&sampler(device, ClampToEdge, nearer)),
                wgpu::BindingResource::TextureView(&self.cells),
                wgpu::BindingResource::TextureView(&self.vessels),
                self.tree_slots.as_entire_binding(),
                self.stains.as_entire_binding(),
            ],
        )
    }
}

fn shadow_map(device: &wgpu::Device, quality: &Quality) -> wgpu::TextureView {
    let side = quality.shadow_side.unwrap_or(1);
    target(device, "shadow", [side; 2], DEPTH, 1).create_view(&Default::default())
}

struct Drawable {
    vertices: wgpu::Buffer,
    corners: wgpu::Buffer,
    count: u32,
}

/// The skins of a scene's organs as they are drawn, with the collars where ducts and vessels join
/// organs.
#[must_use]
pub fn organs(scene: &SceneFile) -> SkinMesh {
    let mut mesh = SkinMesh::from_scene(scene);
    joints::add(&mut mesh, scene);
    mesh
}

impl Renderer {
    /// Prepares a scene for drawing: skin, cavity, ambient light, instruments, pipelines.
    ///
    /// # Errors
    /// [`DisplayError::TooLarge`], [`DisplayError::Size`], [`DisplayError::Device`].
    pub fn new(gpu: &Gpu, scene: &SceneFile, quality: Quality) -> Result<Self, DisplayError> {
        let [width, height] = quality.size;
        if !quality.size.iter().all(|s| (64..=8192).contains(s)) {
            return Err(DisplayError::Size { width, height });
        }
        let mut mesh = organs(scene);
        let trees = trees::grow(&mut mesh, scene);
        let organ_corners = mesh.triangles.len() as u32 * 3;
        let cavity = cavity::around(scene);
        mesh.add_fixed(&cavity.vertices, &cavity.triangles);
        ambient::bake(&mut mesh, scene.spheres());
        let skinning = GpuSkinning::new(gpu, &mesh, scene.spheres().len())?;

        let cells = cells::Cells::new(gpu, scene, &mesh.triangles);
        let sutures = Sutures::of(gpu, scene);

        let device = &gpu.device;
        use wgpu::BufferUsages as Usage;
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        let changing = Usage::UNIFORM | Usage::COPY_DST;
        let frame = buffer("frame", bytes_of(&layout::Frame::default()), changing);
        let parts = buffer(
            "parts",
            cast_slice(&[Mat4::IDENTITY; layout::PARTS]),
            changing,
        );
        let looks = buffer("looks", cast_slice(&look::table()), Usage::UNIFORM);
        let tree_slots = buffer("trees", cast_slice(&trees.slots), Usage::UNIFORM);
        let voxels = trees.texels.as_flattened();
        let vessels = volume(
            gpu,
            "trees",
            trees.size,
            wgpu::TextureFormat::Rg8Unorm,
            voxels,
        );
        let exposure_value = buffer(
            "exposure",
            cast_slice(&[1.0f32, 0.0, 0.0, 0.0]),
            Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC,
        );
        let instruments = instrument::all().map(|model| Drawable {
            vertices: buffer("instrument", cast_slice(&model.vertices), Usage::VERTEX),
            corners: buffer(
                "instrument triangles",
                cast_slice(model.triangles.as_flattened()),
                Usage::INDEX,
            ),
            count: model.triangles.len() as u32 * 3,
        });

        let stains = buffer("stains", bytes_of(&layout::Stains::zeroed()), changing);
        let layouts = Layouts::new(device);
        let pipelines = Pipelines::new(device, &layouts, &quality);
        let filter = sampler(device, wgpu::AddressMode::ClampToEdge, None);
        let shadow = shadow_map(device, &quality);
        let materials = Materials {
            frame: frame.clone(),
            looks,
            noise: noise_texture(gpu),
            cells: cells_texture(gpu),
            vessels,
            tree_slots,
            stains: stains.clone(),
        };
        let scene_group = materials.group(device, &layouts, &shadow);
        let targets = Targets::new(gpu, &layouts, &frame, &exposure_value, &filter, &quality);
        let renderer = Self {
            parts_group: bind(device, &layouts.parts, &[parts.as_entire_binding()]),
            frame_group: bind(device, &layouts.frame, &[frame.as_entire_binding()]),
            quality,
            scope: Scope::default(),
            exposure: Exposure::default(),
            rest: scene.spheres().to_vec(),
            organs: scene.organs().to_vec(),
            springs: scene.links().iter().map(|l| [l.a, l.b]).collect(),
            organ_corners,
            organ_ranges: scene
                .organs()
                .iter()
                .map(|organ| organ.triangles[0] * 3..(organ.triangles[0] + organ.triangles[1]) * 3)
                .collect(),
            shown: Shown::Everything,
            inside: None,
            inside_model: None,
            skinned: mesh.at_rest(),
            pieces: Pieces::of(scene, &mesh),
            mesh,
            skinning,
            cells,
            sutures,
            motions: Motions::new(scene, Follow::Deform),
            effects: Effects::new(-Vec3::from(scene.room().gravity_m_s2)),
            discs: particles::Discs::new(gpu, &layouts),
            stains,
            lens: Lens::default(),
            eye: Vec3::INFINITY,
            timing: Timing::new(gpu),
            layouts,
            pipelines,
            instruments,
            clips: [Mat4::ZERO; MAX_CLIPPED],
            port: Vec3::from(scene.room().instrument_port_m),
            frame,
            parts,
            exposure_value,
            filter,
            shadow,
            materials,
            scene_group,
            targets,
            number: 0,
        };
        gpu.check("preparing the scene")?;
        Ok(renderer)
    }

    /// Quality and size in use.
    #[must_use]
    pub fn quality(&self) -> &Quality {
        &self.quality
    }

    /// The endoscope's optics.
    #[must_use]
    pub fn scope(&self) -> &Scope {
        &self.scope
    }

    /// Mutable access to the endoscope's optics.
    pub fn scope_mut(&mut self) -> &mut Scope {
        &mut self.scope
    }

    /// Mutable access to the exposure.
    pub fn exposure_mut(&mut self) -> &mut Exposure {
        &mut self.exposure
    }

    /// Shows the model inside the organs from the next frame on. `None` hides it.
    pub fn set_inside(&mut self, gpu: &Gpu, inside: Option<Inside>) {
        self.inside = inside;
        if inside.is_some() && self.inside_model.is_none() {
            let (layouts, quality) = (&self.layouts, &self.quality);
            let model = inside::Model::new(gpu, layouts, quality, &self.rest, &self.springs);
            self.inside_model = Some(model);
        }
    }

    /// Selects the tissue drawn from the next frame on.
    pub fn show(&mut self, shown: Shown) {
        self.shown = shown;
    }

    /// Sets the states of the cells of layered tissue (`StateFrame::cells`) from the next frame on.
    pub fn set_cells(&mut self, gpu: &Gpu, states: &[u8]) {
        self.cells.set(gpu, states, &self.skinning.corners);
    }

    /// Number of the scene's cells.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }

    /// Indices of the drawn tissue.
    fn shown_corners(&self) -> Range<u32> {
        let all = 0..self.skinning.corner_count;
        match self.shown {
            Shown::Everything => all,
            Shown::Organ(number) => self.organ_ranges.get(number).cloned().unwrap_or(all),
        }
    }

    /// Moves the skin to these spheres, for effects played before the next frame.
    pub fn follow(&mut self, spheres: &[SphereState]) {
        self.motions.update(spheres);
    }

    /// Starts effects and advances all running ones by `seconds`; the next frame shows them.
    pub fn play(&mut self, spheres: &[SphereState], begin: &[Effect], seconds: f32) {
        let skin = Skin::new(&self.mesh, &self.rest, spheres, self.motions.now());
        for effect in begin {
            self.effects.begin(effect, &skin);
        }
        self.effects.advance(seconds, &skin);
        self.lens
            .advance(seconds, self.eye, self.effects.particles());
    }

    /// Starts or stops evacuating smoke through the instrument's trocar.
    pub fn draw_off_smoke(&mut self, is_on: bool) {
        self.effects.draw_off(is_on.then_some(self.port));
    }

    /// The front lens.
    #[must_use]
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Mutable access to the front lens.
    pub fn lens_mut(&mut self) -> &mut Lens {
        &mut self.lens
    }

    /// Takes the costs of the passes of the latest frame that the device has timed, ms
    /// ([`timing::PASSES`]). `None` if the device has no clock, or has timed no frame since the
    /// last call.
    pub fn take_pass_times(&mut self) -> Option<PassTimes> {
        self.timing.take()
    }

    /// Changes everything about the quality except the picture's size.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn set_quality(&mut self, gpu: &Gpu, quality: Quality) -> Result<(), DisplayError> {
        let size = self.quality.size;
        self.quality = Quality { size, ..quality };
        let device = &gpu.device;
        self.pipelines = Pipelines::new(device, &self.layouts, &self.quality);
        self.shadow = shadow_map(device, &self.quality);
        self.scene_group = self.materials.group(device, &self.layouts, &self.shadow);
        let (frame, exposure) = (&self.frame, &self.exposure_value);
        let (layouts, filter) = (&self.layouts, &self.filter);
        self.targets = Targets::new(gpu, layouts, frame, exposure, filter, &self.quality);
        self.inside_model = None;
        self.set_inside(gpu, self.inside);
        gpu.check("changing the quality")
    }

    /// The running effects.
    #[must_use]
    pub fn effects(&self) -> &Effects {
        &self.effects
    }

    /// Mutable access to the effects.
    pub fn effects_mut(&mut self) -> &mut Effects {
        &mut self.effects
    }

    /// The finished picture.
    #[must_use]
    pub fn picture(&self) -> &wgpu::TextureView {
        &self.targets.picture_view
    }

    /// Changes the picture's size; the last picture is lost.
    ///
    /// # Errors
    /// [`DisplayError::Size`], [`DisplayError::Device`].
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), DisplayError> {
        let [width, height] = size;
        if !size.iter().all(|s| (64..=8192).contains(s)) {
            return Err(DisplayError::Size { width, height });
        }
        let (frame, exposure) = (&self.frame, &self.exposure_value);
        self.quality.size = size;
        let (layouts, filter) = (&self.layouts, &self.filter);
        self.targets = Targets::new(gpu, layouts, frame, exposure, filter, &self.quality);
        gpu.check("resizing the picture")
    }

    /// Sets the sutures between organs and abdominal wall from the next frame on; `None`: the
    /// scene's own.
    pub fn set_sutures(&mut self, sutures: Option<&[SutureMsg]>) {
        self.sutures.set(sutures);
    }

    /// Sets the severed links of tubes (`StateFrame::parted`) from the next frame on.
    pub fn set_parted(&mut self, gpu: &Gpu, parted: impl Iterator<Item = bool>) {
        if self.pieces.set(parted, &mut self.mesh) {
            let severed: Vec<[u32; 2]> = self.pieces.severed().collect();
            self.motions.sever(&severed);
            self.skinning.replace(gpu, &self.mesh, &self.pieces);
        }
    }

    /// Sets the clips on the tubes for the next frame.
    pub fn set_clips(&mut self, clips: &[ClipMsg], spheres: &[SphereState]) {
        self.clips = clips::places(clips, spheres, &self.rest);
    }

    /// Skins, draws and submits a frame. `time_s` drives the animated textures.
    pub fn render(&mut self, gpu: &Gpu, spheres: &[SphereState], tools: &ToolFrame, time_s: f32) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.motions.update(spheres);
        let touch = Touch::of(&self.mesh, &self.organs, spheres, self.motions.now(), tools);
        self.skin(gpu, &mut encoder, &touch);
        self.cells.follow(gpu, self.motions.now());
        self.sutures.follow(gpu, spheres, self.motions.now());
        if let (Some(inside), Some(model)) = (&self.inside, &self.inside_model) {
            model.upload(gpu, spheres, inside);
        }
        let size = self.quality.size;
        let mut frame = camera::frame(
            tools,
            &self.scope,
            &self.exposure,
            size,
            time_s,
            self.number,
        );
        frame.film[1..].copy_from_slice(&[
            self.lens.fog,
            self.lens.soot,
            self.effects.haze_per_m(),
        ]);
        self.effects.hold(tools);
        let wear = self.effects.wear();
        frame.wear[..3].copy_from_slice(&[wear.charred, wear.bloody, wear.bilious]);
        gpu.queue.write_buffer(&self.frame, 0, bytes_of(&frame));
        self.eye = Vec3::from_slice(&frame.camera);
        self.discs.upload(gpu, self.effects.particles(), self.eye);
        gpu.queue
            .write_buffer(&self.stains, 0, bytes_of(&particles::stains(&self.effects)));
        let parts = instrument::parts(tools, self.port);
        gpu.queue.write_buffer(&self.parts, 0, cast_slice(&parts));
        let behind = (clips::FIRST_PART * size_of::<Mat4>()) as u64;
        gpu.queue
            .write_buffer(&self.parts, behind, cast_slice(&self.clips));
        // A tool frame of another version may name an unknown instrument: show the clip applier.
        let instrument = tools.instrument().unwrap_or(Instrument::ClipApplier) as usize;

        if self.quality.shadow_side.is_some() {
            self.draw_shadow(&mut encoder, instrument);
        }
        self.draw_scene(&mut encoder, instrument);
        self.develop(&mut encoder);
        self.timing.finish(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        self.timing.collect();
        self.number = self.number.wrapping_add(1);
    }

    /// Waits for the last frame and copies the distance of each pixel's surface before the camera,
    /// m, row by row from the upper left; 0 where nothing is.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn distances(&self, gpu: &Gpu) -> Result<Vec<f32>, DisplayError> {
        let texels = gpu.read_texture(self.targets.light.texture())?;
        let alpha = texels.chunks_exact(8).map(|texel| [texel[6], texel[7]]);
        Ok(alpha.map(|it| half(u16::from_le_bytes(it))).collect())
    }

    /// Waits for the last frame and copies it as RGBA.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn read(&self, gpu: &Gpu) -> Result<image::RgbaImage, DisplayError> {
        let [width, height] = self.quality.size;
        let pixels = gpu.read_texture(&self.targets.picture)?;
        image::RgbaImage::from_raw(width, height, pixels).ok_or(DisplayError::Device {
            doing: "reading a picture back",
            detail: "picture of the wrong size".into(),
        })
    }
}

/// A number of half precision.
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => fraction / 1024.0 * 2f32.powi(-14),
        31 => f32::INFINITY,
        _ => (1.0 + fraction / 1024.0) * 2f32.powi(exponent - 15),
    };
    if bits >> 15 == 0 { size } else { -size }
}
