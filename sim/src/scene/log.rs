//! Keys for a log that another program recorded: which topics are read as what, its clocks, and where the truth is.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How `wherein replay --robot` reads a log that another program recorded. In a simulation the table has no effect, but a scene with it needs no
/// drive.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Log {
    /// Time that counts as the time of measurement of a message.
    pub stamps: Stamps,
    /// Greatest change of the delay from a message's stamp to the time at which it was logged. A message whose delay differs by more from the usual
    /// one has a false stamp and is dropped; where the log's own time goes back by more, the log is read no further.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub clock_tolerance_s: f64,
    /// Time without a message of a topic above which the report names a gap. Odometry is not relied on in its gaps.
    #[schemars(range(min = 0.001, max = 3600.0))]
    pub longest_gap_s: f64,
    /// Least time between two estimates. They are made at readings of the wheels.
    #[schemars(range(min = 0.001, max = 60.0))]
    pub step_s: f64,
    /// Whether the robot begins in the box that `[start]` states. If not, it may be anywhere in the room and turned in any way.
    pub start_is_known: bool,
    /// Whether the cameras' lenses are those that the messages of type `sensor_msgs/CameraInfo` state: focal length, principal point and distortion.
    /// If not, what these messages state is only compared with the lenses that `[robot]` states.
    pub lens_from_camera_info: bool,
    /// Names of topics. A topic that is not named is the only one of the log that has a fitting type.
    pub topics: Topics,
    /// Names of the wheels' joints in messages of type `sensor_msgs/JointState`.
    pub joints: Joints,
    /// Law of the error of odometry from elsewhere, which is then relied on in place of the wheels. Unless stated, the ways that odometry counts are
    /// those of wheels, with the bounds on their slip in `[bounds]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry: Option<OdometryLaw>,
    /// Mount of the gyroscope that messages of type `sensor_msgs/Imu` come from.
    pub imu: ImuMount,
    /// How geographic positions of messages of type `sensor_msgs/NavSatFix` become positions in the world frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gnss: Option<Datum>,
    /// Where the true poses are, if they are known. They are compared with the estimates and are never given to the localizer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<LoggedTruth>,
}

impl Default for Log {
    fn default() -> Self {
        Log {
            stamps: Stamps::Header,
            clock_tolerance_s: 0.5,
            longest_gap_s: 0.5,
            step_s: 0.1,
            start_is_known: true,
            lens_from_camera_info: false,
            topics: Topics::default(),
            joints: Joints::default(),
            odometry: None,
            imu: ImuMount::default(),
            gnss: None,
            truth: None,
        }
    }
}

/// Times that a message of a log has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stamps {
    /// The stamp in the message's header.
    #[default]
    Header,
    /// The time at which the message was logged. Headers are not read.
    LogTime,
}

/// Names of topics by what they are read as.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Topics {
    /// Topic of wheel odometry, of type `nav_msgs/Odometry`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry: Option<String>,
    /// Topic of the wheels' angles, of type `sensor_msgs/JointState`. Where a log has it and odometry too, and neither is named, the wheels' angles
    /// are read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<String>,
    /// Topic of the gyroscope, of type `sensor_msgs/Imu`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu: Option<String>,
    /// Topic of the floor camera's images, of type `sensor_msgs/Image` or `sensor_msgs/CompressedImage`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor_camera: Option<String>,
    /// Topic of the forward camera's images, of type `sensor_msgs/Image` or `sensor_msgs/CompressedImage`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forward_camera: Option<String>,
    /// Topic of the ceiling camera's images, of type `sensor_msgs/Image` or `sensor_msgs/CompressedImage`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ceiling_camera: Option<String>,
    /// Topic of satellite navigation, of type `sensor_msgs/NavSatFix`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gnss: Option<String>,
    /// Topic of the planar range scanner, of type `sensor_msgs/LaserScan`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scanner: Option<String>,
}

/// Names of the wheels' joints.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Joints {
    /// Joint of the left wheel. Its angle grows when the robot drives forward.
    pub left: String,
    /// Joint of the right wheel. Its angle grows when the robot drives forward.
    pub right: String,
}

impl Default for Joints {
    fn default() -> Self {
        Joints { left: "left_wheel_joint".to_owned(), right: "right_wheel_joint".to_owned() }
    }
}

/// Law of the error of odometry: over any time T in which a wheel goes the way L by the odometry, the error of that way is at most
/// `floor_m + share·L + m_per_s·T`. The two wheels are `robot.base.track_m` apart; the odometry's turn is the difference of their ways over that
/// distance, so that the law bounds the turn's error too.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryLaw {
    /// Part of the error of a wheel's way that does not grow.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub floor_m: f64,
    /// Part of the error of a wheel's way that grows with the way, as a share of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share: f64,
    /// Part of the error of a wheel's way that grows with the time.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub m_per_s: f64,
    /// Part of the sideways way of the axle's middle that does not grow.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub aside_floor_m: f64,
    /// Part of the sideways way of the axle's middle that grows with the mean way of both wheels, as a share of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub aside_share: f64,
    /// Part of the sideways way of the axle's middle that grows with the time.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub aside_m_per_s: f64,
}

impl Default for OdometryLaw {
    /// The slip of a careful user's bounds, rounded up, and some drift.
    fn default() -> Self {
        OdometryLaw {
            floor_m: 0.002,
            share: 0.02,
            m_per_s: 0.0005,
            aside_floor_m: 0.002,
            aside_share: 0.02,
            aside_m_per_s: 0.0,
        }
    }
}

/// Mount of the gyroscope that messages of type `sensor_msgs/Imu` come from.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImuMount {
    /// Axis of the sensor's frame that points up on the robot.
    pub up: UpAxis,
}

/// Axes of a sensor's frame, with their signs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// The x axis points up.
    X,
    /// The y axis points up.
    Y,
    /// The z axis points up.
    #[default]
    Z,
    /// The x axis points down.
    MinusX,
    /// The y axis points down.
    MinusY,
    /// The z axis points down.
    MinusZ,
}

/// Place and direction of the world frame on the earth.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Datum {
    /// Latitude of the world frame's origin, by WGS 84.
    #[schemars(range(min = -90.0, max = 90.0))]
    pub latitude_deg: f64,
    /// Longitude of the world frame's origin, by WGS 84.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub longitude_deg: f64,
    /// Height of the world frame's origin over the ellipsoid of WGS 84.
    #[serde(default)]
    #[schemars(range(min = -1000.0, max = 10000.0))]
    pub altitude_m: f64,
    /// Direction of the world frame's x axis, counter-clockwise from east.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub x_axis_deg: f64,
    /// Number of standard deviations that a position's own covariance has to keep within the declared bound `gnss.fixed` or `gnss.floating`. A
    /// position whose covariance allows more is dropped. At 0 the covariance is not read.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub sigmas: f64,
}

/// Where the true poses are, and in which frame.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LoggedTruth {
    /// Topic of the true poses, of type `nav_msgs/Odometry`, `geometry_msgs/PoseStamped` or `geometry_msgs/PoseWithCovarianceStamped`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
    /// Text file of the true poses in the TUM format, as a path from the folder of the scene's file: time in seconds by the clock of the stamps, x,
    /// y, z, and a quaternion x, y, z, w.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tum: Option<String>,
    /// Greatest error of the true positions, along x and y each.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tolerance_m: f64,
    /// Greatest error of the true headings.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: f64,
    /// World x of the origin of the frame in which the true poses are.
    pub x_m: f64,
    /// World y of the origin of the frame in which the true poses are.
    pub y_m: f64,
    /// Direction of the x axis of the frame in which the true poses are, counter-clockwise from world x.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: f64,
    /// The true poses are those of one place on the robot, such as a reflector; this is the distance of that place forward of the wheel axle.
    #[schemars(range(min = -5.0, max = 5.0))]
    pub forward_m: f64,
    /// The true poses are those of one place on the robot; this is the distance of that place to the left of the robot's middle.
    #[schemars(range(min = -5.0, max = 5.0))]
    pub left_m: f64,
    /// Counter-clockwise angle from the robot's forward direction to the direction that the headings of the true poses give.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub yaw_deg: f64,
}
