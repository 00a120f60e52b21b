//! Triangles whose corners move with the spheres: their buffers, and the positions of the corners.

use glam::Vec3;

use super::gpu::Gpu;
use crate::skinning::motion::{Motion, moved};
use crate::skinning::{RestVertex, SkinnedVertex};

/// Buffers of triangles whose corners move with the spheres.
pub(super) struct Buffers {
    pub(super) now: wgpu::Buffer,
    pub(super) rest: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) count: u32,
}

impl Buffers {
    /// Buffers for this many corners and indices, none in use yet.
    pub(super) fn new(gpu: &Gpu, label: &str, corners: usize, indices: usize) -> Self {
        use wgpu::BufferUsages as Usage;
        let buffer = |size: usize, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: usage | Usage::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            now: buffer(corners * size_of::<SkinnedVertex>(), Usage::VERTEX),
            rest: buffer(corners * size_of::<RestVertex>(), Usage::VERTEX),
            indices: buffer(indices * size_of::<u32>(), Usage::INDEX),
            count: 0,
        }
    }
}

/// Present position of a corner that moves with its spheres.
pub(super) fn carried(corner: &RestVertex, motions: &[Motion]) -> Vec3 {
    let home = Vec3::from(corner.position);
    let mut at = home;
    for (pair, weights) in corner.spheres.iter().zip(&corner.weights) {
        for shift in [0, 16] {
            let weight = (weights >> shift & 0xffff) as f32 / 65_535.0;
            if let Some(motion) = motions.get((pair >> shift & 0xffff) as usize) {
                at += (moved(motion, home) - home) * weight;
            }
        }
    }
    at
}
