//! The floor pass: tiles, joints and strays as luminance, all sub-frames of the exposure in one pass.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Isometry3, Matrix3, Rotation2, Vector2, vector};

use super::{
    FloorLight, RenderError, View,
    device::Graphics,
    exposure::{MAX_SUB_FRAMES, floor_point, sub_frame_ends},
    target::{LUMINANCE_FORMAT, Target},
};
use crate::{
    drawn::{Drawn, LaidTiles},
    scene::{Pattern, Room, Scene, Stray, Tiles},
};

/// Strays in one view at most, as in floor.wgsl.
const MAX_STRAYS: usize = 64;
/// Albedo of a floor without tiles: grey screed.
const PLAIN_ALBEDO: f32 = 0.4;
/// Albedo of what lies beyond the walls' feet: a dark skirting, lit like the floor.
const WALL_ALBEDO: f64 = 0.1;
/// A stray up to this wide is a wire that stands up from the floor and shades it; a wider one is a flat tape.
const WIDEST_WIRE_M: f64 = 0.012;
/// Share of the light that a wire takes away just beside it: it hides about this much of a room's ceiling.
const WIRE_SHADE: f32 = 0.15;

const SHADER: &str = concat!(include_str!("coverage.wgsl"), include_str!("pattern.wgsl"), include_str!("floor.wgsl"));

/// Pipelines of the floor, one for each pattern, so that a plain floor does not pay for marble.
pub(super) struct FloorPass {
    pipelines: [wgpu::RenderPipeline; 4],
    material_layout: wgpu::BindGroupLayout,
    view_layout: wgpu::BindGroupLayout,
}

/// A world's floor on the device, with what views need to place themselves on it.
#[derive(Debug)]
pub(super) struct FloorOnDevice {
    bindings: wgpu::BindGroup,
    pattern: Pattern,
    grid: Option<Grid>,
    room: Room,
    light: FloorLight,
    strays: Vec<Stray>,
}

/// A view's part of the bindings.
pub(super) struct FloorSlot {
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

/// Where the laid corners are.
#[derive(Clone, Copy, Debug)]
struct Grid {
    edge_m: Vector2<f64>,
    phase_m: Vector2<f64>,
    rotation_rad: f64,
    first: [i32; 2],
    count: [usize; 2],
}

/// `Material` of floor.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct MaterialUniform {
    edge_m: [f32; 2],
    half_joint_m: f32,
    joint_reach_m: f32,
    joint_albedo: f32,
    pattern_contrast: f32,
    plain_albedo: f32,
    tiled: u32,
    pattern_seed: u32,
    padding: u32,
}

/// `View` of floor.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ViewUniform {
    local_from_pixel: [[[f32; 4]; 3]; MAX_SUB_FRAMES + 1],
    principal_point_px: [f32; 2],
    sub_frames: u32,
    stray_count: u32,
    light_gradient: [f32; 2],
    light_at_origin: f32,
    wall_albedo: f32,
    walls: [[f32; 4]; 4],
    origin: [i32; 2],
    corners: [i32; 2],
    strays: [StrayUniform; MAX_STRAYS],
}

/// `Stray` of floor.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct StrayUniform {
    middle_m: [f32; 2],
    direction: [f32; 2],
    half_length_m: f32,
    half_width_m: f32,
    albedo: f32,
    shade: f32,
}

/// The frame of a view's floor coordinates: the grid frame moved to a corner near the camera.
struct LocalFrame {
    origin_in_grid: Vector2<f64>,
    grid_from_world: Rotation2<f64>,
    /// Index of the origin among the laid corners.
    corner: [i32; 2],
    corners: [usize; 2],
}

impl FloorPass {
    pub(super) fn new(device: &wgpu::Device) -> FloorPass {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("floor"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let uniform = wgpu::BufferBindingType::Uniform;
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let material_layout = layout(device, "floor material", &[uniform, storage, storage]);
        let view_layout = layout(device, "floor view", &[uniform]);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("floor"),
            bind_group_layouts: &[Some(&material_layout), Some(&view_layout)],
            immediate_size: 0,
        });
        let pipelines = [Pattern::Plain, Pattern::Speckle, Pattern::Marble, Pattern::Stripes]
            .map(|pattern| pipeline(device, &module, &pipeline_layout, pattern));
        FloorPass { pipelines, material_layout, view_layout }
    }

    /// Bindings for one view.
    pub(super) fn slot(&self, device: &wgpu::Device) -> FloorSlot {
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("floor view"),
            size: size_of::<ViewUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bindings = bind(device, &self.view_layout, &[&uniform]);
        FloorSlot { uniform, bindings }
    }

    /// Lays corners, contrasts and albedos of a world's tiles into device memory.
    pub(super) fn upload(
        &self,
        graphics: &Graphics,
        scene: &Scene,
        drawn: &Drawn,
    ) -> Result<FloorOnDevice, RenderError> {
        let tiled = scene.floor.tiles.as_ref().zip(drawn.tiles.as_ref());
        let (material, corners, albedos) = match tiled {
            Some((tiles, laid)) => (material_of(tiles, laid), corners_of(laid), laid.tile_albedo.clone()),
            None => (plain_material(), vec![[0.0; 4]], vec![0.0]),
        };
        let limit = graphics.device.limits().max_storage_buffer_binding_size;
        let needed = size_of_val(corners.as_slice()) as u64;
        if needed > limit {
            return Err(RenderError::TooLarge {
                what: "the floor",
                needed: format!("{} tiles", corners.len()),
                limit: format!("{} tiles", limit / size_of::<[f32; 4]>() as u64),
            });
        }
        let storage = wgpu::BufferUsages::STORAGE;
        let buffers = [
            filled(graphics, wgpu::BufferUsages::UNIFORM, bytemuck::bytes_of(&material)),
            filled(graphics, storage, bytemuck::cast_slice(&corners)),
            filled(graphics, storage, bytemuck::cast_slice(&albedos)),
        ];
        Ok(FloorOnDevice {
            bindings: bind(&graphics.device, &self.material_layout, &buffers.each_ref()),
            pattern: tiled.map_or(Pattern::Plain, |(tiles, _)| tiles.pattern),
            grid: tiled.map(|(tiles, laid)| Grid::new(tiles, laid)),
            room: scene.room.clone(),
            light: FloorLight::new(&scene.light, &scene.room),
            strays: scene.floor.strays.clone(),
        })
    }

    /// Draws one view's floor into its luminance target.
    pub(super) fn draw(
        &self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        floor: &FloorOnDevice,
        view: &View,
        target: &Target,
    ) -> Result<(), RenderError> {
        let uniform = floor.view_uniform(view)?;
        graphics.queue.write_buffer(&target.floor.uniform, 0, bytemuck::bytes_of(&uniform));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("floor"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.luminance,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines[floor.pattern as usize]);
        pass.set_bind_group(0, &floor.bindings, &[]);
        pass.set_bind_group(1, &target.floor.bindings, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}

impl FloorOnDevice {
    fn view_uniform(&self, view: &View) -> Result<ViewUniform, RenderError> {
        let first = view.world_from_camera.first().ok_or(RenderError::BadView("it has no camera pose"))?;
        let foot = first.translation.vector.xy();
        let frame = LocalFrame::near(foot, self.grid.as_ref());
        let ends = sub_frame_ends(&view.intrinsics, &view.world_from_camera);
        let mut local_from_pixel = [[[0.0; 4]; 3]; MAX_SUB_FRAMES + 1];
        for (rows, pose) in local_from_pixel.iter_mut().zip(&ends) {
            *rows = rows_of(&frame.local_from_pixel(pose, view.intrinsics.focal_px));
        }
        let gradient = frame.grid_from_world * self.light.gradient_per_m;
        let origin_in_world = frame.grid_from_world.inverse() * frame.origin_in_grid;
        // A matt surface of albedo 1 under E has the luminance E/π.
        let light_at_origin =
            view.illuminance_at_floor_lux * self.light.factor_at(origin_in_world) / std::f64::consts::PI;
        let (stray_count, strays) = self.strays_near(foot, view_radius_m(view), &frame)?;
        Ok(ViewUniform {
            local_from_pixel,
            principal_point_px: view.intrinsics.principal_point_px.map(|coordinate| coordinate as f32),
            sub_frames: (ends.len() - 1) as u32,
            stray_count,
            light_gradient: single(gradient),
            light_at_origin: light_at_origin as f32,
            wall_albedo: WALL_ALBEDO as f32,
            walls: self.walls(&frame),
            origin: frame.corner,
            corners: frame.corners.map(|count| count as i32),
            strays,
        })
    }

    /// `[normal_x, normal_y, offset, 0]` of each wall in the local frame; positive inside.
    fn walls(&self, frame: &LocalFrame) -> [[f32; 4]; 4] {
        let walls = [
            (vector![1.0, 0.0], 0.0),
            (vector![-1.0, 0.0], self.room.width_m),
            (vector![0.0, 1.0], 0.0),
            (vector![0.0, -1.0], self.room.depth_m),
        ];
        walls.map(|(normal_in_world, offset_m)| {
            let normal = frame.grid_from_world * normal_in_world;
            let offset_m = offset_m + normal.dot(&frame.origin_in_grid);
            [normal.x as f32, normal.y as f32, offset_m as f32, 0.0]
        })
    }

    /// The strays within the radius of a place, in the local frame.
    fn strays_near(
        &self,
        place_m: Vector2<f64>,
        radius_m: f64,
        frame: &LocalFrame,
    ) -> Result<(u32, [StrayUniform; MAX_STRAYS]), RenderError> {
        let mut strays = [StrayUniform::zeroed(); MAX_STRAYS];
        let mut count = 0;
        for stray in &self.strays {
            let [from, to] = [Vector2::from(stray.from_m), Vector2::from(stray.to_m)];
            if distance_to_segment(place_m, from, to) > radius_m + 4.0 * stray.width_m {
                continue;
            }
            if count == MAX_STRAYS {
                return Err(RenderError::TooLarge {
                    what: "the strays in one view",
                    needed: format!("more than {MAX_STRAYS}"),
                    limit: MAX_STRAYS.to_string(),
                });
            }
            strays[count] = StrayUniform::new(stray, from, to, frame);
            count += 1;
        }
        Ok((count as u32, strays))
    }
}

impl StrayUniform {
    fn new(stray: &Stray, from: Vector2<f64>, to: Vector2<f64>, frame: &LocalFrame) -> StrayUniform {
        let length_m = (to - from).norm();
        let direction = (to - from).try_normalize(0.0).unwrap_or(Vector2::x());
        StrayUniform {
            middle_m: single(frame.grid_from_world * ((from + to) / 2.0) - frame.origin_in_grid),
            direction: single(frame.grid_from_world * direction),
            half_length_m: (length_m / 2.0) as f32,
            half_width_m: (stray.width_m / 2.0) as f32,
            albedo: stray.albedo as f32,
            shade: if stray.width_m <= WIDEST_WIRE_M { WIRE_SHADE } else { 0.0 },
        }
    }
}

impl Grid {
    fn new(tiles: &Tiles, laid: &LaidTiles) -> Grid {
        Grid {
            edge_m: vector![tiles.edge_x_m, tiles.edge_y_m],
            phase_m: vector![tiles.phase_x_m, tiles.phase_y_m],
            rotation_rad: tiles.rotation_deg.to_radians(),
            first: laid.first,
            count: laid.count,
        }
    }
}

impl LocalFrame {
    /// The frame at the nominal corner nearest to a place in the world, or at the place itself on a plain floor.
    fn near(place_m: Vector2<f64>, grid: Option<&Grid>) -> LocalFrame {
        let Some(grid) = grid else {
            return LocalFrame {
                origin_in_grid: place_m,
                grid_from_world: Rotation2::identity(),
                corner: [0; 2],
                corners: [1; 2],
            };
        };
        let grid_from_world = Rotation2::new(-grid.rotation_rad);
        let index = (grid_from_world * place_m - grid.phase_m).component_div(&grid.edge_m).map(f64::round);
        LocalFrame {
            origin_in_grid: index.component_mul(&grid.edge_m) + grid.phase_m,
            grid_from_world,
            corner: [index.x as i32 - grid.first[0], index.y as i32 - grid.first[1]],
            corners: grid.count,
        }
    }

    /// Homography from pixels about the principal point to the floor plane.
    ///
    /// A ray r = R·(u/f, v/f, 1) from the optical centre c meets z = 0 at c − r·c_z/r_z, that is
    /// (r_xy·c_z − c_xy·r_z) / (−r_z): numerator and denominator are linear in the pixel.
    fn local_from_pixel(&self, world_from_camera: &Isometry3<f64>, focal_px: f64) -> Matrix3<f64> {
        let rotation = world_from_camera.rotation.to_rotation_matrix();
        let centre = world_from_camera.translation.vector;
        let centre_in_local = self.grid_from_world * centre.xy() - self.origin_in_grid;
        let mut matrix = Matrix3::zeros();
        for (column, scale) in [1.0 / focal_px, 1.0 / focal_px, 1.0].into_iter().enumerate() {
            let ray = rotation.matrix().column(column) * scale;
            let ray_in_local = self.grid_from_world * vector![ray[0], ray[1]];
            let numerator = ray_in_local * centre.z - centre_in_local * ray[2];
            matrix.set_column(column, &vector![numerator.x, numerator.y, -ray[2]]);
        }
        matrix
    }
}

/// Greatest distance from the camera's foot to a floor point in view, over the exposure.
fn view_radius_m(view: &View) -> f64 {
    let [width, height] = view.intrinsics.size_px.map(|size| f64::from(size) - 1.0);
    let foot = view.world_from_camera[0].translation.vector.xy();
    let mut radius_m: f64 = 0.0;
    for pose in &view.world_from_camera {
        for pixel in [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]] {
            let distance_m = floor_point(&view.intrinsics, pose, pixel)
                .map_or(f64::INFINITY, |point| (point.coords.xy() - foot).norm());
            radius_m = radius_m.max(distance_m);
        }
    }
    radius_m
}

fn distance_to_segment(place: Vector2<f64>, from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    let reach = to - from;
    let share = ((place - from).dot(&reach) / reach.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (place - from - reach * share).norm()
}

fn material_of(tiles: &Tiles, laid: &LaidTiles) -> MaterialUniform {
    let largest_offset_m = laid.corner_offset_m.iter().flatten().fold(0.0_f64, |max, offset| max.max(offset.abs()));
    MaterialUniform {
        edge_m: [tiles.edge_x_m as f32, tiles.edge_y_m as f32],
        half_joint_m: (tiles.joint_width_m / 2.0) as f32,
        joint_reach_m: (largest_offset_m + tiles.joint_width_m / 2.0) as f32,
        joint_albedo: tiles.joint_albedo as f32,
        pattern_contrast: tiles.pattern_contrast as f32,
        plain_albedo: PLAIN_ALBEDO,
        tiled: 1,
        pattern_seed: laid.pattern_seed,
        padding: 0,
    }
}

fn plain_material() -> MaterialUniform {
    MaterialUniform { edge_m: [1.0; 2], plain_albedo: PLAIN_ALBEDO, ..Zeroable::zeroed() }
}

/// Corner displacements and contrasts as floor.wgsl reads them.
fn corners_of(laid: &LaidTiles) -> Vec<[f32; 4]> {
    let [towards_j, towards_i] = &laid.contrast;
    laid.corner_offset_m
        .iter()
        .zip(towards_j.iter().zip(towards_i))
        .map(|(offset, (&along_j, &along_i))| [offset[0] as f32, offset[1] as f32, along_j, along_i])
        .collect()
}

fn rows_of(matrix: &Matrix3<f64>) -> [[f32; 4]; 3] {
    std::array::from_fn(|row| [matrix[(row, 0)] as f32, matrix[(row, 1)] as f32, matrix[(row, 2)] as f32, 0.0])
}

fn single(vector: Vector2<f64>) -> [f32; 2] {
    [vector.x as f32, vector.y as f32]
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    pattern: Pattern,
) -> wgpu::RenderPipeline {
    let constants = [("PATTERN", f64::from(pattern as u32))];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("floor"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("cover_view"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("floor_luminance"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            targets: &[Some(LUMINANCE_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn layout(device: &wgpu::Device, label: &str, buffers: &[wgpu::BufferBindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn bind(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

fn filled(graphics: &Graphics, usage: wgpu::BufferUsages, bytes: &[u8]) -> wgpu::Buffer {
    let buffer = graphics.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes.len() as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    graphics.queue.write_buffer(&buffer, 0, bytes);
    buffer
}
