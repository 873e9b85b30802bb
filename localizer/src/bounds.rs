//! The table of declared bounds: every quantity that an estimate may rely on, by name.
//!
//! A bound's value is declared by whoever sets up a robot, a map or a scene; this table gives its name, its unit and the quantity that it bounds.
//! Estimates name the bounds that they rely on, and a judge who knows the truth can check which of these bounds were kept.

/// Name of a declared bound, such as `wheels.slip` or `floor_tiles.laying`.
pub type Assumption = &'static str;

/// Name, unit and meaning of a declared bound; its value is declared elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bound {
    /// Name of the bound, as it stands in estimates, in a judge's verdicts and in the summaries of runs.
    pub name: Assumption,
    /// Unit of the bound and of the quantity that it bounds; `1` for shares and counts.
    pub unit: &'static str,
    /// Description of the quantity whose magnitude is bounded.
    pub what: &'static str,
}

/// How doubtful a bound is before anything was read: 0 for the most doubtful ones. What an event can break, such as a push, oil on the floor or a
/// thing that was moved, is more doubtful than what was measured once and does not change, and an event that is common more so than a rare one.
pub fn doubtfulness(bound: &str) -> usize {
    EVENTS.iter().position(|one| *one == bound).unwrap_or(EVENTS.len())
}

/// Bounds that an event can break, the most doubtful first.
const EVENTS: [Assumption; 16] = [
    WHEELS_SLIP,
    WHEELS_SIDE_SLIP,
    WHEELS_STEERING_SLIP,
    MARKERS_PLACEMENT,
    FLOOR_TILES_LAYING,
    WALL_DIRECTIONS_DIRECTION,
    FLOW_SCALE,
    GNSS_FIXED,
    REACH_ACCELERATION,
    BODY_TILT,
    BODY_HEAVE,
    WHEELS_REST,
    RANGE_LANDMARKS_Q_ITEMS,
    FLOW_BACK_AND_FORTH,
    REACH_SPEED,
    REACH_TURN_RATE,
];

/// Defines a constant for the name of each bound, and the table of all bounds.
macro_rules! bounds {
    ($(#[doc = $what:literal] $constant:ident = $name:literal in $unit:literal;)+) => {
        $(#[doc = $what] pub const $constant: Assumption = $name;)+

        /// Every declared bound that an estimate may rely on.
        pub const ALL: &[Bound] = &[$(Bound { name: $constant, unit: $unit, what: $what }),+];
    };
}

bounds! {
    #[doc = "Slip of a wheel along the robot's axis over any slip window: the difference between the distance that the wheel rolls and the distance that its contact point moves, beyond a declared share of that distance."]
    WHEELS_SLIP = "wheels.slip" in "m";
    #[doc = "Sideways displacement of the robot's origin over any slip window, beyond a declared share of the distance travelled."]
    WHEELS_SIDE_SLIP = "wheels.side_slip" in "m";
    #[doc = "Deviation of each wheel's rolling radius from its nominal radius."]
    WHEELS_RADIUS = "wheels.radius" in "m";
    #[doc = "Deviation of the distance between the wheels' contact points from its nominal value."]
    WHEELS_TRACK = "wheels.track" in "m";
    #[doc = "Angle by which the robot turns while its encoders count no tick."]
    WHEELS_REST = "wheels.rest" in "rad";
    #[doc = "Deviation of the distance between a car's rear axle and its front axle from its nominal value."]
    WHEELS_WHEELBASE = "wheels.wheelbase" in "m";
    #[doc = "Difference between the turn of a car over any slip window and the turn by its steering angle and travel, beyond a declared share of that and an angle per distance."]
    WHEELS_STEERING_SLIP = "wheels.steering_slip" in "rad";
    #[doc = "Rate at which the steering angle of a car changes."]
    WHEELS_STEERING_RATE = "wheels.steering_rate" in "rad/s";
    #[doc = "Steering angle that the steering encoder reads when the car is steered straight ahead."]
    STEERING_ENCODER_ZERO = "steering_encoder.zero" in "rad";
    #[doc = "Deviation of the steering encoder's scale factor from 1."]
    STEERING_ENCODER_SCALE = "steering_encoder.scale" in "1";
    #[doc = "Offset of the clock that stamps the readings of wheels, gyroscope, flow sensor and steering encoder."]
    BASE_STAMP = "base.stamp" in "s";
    #[doc = "Speed of the robot."]
    REACH_SPEED = "reach.speed" in "m/s";
    #[doc = "Turn rate of the robot."]
    REACH_TURN_RATE = "reach.turn_rate" in "rad/s";
    #[doc = "Acceleration of the robot's origin and of its wheels' rims."]
    REACH_ACCELERATION = "reach.acceleration" in "m/s²";
    #[doc = "Angle by which the body leans from the vertical."]
    BODY_TILT = "body.tilt" in "rad";
    #[doc = "Height of the body above or below its height at rest."]
    BODY_HEAVE = "body.heave" in "m";
    #[doc = "Distance by which the robot's origin comes closer to a wall than the body allows."]
    ROOM_WALLS = "room.walls" in "m";
    #[doc = "Rate that the gyroscope reports at rest."]
    GYRO_BIAS = "gyro.bias" in "rad/s";
    #[doc = "Deviation of the gyroscope's scale factor from 1."]
    GYRO_SCALE = "gyro.scale" in "1";
    #[doc = "Error of one reading of the gyroscope, beyond bias and scale."]
    GYRO_NOISE = "gyro.noise" in "rad/s";
    #[doc = "Sum of the errors of the gyroscope's readings over any span of time, as an angle, beyond a declared rate times the span."]
    GYRO_ANGLE = "gyro.angle" in "rad";
    #[doc = "Rate at which the gyroscope's bias changes."]
    GYRO_WANDER = "gyro.wander" in "rad/s²";
    #[doc = "Deviation of the point on the floor that the flow sensor looks at from its nominal position on the robot."]
    FLOW_POSITION = "flow.position" in "m";
    #[doc = "Deviation of the flow sensor's direction from its nominal direction."]
    FLOW_YAW = "flow.yaw" in "rad";
    #[doc = "Deviation of the flow sensor's scale, as far as it is constant over a run, from its nominal scale."]
    FLOW_CALIBRATION = "flow.calibration" in "1";
    #[doc = "Deviation of the flow sensor's scale in any one period from its nominal scale."]
    FLOW_SCALE = "flow.scale" in "1";
    #[doc = "Distance that the point under the flow sensor moves forth and back again within one period of the sensor."]
    FLOW_BACK_AND_FORTH = "flow.back_and_forth" in "m";
    #[doc = "Deviation of the floor camera's position on the body from its nominal position."]
    FLOOR_CAMERA_POSITION = "floor_camera.position" in "m";
    #[doc = "Angle by which the floor camera is turned about the body's vertical against its nominal direction."]
    FLOOR_CAMERA_YAW = "floor_camera.yaw" in "rad";
    #[doc = "Angle between the floor camera's optical axis and the body's vertical."]
    FLOOR_CAMERA_TILT = "floor_camera.tilt" in "rad";
    #[doc = "Deviation of the floor camera's scale, in pixels per metre of floor at rest, from its nominal value."]
    FLOOR_CAMERA_SCALE = "floor_camera.scale" in "px/m";
    #[doc = "Distance by which the floor camera's lens displaces an image point from where its calibration predicts it."]
    FLOOR_CAMERA_DISTORTION = "floor_camera.distortion" in "px";
    #[doc = "Deviation of a floor image's stamp from the middle of its exposure."]
    FLOOR_CAMERA_STAMP = "floor_camera.stamp" in "s";
    #[doc = "Distance of a joint in view from its nominal line of the grid."]
    FLOOR_TILES_LAYING = "floor_tiles.laying" in "m";
    #[doc = "Angle by which a joint in view is turned against the grid."]
    FLOOR_TILES_LAYING_ANGLE = "floor_tiles.laying_angle" in "rad";
    #[doc = "Distance of a joint in view from a straight line."]
    FLOOR_TILES_STRAIGHTNESS = "floor_tiles.straightness" in "m";
    #[doc = "Deviation of the forward camera's position on the body from its nominal position, forward or left."]
    FORWARD_CAMERA_POSITION = "forward_camera.position" in "m";
    #[doc = "Deviation of the forward camera's height above the floor from its nominal height."]
    FORWARD_CAMERA_HEIGHT = "forward_camera.height" in "m";
    #[doc = "Angle by which the forward camera is turned about the body's vertical against its nominal direction."]
    FORWARD_CAMERA_YAW = "forward_camera.yaw" in "rad";
    #[doc = "Angle by which the forward camera leans from its nominal orientation."]
    FORWARD_CAMERA_TILT = "forward_camera.tilt" in "rad";
    #[doc = "Deviation of the forward camera's focal length from its nominal value, as a share of it."]
    FORWARD_CAMERA_FOCAL = "forward_camera.focal" in "1";
    #[doc = "Distance of the forward camera's principal point from its nominal position in the image."]
    FORWARD_CAMERA_PRINCIPAL_POINT = "forward_camera.principal_point" in "px";
    #[doc = "Distance by which the forward camera's lens displaces an image point from where its calibration predicts it."]
    FORWARD_CAMERA_DISTORTION = "forward_camera.distortion" in "px";
    #[doc = "Deviation of a forward image's stamp from the middle of its exposure."]
    FORWARD_CAMERA_STAMP = "forward_camera.stamp" in "s";
    #[doc = "Deviation of a wall's direction from the direction that the map gives."]
    WALL_DIRECTIONS_DIRECTION = "wall_directions.direction" in "rad";
    #[doc = "Angle by which furniture that stands along a wall is turned against the nearest wall's direction."]
    WALL_DIRECTIONS_ASKEW = "wall_directions.askew" in "rad";
    #[doc = "Deviation of the ceiling camera's position on the body from its nominal position."]
    CEILING_CAMERA_POSITION = "ceiling_camera.position" in "m";
    #[doc = "Deviation of the ceiling camera's height above the floor from its nominal height."]
    CEILING_CAMERA_HEIGHT = "ceiling_camera.height" in "m";
    #[doc = "Angle by which the ceiling camera is turned about the vertical against its nominal direction."]
    CEILING_CAMERA_YAW = "ceiling_camera.yaw" in "rad";
    #[doc = "Angle by which the ceiling camera leans from its nominal orientation."]
    CEILING_CAMERA_TILT = "ceiling_camera.tilt" in "rad";
    #[doc = "Deviation of the ceiling camera's focal length from its nominal value, as a share of it."]
    CEILING_CAMERA_FOCAL = "ceiling_camera.focal" in "1";
    #[doc = "Distance of the ceiling camera's principal point from its nominal position in the image."]
    CEILING_CAMERA_CENTRE = "ceiling_camera.centre" in "px";
    #[doc = "Distance by which the ceiling camera's lens displaces an image point from where its calibration predicts it."]
    CEILING_CAMERA_DISTORTION = "ceiling_camera.distortion" in "px";
    #[doc = "Deviation of a ceiling image's stamp from the middle of its exposure."]
    CEILING_CAMERA_STAMP = "ceiling_camera.stamp" in "s";
    #[doc = "Distance of a marker's centre from its position on the map."]
    MARKERS_PLACEMENT = "markers.placement" in "m";
    #[doc = "Deviation of a marker's direction from its direction on the map."]
    MARKERS_ROTATION = "markers.rotation" in "rad";
    #[doc = "Distance of a dot from its nominal position on the printed marker."]
    MARKERS_PRINT = "markers.print" in "m";
    #[doc = "Deviation of a marker's height from its height on the map."]
    MARKERS_HEIGHT = "markers.height" in "m";
    #[doc = "Deviation of the range camera's position on the body from its nominal position."]
    RANGE_CAMERA_POSITION = "range_camera.position" in "m";
    #[doc = "Deviation of the range camera's direction from its nominal direction."]
    RANGE_CAMERA_YAW = "range_camera.yaw" in "rad";
    #[doc = "Angle between the range camera's vertical and the body's vertical."]
    RANGE_CAMERA_TILT = "range_camera.tilt" in "rad";
    #[doc = "Deviation of the range camera's focal length from its nominal value."]
    RANGE_CAMERA_FOCAL = "range_camera.focal" in "px";
    #[doc = "Deviation of the distance between the range camera's two views from its nominal value."]
    RANGE_CAMERA_BASELINE = "range_camera.baseline" in "m";
    #[doc = "Noise of a measured image column before it is rounded."]
    RANGE_CAMERA_COLUMNS = "range_camera.columns" in "px";
    #[doc = "Height of a landmark above or below the range camera."]
    RANGE_CAMERA_HEIGHT_SPAN = "range_camera.height_span" in "m";
    #[doc = "Deviation of a range reading's stamp from the instant of the measurement."]
    RANGE_CAMERA_STAMP = "range_camera.stamp" in "s";
    #[doc = "Deviation of the time between a range measurement and the arrival of its reading from the nominal latency."]
    RANGE_CAMERA_LATENCY = "range_camera.latency" in "s";
    #[doc = "Deviation of the scanner's position on the robot from its nominal position."]
    SCANNER_POSITION = "scanner.position" in "m";
    #[doc = "Angle by which the scanner's forward axis is turned about the body's vertical against its nominal direction."]
    SCANNER_YAW = "scanner.yaw" in "rad";
    #[doc = "Angle between the plane of the scanner's beams and the level plane of the body."]
    SCANNER_TILT = "scanner.tilt" in "rad";
    #[doc = "Error of a distance that a beam of the scanner measures."]
    SCANNER_RANGE = "scanner.range" in "m";
    #[doc = "Deviation of a scan's stamp from the instant of the measurement."]
    SCANNER_STAMP = "scanner.stamp" in "s";
    #[doc = "Distance of a point of a wall from its place on the map."]
    WALLS_PLACEMENT = "walls.placement" in "m";
    #[doc = "Deviation of the antenna's position on the robot from its nominal position."]
    GNSS_ANTENNA = "gnss.antenna" in "m";
    #[doc = "Error of either coordinate of a position with resolved ambiguities (a fixed solution)."]
    GNSS_FIXED = "gnss.fixed" in "m";
    #[doc = "Error of either coordinate of a position without resolved ambiguities (a floating solution)."]
    GNSS_FLOATING = "gnss.floating" in "m";
    #[doc = "Deviation of a position's stamp from the instant at which the antenna was there."]
    GNSS_STAMP = "gnss.stamp" in "s";
    #[doc = "Deviation of the point camera's position on the body from its nominal position."]
    POINT_CAMERA_POSITION = "point_camera.position" in "m";
    #[doc = "Deviation of the point camera's height above the floor from its nominal height."]
    POINT_CAMERA_HEIGHT = "point_camera.height" in "m";
    #[doc = "Angle by which the point camera is turned about the body's vertical against its nominal direction."]
    POINT_CAMERA_YAW = "point_camera.yaw" in "rad";
    #[doc = "Angle by which the point camera leans from its nominal orientation."]
    POINT_CAMERA_TILT = "point_camera.tilt" in "rad";
    #[doc = "Deviation of the point camera's focal length from its nominal value, as a share of it."]
    POINT_CAMERA_FOCAL = "point_camera.focal" in "1";
    #[doc = "Distance of the point camera's principal point from its nominal position in the image, along u or v."]
    POINT_CAMERA_CENTRE = "point_camera.centre" in "px";
    #[doc = "Error of an image point of a landmark, along u or v."]
    POINT_CAMERA_POINTS = "point_camera.points" in "px";
    #[doc = "Distance by which a landmark that the point camera sees is nearer than declared, along the optical axis."]
    POINT_CAMERA_LEAST_DEPTH = "point_camera.least_depth" in "m";
    #[doc = "Deviation of the stamp of a point camera's image from the instant of the exposure."]
    POINT_CAMERA_STAMP = "point_camera.stamp" in "s";
    #[doc = "Number of matches of one range reading that name another landmark than the measured one."]
    RANGE_LANDMARKS_Q_ITEMS = "range_landmarks.q_items" in "1";
    #[doc = "Number of uses of one landmark code between two wrong matches of it."]
    RANGE_LANDMARKS_WRONG_SPACING = "range_landmarks.wrong_spacing" in "1";
}
