//! The point camera as the localizer knows it, and the readings that it gives.

use interval::Interval;

use crate::reading::LandmarkId;

/// Name of the point camera as a device whose readings the method uses.
pub const DEVICE: &str = "point_camera";

/// Model of a point camera: a pinhole camera with a front end that tells where in the image it sees which landmark.
///
/// Frame `camera`: x to the right of the image, y down, z along the optical axis. A landmark at (x, y, z) is seen at u = cᵤ + f·x/z and
/// v = cᵥ + f·y/z, with the lens's distortion taken off. The nominal camera looks forward, tilted up about its own x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointCameraModel {
    /// Focal length in pixels (bound `point_camera.focal`).
    pub focal_px: Interval,
    /// Principal point, u and v (bound `point_camera.centre`).
    pub centre_px: [Interval; 2],
    /// Nominal upward tilt of the optical axis.
    pub tilt_up_rad: f64,
    /// Direction of the optical axis from robot forward, counter-clockwise (bound `point_camera.yaw`).
    pub yaw_rad: Interval,
    /// Greatest turn of the camera about any level axis from its nominal attitude (bound `point_camera.tilt`).
    pub tilt_rad: f64,
    /// Position of the optical centre in the robot frame: forward and left (bound `point_camera.position`).
    pub position_m: [Interval; 2],
    /// Height of the optical centre above the floor at rest (bound `point_camera.height`).
    pub height_m: Interval,
    /// Greatest error of an image point along u and along v (bound `point_camera.points`).
    pub error_px: f64,
    /// Least depth, along the optical axis, of a landmark that is seen (bound `point_camera.least_depth`).
    pub least_depth_m: f64,
    /// Greatest error of an image's stamp (bound `point_camera.stamp`).
    pub stamp_error_s: f64,
}

/// Image point of one landmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// The landmark that is seen.
    pub landmark: LandmarkId,
    /// Column u and row v in pixels.
    pub at_px: [f64; 2],
}

impl SeenPoint {
    /// Numbers that encode image points in a [`Reading::Other`](crate::Reading::Other): for each its landmark's number, u and v.
    pub fn numbers(points: &[SeenPoint]) -> Vec<f64> {
        points.iter().flat_map(|point| [f64::from(point.landmark.0), point.at_px[0], point.at_px[1]]).collect()
    }

    /// Image points that the numbers of a reading encode; `None` if they encode none, or one landmark twice.
    pub fn of(numbers: &[f64]) -> Option<Vec<SeenPoint>> {
        let point = |numbers: &[f64]| {
            let &[landmark, u, v] = numbers else { return None };
            let is_number = landmark.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&landmark);
            let is_told = is_number && u.is_finite() && v.is_finite();
            is_told.then_some(SeenPoint { landmark: LandmarkId(landmark as u32), at_px: [u, v] })
        };
        let points: Vec<SeenPoint> = numbers.chunks(3).map(point).collect::<Option<_>>()?;
        let mut landmarks: Vec<LandmarkId> = points.iter().map(|point| point.landmark).collect();
        landmarks.sort_unstable();
        landmarks.dedup();
        (landmarks.len() == points.len()).then_some(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_points_come_back_from_their_numbers_and_other_numbers_are_refused() {
        let points =
            [(7, [1.5, -2.0]), (0, [320.0, 240.0])].map(|(id, at_px)| SeenPoint { landmark: LandmarkId(id), at_px });
        assert_eq!(SeenPoint::of(&SeenPoint::numbers(&points)), Some(points.to_vec()));
        assert_eq!(SeenPoint::of(&[]), Some(Vec::new()));
        for refused in [&[1.0, 2.0][..], &[0.5, 1.0, 1.0], &[-1.0, 1.0, 1.0], &[5e9, 1.0, 1.0], &[1.0, f64::NAN, 1.0]] {
            assert_eq!(SeenPoint::of(refused), None, "{refused:?}");
        }
        assert_eq!(SeenPoint::of(&[1.0, 2.0, 3.0, 1.0, 4.0, 5.0]), None);
    }
}
