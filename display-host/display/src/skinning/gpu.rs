//! Skinning on the graphics device.

use bytemuck::{bytes_of, cast_slice};
use wgpu::util::DeviceExt;

use super::motion::Motion;
use super::parts::Pieces;
use super::{RestVertex, SkinMesh, Touch};
use crate::DisplayError;
use crate::render::gpu::Gpu;

/// The shader's source, for tests without a device.
pub const SHADER: &str = include_str!("skinning.wgsl");
const GROUP: u32 = 64;

/// Buffers of the skin, and the two pipelines that fill [`GpuSkinning::now`].
#[derive(Debug)]
pub struct GpuSkinning {
    /// Vertices at rest; also a vertex buffer.
    pub rest: wgpu::Buffer,
    /// Present vertices; also a vertex buffer.
    pub now: wgpu::Buffer,
    /// Triangles; also an index buffer.
    pub corners: wgpu::Buffer,
    /// Number of indices in `corners`.
    pub corner_count: u32,
    motions: wgpu::Buffer,
    touch: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    move_vertices: wgpu::ComputePipeline,
    gather_normals: wgpu::ComputePipeline,
    skinned: u32,
}

impl GpuSkinning {
    /// Uploads a skin for `spheres` spheres.
    ///
    /// # Errors
    /// [`DisplayError::TooLarge`] if the device cannot hold it.
    pub fn new(gpu: &Gpu, mesh: &SkinMesh, spheres: usize) -> Result<Self, DisplayError> {
        let device = &gpu.device;
        let limits = device.limits();
        let max = limits
            .max_storage_buffer_binding_size
            .min(u64::from(limits.max_compute_workgroups_per_dimension) * u64::from(GROUP) * 64);
        fits("skin vertices", mesh.vertices.len(), max / 64)?;
        fits("skin triangles", mesh.triangles.len(), max / 12)?;
        use wgpu::BufferUsages as Usage;
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        let counts = [mesh.skinned as u32, 0, 0, 0];
        let counts = buffer("skin counts", cast_slice(&counts), Usage::UNIFORM);
        let rest = buffer(
            "skin at rest",
            cast_slice(&mesh.vertices),
            Usage::STORAGE | Usage::VERTEX | Usage::COPY_DST,
        );
        let now = buffer(
            "skin now",
            cast_slice(&mesh.at_rest()),
            Usage::STORAGE | Usage::VERTEX | Usage::COPY_SRC | Usage::COPY_DST,
        );
        let corners = buffer(
            "skin triangles",
            cast_slice(mesh.triangles.as_flattened()),
            Usage::STORAGE | Usage::INDEX | Usage::COPY_DST,
        );
        let ring_first = buffer("ring first", cast_slice(&mesh.ring_first), Usage::STORAGE);
        let ring = buffer("ring", cast_slice(&mesh.ring), Usage::STORAGE);
        let ring_rest = buffer("ring at rest", cast_slice(&mesh.ring_rest), Usage::STORAGE);
        let motions = buffer(
            "sphere motions",
            cast_slice(&vec![Motion::default(); spheres.max(1)]),
            Usage::STORAGE | Usage::COPY_DST,
        );

        let touch = buffer(
            "touch",
            bytes_of(&Touch::default()),
            Usage::UNIFORM | Usage::COPY_DST,
        );

        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let write = wgpu::BufferBindingType::Storage { read_only: false };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("skinning"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform),
                entry(1, read),
                entry(2, read),
                entry(3, write),
                entry(4, read),
                entry(5, read),
                entry(6, read),
                entry(7, read),
                entry(8, wgpu::BufferBindingType::Uniform),
            ],
        });
        let bound = [
            &counts,
            &rest,
            &motions,
            &now,
            &ring_first,
            &ring,
            &ring_rest,
            &corners,
            &touch,
        ];
        let entries: Vec<_> = (0..)
            .zip(bound)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("skinning"),
            layout: &layout,
            entries: &entries,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("skinning"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("skinning"),
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        Ok(Self {
            move_vertices: pipeline("move_vertices"),
            gather_normals: pipeline("gather_normals"),
            bind_group,
            motions,
            touch,
            rest,
            now,
            corners,
            corner_count: mesh.triangles.len() as u32 * 3,
            skinned: mesh.skinned as u32,
        })
    }

    /// Takes the spheres' motions and the tools' touch for the next [`GpuSkinning::encode`].
    pub fn upload(&self, gpu: &Gpu, motions: &[Motion], touch: &Touch) {
        gpu.queue
            .write_buffer(&self.motions, 0, cast_slice(motions));
        gpu.queue.write_buffer(&self.touch, 0, bytes_of(touch));
    }

    /// Uploads the vertices and triangles of tubes, after [`Pieces::set`] has changed them in
    /// `mesh`.
    pub fn replace(&self, gpu: &Gpu, mesh: &SkinMesh, pieces: &Pieces) {
        for run in pieces.vertex_runs() {
            let at = run.start as u64 * size_of::<RestVertex>() as u64;
            (gpu.queue).write_buffer(&self.rest, at, cast_slice(&mesh.vertices[run]));
        }
        for run in pieces.triangle_runs() {
            let at = run.start as u64 * size_of::<[u32; 3]>() as u64;
            (gpu.queue).write_buffer(&self.corners, at, cast_slice(&mesh.triangles[run]));
        }
    }

    /// Records one pass, which moves the vertices and then gathers the normals. `stamps` receives
    /// the pass's start and end.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("skinning"),
            timestamp_writes: stamps,
        });
        pass.set_bind_group(0, &self.bind_group, &[]);
        for pipeline in [&self.move_vertices, &self.gather_normals] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(self.skinned.div_ceil(GROUP), 1, 1);
        }
    }
}

/// Returns an error if there is more of something than the device can hold.
fn fits(what: &'static str, found: usize, max: u64) -> Result<(), DisplayError> {
    let found = found as u64;
    if found > max {
        return Err(DisplayError::TooLarge { what, found, max });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skin_that_is_too_large_is_refused_with_its_limit() {
        fits("skin vertices", 100, 100).unwrap();
        let said = fits("skin vertices", 101, 100).unwrap_err().to_string();
        let words = "101 skin vertices, this graphics device allows 100; reduce the triangles";
        assert!(said.contains(words), "{said}");
    }
}
