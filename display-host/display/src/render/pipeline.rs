//! Pipelines of the passes, and their bindings.

use wgpu::{
    BindGroupLayout, BindingType, BufferBindingType, ComputePipeline, Device, RenderPipeline,
    SamplerBindingType, ShaderStages, TextureSampleType, TextureViewDimension, VertexFormat,
};

use super::layout::shader;
use super::quality::Quality;
use super::solid::RigidVertex;
use crate::skinning::{RestVertex, SkinnedVertex};

/// Format of the light before exposure.
pub(super) const LIGHT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Format of the depth. Depth is reversed (1 near, 0 far), except in the shadow map.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Format of the finished picture.
pub(super) const PICTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Bindings of each kind of pass.
pub(super) struct Layouts {
    pub(super) scene: BindGroupLayout,
    pub(super) parts: BindGroupLayout,
    pub(super) inside: BindGroupLayout,
    pub(super) effects: BindGroupLayout,
    pub(super) frame: BindGroupLayout,
    pub(super) exposure: BindGroupLayout,
    pub(super) bloom: BindGroupLayout,
    pub(super) lens: BindGroupLayout,
}

const UNIFORM: BindingType = BindingType::Buffer {
    ty: BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};
const READ: BindingType = BindingType::Buffer {
    ty: BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};
const WRITE: BindingType = BindingType::Buffer {
    ty: BufferBindingType::Storage { read_only: false },
    has_dynamic_offset: false,
    min_binding_size: None,
};
const FILTER: BindingType = BindingType::Sampler(SamplerBindingType::Filtering);

const fn texture(dimension: TextureViewDimension, sample_type: TextureSampleType) -> BindingType {
    BindingType::Texture {
        sample_type,
        view_dimension: dimension,
        multisampled: false,
    }
}

const COLOUR: TextureSampleType = TextureSampleType::Float { filterable: true };
const FLAT: BindingType = texture(TextureViewDimension::D2, COLOUR);

impl Layouts {
    pub(super) fn new(device: &Device) -> Self {
        let layout = |label, bindings: &[(BindingType, ShaderStages)]| {
            let entries: Vec<_> = (0..)
                .zip(bindings)
                .map(|(binding, &(ty, visibility))| wgpu::BindGroupLayoutEntry {
                    binding,
                    visibility,
                    ty,
                    count: None,
                })
                .collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        };
        let both = ShaderStages::VERTEX_FRAGMENT;
        let fragment = ShaderStages::FRAGMENT;
        let compute = ShaderStages::COMPUTE;
        Self {
            scene: layout(
                "scene",
                &[
                    (UNIFORM, both),
                    (UNIFORM, fragment),
                    (texture(TextureViewDimension::D3, COLOUR), fragment),
                    (FILTER, both),
                    (
                        texture(TextureViewDimension::D2, TextureSampleType::Depth),
                        fragment,
                    ),
                    (
                        BindingType::Sampler(SamplerBindingType::Comparison),
                        fragment,
                    ),
                    (texture(TextureViewDimension::D3, COLOUR), fragment),
                    (texture(TextureViewDimension::D3, COLOUR), fragment),
                    (UNIFORM, fragment),
                    (UNIFORM, both),
                    (texture(TextureViewDimension::D3, COLOUR), both),
                ],
            ),
            effects: layout("effects", &[(READ, both)]),
            parts: layout("parts", &[(UNIFORM, ShaderStages::VERTEX_FRAGMENT)]),
            inside: layout(
                "inside",
                &[(READ, ShaderStages::VERTEX), (READ, ShaderStages::VERTEX)],
            ),
            frame: layout("frame", &[(UNIFORM, both)]),
            exposure: layout(
                "exposure",
                &[(UNIFORM, compute), (FLAT, compute), (WRITE, compute)],
            ),
            bloom: layout(
                "bloom",
                &[(FLAT, fragment), (FILTER, fragment), (READ, fragment)],
            ),
            lens: layout(
                "lens",
                &[
                    (UNIFORM, both),
                    (FLAT, fragment),
                    (FLAT, fragment),
                    (FILTER, fragment),
                    (READ, fragment),
                ],
            ),
        }
    }
}

/// The pipelines of all passes except skinning.
pub(super) struct Pipelines {
    pub(super) tissue: RenderPipeline,
    pub(super) rigid: RenderPipeline,
    pub(super) effects: RenderPipeline,
    pub(super) tissue_shadow: RenderPipeline,
    pub(super) rigid_shadow: RenderPipeline,
    pub(super) mask: RenderPipeline,
    pub(super) exposure: ComputePipeline,
    pub(super) glare: [RenderPipeline; 2],
    pub(super) lens: RenderPipeline,
}

const SKINNED: [wgpu::VertexAttribute; 2] = [
    attribute(0, 0, VertexFormat::Float32x4),
    attribute(1, 16, VertexFormat::Float32x4),
];
const REST: [wgpu::VertexAttribute; 3] = [
    attribute(2, 0, VertexFormat::Float32x3),
    attribute(3, 12, VertexFormat::Uint32),
    attribute(5, 28, VertexFormat::Float32),
];
const RIGID: [wgpu::VertexAttribute; 4] = [
    attribute(0, 0, VertexFormat::Float32x3),
    attribute(1, 12, VertexFormat::Uint32),
    attribute(2, 16, VertexFormat::Float32x3),
    attribute(3, 28, VertexFormat::Uint32),
];

const fn attribute(location: u32, offset: u64, format: VertexFormat) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute {
        format,
        offset,
        shader_location: location,
    }
}

const fn vertices<'a, T>(
    attributes: &'a [wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'a>> {
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<T>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes,
    })
}

/// Properties in which the render pipelines differ.
struct Draw<'a> {
    shader: &'static str,
    vertex: &'static str,
    fragment: Option<&'static str>,
    layouts: &'a [Option<&'a BindGroupLayout>],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    target: Option<wgpu::TextureFormat>,
    depth: Option<wgpu::CompareFunction>,
    cull: bool,
    /// Blends with the background and hides nothing.
    translucent: bool,
    samples: u32,
    constants: &'a [(&'a str, f64)],
}

impl Pipelines {
    pub(super) fn new(device: &Device, layouts: &Layouts, quality: &Quality) -> Self {
        let flag = |on: bool| if on { 1.0 } else { 0.0 };
        let plain = ("PLAIN", flag(quality.detail == 0));
        let shaded = [
            ("DETAIL", f64::from(quality.detail)),
            ("SHADOW", flag(quality.shadow_side.is_some())),
            plain,
        ];
        let developed = [
            ("BLOOM", flag(quality.bloom)),
            ("SMOOTH", flag(quality.samples == 1)),
            plain,
        ];
        let tissue = [
            vertices::<SkinnedVertex>(&SKINNED),
            vertices::<RestVertex>(&REST),
        ];
        let tissue_cast = [vertices::<SkinnedVertex>(&SKINNED[..1])];
        let rigid = [vertices::<RigidVertex>(&RIGID)];
        let near_first = Some(wgpu::CompareFunction::Greater);
        let shadow = Some(wgpu::CompareFunction::LessEqual);
        let samples = quality.samples;
        let full_screen = |shader, layout, target, depth, constants: &[(&str, f64)]| {
            draw(
                device,
                &Draw {
                    shader,
                    vertex: "vertex",
                    fragment: Some("fragment"),
                    layouts: &[Some(layout)],
                    buffers: &[],
                    target: Some(target),
                    depth,
                    cull: false,
                    translucent: false,
                    // Only the mask has a depth, because it is drawn in the scene's pass. So it has
                    // as many samples as the scene.
                    samples: if depth.is_some() { samples } else { 1 },
                    constants,
                },
            )
        };
        let always = Some(wgpu::CompareFunction::Always);
        Self {
            tissue: draw(
                device,
                &Draw {
                    shader: "tissue",
                    vertex: "vertex",
                    fragment: Some("fragment"),
                    layouts: &[Some(&layouts.scene)],
                    buffers: &tissue,
                    target: Some(LIGHT),
                    depth: near_first,
                    cull: true,
                    translucent: false,
                    samples,
                    constants: &shaded,
                },
            ),
            rigid: draw(
                device,
                &Draw {
                    shader: "rigid",
                    vertex: "vertex",
                    fragment: Some("fragment"),
                    layouts: &[Some(&layouts.scene), Some(&layouts.parts)],
                    buffers: &rigid,
                    target: Some(LIGHT),
                    depth: near_first,
                    cull: true,
                    translucent: false,
                    samples,
                    constants: &shaded[1..],
                },
            ),
            effects: draw(
                device,
                &Draw {
                    shader: "effects",
                    vertex: "vertex",
                    fragment: Some("fragment"),
                    layouts: &[Some(&layouts.scene), Some(&layouts.effects)],
                    buffers: &[],
                    target: Some(LIGHT),
                    depth: near_first,
                    cull: false,
                    translucent: true,
                    samples,
                    constants: &shaded[2..],
                },
            ),
            tissue_shadow: draw(
                device,
                &Draw {
                    shader: "tissue",
                    vertex: "cast_shadow",
                    fragment: None,
                    layouts: &[Some(&layouts.frame)],
                    buffers: &tissue_cast,
                    target: None,
                    depth: shadow,
                    cull: false,
                    translucent: false,
                    samples: 1,
                    constants: &[],
                },
            ),
            rigid_shadow: draw(
                device,
                &Draw {
                    shader: "rigid",
                    vertex: "cast_shadow",
                    fragment: None,
                    layouts: &[Some(&layouts.frame), Some(&layouts.parts)],
                    buffers: &rigid,
                    target: None,
                    depth: shadow,
                    cull: false,
                    translucent: false,
                    samples: 1,
                    constants: &[],
                },
            ),
            mask: full_screen("scope mask", &layouts.frame, LIGHT, always, &[]),
            exposure: compute(device, "exposure", "measure", &layouts.exposure),
            glare: [0.9, 0.0].map(|threshold| {
                let threshold = ("THRESHOLD", threshold);
                full_screen("bloom", &layouts.bloom, LIGHT, None, &[threshold])
            }),
            lens: full_screen("lens", &layouts.lens, PICTURE, None, &developed),
        }
    }
}

/// Pipelines of the view of the model.
pub(super) struct InsidePipelines {
    pub(super) balls: RenderPipeline,
    pub(super) springs: RenderPipeline,
    pub(super) glass: RenderPipeline,
}

impl InsidePipelines {
    pub(super) fn new(device: &Device, layouts: &Layouts, quality: &Quality) -> Self {
        let skin = [
            vertices::<SkinnedVertex>(&SKINNED),
            vertices::<RestVertex>(&REST[1..2]),
        ];
        let pipeline = |vertex, fragment, translucent| {
            draw(
                device,
                &Draw {
                    shader: "inside",
                    vertex,
                    fragment: Some(fragment),
                    layouts: &[Some(&layouts.scene), Some(&layouts.inside)],
                    buffers: if translucent { &skin } else { &[] },
                    target: Some(LIGHT),
                    depth: Some(wgpu::CompareFunction::Greater),
                    // A spring is drawn as a ribbon, which may show its back.
                    cull: vertex != "spring",
                    translucent,
                    samples: quality.samples,
                    constants: &[],
                },
            )
        };
        Self {
            balls: pipeline("ball", "solid", false),
            springs: pipeline("spring", "solid", false),
            glass: pipeline("glass", "shine", true),
        }
    }
}

fn module(device: &Device, name: &'static str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(shader(name).into()),
    })
}

fn compute(
    device: &Device,
    name: &'static str,
    entry: &'static str,
    layout: &BindGroupLayout,
) -> ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(layout)],
        ..Default::default()
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&layout),
        module: &module(device, name),
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}

fn draw(device: &Device, what: &Draw<'_>) -> RenderPipeline {
    let module = module(device, what.shader);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(what.shader),
        bind_group_layouts: what.layouts,
        ..Default::default()
    });
    let options = || wgpu::PipelineCompilationOptions {
        constants: what.constants,
        ..Default::default()
    };
    let targets: Vec<_> = what
        .target
        .iter()
        .map(|&format| {
            Some(wgpu::ColorTargetState {
                format,
                blend: what.translucent.then_some(wgpu::BlendState::ALPHA_BLENDING),
                // Alpha stores the distance. Translucent surfaces keep the distance of their
                // background.
                write_mask: match what.translucent {
                    true => wgpu::ColorWrites::COLOR,
                    false => wgpu::ColorWrites::ALL,
                },
            })
        })
        .collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(what.shader),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(what.vertex),
            compilation_options: options(),
            buffers: what.buffers,
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: what.cull.then_some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: what.depth.map(|compare| wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(!what.translucent),
            depth_compare: Some(compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: what.samples,
            ..Default::default()
        },
        fragment: what.fragment.map(|entry| wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options: options(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
