//! Textures and buffers of the scene's shaders.

use super::pipeline::{DEPTH, Layouts};
use super::quality::Quality;
use super::resource::{bind, sampler, target};

/// Textures and buffers of the scene's shaders, except the shadow map.
pub(super) struct Materials {
    pub(super) frame: wgpu::Buffer,
    pub(super) looks: wgpu::Buffer,
    pub(super) noise: wgpu::TextureView,
    pub(super) cells: wgpu::TextureView,
    pub(super) vessels: wgpu::TextureView,
    pub(super) tree_slots: wgpu::Buffer,
    pub(super) stains: wgpu::Buffer,
    pub(super) films: wgpu::TextureView,
}

impl Materials {
    pub(super) fn group(
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
                wgpu::BindingResource::TextureView(&self.films),
            ],
        )
    }
}

pub(super) fn shadow_map(device: &wgpu::Device, quality: &Quality) -> wgpu::TextureView {
    let side = quality.shadow_side.unwrap_or(1);
    target(device, "shadow", [side; 2], DEPTH, 1).create_view(&Default::default())
}

pub(super) struct Drawable {
    pub(super) vertices: wgpu::Buffer,
    pub(super) corners: wgpu::Buffer,
    pub(super) count: u32,
}
