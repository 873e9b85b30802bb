//! Graphics pipelines of the room pass, each specialised for what it draws and for the camera that it draws for; they are made when first needed.

use std::collections::BTreeMap;

use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, VertexFormat};

use super::layouts::{Vertices, constant, sampler, stored, texture, uniform, vertices};
use crate::{
    optics::Lens,
    place::building::{Material, Texture},
    render::texels::{LUMINANCE_FORMAT, linear},
    scene::Band,
};

const SURFACE_SHADER: &str = concat!(
    include_str!("../row.wgsl"),
    include_str!("view.wgsl"),
    include_str!("world.wgsl"),
    include_str!("sun.wgsl"),
    include_str!("texture.wgsl"),
    include_str!("mirror.wgsl"),
    include_str!("surface.wgsl")
);
const THING_SHADER: &str = concat!(
    include_str!("../row.wgsl"),
    include_str!("view.wgsl"),
    include_str!("world.wgsl"),
    include_str!("sun.wgsl"),
    include_str!("lamp.wgsl"),
    include_str!("disc.wgsl"),
    include_str!("body.wgsl"),
    include_str!("edge.wgsl"),
    include_str!("strip.wgsl")
);
const MEAN_SHADER: &str = include_str!("mean.wgsl");

/// Format of the depth buffer. Depth is near/z, so that it is cleared to 0, which is infinitely far.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Properties of a surface's material for which the graphics pipeline that draws the surface is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    texture: Texture,
    gloss: bool,
    glints: bool,
}

impl Kind {
    pub(super) fn of(material: &Material) -> Kind {
        let gloss = material.mirrored > 0.0;
        Kind { texture: material.texture, gloss, glints: gloss }
    }

    pub(super) fn gloss(&self) -> bool {
        self.gloss
    }

    /// This kind of surface as it is drawn where no lamp is seen reflected in it.
    pub(super) fn without_glints(self) -> Kind {
        Kind { glints: false, ..self }
    }
}

/// Properties of a camera for which its graphics pipelines are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    rolling: bool,
    ring: bool,
    infrared: bool,
    sky: bool,
}

impl Use {
    /// The properties of a camera, and whether it looks at a place under the sky.
    pub(super) fn of(lens: &Lens, sky: bool) -> Use {
        let infrared = lens.band == Band::Infrared;
        Use { rolling: lens.row_time_s > 0.0, ring: lens.ring_candela > 0.0, infrared, sky }
    }

    /// Whether the camera reads its rows one after another.
    pub(super) fn rolling(&self) -> bool {
        self.rolling
    }

    /// Index of the camera's band: 0 for visible, 1 for infrared.
    pub(super) fn band(&self) -> usize {
        usize::from(self.infrared)
    }
}

/// The kind of thing that a graphics pipeline of the room pass draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Drawn {
    Surface(Kind),
    Lamps,
    Bodies,
    Discs,
    Edges,
    Strips,
}

/// Layouts and shaders of the room pass, and the pipelines that have been made.
pub(super) struct Pipelines {
    pub(super) view_layout: wgpu::BindGroupLayout,
    pub(super) world_layout: wgpu::BindGroupLayout,
    pub(super) stepped_layout: wgpu::BindGroupLayout,
    pub(super) mean_layout: wgpu::BindGroupLayout,
    /// Graphics pipeline that takes the mean of the images drawn for the instants of an exposure (its sub-frames).
    pub(super) mean: wgpu::RenderPipeline,
    /// Texture sampler that interpolates linearly between texels.
    pub(super) linear: wgpu::Sampler,
    plate_layout: wgpu::PipelineLayout,
    edge_layout: wgpu::PipelineLayout,
    surfaces: wgpu::ShaderModule,
    things: wgpu::ShaderModule,
    made: BTreeMap<(Drawn, Use), wgpu::RenderPipeline>,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Pipelines {
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let (flat, layered) = (wgpu::TextureViewDimension::D2, wgpu::TextureViewDimension::D2Array);
        let view_layout = layout("room view", &[uniform(0), stored(1, true)]);
        let world_layout = layout(
            "room world",
            &[
                stored(0, false),
                constant(1),
                constant(2),
                stored(3, false),
                texture(4, flat),
                sampler(5),
                stored(6, false),
                constant(7),
            ],
        );
        let stepped_layout = layout("stepped", &[texture(0, flat)]);
        let mean_layout = layout("plates", &[stored(0, false), texture(1, layered)]);
        let pipeline_layout = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let module = |label, source: &str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        Pipelines {
            plate_layout: pipeline_layout("plate", &[Some(&view_layout), Some(&world_layout)]),
            edge_layout: pipeline_layout("edges", &[Some(&view_layout), Some(&world_layout), Some(&stepped_layout)]),
            surfaces: module("surfaces", SURFACE_SHADER),
            things: module("things", THING_SHADER),
            mean: mean(device, &pipeline_layout("mean", &[Some(&mean_layout)]), &module("mean", MEAN_SHADER)),
            made: BTreeMap::new(),
            mean_layout,
            view_layout,
            world_layout,
            stepped_layout,
            linear: linear(device),
        }
    }

    /// Makes the graphics pipelines that a picture with these kinds of surfaces needs and that do not exist yet.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, how: &Use, kinds: impl Iterator<Item = Kind>) {
        let things = [Drawn::Lamps, Drawn::Bodies, Drawn::Discs, Drawn::Edges, Drawn::Strips];
        for drawn in kinds.map(Drawn::Surface).chain(things) {
            let key = (drawn, *how);
            if !self.made.contains_key(&key) {
                let pipeline = self.make(device, drawn, how);
                self.made.insert(key, pipeline);
            }
        }
    }

    pub(super) fn surface(&self, how: &Use, kind: Kind) -> &wgpu::RenderPipeline {
        &self.made[&(Drawn::Surface(kind), *how)]
    }

    pub(super) fn lamps(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&(Drawn::Lamps, *how)]
    }

    pub(super) fn bodies(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&(Drawn::Bodies, *how)]
    }

    pub(super) fn discs(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&(Drawn::Discs, *how)]
    }

    pub(super) fn edges(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&(Drawn::Edges, *how)]
    }

    pub(super) fn strips(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&(Drawn::Strips, *how)]
    }

    fn make(&self, device: &wgpu::Device, drawn: Drawn, how: &Use) -> wgpu::RenderPipeline {
        let flag = |on: bool| f64::from(u8::from(on));
        let view = [("ROLLING", flag(how.rolling)), ("RING", flag(how.ring)), ("SKY", flag(how.sky))];
        let used = |names: &[&str]| view.iter().filter(|(name, _)| names.contains(name)).copied().collect::<Vec<_>>();
        match drawn {
            Drawn::Surface(kind) => {
                let mut constants = used(&["ROLLING", "RING", "SKY"]);
                constants.extend([
                    ("TEXTURE", f64::from(kind.texture as u32)),
                    ("GLOSS", flag(kind.gloss)),
                    ("GLINTS", flag(kind.glints)),
                ]);
                let layout = vertices(wgpu::VertexStepMode::Vertex, &[VertexFormat::Uint32, VertexFormat::Float32x2]);
                let stage = Stage { entry_points: ["surface_node", "surface_luminance"], cull: true, ..PLATE };
                self.pipeline(device, &self.surfaces, &stage, Some(layout), &constants)
            }
            Drawn::Lamps => {
                let stage = Stage { entry_points: ["lamp_corner", "lamp_luminance"], cull: true, ..PLATE };
                self.pipeline(device, &self.things, &stage, None, &used(&["ROLLING", "RING"]))
            }
            Drawn::Bodies => {
                let formats = [
                    VertexFormat::Float32x3,
                    VertexFormat::Float32x3,
                    VertexFormat::Float32,
                    VertexFormat::Float32,
                    VertexFormat::Float32x3,
                ];
                let layout = vertices(wgpu::VertexStepMode::Vertex, &formats);
                let stage = Stage { entry_points: ["body_corner", "body_luminance"], cull: true, ..PLATE };
                self.pipeline(device, &self.things, &stage, Some(layout), &used(&["ROLLING", "RING"]))
            }
            Drawn::Discs => {
                let formats =
                    [VertexFormat::Float32x3, VertexFormat::Float32, VertexFormat::Float32, VertexFormat::Float32];
                let layout = vertices(wgpu::VertexStepMode::Instance, &formats);
                let topology = wgpu::PrimitiveTopology::TriangleStrip;
                let entry_points = ["disc_corner", "disc_luminance"];
                let stage = Stage { entry_points, blend: Some(OVER), writes_depth: false, topology, ..PLATE };
                self.pipeline(device, &self.things, &stage, Some(layout), &used(&["ROLLING", "RING"]))
            }
            Drawn::Strips => {
                let formats = [VertexFormat::Uint32, VertexFormat::Uint32, VertexFormat::Float32x2];
                let layout = vertices(wgpu::VertexStepMode::Instance, &formats);
                let topology = wgpu::PrimitiveTopology::TriangleStrip;
                let entry_points = ["strip_corner", "strip_luminance"];
                let stage = Stage { entry_points, blend: Some(OVER), writes_depth: false, topology, ..PLATE };
                self.pipeline(device, &self.things, &stage, Some(layout), &used(&["ROLLING", "RING", "SKY"]))
            }
            Drawn::Edges => {
                let layout = vertices(wgpu::VertexStepMode::Instance, &[VertexFormat::Float32x3; 6]);
                let topology = wgpu::PrimitiveTopology::TriangleStrip;
                let entry_points = ["edge_corner", "edge_luminance"];
                let stage = Stage { entry_points, writes_depth: false, topology, layout: Layout::Edges, ..PLATE };
                self.pipeline(device, &self.things, &stage, Some(layout), &used(&["ROLLING"]))
            }
        }
    }

    fn pipeline(
        &self,
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        stage: &Stage,
        vertices: Option<Vertices>,
        constants: &[(&str, f64)],
    ) -> wgpu::RenderPipeline {
        let options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
        let depth_stencil = Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(stage.writes_depth),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        });
        let buffer = vertices.as_ref().map(Vertices::layout);
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(stage.entry_points[1]),
            layout: Some(match stage.layout {
                Layout::Plate => &self.plate_layout,
                Layout::Edges => &self.edge_layout,
            }),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(stage.entry_points[0]),
                compilation_options: options.clone(),
                buffers: if buffer.is_some() { std::slice::from_ref(&buffer) } else { &[] },
            },
            primitive: wgpu::PrimitiveState {
                topology: stage.topology,
                cull_mode: stage.cull.then_some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(stage.entry_points[1]),
                compilation_options: options,
                targets: &[Some(wgpu::ColorTargetState {
                    format: LUMINANCE_FORMAT,
                    blend: stage.blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn mean(device: &wgpu::Device, layout: &wgpu::PipelineLayout, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("mean"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("whole_plate"),
            compilation_options: compilation_options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("mean_luminance"),
            compilation_options,
            targets: &[Some(LUMINANCE_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Properties, besides shaders, by which two pipelines of the room differ.
struct Stage {
    /// Names of the entry points in the vertex and in the fragment shader.
    entry_points: [&'static str; 2],
    blend: Option<BlendState>,
    writes_depth: bool,
    cull: bool,
    layout: Layout,
    topology: wgpu::PrimitiveTopology,
}

/// The set of bindings that a pipeline reads.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Layout {
    Plate,
    Edges,
}

const PLATE: Stage = Stage {
    entry_points: ["", ""],
    blend: None,
    writes_depth: true,
    cull: false,
    layout: Layout::Plate,
    topology: wgpu::PrimitiveTopology::TriangleList,
};

const OVER: BlendState = both(BlendFactor::OneMinusSrcAlpha);

/// Blending that gives `source + factor·target`, for colour and alpha alike.
const fn both(dst_factor: BlendFactor) -> BlendState {
    let component = BlendComponent { src_factor: BlendFactor::One, dst_factor, operation: BlendOperation::Add };
    BlendState { color: component, alpha: component }
}
