//! The part of a floor that a view sees: values for the whole picture, the faces of tiles, and the flat bands that lie over them (joints, wires,
//! tapes, coverings, walls).

use bytemuck::{Pod, Zeroable};
use nalgebra::{Isometry3, Matrix3, Vector2};

use super::{
    geometry::{self, BandInstance, Footprint, TileInstance},
    local::{self, LocalFrame},
};
use crate::{
    optics::Intrinsics,
    place::{building::GroundPlan, drawn::LaidTiles, light::FloorField},
    render::{
        FloorLight, RenderError, View,
        exposure::{MAX_SUB_FRAMES, Path, interpolate},
        lens::{LAMPLIGHT_PX, LensSlot},
    },
    scene::{Pattern, Region, Scene, Stray, Tiles},
    world::Drawn,
};

/// Number of stripes on a tile, by the scene's definition of the striped pattern: they are a fifth of the tile apart.
const STRIPES_IN_TILE: f64 = 5.0;

/// The floor of a world as the renderer knows it; from it the part is cut that a picture shows.
#[derive(Debug)]
pub(in crate::render) struct Floor {
    tiled: Option<(Tiles, LaidTiles)>,
    strays: Vec<Stray>,
    ground_plan: GroundPlan,
    light: FloorLight,
    /// Distribution over the floor of the light from the scene's lamps, if it has any.
    pub(in crate::render) lamplight: Option<FloorField>,
    coverings: Vec<Region>,
}

/// The part of a floor that one picture (view) shows, ready to be drawn.
pub(super) struct Cut {
    pub(super) uniform: ViewOnDevice,
    pub(super) faces: Vec<TileInstance>,
    /// Flat bands over the floor (joints, coverings, stray wires and tapes, walls), in the order in which they lie on each other.
    pub(super) bands: Vec<BandInstance>,
}

/// Rows of a 3 × 3 matrix, as `Homography` of view.wgsl.
type Rows = [[f32; 4]; 3];

/// Device layout of `View` of view.wgsl: the values that the shader needs for one picture of the floor.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct ViewOnDevice {
    start: Rows,
    middle: Rows,
    end: Rows,
    clip_from_local: Rows,
    principal_point_px: [f32; 2],
    sub_frames: u32,
    pattern_samples: u32,
    light_gradient: [f32; 2],
    light_at_origin: f32,
    pattern_contrast: f32,
    stripe_spacing_m: f32,
    exposed_share: f32,
    plate_size_px: [f32; 2],
    distortion: [f32; 4],
    distortion_k3: f32,
    per_focal_px: f32,
    first_share: f32,
    share_per_slope: f32,
    sub_frame_ends: [Rows; MAX_SUB_FRAMES + 1],
}

impl Floor {
    /// The floor of a scene as it was truly laid, for the renderer.
    pub(in crate::render) fn new(scene: &Scene, drawn: &Drawn, lamplight: Option<FloorField>) -> Floor {
        Floor {
            tiled: scene.floor.tiles.clone().zip(drawn.place.tiles.clone()),
            strays: scene.floor.strays.clone(),
            ground_plan: GroundPlan::of(scene),
            light: FloorLight::new(&scene.light, &scene.room),
            lamplight,
            coverings: scene.floor.regions.iter().filter(|region| region.covering.is_some()).cloned().collect(),
        }
    }

    /// Pattern of the floor's tiles; the plain pattern if the floor has no tiles.
    pub(super) fn pattern(&self) -> Pattern {
        self.tiled.as_ref().map_or(Pattern::Plain, |(tiles, _)| tiles.pattern)
    }

    /// Cuts out the part of the floor that a picture (view) shows.
    pub(super) fn cut(&self, view: &View, seen_by: &LensSlot) -> Result<Cut, RenderError> {
        if view.lens.focal_px[0] != view.lens.focal_px[1] {
            return Err(RenderError::BadView("the floor from near is drawn for lenses of one focal length"));
        }
        let plate = seen_by.pinhole();
        let path = Path::new(&plate, view).ok_or(RenderError::BadView("it has no camera pose"))?;
        let frame = LocalFrame::near(path.middle.translation.vector.xy(), self.tiled.as_ref());
        let seen = self.footprint(&plate, &path, &frame);
        let (faces, mut bands) = match &self.tiled {
            Some((tiles, laid)) => geometry::tiles_in_view(tiles, laid, &frame, &seen),
            None => (vec![geometry::plain_face(&seen)], Vec::new()),
        };
        bands.extend(geometry::coverings_in_view(&self.coverings, &frame, &seen));
        bands.extend(geometry::strays_in_view(&self.strays, &frame, &seen));
        bands.extend(geometry::walls_in_view(&self.ground_plan, &path.middle, &frame, &seen));
        Ok(Cut { uniform: self.uniform((view, &plate), &path, &frame)?, faces, bands })
    }

    /// Light of the scene's lamps at the floor points that a picture shows in the middle of the exposure of their row, per lux of the mean. It is
    /// given in [`LAMPLIGHT_PX`] rows of as many places, evenly spaced from the image's first pixel to its last in both directions; `None`
    /// without lamps.
    pub(in crate::render) fn lamplight_over(&self, view: &View, seen_by: &LensSlot) -> Option<Vec<f32>> {
        let field = self.lamplight.as_ref()?;
        let (plate, lens) = (seen_by.pinhole(), &view.lens);
        let exposed_share = Path::new(&plate, view)?.exposed_share;
        let last = f64::from(LAMPLIGHT_PX - 1);
        let share = |i: u32, j: u32| {
            let [u, v] = [(i, 0), (j, 1)].map(|(at, axis)| f64::from(at) / last * f64::from(plate.size_px[axis] - 1));
            let ray = plate.ray([u, v]);
            let row_share = lens.pixel([ray.x, ray.y])[1] / f64::from(lens.size_px[1] - 1);
            let middle_share = (1.0 - exposed_share) * row_share.clamp(0.0, 1.0) + 0.5 * exposed_share;
            let pose = interpolate(&view.world_from_camera, middle_share)?;
            Some(plate.floor_point(&pose, [u, v]).map_or(0.0, |point| field.at(point.coords.xy()) as f32))
        };
        (0..LAMPLIGHT_PX).flat_map(|j| (0..LAMPLIGHT_PX).map(move |i| (i, j))).map(|(i, j)| share(i, j)).collect()
    }

    fn uniform(
        &self,
        (view, plate): (&View, &Intrinsics),
        path: &Path,
        frame: &LocalFrame,
    ) -> Result<ViewOnDevice, RenderError> {
        let local_from_pixel = |pose: &Isometry3<f64>| frame.local_from_pixel(pose, plate.focal_px);
        let middle = local_from_pixel(&path.middle);
        let clip_from_local =
            local::clip_from_local(&middle, plate).ok_or(RenderError::BadView("the camera lies in the floor"))?;
        let mut sub_frame_ends = [[[0.0; 4]; 3]; MAX_SUB_FRAMES + 1];
        for (rows, pose) in sub_frame_ends.iter_mut().zip(&path.sub_frame_ends) {
            *rows = rows_of(&local_from_pixel(pose));
        }
        let origin_in_world = frame.grid_from_world.inverse() * frame.origin_in_grid;
        // Where the scene has lamps, the unevenness of their light is laid over the whole picture later, so that the light is even here.
        let (factor, gradient_per_m) = match &self.lamplight {
            None => (self.light.factor_at(origin_in_world), self.light.gradient_per_m),
            Some(_) => (1.0, Vector2::zeros()),
        };
        let gradient = frame.grid_from_world * gradient_per_m;
        // A matt surface of albedo 1 under the illuminance E has the luminance E/π.
        let light_at_origin = view.illuminance_at_floor_lux * factor / std::f64::consts::PI;
        let [cu, cv] = plate.principal_point_px;
        let [k1, k2, p1, p2, k3] = view.lens.distortion.map(|coefficient| coefficient as f32);
        // Delay from the start of one row's exposure to the start of the next row's, as a share of the time from the first row's start to the
        // last row's end: that time less the exposure of one row, spread over all rows.
        let share_per_row = (1.0 - path.exposed_share) / f64::from(view.lens.size_px[1] - 1);
        let tiles = self.tiled.as_ref().map(|(tiles, _)| tiles);
        Ok(ViewOnDevice {
            start: sub_frame_ends[0],
            middle: rows_of(&middle),
            end: sub_frame_ends[path.sub_frame_ends.len() - 1],
            clip_from_local: rows_of(&clip_from_local.transpose()),
            principal_point_px: [cu as f32, cv as f32],
            sub_frames: (path.sub_frame_ends.len() - 1) as u32,
            pattern_samples: path.pattern_samples,
            light_gradient: [gradient.x as f32, gradient.y as f32],
            light_at_origin: light_at_origin as f32,
            pattern_contrast: tiles.map_or(0.0, |tiles| tiles.pattern_contrast as f32),
            stripe_spacing_m: tiles.map_or(1.0, |tiles| (tiles.edge_x_m / STRIPES_IN_TILE) as f32),
            exposed_share: path.exposed_share as f32,
            plate_size_px: plate.size_px.map(|size_px| size_px as f32),
            distortion: [k1, k2, p1, p2],
            distortion_k3: k3,
            per_focal_px: (1.0 / plate.focal_px) as f32,
            first_share: (share_per_row * view.lens.principal_point_px[1]) as f32,
            share_per_slope: (share_per_row * view.lens.focal_px[1]) as f32,
            sub_frame_ends,
        })
    }

    /// The part of the floor that the camera sees during its exposure. A camera that sees above the horizon is taken to see the whole floor.
    fn footprint(&self, plate: &Intrinsics, path: &Path, frame: &LocalFrame) -> Footprint {
        let [width, height] = plate.size_px.map(|size| f64::from(size) - 0.5);
        let pixels = [[-0.5, -0.5], [width, -0.5], [-0.5, height], [width, height]];
        let at = |pose, pixel: [f64; 2]| plate.floor_point(pose, pixel).map(|point| frame.place(point.coords.xy()));
        let mut seen = Footprint {
            low: Vector2::repeat(f64::INFINITY),
            high: Vector2::repeat(f64::NEG_INFINITY),
            pixel_m: 0.0,
            motion_m: Vector2::zeros(),
        };
        for pixel in pixels {
            let beside = [pixel[0] + 1.0, pixel[1] + 1.0];
            let (Some(place), Some(next)) = (at(&path.middle, pixel), at(&path.middle, beside)) else {
                return self.whole_floor(frame);
            };
            // The diagonal of a pixel on the floor, and half as much again for the margin in which the edges of drawn faces and bands fade out.
            seen.pixel_m = seen.pixel_m.max(1.5 * (next - place).norm());
            for pose in &path.sub_frame_ends {
                let Some(moved) = at(pose, pixel) else {
                    return self.whole_floor(frame);
                };
                seen.low = seen.low.inf(&moved);
                seen.high = seen.high.sup(&moved);
                seen.motion_m = seen.motion_m.sup(&(moved - place).abs());
            }
        }
        seen
    }

    fn whole_floor(&self, frame: &LocalFrame) -> Footprint {
        let [[x0_m, y0_m], [x1_m, y1_m]] = self.ground_plan.extents_m();
        let corners = [[x0_m, y0_m], [x1_m, y0_m], [x0_m, y1_m], [x1_m, y1_m]].map(|corner| frame.place(corner.into()));
        Footprint {
            low: corners.iter().fold(corners[0], |low, corner| low.inf(corner)),
            high: corners.iter().fold(corners[0], |high, corner| high.sup(corner)),
            pixel_m: (x1_m - x0_m).max(y1_m - y0_m) / 100.0,
            motion_m: Vector2::zeros(),
        }
    }
}

fn rows_of(matrix: &Matrix3<f64>) -> Rows {
    std::array::from_fn(|row| [matrix[(row, 0)] as f32, matrix[(row, 1)] as f32, matrix[(row, 2)] as f32, 0.0])
}
