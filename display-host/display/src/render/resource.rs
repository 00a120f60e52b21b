//! Shorthand for wgpu's descriptors: textures, samplers, groups, attachments.

use bytemuck::cast_slice;
use wgpu::util::DeviceExt;

use super::gpu::Gpu;
use super::noise;

pub(super) fn target(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: if samples > 1 {
            wgpu::TextureUsages::RENDER_ATTACHMENT
        } else {
            wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
        },
        view_formats: &[],
    })
}

pub(super) fn noise_texture(gpu: &Gpu) -> wgpu::TextureView {
    tile_texture(gpu, "noise", &noise::tile())
}

pub(super) fn cells_texture(gpu: &Gpu) -> wgpu::TextureView {
    tile_texture(gpu, "cells", &noise::cells_tile())
}

fn tile_texture(gpu: &Gpu, label: &str, voxels: &[[f32; 4]]) -> wgpu::TextureView {
    let voxels: Vec<u16> = voxels.as_flattened().iter().map(|&x| half(x)).collect();
    let size = [noise::SIDE as u32; 3];
    let format = wgpu::TextureFormat::Rgba16Float;
    volume(gpu, label, size, format, cast_slice(&voxels))
}

/// A texture in three dimensions, x fastest.
pub(super) fn volume(
    gpu: &Gpu,
    label: &str,
    [width, height, depth]: [u32; 3],
    format: wgpu::TextureFormat,
    voxels: &[u8],
) -> wgpu::TextureView {
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: depth,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        voxels,
    );
    texture.create_view(&Default::default())
}

/// Bits of a number of ordinary size in half precision. The number is rounded to the nearest one,
/// and a tiny number becomes zero.
fn half(x: f32) -> u16 {
    let bits = x.to_bits();
    let sign = (bits >> 16 & 0x8000) as u16;
    let magnitude = (bits & 0x7fff_ffff) + 0x1000;
    let exponent = (magnitude >> 23) as i32 - 112;
    match exponent {
        ..=0 => sign,
        1..=30 => sign | (exponent as u16) << 10 | (magnitude >> 13 & 0x3ff) as u16,
        _ => sign | 0x7bff,
    }
}

pub(super) fn sampler(
    device: &wgpu::Device,
    address: wgpu::AddressMode,
    compare: Option<wgpu::CompareFunction>,
) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        compare,
        ..Default::default()
    })
}

pub(super) fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding,
            resource: resource.clone(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

pub(super) fn colour(view: &wgpu::TextureView) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            // Alpha 0 marks an empty background, which is always in focus.
            load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            store: wgpu::StoreOp::Store,
        },
    })
}

pub(super) fn depth(
    view: &wgpu::TextureView,
    clear: f32,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(clear),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

#[cfg(test)]
mod tests {
    use super::half;

    #[test]
    fn half_precision_rounds_to_nearest() {
        for (x, bits) in [
            (0.0, 0),
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (0.333_333_34, 0x3555),
            (65504.0, 0x7bff),
            (1e9, 0x7bff),
            (1e-9, 0),
        ] {
            assert_eq!(half(x), bits, "{x}");
        }
    }
}
