//! The paper's Algorithm 2 on a graphics card: one thread for each sphere loops over the cylinders.

use rt_core::tool::Capsule;

use super::methods::{Found, V3};

/// A graphics card with the kernel on it.
pub(crate) struct Card {
    /// Name of the card and of its driver.
    pub(crate) name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::ComputePipeline,
}

/// The spheres of an organ on a card.
pub(crate) struct Loaded {
    spheres: wgpu::Buffer,
    parts: wgpu::Buffer,
    depths: wgpu::Buffer,
    staging: wgpu::Buffer,
    bound: wgpu::BindGroup,
    count: u32,
}

const GROUP: u32 = 64;
/// Largest number of parts that fit into the buffer.
const PARTS: usize = 16;

const KERNEL: &str = "
struct Part { a: vec4f, b: vec4f }
@group(0) @binding(0) var<storage, read> spheres: array<vec4f>;
@group(0) @binding(1) var<storage, read> parts: array<Part>;
@group(0) @binding(2) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(64)
fn meet(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&spheres) { return; }
    let c = spheres[id.x].xyz;
    let r = spheres[id.x].w;
    var deepest = -1.0;
    for (var i = 0u; i < arrayLength(&parts); i++) {
        let p1 = parts[i].a.xyz;
        let p2 = parts[i].b.xyz;
        let r0 = parts[i].a.w;
        if r0 <= 0.0 { break; }
        let h = distance(p1, p2);
        let u = (p2 - p1) / h;
        let away = c - 0.5 * (p1 + p2);
        let x = abs(dot(u, away));
        let d = length(cross(u, away));
        // Algorithm 1 of the paper, as a depth.
        let beyond = x - 0.5 * h;
        var gap = length(vec2f(max(beyond, 0.0), max(d - r0, 0.0)));
        if beyond < 0.0 && d < r0 { gap = max(beyond, d - r0); }
        deepest = max(deepest, r - gap);
    }
    depths[id.x] = deepest;
}
";

impl Card {
    /// Opens the best card of this machine.
    ///
    /// # Errors
    /// When there is none. The error gives the reason in words.
    pub(crate) fn open() -> Result<Self, String> {
        let mut choice = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        if std::env::var_os("WGPU_BACKEND").is_none() {
            choice.backends = wgpu::Backends::PRIMARY;
        }
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let instance = wgpu::Instance::new(choice);
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|e| format!("no graphics card: {e}"))?;
        let info = adapter.get_info();
        let asked = wgpu::DeviceDescriptor {
            label: Some("collision"),
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&asked))
            .map_err(|e| format!("{}: {e}", info.name))?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("Algorithm 2"),
            source: wgpu::ShaderSource::Wgsl(KERNEL.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("Algorithm 2"),
            layout: None,
            module: &module,
            entry_point: Some("meet"),
            compilation_options: Default::default(),
            cache: None,
        });
        Ok(Self {
            name: format!("{}, {}", info.name, info.driver),
            device,
            queue,
            pipeline,
        })
    }

    /// Makes buffers on the card for this number of spheres.
    pub(crate) fn load(&self, spheres: &[(V3, f32)]) -> Loaded {
        let buffer = |label, size: u64, usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Use;
        let count = spheres.len() as u64;
        let loaded = [
            buffer("spheres", 16 * count, Use::STORAGE | Use::COPY_DST),
            buffer("parts", 32 * PARTS as u64, Use::STORAGE | Use::COPY_DST),
            buffer("depths", 4 * count, Use::STORAGE | Use::COPY_SRC),
        ];
        let entries: Vec<_> = (0..)
            .zip(&loaded)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let bound = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("Algorithm 2"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let [spheres_there, parts, depths] = loaded;
        Loaded {
            spheres: spheres_there,
            parts,
            depths,
            staging: buffer("read back", 4 * count, Use::COPY_DST | Use::MAP_READ),
            bound,
            count: count as u32,
        }
    }

    /// Runs one tick: sends spheres and parts, and reads every sphere's depth back.
    ///
    /// # Errors
    /// The driver's message.
    pub(crate) fn find(
        &self,
        to: &Loaded,
        spheres: &[(V3, f32)],
        parts: &[Capsule],
    ) -> Result<Found, String> {
        let up = bytes_of(spheres.iter().map(|(c, r)| [c.x, c.y, c.z, *r]));
        self.queue.write_buffer(&to.spheres, 0, &up);
        let ends = |p: &Capsule| [(p.a_m, p.radius_m), (p.b_m, 0.0)];
        let ends = parts.iter().take(PARTS).flat_map(ends);
        let mut up = bytes_of(ends.map(|(v, w)| [v.x, v.y, v.z, w]));
        up.resize(32 * PARTS, 0);
        self.queue.write_buffer(&to.parts, 0, &up);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &to.bound, &[]);
            pass.dispatch_workgroups(to.count.div_ceil(GROUP), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&to.depths, 0, &to.staging, 0, u64::from(to.count) * 4);
        self.queue.submit([encoder.finish()]);
        to.staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| e.to_string())?;
        let deepest = {
            let range = to.staging.slice(..).get_mapped_range();
            let range = range.map_err(|e| e.to_string())?;
            let depths = range.chunks_exact(4).filter_map(|b| b.try_into().ok());
            depths.map(f32::from_le_bytes).fold(-1.0, f32::max)
        };
        to.staging.unmap();
        Ok((deepest > 0.0).then_some(deepest))
    }
}

fn bytes_of(vectors: impl Iterator<Item = [f32; 4]>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(16 * vectors.size_hint().0);
    for number in vectors.flatten() {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes
}
