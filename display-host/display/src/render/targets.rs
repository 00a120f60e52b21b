//! The textures that a frame is drawn into, and the bind groups that read them: everything that
//! depends on the picture's size.

use super::gpu::Gpu;
use super::pipeline::{DEPTH, LIGHT, Layouts, PICTURE};
use super::quality::Quality;
use super::resource::{bind, target};

/// Textures and bind groups of one size.
pub(super) struct Targets {
    pub(super) light: wgpu::TextureView,
    /// Light with several samples per pixel, to be resolved into `light`.
    pub(super) sampled_light: Option<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
    pub(super) glare: [wgpu::TextureView; 3],
    pub(super) picture: wgpu::Texture,
    pub(super) picture_view: wgpu::TextureView,
    pub(super) exposure_group: wgpu::BindGroup,
    pub(super) glare_groups: [wgpu::BindGroup; 3],
    pub(super) lens_group: wgpu::BindGroup,
}

impl Targets {
    pub(super) fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        frame: &wgpu::Buffer,
        exposure: &wgpu::Buffer,
        filter: &wgpu::Sampler,
        quality: &Quality,
    ) -> Self {
        let (device, size) = (&gpu.device, quality.light_size());
        let samples = quality.samples;
        let view = |texture: wgpu::Texture| texture.create_view(&Default::default());
        let light = view(target(device, "light", size, LIGHT, 1));
        let glare = [2, 4, 8].map(|part| {
            let small = size.map(|s| (s / part).max(1));
            view(target(device, "glare", small, LIGHT, 1))
        });
        let picture = target(device, "picture", quality.size, PICTURE, 1);
        let picture_view = picture.create_view(&Default::default());
        let texture = wgpu::BindingResource::TextureView;
        let sampler = || wgpu::BindingResource::Sampler(filter);
        Self {
            exposure_group: bind(
                device,
                &layouts.exposure,
                &[
                    frame.as_entire_binding(),
                    texture(&light),
                    exposure.as_entire_binding(),
                ],
            ),
            glare_groups: [&light, &glare[0], &glare[1]].map(|source| {
                bind(
                    device,
                    &layouts.bloom,
                    &[texture(source), sampler(), exposure.as_entire_binding()],
                )
            }),
            lens_group: bind(
                device,
                &layouts.lens,
                &[
                    frame.as_entire_binding(),
                    texture(&light),
                    texture(&glare[2]),
                    sampler(),
                    exposure.as_entire_binding(),
                ],
            ),
            depth: view(target(device, "depth", size, DEPTH, samples)),
            sampled_light: (samples > 1)
                .then(|| view(target(device, "sampled light", size, LIGHT, samples))),
            light,
            glare,
            picture,
            picture_view,
        }
    }
}
