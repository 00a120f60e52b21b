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
//! Skin whose proteins heat has denatured takes on the look of cooked tissue (`heated`).
//!
//! Effects begin with a plain list of `Effect`s. Smoke, steam, sparks and drops are particles.
//! Blood and bile flow over the skin (`effects::fluid`); the shader reads the thickness of their
//! films from a grid in the tissue at rest (`film`). Stains of char are places in the tissue at
//! rest, too. Smoke that has spread is one number, a haze over the whole cavity. It settles slowly,
//! or is evacuated. Char, blood and bile stay on the instrument (`wear`) until it is exchanged. The
//! controller reports leaks. Torn or cut tissue, except fat and connective tissue, also bleeds or
//! leaks bile for some seconds. A reset or a new controller clears everything.
//!
//! The graphics device times each pass (`timing`), and `governor` chooses the quality from these
//! times. The quality falls after 40 frames that cost too much. It rises only after many cheap
//! frames, and each rise that was wrong doubles their number. If the device has no clock, or is the
//! processor itself, the time from frame to frame decides. On the processor, only those triangles
//! of the skin are drawn that the picture can show (`visible`). With one sample a pixel, the lens
//! smooths edges. If the graphics device is lost, it is reopened in a new window, and the run goes
//! on.
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
mod film;
mod frame;
pub mod governor;
pub mod gpu;
mod heated;
mod hexahedron;
pub mod inside;
mod instrument;
mod joints;
pub mod layout;
pub mod lens;
mod look;
mod materials;
mod noise;
mod particles;
mod passes;
mod pipeline;
mod prepare;
mod quality;
mod read_back;
mod resource;
mod settings;
mod solid;
mod stones;
mod strands;
pub(crate) mod sutures;
mod targets;
pub mod timing;
mod trees;
mod visible;

use std::ops::Range;

use glam::{Mat4, Vec3};
use shared_mem::message::{MAX_CLIPPED, SphereState};
use shared_mem::scene::{OrganRecord, SceneFile, SphereRecord};

use self::camera::{Exposure, Scope};
use self::inside::Inside;
use self::lens::Lens;
use self::materials::{Drawable, Materials};
use self::pipeline::{Layouts, Pipelines};
pub use self::quality::Quality;
use self::sutures::Sutures;
use self::targets::Targets;
use self::timing::{PassTimes, Timing};
use self::visible::Visible;
use crate::effects::{Effect, Effects, Skin};
use crate::skinning::gpu::GpuSkinning;
use crate::skinning::motion::Motions;
use crate::skinning::parts::Pieces;
use crate::skinning::{SkinMesh, SkinnedVertex};

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
    heated: heated::Heated,
    sutures: Sutures,
    motions: Motions,
    pieces: Pieces,
    effects: Effects,
    discs: particles::Discs,
    films: film::Films,
    stains: wgpu::Buffer,
    lens: Lens,
    eye: Vec3,
    timing: Timing,
    skinned: Vec<SkinnedVertex>,
    visible: Visible,
    layouts: Layouts,
    pipelines: Pipelines,
    /// The instruments, the trocar, and the clips.
    instruments: [Drawable; 7],
    clips: [Mat4; MAX_CLIPPED],
    stone_shapes: Drawable,
    stones: stones::Stones,
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
const TROCAR: usize = 5;
/// Index of the clips among the instruments.
const CLIPS: usize = 6;

/// The skins of a scene's organs as they are drawn, with the collars where ducts and vessels join
/// organs.
#[must_use]
pub fn organs(scene: &SceneFile) -> SkinMesh {
    let mut mesh = SkinMesh::from_scene(scene);
    joints::add(&mut mesh, scene);
    mesh
}

impl Renderer {
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
}
