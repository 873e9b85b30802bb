//! What the robot knows of itself: nominal dimensions as intervals, and the declared bounds of its errors.
//!
//! Frame `robot`: x forward, y left, z up; its origin is the middle of the wheel axle, projected on the floor at rest.

use interval::Interval;

/// Everything the localizer is told about the robot; the drawn true values stay with the simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Both drive wheels and their encoders.
    pub wheels: WheelModel,
    /// What no motion of the robot exceeds, whatever the wheels say.
    pub reach: Reach,
    /// How far the body leaves its posture at rest.
    pub body: BodyModel,
    /// The camera that looks straight down at the floor, if there is one.
    pub floor_camera: Option<FloorCameraModel>,
    /// The camera that looks ahead, if there is one.
    pub forward_camera: Option<ForwardCameraModel>,
    /// The gyroscope about the vertical, if there is one.
    pub gyro: Option<GyroModel>,
    /// The optical flow sensor, if there is one.
    pub flow: Option<FlowModel>,
    /// The camera that looks up at the ceiling's markers, if there is one.
    pub ceiling_camera: Option<CeilingCameraModel>,
    /// The range camera that measures coded landmarks, if there is one.
    pub range_camera: Option<RangeCameraModel>,
}

/// Drive wheels, encoders and the displacement bounds of slip.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelModel {
    /// Rolling radius of the left and of the right wheel.
    pub radius_m: [Interval; 2],
    /// Distance between the two contact points.
    pub track_m: Interval,
    /// Encoder ticks in one turn of a wheel.
    pub ticks_per_turn: f64,
    /// `|true travel − rolled| ≤ slip_ratio·|rolled| + slip_floor_m` over any window of `slip_window_s`, per wheel.
    pub slip_ratio: f64,
    /// Additive part of the slip bound, once per started window.
    pub slip_floor_m: f64,
    /// `|lateral travel of the axle middle| ≤ side_slip_ratio·|rolled| + side_slip_floor_m`, same window.
    pub side_slip_ratio: f64,
    /// Additive part of the side-slip bound, once per started window.
    pub side_slip_floor_m: f64,
    /// Length of the window over which the two bounds hold.
    pub slip_window_s: f64,
}

/// Physical limits of any motion, pushes included: declared generously, they hold when the wheels lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Greatest speed of the axle middle over the floor.
    pub speed_m_per_s: f64,
    /// Greatest turn rate.
    pub turn_rate_rad_per_s: f64,
    /// Greatest acceleration of a wheel's travel while the wheel bounds hold.
    pub acceleration_m_per_s2: f64,
}

/// Posture of the body over the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyModel {
    /// Greatest angle between the body's vertical and the floor's, `body.tilt`.
    pub tilt_rad: f64,
    /// Greatest rise or sink of the robot origin from its height at rest, `body.heave`.
    pub heave_m: f64,
    /// Radius of the body about the robot origin: the origin keeps at least this distance from every wall.
    pub clearance_m: f64,
}

/// A camera that looks straight down. Image up is robot forward, image right is robot right.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorCameraModel {
    /// Image width.
    pub width_px: u32,
    /// Image height.
    pub height_px: u32,
    /// Focal length over height: pixels per metre on the floor at rest, in the picture of a pinhole, `floor_camera.scale`.
    pub pixels_per_m: Interval,
    /// Height of the optical centre above the floor.
    pub height_m: f64,
    /// Brown and Conrady's k1, k2, p1, p2, k3, as calibrated, for coordinates in focal lengths from the middle of the image.
    pub distortion: [f64; 5],
    /// Greatest distance between a pixel and where the lens model puts it, `floor_camera.distortion`.
    pub distortion_px: f64,
    /// From the start of one row's exposure to that of the next; an image's stamp is mid-exposure of row (height − 1)/2. 0 for a
    /// global shutter.
    pub row_time_s: f64,
    /// Optical centre in the robot frame: forward and left, `floor_camera.position`.
    pub position_m: [Interval; 2],
    /// Rotation of the image about the vertical, counter-clockwise seen from above, `floor_camera.yaw`.
    pub yaw_rad: Interval,
    /// Greatest angle between the optical axis and the body's vertical, `floor_camera.tilt`.
    pub tilt_rad: f64,
    /// Greatest error of an image's stamp, `floor_camera.stamp`.
    pub stamp_error_s: f64,
    /// At most this many wrong lines in one image, `floor_tiles.q_items`.
    pub q_items: usize,
}

/// A camera that looks up at the ceiling, with an infrared ring around its lens.
///
/// With yaw and lean 0, image up is robot forward and image right is robot left (it looks up). `body_from_camera` is the rotation by the
/// yaw about the vertical, times that by the unknown tilt error, times that by the lean, times that posture.
#[derive(Clone, Debug, PartialEq)]
pub struct CeilingCameraModel {
    /// Image width.
    pub width_px: u32,
    /// Image height.
    pub height_px: u32,
    /// Focal lengths along u and v, `ceiling_camera.focal`.
    pub focal_px: [Interval; 2],
    /// Principal point, `ceiling_camera.centre`.
    pub centre_px: [Interval; 2],
    /// Brown's coefficients k1, k2, p1, p2 of the lens, for coordinates in focal lengths.
    pub distortion: [f64; 5],
    /// Greatest distance between a pixel and where the lens model puts it, `ceiling_camera.distortion`.
    pub distortion_px: f64,
    /// Optical centre above the floor at rest, `ceiling_camera.height`.
    pub height_m: Interval,
    /// Optical centre in the robot frame: forward and left, `ceiling_camera.position`.
    pub position_m: [Interval; 2],
    /// Rotation of the image about the vertical, counter-clockwise seen from above, `ceiling_camera.yaw`.
    pub yaw_rad: Interval,
    /// Nominal angles by which the optical axis leans from the body's vertical, seen at yaw 0: towards forward and towards left. They are the
    /// components of one rotation about a horizontal axis.
    pub lean_rad: [f64; 2],
    /// Greatest angle between the optical axis and its nominal direction, `ceiling_camera.tilt`.
    pub tilt_rad: f64,
    /// Greatest error of an image's stamp, `ceiling_camera.stamp`.
    pub stamp_error_s: f64,
    /// Photoelectrons of one step of grey level, at least: how noisy bright pixels are.
    pub electrons_per_grey: f64,
    /// At most this many markers of one image are not what the map says, `ceiling_markers.q_items`.
    pub q_items: usize,
}

/// A gyroscope about the vertical: `rate read = scale·true rate + bias + noise`, each within its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroModel {
    /// At any time, `gyro.bias`.
    pub bias_rad_per_s: Interval,
    /// Constant over a run, `gyro.scale`.
    pub scale: Interval,
    /// Greatest noise of one reading, quantisation included, `gyro.noise`.
    pub noise_rad_per_s: f64,
    /// Over any span, noise and what the bias departs from one that is the same all the run add up to at most this, `gyro.angle`,
    pub angle_floor_rad: f64,
    /// and this times the span. Infinite where only single readings are bounded.
    pub angle_rad_per_s: f64,
    /// Greatest change of the bias per time, `gyro.wander`; 0 for a constant.
    pub bias_wander_rad_per_s2: f64,
    /// Span that a reading averages over; it ends at the reading's stamp.
    pub period_s: f64,
}

impl GyroModel {
    /// Whether `gyro.angle` is declared.
    pub fn bounds_angle(&self) -> bool {
        self.angle_floor_rad.is_finite()
    }
}

/// A stereo or structured-light camera that measures landmarks by the columns at which its two views see them.
///
/// Frame `sensor`: x right, z forward, origin at the optical centre of the first view. A point at (x, z) has the columns
/// `left = centre + f·x/z` and `right = centre + f·(x − b)/z` (paper 3, Fig. 2), each rounded to a multiple of its step.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeCameraModel {
    /// Focal length, `range_camera.focal`.
    pub focal_px: Interval,
    /// Distance between the optical centres, `range_camera.baseline`.
    pub baseline_m: Interval,
    /// Column of the optical axis.
    pub centre_px: f64,
    /// Twice the greatest error of a column of the first and of the second view, `range_camera.columns`: without noise the steps to which
    /// they are rounded.
    pub step_px: [f64; 2],
    /// Optical centre of the first view in the robot frame: forward and left, `range_camera.position`.
    pub position_m: [Interval; 2],
    /// Height of the optical centres above the floor.
    pub height_m: f64,
    /// Direction of the optical axis from robot forward, counter-clockwise, `range_camera.yaw`.
    pub yaw_rad: Interval,
    /// Greatest angle between the sensor's vertical and the body's, `range_camera.tilt`.
    pub tilt_rad: f64,
    /// Greatest difference in height between the sensor and a landmark, `range_camera.height_span`.
    pub height_span_m: f64,
    /// Greatest error of a stamp, `range_camera.stamp`.
    pub stamp_error_s: f64,
    /// Time from measurement to delivery, `range_camera.latency`.
    pub latency_s: Interval,
    /// Least time between two readings.
    pub period_s: f64,
    /// At most this many wrong correspondences in one reading, `range_landmarks.q_items`.
    pub q_items: usize,
    /// With wrong correspondences: at least so many right ones lie between two wrong ones given to the same landmark, in the order in which
    /// they were measured, `range_landmarks.wrong_spacing`.
    pub wrong_spacing: usize,
}

/// A camera that looks ahead, tilted up about its own u axis, which is level and points to the robot's right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardCameraModel {
    /// Both focal lengths, `forward_camera.focal`.
    pub focal_px: Interval,
    /// Where the optical axis meets the image, `forward_camera.principal_point`.
    pub principal_point_px: [Interval; 2],
    /// Brown and Conrady's k1, k2, p1, p2, k3, as calibrated.
    pub distortion: [f64; 5],
    /// Greatest distance between a pixel and where the lens model puts it, `forward_camera.distortion`.
    pub distortion_px: f64,
    /// Nominal upward tilt of the optical axis.
    pub tilt_up_rad: f64,
    /// Direction of the optical axis from robot forward, counter-clockwise, `forward_camera.yaw`.
    pub yaw_rad: Interval,
    /// Greatest turn of the camera about any level axis from its nominal attitude, `forward_camera.tilt`.
    pub tilt_error_rad: f64,
    /// Greatest error of an image's stamp, `forward_camera.stamp`.
    pub stamp_error_s: f64,
}

/// A two-axis optical flow sensor that looks at the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowModel {
    /// Where it looks, in the robot frame: forward and left, `flow.position`.
    pub position_m: [Interval; 2],
    /// Travel of one count at the mounted height, the same in all the run, `flow.calibration`.
    pub metres_per_count: Interval,
    /// Greatest share by which counts per metre depart from those at the mounted height, now more, now less, `flow.scale`; below 1.
    pub scale_change: f64,
    /// Turn of its forward axis from the robot's, counter-clockwise, `flow.yaw`.
    pub yaw_rad: Interval,
    /// Width of the interval in which, at all stamps, an axis' error of counting lies: 1 by the nature of counting.
    pub quantisation_counts: f64,
    /// Greatest way that it goes back and forth within one period, beyond the distance between its ends, `flow.back_and_forth`.
    pub back_and_forth_m: f64,
    /// Time between two readings.
    pub period_s: f64,
}
