//! The passes of a frame, in their order: skinning, shadow, scene, exposure, glare, lens.

use std::ops::Range;

use bytemuck::cast_slice;
use shared_mem::message::MAX_STONES;

use super::gpu::Gpu;
use super::resource::{colour, depth};
use super::{CLIPS, Drawable, Renderer, Shown, TROCAR};
use crate::skinning::Touch;

impl Renderer {
    pub(super) fn skin(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, touch: &Touch) {
        if self.quality.skin_on_cpu {
            self.mesh.skin(self.motions.now(), touch, &mut self.skinned);
            let moving = &self.skinned[..self.mesh.skinned];
            gpu.queue
                .write_buffer(&self.skinning.now, 0, cast_slice(moving));
        } else {
            self.skinning.upload(gpu, self.motions.now(), touch);
            self.skinning.encode(encoder, self.timing.compute(0));
        }
    }

    pub(super) fn draw_shadow(&mut self, encoder: &mut wgpu::CommandEncoder, instrument: usize) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(depth(&self.shadow, 1.0)),
            timestamp_writes: self.timing.render(1, true, true),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.frame_group, &[]);
        pass.set_pipeline(&self.pipelines.tissue_shadow);
        self.draw_tissue(&mut pass, false, self.shown_corners());
        self.draw_cells(&mut pass, false);
        pass.set_pipeline(&self.pipelines.rigid_shadow);
        pass.set_bind_group(1, &self.parts_group, &[]);
        self.instruments[instrument].draw(&mut pass);
        if self.shown == Shown::Everything {
            self.instruments[TROCAR].draw(&mut pass);
            self.instruments[CLIPS].draw(&mut pass);
            self.draw_stones(&mut pass);
        }
    }

    pub(super) fn draw_scene(&mut self, encoder: &mut wgpu::CommandEncoder, instrument: usize) {
        let light = match &self.targets.sampled_light {
            Some(sampled) => colour(sampled).map(|attachment| wgpu::RenderPassColorAttachment {
                resolve_target: Some(&self.targets.light),
                ..attachment
            }),
            None => colour(&self.targets.light),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[light],
            depth_stencil_attachment: Some(depth(&self.targets.depth, 0.0)),
            timestamp_writes: self.timing.render(2, true, true),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines.mask);
        pass.set_bind_group(0, &self.frame_group, &[]);
        pass.draw(0..3, 0..1);
        pass.set_bind_group(0, &self.scene_group, &[]);
        // The instruments come first, so that the tissue behind them is not shaded.
        pass.set_pipeline(&self.pipelines.rigid);
        pass.set_bind_group(1, &self.parts_group, &[]);
        self.instruments[instrument].draw(&mut pass);
        if self.shown == Shown::Everything {
            self.instruments[TROCAR].draw(&mut pass);
            self.instruments[CLIPS].draw(&mut pass);
            self.draw_stones(&mut pass);
        }
        let all = self.skinning.corner_count;
        let Some((inside, model)) = self.inside.as_ref().zip(self.inside_model.as_ref()) else {
            pass.set_pipeline(&self.pipelines.tissue);
            if self.chooses_triangles() {
                self.draw_visible(&mut pass);
            } else {
                self.draw_tissue(&mut pass, true, self.shown_corners());
            }
            self.draw_cells(&mut pass, true);
            self.discs.draw(&mut pass, &self.pipelines.effects);
            return;
        };
        model.draw(&mut pass, inside);
        if inside.cavity {
            pass.set_pipeline(&self.pipelines.tissue);
            self.draw_tissue(&mut pass, true, self.organ_corners..all);
        }
        // Glass comes last, so that it shows what is behind it.
        model.set_glass(&mut pass);
        self.draw_tissue(&mut pass, true, 0..self.organ_corners);
    }

    fn draw_stones(&self, pass: &mut wgpu::RenderPass<'_>) {
        let shapes = &self.stone_shapes;
        let each = shapes.count / MAX_STONES as u32;
        for number in self.stones.numbers().filter(|it| *it < MAX_STONES as u32) {
            pass.set_vertex_buffer(0, shapes.vertices.slice(..));
            pass.set_index_buffer(shapes.corners.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(number * each..(number + 1) * each, 0, 0..1);
        }
    }

    fn draw_tissue(&self, pass: &mut wgpu::RenderPass<'_>, with_rest: bool, corners: Range<u32>) {
        pass.set_vertex_buffer(0, self.skinning.now.slice(..));
        if with_rest {
            pass.set_vertex_buffer(1, self.skinning.rest.slice(..));
        }
        pass.set_index_buffer(self.skinning.corners.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(corners, 0, 0..1);
    }

    /// True if only those triangles of the skin are drawn that the picture can show.
    pub(super) fn chooses_triangles(&self) -> bool {
        let shows_skin = self.shown == Shown::Everything && self.inside.is_none();
        self.quality.skin_on_cpu && shows_skin
    }

    fn draw_visible(&self, pass: &mut wgpu::RenderPass<'_>) {
        let (corners, count) = self.visible.corners();
        pass.set_vertex_buffer(0, self.skinning.now.slice(..));
        pass.set_vertex_buffer(1, self.skinning.rest.slice(..));
        pass.set_index_buffer(corners.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..count, 0, 0..1);
    }

    fn draw_cells(&self, pass: &mut wgpu::RenderPass<'_>, with_rest: bool) {
        if self.shown != Shown::Everything {
            return;
        }
        let buffers = [
            &self.cells.buffers,
            &self.cells.strands.buffers,
            &self.sutures.buffers,
        ];
        for it in buffers.into_iter().flatten().filter(|it| it.count > 0) {
            pass.set_vertex_buffer(0, it.now.slice(..));
            if with_rest {
                pass.set_vertex_buffer(1, it.rest.slice(..));
            }
            pass.set_index_buffer(it.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..it.count, 0, 0..1);
        }
    }

    /// Records the passes of exposure, glare and lens.
    pub(super) fn develop(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let targets = &self.targets;
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("exposure"),
                timestamp_writes: self.timing.compute(3),
            });
            pass.set_pipeline(&self.pipelines.exposure);
            pass.set_bind_group(0, &targets.exposure_group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        if self.quality.bloom {
            for (k, view) in targets.glare.iter().enumerate() {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("glare"),
                    color_attachments: &[colour(view)],
                    timestamp_writes: self.timing.render(4, k == 0, k + 1 == targets.glare.len()),
                    ..Default::default()
                });
                pass.set_pipeline(&self.pipelines.glare[k.min(1)]);
                pass.set_bind_group(0, &targets.glare_groups[k], &[]);
                pass.draw(0..3, 0..1);
            }
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lens"),
            color_attachments: &[colour(&targets.picture_view)],
            timestamp_writes: self.timing.render(5, true, true),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines.lens);
        pass.set_bind_group(0, &targets.lens_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Drawable {
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.corners.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
    }
}
