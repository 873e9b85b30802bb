//! `floor_tiles`: a method that bounds the pose by the joints of a tiled floor, seen by a camera that looks straight down.
//!
//! The method follows Lv, Kang and Qin, *FVO: floor vision aided odometry* (2019), in a form without quadrants. Let the pose have the
//! position P and the heading θ, and the camera the position a in the robot frame. A joint whose image has its normal at the angle ψ (robot
//! frame, counter-clockwise from forward) and the distance ρ from the camera belongs to the family k with θ + ψ = k·π/2 + γ, and it implies
//! for the pose n(k·π/2 + γ)·P ∈ ±(E·ℤ + phase) − n(ψ)·a − ρ. Here n is the unit vector at an angle, γ the angle of the tile grid in the
//! world, E the distance between joints, phase the grid coordinate of joint 0, and ℤ the whole numbers. Each grid axis is contracted on its
//! own. Which tile the robot is on and in which quadrant its heading lies stay open as a union of branches, each a box of poses. Joints end
//! at the walls: a branch from which most points of a line would lie outside the room is dropped.
//!
//! All of this holds for the picture of a pinhole with a global shutter. The distortion of the lens is taken out of the image before lines
//! are looked for, and the errors that lens and row-by-row exposure leave widen the bounds of the lines' points.

mod floor_point;
mod joint;
mod normals;
mod optics;
mod pose_contractor;
mod relate;
#[cfg(test)]
mod trial;

use std::sync::Arc;

use interval::Interval;

use crate::{
    Map, PoseUnion, Reading, RobotModel, bounds,
    bounds::Assumption,
    method::{Claim, Constraint, Context, Method},
    motion::Twist,
    quota::Quota,
    reading::Camera,
    vision::{self, FloorLines, FloorView, line_fit, straighten::RowMotion},
};

use joint::Joint;
use optics::Optics;
use pose_contractor::TileJoints;
use relate::Joints;

/// Declared bounds that a constraint from floor joints relies on.
pub const RELIES_ON: [Assumption; 14] = [
    bounds::FLOOR_TILES_LAYING,
    bounds::FLOOR_TILES_LAYING_ANGLE,
    bounds::FLOOR_TILES_STRAIGHTNESS,
    bounds::FLOOR_CAMERA_SCALE,
    bounds::FLOOR_CAMERA_POSITION,
    bounds::FLOOR_CAMERA_YAW,
    bounds::FLOOR_CAMERA_TILT,
    bounds::FLOOR_CAMERA_DISTORTION,
    bounds::FLOOR_CAMERA_STAMP,
    bounds::BODY_TILT,
    bounds::BODY_HEAVE,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
    bounds::ROOM_WALLS,
];

/// Chain of image operations that finds joints between tiles in an image of the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Chain {
    /// The project's own chain to find joints: points on dark or light ridges of the image, one vote of these points for the lines of both
    /// families of joints, and matched filters across each line.
    #[default]
    Direct,
    /// The chain of Lv, Kang and Qin (2019) to find joints: deconvolution, Canny, skeleton, pruning, Hough, clustering.
    Paper,
}

/// Method that bounds the pose by floor joints; the module's page says how.
#[derive(Clone, Debug)]
pub struct FloorTiles {
    geometry: Arc<Geometry>,
    optics: Optics,
    view: FloorView,
    chain: Chain,
}

/// Declared geometry of robot, camera, tile grid and room, by which a line in a floor image becomes a statement about the robot's pose.
#[derive(Clone, Debug)]
struct Geometry {
    robot: RobotModel,
    camera: crate::robot::FloorCameraModel,
    grid: crate::map::TileGrid,
    room_m: [Interval; 2],
}

impl Geometry {
    /// Middle of the floor camera's picture in pixels, which is taken as the principal point.
    fn principal_point_px(&self) -> [f64; 2] {
        [self.camera.width_px, self.camera.height_px].map(|size_px| (f64::from(size_px) - 1.0) / 2.0)
    }

    /// Position of a pixel of the pinhole's picture in the camera frame: forward and left of the principal point, in pixels.
    ///
    /// Image up is forward, image right is right: forward = v₀ − v, left = u₀ − u.
    fn in_camera_px(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [middle_u, middle_v] = self.principal_point_px();
        [middle_v - v, middle_u - u]
    }
}

impl FloorTiles {
    /// Makes the floor-tile method for a robot and a map; `None` if the robot has no floor camera or the map no tiled floor.
    pub fn new(map: &Map, robot: &RobotModel, chain: Chain) -> Option<Self> {
        let (camera, grid) = (robot.floor_camera.clone()?, map.tiles.clone()?);
        let scale = camera.pixels_per_m.mid();
        let view = FloorView {
            pixels_per_m: scale,
            edge_px: grid.edge_m.map(|edge_m| edge_m * scale),
            joint_width_px: grid.joint_width_m * scale,
            q_items: camera.q_items,
        };
        let optics = Optics::of(&camera);
        let geometry = Arc::new(Geometry { robot: robot.clone(), camera, grid, room_m: map.room_m });
        Some(FloorTiles { geometry, optics, view, chain })
    }

    /// Constraint on the pose from the lines found in an image with the stamp `stamp_s`; `None` when no line is left.
    ///
    /// The lines' points are given in pixels of a pinhole's picture: each where a pinhole camera would show it at the instant at which the
    /// row of the raw image that shows the point is exposed.
    pub fn constraint(&self, stamp_s: f64, found: FloorLines, prior: &PoseUnion) -> Option<Constraint> {
        let FloorLines { lines, mut rejected_px } = found;
        let straightness_px = self.geometry.grid.straightness_m * self.geometry.camera.pixels_per_m.hi();
        let mut related = Joints::new(&self.geometry);
        let mut joints = Vec::new();
        let mut claims = Vec::new();
        for line in lines {
            let mut points = line.points_px.clone();
            let open_px = self.optics.left_open_px(&line.points_px, line.share_wrong, &self.geometry);
            // If the declared errors of lens and row-by-row exposure may put a point of a line anywhere, the line says nothing about the
            // pose.
            let Some(open_px) = open_px else { continue };
            points.iter_mut().zip(&open_px).for_each(|(point, open_px)| point[2] += straightness_px + open_px);
            let most_open_px = open_px.into_iter().fold(0.0, f64::max);
            let set = line_fit::enclose(&points, line.share_wrong);
            let Some(set) = set else { continue };
            let Some(joint) = Joint::new(set.clone(), &line, most_open_px, &self.geometry) else { continue };
            // Eq. (20) of the paper (Lv, Kang and Qin 2019) drops a line that no heading of the odometric prior explains. Lines of the
            // project's own chain are already known to be orthogonal and at the tiles' pitch, so that a line which contradicts the prior is
            // evidence against the prior and is kept.
            if self.chain == Chain::Paper && !joint.agrees(prior, &self.geometry) {
                rejected_px.push(ends(&line.points_px));
                continue;
            }
            let Some(points_px) = self.optics.as_taken(line.points_px, line.share_wrong) else { continue };
            related.add(&joint, set, &points);
            joints.push(joint);
            claims.push(Claim::FloorJoint { points_px, share_wrong: line.share_wrong });
        }
        if joints.is_empty() {
            return None;
        }
        let on_pose = TileJoints::new(joints, self.geometry.clone(), self.view.q_items);
        Some(Constraint {
            relies_on: RELIES_ON.to_vec(),
            claims,
            quota: Quota::of_each(self.view.q_items),
            rejected_px: rejected_px.into_iter().map(|segment| self.optics.segment_as_taken(segment)).collect(),
            // Parallel joints between tiles leave the position along them open, but the joints in the many images during a doubt about a
            // failed assumption do not. So every image counts as evidence to end the doubt.
            decides: true,
            // Where a line may be no joint, its rows may not hold.
            relations: (self.view.q_items == 0).then(|| Arc::new(related) as _),
            ..Constraint::new(self.name(), stamp_s, on_pose)
        })
    }

    /// The joints seen in an image of the floor camera, in pixels of a pinhole's picture; `None` for any other reading.
    pub fn look(&self, reading: &Reading, twist: &Twist) -> Option<FloorLines> {
        let Reading::Camera { camera: Camera::Floor, exposure_s, image, .. } = reading else { return None };
        let (blur_px, turn_rad) = (self.blur_px(twist, *exposure_s), twist.turn_rad_per_s * exposure_s);
        let chain = match self.chain {
            Chain::Direct => vision::direct::detect,
            Chain::Paper => vision::paper::detect,
        };
        let row_time_s = self.geometry.camera.row_time_s;
        let rows = RowMotion { shift_px: self.blur_px(twist, row_time_s), turn_rad: twist.turn_rad_per_s * row_time_s };
        Some(self.optics.look(image, rows, |picture| chain(picture, &self.view, blur_px, turn_rad)))
    }

    /// Motion of the picture at its centre during an exposure, or any other time, in pixels right and down.
    ///
    /// The floor passes under the camera against the camera's own velocity (v − ω·a_l, ω·a_f), forward and left, with v the robot's speed,
    /// ω its turn rate and the camera at a_f forward and a_l left of the robot origin; image up is forward, image right is right.
    fn blur_px(&self, twist: &Twist, exposure_s: f64) -> [f64; 2] {
        let [forward_m, left_m] = self.geometry.camera.position_m.map(Interval::mid);
        let speed = [twist.forward_m_per_s - twist.turn_rad_per_s * left_m, twist.turn_rad_per_s * forward_m];
        [speed[1] * exposure_s * self.view.pixels_per_m, speed[0] * exposure_s * self.view.pixels_per_m]
    }
}

impl Method for FloorTiles {
    fn name(&self) -> &'static str {
        "floor_tiles"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Camera { camera: Camera::Floor, .. })
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let lines = self.look(reading, context.twist)?;
        self.constraint(reading.measured_s(), lines, context.prior)
    }
}

/// First and last point of a line in the image, as a segment.
fn ends(points_px: &[[f64; 3]]) -> [f64; 4] {
    match (points_px.first(), points_px.last()) {
        (Some(first), Some(last)) => [first[0], first[1], last[0], last[1]],
        _ => [0.0; 4],
    }
}
