//! Pipelines of the room, each specialised for what it draws and for the camera that it draws for, made when first needed.

use std::collections::BTreeMap;

use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, VertexFormat};

use super::layouts::{Vertices, stored, texture, vertices};
use crate::{
    building::{Material, Texture},
    render::target::LUMINANCE_FORMAT,
    scene::Band,
    sensors::lens::Lens,
};

const SURFACE_SHADER: &str = concat!(
    include_str!("view.wgsl"),
    include_str!("world.wgsl"),
    include_str!("texture.wgsl"),
    include_str!("mirror.wgsl"),
    include_str!("surface.wgsl")
);
const THING_SHADER: &str = concat!(
    include_str!("view.wgsl"),
    include_str!("world.wgsl"),
    include_str!("lamp.wgsl"),
    include_str!("disc.wgsl"),
    include_str!("body.wgsl")
);
const LENS_SHADER: &str = include_str!("lens.wgsl");

/// Samples of a plate's pixel.
pub(super) const SAMPLES: u32 = 4;
/// Depth is near/z, cleared to 0 far away.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What of a surface's material its pipeline is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    texture: Texture,
    gloss: bool,
}

impl Kind {
    pub(super) fn of(material: &Material) -> Kind {
        Kind { texture: material.texture, gloss: material.mirrored > 0.0 }
    }
}

/// What of a camera its pipelines are made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    rolling: bool,
    ring: bool,
    infrared: bool,
    bent: bool,
    defocused: bool,
    vignetting: bool,
}

impl Use {
    pub(super) fn of(lens: &Lens) -> Use {
        Use {
            rolling: lens.row_time_s > 0.0,
            ring: lens.ring_candela > 0.0,
            infrared: lens.band == Band::Infrared,
            bent: lens.bends(),
            defocused: lens.defocus_px > 0.0,
            vignetting: lens.vignetting,
        }
    }

    /// 0 visible, 1 infrared.
    pub(super) fn band(&self) -> usize {
        usize::from(self.infrared)
    }

    /// What matters on the way to the plate.
    fn before_plate(&self) -> Use {
        Use { bent: false, defocused: false, vignetting: false, ..*self }
    }

    /// What matters from the plate on.
    fn after_plate(&self) -> Use {
        Use { rolling: false, ring: false, infrared: false, ..*self }
    }
}

/// What a pipeline draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Drawn {
    Surface(Kind),
    Lamps,
    Bodies,
    Discs,
    Lens,
}

/// Layouts, shaders and the pipelines made so far.
pub(super) struct Pipelines {
    pub(super) view_layout: wgpu::BindGroupLayout,
    pub(super) world_layout: wgpu::BindGroupLayout,
    pub(super) lens_layout: wgpu::BindGroupLayout,
    plate_layout: wgpu::PipelineLayout,
    sheet_layout: wgpu::PipelineLayout,
    surfaces: wgpu::ShaderModule,
    things: wgpu::ShaderModule,
    lens: wgpu::ShaderModule,
    made: BTreeMap<(Drawn, Use), wgpu::RenderPipeline>,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Pipelines {
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let view_layout = layout("room view", &[stored(0, true)]);
        let world_layout = layout(
            "room world",
            &[stored(0, false), stored(1, false), stored(2, false), stored(3, false), texture(4, false)],
        );
        let lens_layout = layout("lens", &[stored(0, false), texture(1, true), stored(2, false)]);
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
            sheet_layout: pipeline_layout("lens", &[Some(&lens_layout)]),
            surfaces: module("surfaces", SURFACE_SHADER),
            things: module("things", THING_SHADER),
            lens: module("lens", LENS_SHADER),
            made: BTreeMap::new(),
            view_layout,
            world_layout,
            lens_layout,
        }
    }

    /// Makes what a view of these kinds of surfaces needs and is not there yet.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, how: &Use, kinds: impl Iterator<Item = Kind>) {
        let things = [Drawn::Lamps, Drawn::Bodies, Drawn::Discs, Drawn::Lens];
        for drawn in kinds.map(Drawn::Surface).chain(things) {
            let key = key(drawn, how);
            if !self.made.contains_key(&key) {
                let pipeline = self.make(device, drawn, how);
                self.made.insert(key, pipeline);
            }
        }
    }

    pub(super) fn surface(&self, how: &Use, kind: Kind) -> &wgpu::RenderPipeline {
        &self.made[&key(Drawn::Surface(kind), how)]
    }

    pub(super) fn lamps(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&key(Drawn::Lamps, how)]
    }

    pub(super) fn bodies(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&key(Drawn::Bodies, how)]
    }

    pub(super) fn discs(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&key(Drawn::Discs, how)]
    }

    pub(super) fn lens(&self, how: &Use) -> &wgpu::RenderPipeline {
        &self.made[&key(Drawn::Lens, how)]
    }

    fn make(&self, device: &wgpu::Device, drawn: Drawn, how: &Use) -> wgpu::RenderPipeline {
        let flag = |on: bool| f64::from(u8::from(on));
        let view = [("ROLLING", flag(how.rolling)), ("RING", flag(how.ring)), ("BAND", flag(how.infrared))];
        let used = |names: &[&str]| view.iter().filter(|(name, _)| names.contains(name)).copied().collect::<Vec<_>>();
        match drawn {
            Drawn::Surface(kind) => {
                let mut constants = used(&["ROLLING", "RING"]);
                constants.extend([("TEXTURE", f64::from(kind.texture as u32)), ("GLOSS", flag(kind.gloss))]);
                let layout =
                    vertices(12, wgpu::VertexStepMode::Vertex, &[VertexFormat::Uint32, VertexFormat::Float32x2]);
                let stage = Stage { entry_points: ["surface_node", "surface_luminance"], cull: true, ..PLATE };
                self.pipeline(device, &self.surfaces, &stage, Some(layout), &constants)
            }
            Drawn::Lamps => {
                let stage = Stage { entry_points: ["lamp_corner", "lamp_luminance"], cull: true, ..PLATE };
                self.pipeline(device, &self.things, &stage, None, &used(&["ROLLING", "RING"]))
            }
            Drawn::Bodies => {
                let formats =
                    [VertexFormat::Float32x3, VertexFormat::Float32x3, VertexFormat::Float32, VertexFormat::Float32];
                let layout = vertices(32, wgpu::VertexStepMode::Vertex, &formats);
                let stage = Stage { entry_points: ["body_corner", "body_luminance"], cull: true, ..PLATE };
                self.pipeline(device, &self.things, &stage, Some(layout), &used(&["ROLLING", "RING"]))
            }
            Drawn::Discs => {
                let formats =
                    [VertexFormat::Float32x3, VertexFormat::Float32, VertexFormat::Float32, VertexFormat::Float32];
                let layout = vertices(24, wgpu::VertexStepMode::Instance, &formats);
                let topology = wgpu::PrimitiveTopology::TriangleStrip;
                let entry_points = ["disc_corner", "disc_luminance"];
                let stage = Stage { entry_points, blend: Some(OVER), writes_depth: false, topology, ..PLATE };
                self.pipeline(device, &self.things, &stage, Some(layout), &used(&["ROLLING", "RING"]))
            }
            Drawn::Lens => {
                let constants = [
                    ("BENT", flag(how.bent)),
                    ("DEFOCUSED", flag(how.defocused)),
                    ("VIGNETTING", flag(how.vignetting)),
                ];
                let entry_points = ["sheet_corner", "sheet_luminance"];
                let stage = Stage { entry_points, blend: Some(SUM), on_plate: false, ..PLATE };
                self.pipeline(device, &self.lens, &stage, None, &constants)
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
        let depth_stencil = stage.on_plate.then(|| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(stage.writes_depth),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        });
        let buffer = vertices.as_ref().map(|vertices| wgpu::VertexBufferLayout {
            array_stride: vertices.stride,
            step_mode: vertices.step_mode,
            attributes: &vertices.attributes,
        });
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(stage.entry_points[1]),
            layout: Some(if stage.on_plate { &self.plate_layout } else { &self.sheet_layout }),
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
            multisample: wgpu::MultisampleState {
                count: if stage.on_plate { SAMPLES } else { 1 },
                ..Default::default()
            },
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

/// What tells two pipelines apart besides shaders.
struct Stage {
    /// Of the vertex and of the fragment shader.
    entry_points: [&'static str; 2],
    blend: Option<BlendState>,
    writes_depth: bool,
    cull: bool,
    on_plate: bool,
    topology: wgpu::PrimitiveTopology,
}

const PLATE: Stage = Stage {
    entry_points: ["", ""],
    blend: None,
    writes_depth: true,
    cull: false,
    on_plate: true,
    topology: wgpu::PrimitiveTopology::TriangleList,
};

const OVER: BlendState = both(BlendFactor::OneMinusSrcAlpha);
const SUM: BlendState = both(BlendFactor::One);

/// `source + factor·target`.
const fn both(dst_factor: BlendFactor) -> BlendState {
    let component = BlendComponent { src_factor: BlendFactor::One, dst_factor, operation: BlendOperation::Add };
    BlendState { color: component, alpha: component }
}

fn key(drawn: Drawn, how: &Use) -> (Drawn, Use) {
    (drawn, if drawn == Drawn::Lens { how.after_plate() } else { how.before_plate() })
}
