//! A frame: what it shows is uploaded, its passes are drawn and submitted.

use bytemuck::{bytes_of, cast_slice};
use glam::{Mat4, Vec3};
use shared_mem::message::{SphereState, ToolFrame};
use shared_mem::words::Instrument;

use super::gpu::Gpu;
use super::visible::View;
use super::{Renderer, camera, clips, instrument, particles, stones};
use crate::skinning::Touch;

impl Renderer {
    /// Skins, draws and submits a frame. `time_s` drives the animated textures.
    pub fn render(&mut self, gpu: &Gpu, spheres: &[SphereState], tools: &ToolFrame, time_s: f32) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.motions.update(spheres);
        let touch = Touch::of(&self.mesh, &self.organs, spheres, self.motions.now(), tools);
        (self.heated).follow(gpu, spheres, &mut self.mesh, &self.skinning.rest);
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
        frame.counts[2] = self.quality.part;
        (frame.stones, frame.counts[3]) = self.stones.shading(Vec3::from_slice(&frame.camera));
        gpu.queue.write_buffer(&self.frame, 0, bytes_of(&frame));
        if self.chooses_triangles() {
            let view = View {
                clip_from_world: Mat4::from_cols_array_2d(&frame.clip_from_world),
                size: self.quality.light_size(),
                samples: self.quality.samples,
                near_m: self.scope.near_m,
            };
            let (triangles, is_hidden) = (&self.mesh.triangles, &self.cells.is_hidden);
            (self.visible).choose(gpu, &view, &self.skinned, triangles, is_hidden);
        }
        self.eye = Vec3::from_slice(&frame.camera);
        self.discs.upload(gpu, &self.effects, self.eye);
        self.films.upload(gpu, self.effects.fluids());
        gpu.queue
            .write_buffer(&self.stains, 0, bytes_of(&particles::stains(&self.effects)));
        let parts = instrument::parts(tools, self.port);
        gpu.queue.write_buffer(&self.parts, 0, cast_slice(&parts));
        let behind = (clips::FIRST_PART * size_of::<Mat4>()) as u64;
        gpu.queue
            .write_buffer(&self.parts, behind, cast_slice(&self.clips));
        let behind = (stones::FIRST_PART * size_of::<Mat4>()) as u64;
        gpu.queue
            .write_buffer(&self.parts, behind, cast_slice(&self.stones.places()));
        // A tool frame of another version may name an unknown instrument. The picture then shows
        // the clip applier.
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
}
