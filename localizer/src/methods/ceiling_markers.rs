//! `ceiling_markers`: a method that bounds the pose by dot-matrix markers on the ceiling, seen by a camera that looks up.
//!
//! The method follows Zhou et al., *A high precision visual localization sensor and its working methodology for an indoor mobile robot*
//! (2016). Where the paper solves for six degrees of freedom from three dots of one marker, here every dot of every marker bounds the
//! planar pose: the tilt of the body and of the mount, the lens, the mount's position and the ceiling's height are known within declared
//! intervals, and that is worth far more than what a marker's image, 35 pixels wide, tells about them (erratum I5 in the project's list of
//! the papers' errors). The paper's own method is in [`paper`].

mod group;
mod pairs;
pub mod paper;
mod pose_contractor;
mod ray;
mod relate;
mod rows;
#[cfg(test)]
#[allow(clippy::expect_used)]
mod trial;

use std::sync::Arc;

use interval::Interval;

use crate::{
    Map, Reading, RobotModel, bounds,
    bounds::Assumption,
    map::{MarkerMap, PlacedMarker},
    markers::{DOT_RADIUS_M, GridPlace, dot_in_marker_m},
    method::{Claim, Constraint, Context, Method, MotionBetween},
    motion::Twist,
    quota::Quota,
    reading::Camera,
    robot::CeilingCameraModel,
    vision::ceiling::{self, CeilingMarkers as Seen, CeilingView, Lens, PictureMotion, SeenMarker},
};

use super::lean::{heading_off_rad, twist_of_tipped_rad};
use pose_contractor::Markers;
use ray::{Optics, SeenDot};
use relate::Dots;
use rows::Rows;

/// Declared bounds that a constraint from ceiling markers relies on.
pub const RELIES_ON: [Assumption; 16] = [
    bounds::MARKERS_PLACEMENT,
    bounds::MARKERS_ROTATION,
    bounds::MARKERS_PRINT,
    bounds::MARKERS_HEIGHT,
    bounds::CEILING_CAMERA_FOCAL,
    bounds::CEILING_CAMERA_CENTRE,
    bounds::CEILING_CAMERA_DISTORTION,
    bounds::CEILING_CAMERA_HEIGHT,
    bounds::CEILING_CAMERA_POSITION,
    bounds::CEILING_CAMERA_YAW,
    bounds::CEILING_CAMERA_TILT,
    bounds::CEILING_CAMERA_STAMP,
    bounds::BODY_TILT,
    bounds::BODY_HEAVE,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];

pub use crate::vision::ceiling::marker::LEAST_RADIUS_PX;

/// Greatest number of markers of an image that are used. Those farthest from the middle of the picture are left out, because the number of
/// ways to choose which markers are wrong (not as the map says) grows quickly with the number of markers.
const MOST_MARKERS: usize = 8;

/// Method that bounds the pose by coded markers on the ceiling; the module's page says how.
#[derive(Clone, Debug)]
pub struct CeilingMarkers {
    map: MarkerMap,
    is_word: Vec<bool>,
    robot: RobotModel,
    camera: CeilingCameraModel,
    optics: Optics,
    view: CeilingView,
}

impl CeilingMarkers {
    /// Makes the ceiling-marker method for a robot and a map; `None` if the robot has no ceiling camera, the map has no markers, or a
    /// marker may be no higher than the camera.
    pub fn new(map: &Map, robot: &RobotModel) -> Option<Self> {
        let (camera, map) = (robot.ceiling_camera.clone()?, map.markers.clone()?);
        let height_m = map.markers.iter().fold(Interval::EMPTY, |hull, marker| hull.hull(marker.height_m));
        let distance_m = (height_m - camera.height_m).inflate(robot.body.heave_m);
        if distance_m.is_empty() || distance_m.lo() <= 0.0 {
            return None;
        }
        let lean_rad = camera.lean_rad[0].hypot(camera.lean_rad[1]) + camera.tilt_rad + robot.body.tilt_rad;
        let focal_px = 0.5 * (camera.focal_px[0].mid() + camera.focal_px[1].mid());
        let view =
            CeilingView::new(focal_px, [distance_m.lo(), distance_m.hi()], lean_rad.tan(), camera.electrons_per_grey)
                .behind(Lens {
                    distortion: camera.distortion,
                    focal_px: camera.focal_px.map(Interval::mid),
                    centre_px: camera.centre_px.map(Interval::mid),
                });
        Some(CeilingMarkers {
            is_word: map.coding.table(),
            optics: Optics::new(&camera, &robot.body),
            robot: robot.clone(),
            map,
            camera,
            view,
        })
    }

    /// Whether the dots of the lowest marker, seen straight above an upright camera, are large enough to be read: a radius of at least
    /// [`LEAST_RADIUS_PX`].
    pub fn resolves_dots(&self) -> bool {
        self.view.greatest_upright_radius_px() >= LEAST_RADIUS_PX
    }

    /// Constraint on the pose from the markers found in an image with the stamp `stamp_s`; `None` when none of the markers is on the map. `motion` is
    /// how the robot moved meanwhile, which counts where the camera has a rolling shutter.
    pub fn constraint(&self, stamp_s: f64, found: Seen, motion: MotionBetween) -> Option<Constraint> {
        let rows = Rows::of(&self.camera, &self.robot, stamp_s, motion);
        let Seen { markers, mut rejected_px } = found;
        let (mut dots, mut claims) = (Vec::new(), Vec::new());
        let mut related = Dots::new(&self.robot, self.map.placement_m, self.camera.stamp_error_s);
        for seen in self.unambiguous(&markers, &mut rejected_px) {
            let Some(placed) = self.map.markers.iter().find(|placed| placed.id == seen.id) else { continue };
            let sights: Option<Vec<SeenDot>> = seen
                .dots
                .iter()
                .map(|(place, dot)| {
                    let pixel = [dot.centre_px[0], dot.centre_px[1], dot.bound_px];
                    let sight = self.optics.sight(pixel, placed.height_m)?;
                    let dot = SeenDot { sight, in_world_m: self.dot_in_world_m(placed, *place) };
                    Some(rows.as_ref().map_or(dot, |rows| rows.at_stamp(&dot, pixel)))
                })
                .collect();
            if let Some(sights) = sights {
                let named: Vec<(GridPlace, SeenDot)> =
                    seen.dots.iter().map(|(place, _)| *place).zip(sights.iter().copied()).collect();
                related.add(*placed, &named, &self.optics, self.turn_rad());
                dots.push(sights);
            }
            let claimed =
                |(place, dot): &(GridPlace, ceiling::Dot)| (*place, [dot.centre_px[0], dot.centre_px[1], dot.bound_px]);
            claims.push(Claim::Marker { marker: seen.id, dots_px: seen.dots.iter().map(claimed).collect() });
        }
        let reach = &self.robot.reach;
        let stamp_s_error = self.camera.stamp_error_s;
        let stamp = [reach.speed_m_per_s * stamp_s_error, reach.turn_rate_rad_per_s * stamp_s_error];
        let alone = |dots: &Vec<SeenDot>| {
            Markers::new(std::slice::from_ref(dots), self.map.placement_m, self.camera.q_items, self.yaw_error(), stamp)
        };
        let seen_alone = dots.iter().zip(&claims).filter(|_| dots.len() > 1 && dots.len() == claims.len());
        let by_marker = seen_alone.filter_map(|(dots, claim)| match claim {
            Claim::Marker { marker, .. } => Some((*marker, Box::new(alone(dots)?) as Box<_>)),
            _ => None,
        });
        let by_marker = by_marker.collect();
        let on_pose = Markers::new(&dots, self.map.placement_m, self.camera.q_items, self.yaw_error(), stamp)?;
        Some(Constraint {
            by_marker,
            relies_on: RELIES_ON.to_vec(),
            claims,
            quota: Quota::of_each(self.camera.q_items),
            // Where a marker may not be as the map says, its rows may not hold.
            relations: (self.camera.q_items == 0).then(|| Arc::new(related) as _),
            rejected_px,
            ..Constraint::new(self.name(), stamp_s, on_pose)
        })
    }

    /// The markers read in an image of the ceiling camera; `None` for any other reading.
    pub fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let Reading::Camera { camera: Camera::Ceiling, exposure_s, image, .. } = reading else { return None };
        Some(ceiling::detect(image, &self.view, &self.is_word, &self.motion(twist, *exposure_s)))
    }

    /// Markers found in the image, sorted by their distance from its middle, without markers whose identity was seen twice; at most
    /// [`MOST_MARKERS`] of them, those nearest to the middle.
    fn unambiguous<'a>(&self, markers: &'a [SeenMarker], rejected_px: &mut Vec<[f64; 4]>) -> Vec<&'a SeenMarker> {
        let middle = self.camera.centre_px.map(Interval::mid);
        let distance = |marker: &SeenMarker| {
            let [u, v] = marker.centre_px();
            (u - middle[0]).hypot(v - middle[1])
        };
        let mut kept: Vec<&SeenMarker> = Vec::new();
        for marker in markers {
            if markers.iter().filter(|other| other.id == marker.id).count() == 1 {
                kept.push(marker);
            } else {
                let [u, v] = marker.centre_px();
                rejected_px.push([u, v, u, v]);
            }
        }
        kept.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        kept.truncate(MOST_MARKERS);
        kept
    }

    /// Interval of the world x and y of one dot of a marker. The error of the marker's placement on the ceiling is not included.
    fn dot_in_world_m(&self, placed: &PlacedMarker, place: GridPlace) -> [Interval; 2] {
        let [x, y] = dot_in_marker_m(place).map(Interval::point);
        let rotation = Interval::point(placed.rotation_rad);
        let (cos, sin) = (rotation.cos(), rotation.sin());
        let turned = [x * cos - y * sin, x * sin + y * cos];
        // If a marker is turned by a small angle, a dot moves along an arc. The straight distance that the dot moves is the arc's chord,
        // which is shorter, so that radius times angle bounds it.
        let slack_m = (x.hypot(y) * self.map.rotation_tolerance_rad + self.map.print_m).hi();
        [0, 1].map(|axis| (turned[axis] + placed.centre_m[axis]).inflate(slack_m))
    }

    /// Interval of the apparent heading minus the true heading, where the apparent heading is that by the camera's nominal mount. It holds
    /// the yaw error of the mount; the turn about the vertical that the mount's tilt error causes because it acts before the mount's known
    /// lean; and the difference between two definitions of a leaning body's heading.
    fn yaw_error(&self) -> Interval {
        let yaw = self.camera.yaw_rad - Interval::point(self.camera.yaw_rad.mid());
        yaw.inflate(self.turn_rad())
    }

    /// Greatest part of that which neither the heading nor the camera's yaw tells.
    fn turn_rad(&self) -> f64 {
        let [forward, left] = self.camera.lean_rad.map(Interval::point);
        let twist = Interval::point(twist_of_tipped_rad(self.camera.tilt_rad, forward.hypot(left).hi()));
        (twist + heading_off_rad(self.robot.body.tilt_rad)).hi()
    }

    /// Motion of the picture during an exposure: the ceiling's image shifts against the camera's velocity v + ω × m, with v the robot's
    /// velocity, ω its turn rate and m the camera's position on the robot, and turns against the turn rate ω.
    fn motion(&self, twist: &Twist, exposure_s: f64) -> PictureMotion {
        let [forward_m, left_m] = self.camera.position_m.map(Interval::mid);
        let speed = [twist.forward_m_per_s - twist.turn_rad_per_s * left_m, twist.turn_rad_per_s * forward_m];
        let (sin, cos) = self.camera.yaw_rad.mid().sin_cos();
        // Components of the camera's velocity along the image's forward direction (up in the image) and its left direction (right in the
        // image).
        let (ahead, aside) = (speed[0] * cos + speed[1] * sin, speed[1] * cos - speed[0] * sin);
        let pixels_per_m = 0.5 * (self.view.dot_radius_px[0] + self.view.dot_radius_px[1]) / DOT_RADIUS_M;
        PictureMotion {
            shift_px: [-aside * exposure_s * pixels_per_m, ahead * exposure_s * pixels_per_m],
            turn_rad: twist.turn_rad_per_s * exposure_s,
            about_px: self.camera.centre_px.map(Interval::mid),
        }
    }
}

impl Method for CeilingMarkers {
    fn name(&self) -> &'static str {
        "ceiling_markers"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Camera { camera: Camera::Ceiling, .. })
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let mut found = self.look(reading, context.twist)?;
        found.markers.retain(|marker| {
            let is_set_aside = context.set_aside.contains(&marker.id);
            let [u, v] = marker.centre_px();
            found.rejected_px.extend(is_set_aside.then_some([u, v, u, v]));
            !is_set_aside
        });
        self.constraint(reading.measured_s(), found, context.motion)
    }
}
