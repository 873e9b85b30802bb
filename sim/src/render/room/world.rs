//! A building on the graphics device: faces, lamps and light maps, made once per scene and seed.

use bytemuck::Zeroable;

use super::{
    edges::{self, Edges},
    faces::{self, Cells},
    people::People,
    pipelines::Pipelines,
    sun::SunOnDevice,
};
use crate::{
    place::{
        building::Building,
        light::{Daylight, FloorField, LightMap, Lighting, Shadows},
    },
    render::device::Graphics,
    scene::MAX_LAMPS,
};

/// The room of a scene on the device: everything that stands still, and the people as they were last placed.
#[derive(Debug)]
pub(in crate::render) struct RoomWorld {
    pub(super) building: Building,
    pub(super) lighting: Lighting,
    pub(super) map: LightMap,
    /// Textures with the light maps (illuminance over all faces) in the visible and in the infrared band, with the shadows of people.
    pub(super) light_maps: [wgpu::Texture; 2],
    pub(super) people: People,
    pub(super) nodes: wgpu::Buffer,
    pub(super) cells: Cells,
    /// Index of the first bulb among the lamps; rectangular lamps come before bulbs.
    pub(super) first_bulb: u32,
    pub(in crate::render) lamp_count: u32,
    pub(super) mirrored_count: u32,
    pub(super) disc_count: u32,
    /// Edges of the building's faces for a global shutter and for a rolling one.
    pub(super) edges: [wgpu::Buffer; 2],
    pub(super) edge_lists: [Edges; 2],
    /// Buffers with the building's panels, lamps and tiles for the visible and for the infrared band.
    stored: [Stored; 2],
    /// Bindings for drawing the building in the visible and in the infrared band.
    bindings: [wgpu::BindGroup; 2],
    discs: [wgpu::Buffer; 2],
}

/// Buffers of one band that faces read in addition to the light map: panels, lamps, the tile grid and the albedo of the tiles.
#[derive(Debug)]
struct Stored {
    surfaces: wgpu::Buffer,
    lamps: wgpu::Buffer,
    grid: wgpu::Buffer,
    tile_albedo: wgpu::Buffer,
    sunlight: wgpu::Buffer,
    sun: wgpu::Buffer,
}

impl RoomWorld {
    pub(super) fn new(
        graphics: &Graphics,
        pipelines: &Pipelines,
        building: Building,
        (lighting, map): (Lighting, LightMap),
    ) -> RoomWorld {
        let (nodes, cells) = faces::cells(&building, &lighting);
        let edges = [false, true].map(|rolling| edges::of_building(&building, &lighting, rolling));
        let discs = [0, 1].map(|band| faces::discs(&building, &lighting, band));
        let light_maps = [0, 1].map(|band| {
            let texture = light_texture(graphics, &map);
            write_light(graphics, &texture, &map.nodes, band);
            texture
        });
        let n_panels = building.panels.len();
        let to_sun = lighting.daylight.map(|daylight| daylight.to_sun);
        let shadows = to_sun.map_or_else(|| Shadows::none(n_panels), |to_sun| Shadows::new(&building, to_sun));
        let stored = [0, 1].map(|band| Stored::new(graphics, &building, (&lighting, &shadows), &map, band));
        let bindings = [0, 1].map(|band| stored[band].bind(graphics, pipelines, &light_maps[band]));
        RoomWorld {
            nodes: graphics.buffer("nodes", wgpu::BufferUsages::VERTEX, &nodes),
            cells,
            first_bulb: lighting.sources.iter().filter(|source| source.shape.normal().is_some()).count() as u32,
            lamp_count: lighting.sources.len() as u32,
            mirrored_count: building.n_large_panels as u32,
            disc_count: discs[0].len() as u32,
            edges: edges.each_ref().map(|(edges, _)| graphics.buffer("edges", wgpu::BufferUsages::VERTEX, edges)),
            edge_lists: edges.map(|(_, list)| list),
            stored,
            bindings,
            discs: discs.map(|discs| graphics.buffer("discs", wgpu::BufferUsages::VERTEX, &discs)),
            people: People::none(graphics),
            building,
            lighting,
            map,
            light_maps,
        }
    }

    /// Gives the building other light of the same lamps, without the shadows of people, who have to be placed anew.
    pub(in crate::render) fn light_up(&mut self, graphics: &Graphics, (lighting, map): (Lighting, LightMap)) {
        for band in 0..2 {
            write_light(graphics, &self.light_maps[band], &map.nodes, band);
            let lamps = faces::lamps(&self.building, &lighting, band);
            graphics.queue.write_buffer(&self.stored[band].lamps, 0, bytemuck::cast_slice(&lamps));
            let discs = faces::discs(&self.building, &lighting, band);
            graphics.queue.write_buffer(&self.discs[band], 0, bytemuck::cast_slice(&discs));
        }
        (self.lighting, self.map) = (lighting, map);
        self.people.placed.clear();
    }

    /// Luminance of the sky in one band (visible or infrared), before the factor on all light; that of an even sky is its illuminance on a level plane
    /// over π. 0 without a sky.
    pub(super) fn sky_luminance(&self, band: usize) -> f64 {
        let of_sky = |daylight: &Daylight| daylight.diffuse_horizontal.by_band[band] / std::f64::consts::PI;
        self.lighting.daylight.as_ref().map_or(0.0, of_sky)
    }

    /// Tells the sun where people stand before it.
    pub(super) fn shade(&self, graphics: &Graphics) {
        for (band, stored) in self.stored.iter().enumerate() {
            let sun = SunOnDevice::new(&self.lighting, &self.people.placed, band);
            graphics.queue.write_buffer(&stored.sun, 0, bytemuck::bytes_of(&sun));
        }
    }

    pub(super) fn bindings(&self, band: usize) -> &wgpu::BindGroup {
        &self.bindings[band]
    }

    /// Bindings for this building under other light, given by its values at the nodes of the light map.
    pub(super) fn lit_by(
        &self,
        graphics: &Graphics,
        pipelines: &Pipelines,
        band: usize,
        nodes: &[[f32; 2]],
    ) -> wgpu::BindGroup {
        let texture = light_texture(graphics, &self.map);
        write_light(graphics, &texture, nodes, band);
        self.stored[band].bind(graphics, pipelines, &texture)
    }

    pub(super) fn discs(&self, band: usize) -> &wgpu::Buffer {
        &self.discs[band]
    }

    /// Illuminance at the nodes (points) of the light map, without the shadows of people.
    pub(in crate::render) fn still_nodes(&self) -> &[[f32; 2]] {
        &self.map.nodes
    }

    /// Distribution of light over the floor of the robot's room, from the given illuminance at the nodes (points) of the light map.
    pub(in crate::render) fn floor_field(&self, nodes: &[[f32; 2]]) -> Option<FloorField> {
        FloorField::new(&self.building, &self.map, nodes)
    }

    /// Mean illuminance at the floor of the robot's room, as the scene's lamps give it.
    pub(in crate::render) fn mean_at_floor_lux(&self) -> f64 {
        self.map.mean_at_floor.lux * self.lighting.dimming
    }
}

impl Stored {
    fn new(
        graphics: &Graphics,
        building: &Building,
        (lighting, shadows): (&Lighting, &Shadows),
        map: &LightMap,
        band: usize,
    ) -> Stored {
        let storage = |label, bytes: &[u8]| graphics.buffer(label, wgpu::BufferUsages::STORAGE, bytes);
        let uniform = |label, bytes: &[u8]| graphics.buffer(label, wgpu::BufferUsages::UNIFORM, bytes);
        let (grid, albedo) = faces::grid(building);
        let mut lamps = faces::lamps(building, lighting, band);
        lamps.resize(MAX_LAMPS, Zeroable::zeroed());
        Stored {
            surfaces: storage(
                "surfaces",
                bytemuck::cast_slice(&faces::surfaces(building, &map.patches, shadows, band)),
            ),
            lamps: uniform("lamps", bytemuck::cast_slice(&lamps)),
            grid: uniform("grid", bytemuck::bytes_of(&grid)),
            tile_albedo: storage("tiles", bytemuck::cast_slice(&albedo)),
            sunlight: storage("sunlight", bytemuck::cast_slice(&shadows.words)),
            sun: uniform("sun", bytemuck::bytes_of(&SunOnDevice::new(lighting, &[], band))),
        }
    }

    fn bind(&self, graphics: &Graphics, pipelines: &Pipelines, light: &wgpu::Texture) -> wgpu::BindGroup {
        let light = light.create_view(&wgpu::TextureViewDescriptor::default());
        graphics.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("room world"),
            layout: &pipelines.world_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.surfaces.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: self.lamps.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 2, resource: self.grid.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: self.tile_albedo.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 4, resource: wgpu::BindingResource::TextureView(&light) },
                wgpu::BindGroupEntry { binding: 5, resource: wgpu::BindingResource::Sampler(&pipelines.linear) },
                wgpu::BindGroupEntry { binding: 6, resource: self.sunlight.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 7, resource: self.sun.as_entire_binding() },
            ],
        })
    }
}

/// A texture for the light map in one band (visible or infrared).
fn light_texture(graphics: &Graphics, map: &LightMap) -> wgpu::Texture {
    let [width, height] = map.size.map(|count| count as u32);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    graphics.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("light map"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Writes one band (visible or infrared) of the illuminance at all nodes of the light map into a texture.
pub(super) fn write_light(graphics: &Graphics, texture: &wgpu::Texture, nodes: &[[f32; 2]], band: usize) {
    let nodes: Vec<f32> = nodes.iter().map(|bands| bands[band]).collect();
    graphics.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&nodes),
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * texture.width()), rows_per_image: None },
        texture.size(),
    );
}
