//! The pose from the dots of the ceiling's markers: the planar least-squares fit of all dots in a picture, with the covariance that the declared
//! bounds give it.

use interval::Interval;
use localizer::{
    Map, Reading, RobotModel,
    baselines::{dot_pairs, least_squares},
    map::{MarkerMap, PlacedMarker},
    methods::ceiling_markers::CeilingMarkers,
    motion::Twist,
    robot::{BodyModel, CeilingCameraModel},
    vision::ceiling::SeenMarker,
};
use nalgebra::{Matrix3, Vector2, Vector3};

use super::{Mount, SIGMAS_OF_BOUND, Seen, since_stamp, stray};

/// Markers of the ceiling as the camera that looks up sees them.
pub(crate) struct Ceiling {
    method: CeilingMarkers,
    map: MarkerMap,
    camera: CeilingCameraModel,
    body: BodyModel,
}

/// Pairs of the places of a marker's dots in the world and in the robot frame, with the marker's middle and the standard deviation of a dot.
struct Marker {
    pairs: Vec<([f64; 2], [f64; 2])>,
    centre_m: Vector2<f64>,
    sigma_m: f64,
}

/// Greatest root mean square distance of a marker's dots from their places by the pose of all markers, over what they may be off by: beyond it, the
/// marker is not where the map says.
const MOST_MISFIT: f64 = 5.0;

impl Ceiling {
    pub(crate) fn new(map: &Map, robot: &RobotModel) -> Option<Ceiling> {
        Some(Ceiling {
            method: CeilingMarkers::new(map, robot)?,
            map: map.markers.clone()?,
            camera: robot.ceiling_camera.clone()?,
            body: robot.body,
        })
    }

    /// Position and yaw of the camera, and what moves the picture of a ceiling at one height like a wrong position: the tilt of its mount and a wrong
    /// principal point.
    pub(crate) fn mount(&self) -> Mount {
        let camera = &self.camera;
        let tilted_m = camera.tilt_rad * self.up_m();
        let off_m = |axis: usize| 0.5 * camera.centre_px[axis].width() * self.up_m() / camera.focal_px[axis].mid();
        let seen_off_m = tilted_m.hypot(off_m(0).max(off_m(1)));
        let along = |axis: usize| SIGMAS_OF_BOUND * (0.5 * camera.position_m[axis].width()).hypot(seen_off_m);
        Mount { sigma: [along(0), along(1), SIGMAS_OF_BOUND * 0.5 * self.camera.yaw_rad.width()] }
    }

    pub(crate) fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let found = self.method.look(reading, twist)?.markers;
        let is_once = |marker: &&SeenMarker| found.iter().filter(|other| other.id == marker.id).count() == 1;
        let mut markers: Vec<Marker> =
            found.iter().filter(is_once).filter_map(|marker| self.marker(marker, twist)).collect();
        let pose = self.fit(&mut markers)?;
        Some(Seen::Pose { pose: pose.into(), covariance: self.covariance(&markers, &pose, twist) })
    }

    /// Height of the markers above the camera.
    fn up_m(&self) -> f64 {
        let heights = self.map.markers.iter().fold(Interval::EMPTY, |hull, marker| hull.hull(marker.height_m));
        heights.mid() - self.camera.height_m.mid()
    }

    fn marker(&self, seen: &SeenMarker, twist: &Twist) -> Option<Marker> {
        let placed: &PlacedMarker = self.map.markers.iter().find(|placed| placed.id == seen.id)?;
        let dots: Vec<_> = seen.dots.iter().map(|(place, dot)| (*place, dot.centre_px)).collect();
        let bound_px = seen.dots.iter().map(|(_, dot)| dot.bound_px).sum::<f64>() / seen.dots.len() as f64;
        let sigma_m =
            SIGMAS_OF_BOUND * (bound_px * self.up_m() / self.camera.focal_px[0].mid()).hypot(self.map.print_m);
        let mut pairs = dot_pairs(&dots, placed, &self.camera)?;
        // Each dot is where the robot sees it when its row is exposed.
        for ((_, in_robot_m), (_, [_, v])) in pairs.iter_mut().zip(&dots) {
            let [ahead_m, left_m, turn_rad] = since_stamp(twist, (self.camera.row_time_s, self.camera.height_px), *v);
            let [x, y] = super::turned(*in_robot_m, turn_rad);
            *in_robot_m = [ahead_m + x, left_m + y];
        }
        Some(Marker { pairs, centre_m: placed.centre_m.into(), sigma_m })
    }

    /// Pose by all markers; a marker that does not fit is left out of the list.
    fn fit(&self, markers: &mut Vec<Marker>) -> Option<Vector3<f64>> {
        loop {
            let pairs: Vec<_> = markers.iter().flat_map(|marker| marker.pairs.iter().copied()).collect();
            let pose = least_squares(&pairs)?;
            let off = |marker: &Marker| {
                let squares = marker.pairs.iter().map(|(world, robot)| {
                    let at = super::turned(*robot, pose.heading_rad);
                    (at[0] + pose.x_m - world[0]).powi(2) + (at[1] + pose.y_m - world[1]).powi(2)
                });
                let rms_m = (squares.sum::<f64>() / marker.pairs.len() as f64).sqrt();
                rms_m / marker.sigma_m.hypot(SIGMAS_OF_BOUND * self.map.placement_m)
            };
            let worst =
                (0..markers.len()).max_by(|one, other| off(&markers[*one]).total_cmp(&off(&markers[*other])))?;
            if off(&markers[worst]) <= MOST_MISFIT {
                return Some(Vector3::new(pose.x_m, pose.y_m, pose.heading_rad));
            }
            markers.remove(worst);
        }
    }

    /// Covariance of the fitted pose.
    ///
    /// With r the places of the dots about their centroid and S = Σ|r|², an error e of a dot turns the pose by r × e / S and moves the centroid by
    /// e/n. Dots are off each by itself; all dots of a marker are off alike by its placement, and turned alike about its middle. The body's tilt
    /// moves all that is seen alike, and so does the motion within the error of the stamp.
    fn covariance(&self, markers: &[Marker], pose: &Vector3<f64>, twist: &Twist) -> Matrix3<f64> {
        let n_dots = markers.iter().map(|marker| marker.pairs.len()).sum::<usize>() as f64;
        let places = |marker: &Marker| marker.pairs.iter().map(|(world, _)| Vector2::from(*world)).collect::<Vec<_>>();
        let centroid: Vector2<f64> =
            markers.iter().flat_map(places).fold(Vector2::zeros(), |sum, place| sum + place) / n_dots;
        let square_m2: f64 = markers.iter().flat_map(places).map(|place| (place - centroid).norm_squared()).sum();
        let [stray_m, stray_rad] = stray(twist, self.camera.stamp_error_s);
        let placed_m = SIGMAS_OF_BOUND * self.map.placement_m;
        let rotated_rad = SIGMAS_OF_BOUND * self.map.rotation_tolerance_rad;
        let tilted_m = SIGMAS_OF_BOUND * self.body.tilt_rad * (self.up_m() + self.camera.height_m.mid());
        let lens_m = SIGMAS_OF_BOUND * self.camera.distortion_px * self.up_m() / self.camera.focal_px[0].mid();
        let mut along_m2 = tilted_m.powi(2) + lens_m.powi(2) + stray_m.powi(2);
        let mut turn_rad2 = stray_rad.powi(2);
        for marker in markers {
            let places = places(marker);
            let n_of_marker = places.len() as f64;
            let sum: Vector2<f64> = places.iter().map(|place| place - centroid).sum();
            let turning: f64 =
                places.iter().map(|place| (place - centroid).dot(&(place - marker.centre_m))).sum::<f64>() / square_m2;
            let squares: f64 = places.iter().map(|place| (place - centroid).norm_squared()).sum();
            turn_rad2 += squares * (marker.sigma_m / square_m2).powi(2);
            turn_rad2 += sum.norm_squared() * (placed_m / square_m2).powi(2) + (turning * rotated_rad).powi(2);
            along_m2 += n_of_marker * (marker.sigma_m / n_dots).powi(2) + (n_of_marker / n_dots * placed_m).powi(2);
        }
        // A turn about the centroid moves the robot, which is away from it.
        let arm = Vector2::new(-(pose.y - centroid.y), pose.x - centroid.x);
        let turn = Vector3::new(arm.x, arm.y, 1.0);
        Matrix3::from_diagonal(&Vector3::new(along_m2, along_m2, 0.0)) + turn * turn.transpose() * turn_rad2
    }
}
