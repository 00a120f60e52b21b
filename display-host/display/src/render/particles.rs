//! Drawing of particles: one disc for each, far ones first.

use bytemuck::{Zeroable, cast_slice};
use glam::Vec3;
use wgpu::util::DeviceExt;

use super::film;
use super::gpu::Gpu;
use super::layout::{Disc, Stains};
use super::pipeline::Layouts;
use super::resource::bind;
use crate::effects::fluid::FALLING;
use crate::effects::{Effects, Kind, PARTICLES, Particle, STAINS};

/// Largest number of discs.
const DISCS: usize = PARTICLES + FALLING;

/// Buffer of the discs, and the number of discs that are drawn.
pub(super) struct Discs {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
    count: u32,
}

impl Discs {
    pub(super) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let none = vec![Disc::default(); DISCS];
        let buffer = gpu
            .device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("discs"),
                contents: cast_slice(&none),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            });
        let group = bind(&gpu.device, &layouts.effects, &[buffer.as_entire_binding()]);
        Self {
            buffer,
            group,
            count: 0,
        }
    }

    /// Uploads the particles and the drops, the farthest from `eye` first.
    pub(super) fn upload(&mut self, gpu: &Gpu, effects: &Effects, eye: Vec3) {
        let drops = effects.fluids().drops();
        let all = effects.particles().iter().copied().chain(drops);
        let mut far: Vec<Particle> = all.take(DISCS).collect();
        let distance = |p: &Particle| p.at_m.distance_squared(eye);
        far.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
        let discs: Vec<Disc> = far.iter().map(disc).collect();
        self.count = discs.len() as u32;
        if !discs.is_empty() {
            gpu.queue.write_buffer(&self.buffer, 0, cast_slice(&discs));
        }
    }

    /// Draws the discs. The scene's bindings must be set already.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline) {
        if self.count > 0 {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, &self.group, &[]);
            pass.draw(0..6, 0..self.count);
        }
    }
}

fn disc(p: &Particle) -> Disc {
    let life = p.life();
    let fade = (1.0 - life) * (life * 12.0).min(1.0);
    let (colour, hides, look) = match p.kind {
        Kind::Smoke => ([0.40, 0.395, 0.38], 0.13 * fade, 0.0),
        Kind::Steam => ([0.75, 0.76, 0.78], 0.12 * fade, 0.0),
        Kind::Sparks => ([9.0, 5.2, 1.8], 1.0, 2.0),
        Kind::Blood => ([0.085, 0.003, 0.0035], 0.97, 1.0),
        Kind::Bile => ([0.100, 0.066, 0.006], 0.85, 1.0),
        Kind::Char => ([0.01, 0.01, 0.01], 1.0, 1.0),
        Kind::Water => ([0.30, 0.31, 0.32], 0.35, 1.0),
        Kind::Suction => ([0.0; 3], 0.0, 1.0),
    };
    let [r, g, b] = colour;
    let speed = p.velocity_m_s.length();
    // A fast drop is a streak as long as its path in 8 ms; a fast spark, in 6 ms.
    let half_s = if look > 1.5 { 0.003 } else { 0.004 };
    let streak = if look > 0.5 {
        (speed * half_s / p.radius_m()).clamp(0.0, 14.0)
    } else {
        0.0
    };
    Disc {
        at: p.at_m.extend(p.radius_m()).to_array(),
        colour: [r, g, b, hides],
        look: [look, p.own, if streak > 1.0 { streak } else { 0.0 }, 0.0],
        along: p.velocity_m_s.normalize_or(Vec3::Y).extend(0.0).to_array(),
    }
}

/// Stains of char, and the box of the films' texture, in the layout of the tissue's shader. Lengths
/// are in cm.
pub(super) fn stains(effects: &Effects) -> Stains {
    let mut table = Stains::zeroed();
    for (slot, stain) in table
        .places
        .iter_mut()
        .zip(effects.stains().iter().take(STAINS))
    {
        *slot = (stain.rest_m * 100.0)
            .extend(stain.radius_m * 100.0)
            .to_array();
    }
    table.count[0] = effects.stains().len().min(STAINS) as u32;
    film::window(effects.fluids(), &mut table);
    table
}
