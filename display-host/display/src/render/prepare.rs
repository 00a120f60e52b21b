//! Prepares a scene for drawing.

use bytemuck::{Zeroable as _, bytes_of, cast_slice};
use glam::{Mat4, Vec3};
use shared_mem::message::MAX_CLIPPED;
use shared_mem::scene::SceneFile;
use wgpu::util::DeviceExt;

use super::camera::{Exposure, Scope};
use super::gpu::Gpu;
use super::lens::Lens;
use super::materials::{Drawable, Materials, shadow_map};
use super::pipeline::{Layouts, Pipelines};
use super::quality::Quality;
use super::resource::{bind, cells_texture, noise_texture, sampler, volume};
use super::sutures::Sutures;
use super::targets::Targets;
use super::timing::Timing;
use super::visible::Visible;
use super::{
    Renderer, Shown, ambient, cavity, cells, film, heated, instrument, layout, look, organs,
    particles, stones, trees,
};
use crate::DisplayError;
use crate::effects::Effects;
use crate::skinning::gpu::GpuSkinning;
use crate::skinning::motion::{Follow, Motions};
use crate::skinning::parts::Pieces;

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
        let (shapes, triangles) = stones::all();
        let stone_shapes = Drawable {
            vertices: buffer("stones", cast_slice(&shapes), Usage::VERTEX),
            corners: buffer(
                "stones' triangles",
                cast_slice(triangles.as_flattened()),
                Usage::INDEX,
            ),
            count: triangles.len() as u32 * 3,
        };

        let stains = buffer("stains", bytes_of(&layout::Stains::zeroed()), changing);
        let films = film::Films::new(gpu);
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
            films: films.view(),
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
            visible: Visible::new(gpu, mesh.triangles.len()),
            pieces: Pieces::of(scene, &mesh),
            heated: heated::Heated::of(&mesh),
            mesh,
            skinning,
            cells,
            sutures,
            motions: Motions::new(scene, Follow::Deform),
            effects: Effects::new(-Vec3::from(scene.room().gravity_m_s2)),
            discs: particles::Discs::new(gpu, &layouts),
            films,
            stains,
            lens: Lens::default(),
            eye: Vec3::INFINITY,
            timing: Timing::new(gpu),
            layouts,
            pipelines,
            instruments,
            clips: [Mat4::ZERO; MAX_CLIPPED],
            stone_shapes,
            stones: stones::Stones::default(),
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
}
