//! The films of blood, bile and water as a texture. The red channel holds blood, the green one
//! bile, the blue one clotted blood and the last one water. When the fluid has changed, the block
//! that is or was wet is uploaded.

use glam::Vec3;

use super::gpu::Gpu;
use super::layout::Stains;
use crate::effects::fluid::{Block, Field, Fluids, SIZE, VOXEL_M};

/// Thickness of a film whose texel is 1, m. A thicker film looks equal, and rises no higher.
const THICKEST_M: f32 = 0.006;

/// The texture, and the block of it that is wet.
pub(super) struct Films {
    texture: wgpu::Texture,
    wet: Option<Block>,
    /// Number of the fluid's change that the texture shows.
    change: Option<u64>,
    texels: Vec<[u8; 4]>,
}

impl Films {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let [width, height, depth_or_array_layers] = SIZE.map(|n| n as u32);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("films"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Self {
            texture,
            wet: None,
            change: None,
            texels: Vec::new(),
        }
    }

    pub(super) fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&Default::default())
    }

    /// Uploads the films if they have changed. Texels that were wet before, and are no more, become
    /// dry.
    pub(super) fn upload(&mut self, gpu: &Gpu, fluids: &Fluids) {
        let change = Some(fluids.change());
        if core::mem::replace(&mut self.change, change) == change {
            return;
        }
        let wet = fluids.field().and_then(Field::wet);
        let block = match (wet, self.wet) {
            (Some(now), Some(before)) => core::array::from_fn(|k| {
                let ([a, b], [c, d]) = (now[k], before[k]);
                [a.min(c), b.max(d)]
            }),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => return,
        };
        self.wet = wet;
        self.texels.clear();
        let [xs, ys, zs] = block;
        for z in zs[0]..zs[1] {
            for y in ys[0]..ys[1] {
                let row = (xs[0]..xs[1]).map(|x| texel(fluids.field(), [x, y, z]));
                self.texels.extend(row);
            }
        }
        let [width, height, depth_or_array_layers] = block.map(|[from, to]| (to - from) as u32);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: xs[0] as u32,
                    y: ys[0] as u32,
                    z: zs[0] as u32,
                },
                aspect: wgpu::TextureAspect::All,
            },
            self.texels.as_flattened(),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers,
            },
        );
    }
}

fn texel(field: Option<&Field>, at: [usize; 3]) -> [u8; 4] {
    let film = field.map_or_else(Default::default, |field| field.at(at));
    // The square root gives thin films enough steps.
    let byte = |thick_m: f32| ((thick_m / THICKEST_M).sqrt() * 255.0 + 0.5) as u8;
    let [blood, bile, water] = film.thick_m.map(byte);
    [blood, bile, byte(film.clotted_m), water]
}

/// Tells the tissue's shader which box the texture covers, with lengths in cm.
pub(super) fn window(fluids: &Fluids, table: &mut Stains) {
    let Some(field) = fluids.field().filter(|it| it.wet().is_some()) else {
        return;
    };
    table.count[1] = 1;
    table.window = (field.low_m() * 100.0).extend(0.0).to_array();
    let size = Vec3::from(SIZE.map(|n| n as f32)) * (VOXEL_M * 100.0);
    table.up = fluids.up().extend(0.0).to_array();
    table.scale = size.recip().extend(THICKEST_M * 1000.0).to_array();
}
