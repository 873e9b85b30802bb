//! The table of declared bounds: every quantity that an estimate may rely on, by name.
//!
//! A bound's value is declared by whoever sets up a robot, a map or a scene; this table gives its name, its unit and the quantity that it bounds.
//! Estimates name the bounds that they rely on, and a judge who knows the truth can check which of these bounds were kept.

/// Name of a declared bound, such as `wheels.slip` or `floor_tiles.laying`.
pub type Assumption = &'static str;

/// Name, unit and meaning of a declared bound; its value is declared elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bound {
    /// Name of the bound in estimates, verdicts and summaries.
    pub name: Assumption,
    /// Unit of the bound and of the true value behind it; `1` for shares and counts.
    pub unit: &'static str,
    /// Description of the quantity whose magnitude is bounded.
    pub what: &'static str,
}

/// Defines a constant for the name of each bound, and the table of all bounds.
macro_rules! bounds {
    ($(#[doc = $what:literal] $constant:ident = $name:literal in $unit:literal;)+) => {
        $(#[doc = $what] pub const $constant: Assumption = $name;)+

        /// Every declared bound that an estimate may rely on.
        pub const ALL: &[Bound] = &[$(Bound { name: $constant, unit: $unit, what: $what }),+];
    };
}

bounds! {
    #[doc = "By how much the way that a wheel rolls and the way of its contact point along the robot's axis differ over any slip window, beyond a share of the way."]
    WHEELS_SLIP = "wheels.slip" in "m";
    #[doc = "How far the origin moves sideways over any slip window, beyond a share of the way."]
    WHEELS_SIDE_SLIP = "wheels.side_slip" in "m";
    #[doc = "Each wheel's rolling radius against its nominal one."]
    WHEELS_RADIUS = "wheels.radius" in "m";
    #[doc = "The distance between the wheels' contact points against its nominal one."]
    WHEELS_TRACK = "wheels.track" in "m";
    #[doc = "How far the robot turns while its encoders count nothing."]
    WHEELS_REST = "wheels.rest" in "rad";
    #[doc = "By how much the stamps of wheels, gyroscope and flow sensor are off, all alike."]
    BASE_STAMP = "base.stamp" in "s";
    #[doc = "The robot's speed."]
    REACH_SPEED = "reach.speed" in "m/s";
    #[doc = "The robot's rate of turn."]
    REACH_TURN_RATE = "reach.turn_rate" in "rad/s";
    #[doc = "The robot's acceleration, of its origin and of its wheels' rims."]
    REACH_ACCELERATION = "reach.acceleration" in "m/s²";
    #[doc = "How far the body leans from the vertical."]
    BODY_TILT = "body.tilt" in "rad";
    #[doc = "How far the body stands above or below its height at rest."]
    BODY_HEAVE = "body.heave" in "m";
    #[doc = "How close the robot's origin comes to a wall."]
    ROOM_WALLS = "room.walls" in "m";
    #[doc = "The gyroscope's rate at rest."]
    GYRO_BIAS = "gyro.bias" in "rad/s";
    #[doc = "The gyroscope's scale against 1."]
    GYRO_SCALE = "gyro.scale" in "1";
    #[doc = "The error of one reading of the gyroscope beyond bias and scale."]
    GYRO_NOISE = "gyro.noise" in "rad/s";
    #[doc = "What errors of the gyroscope's readings add up to over any span, beyond a rate times the span."]
    GYRO_ANGLE = "gyro.angle" in "rad";
    #[doc = "How fast the gyroscope's bias changes."]
    GYRO_WANDER = "gyro.wander" in "rad/s²";
    #[doc = "Where the flow sensor looks at the floor, against its nominal place."]
    FLOW_POSITION = "flow.position" in "m";
    #[doc = "The flow sensor's direction against its nominal one."]
    FLOW_YAW = "flow.yaw" in "rad";
    #[doc = "The flow sensor's scale, constant over a run, against its nominal one."]
    FLOW_CALIBRATION = "flow.calibration" in "1";
    #[doc = "The flow sensor's scale in any period against its nominal one."]
    FLOW_SCALE = "flow.scale" in "1";
    #[doc = "The way forth and back within one period of the flow sensor."]
    FLOW_BACK_AND_FORTH = "flow.back_and_forth" in "m";
    #[doc = "The floor camera's place on the body against its nominal one."]
    FLOOR_CAMERA_POSITION = "floor_camera.position" in "m";
    #[doc = "The floor camera's turn about the body's vertical against its nominal one."]
    FLOOR_CAMERA_YAW = "floor_camera.yaw" in "rad";
    #[doc = "The angle of the floor camera's optical axis with the body's vertical."]
    FLOOR_CAMERA_TILT = "floor_camera.tilt" in "rad";
    #[doc = "Pixels of the floor camera per metre of floor at rest, against nominal ones."]
    FLOOR_CAMERA_SCALE = "floor_camera.scale" in "px/m";
    #[doc = "How far the floor camera's lens moves an image point against its calibration."]
    FLOOR_CAMERA_DISTORTION = "floor_camera.distortion" in "px";
    #[doc = "The stamp of a floor image against the middle of its exposure."]
    FLOOR_CAMERA_STAMP = "floor_camera.stamp" in "s";
    #[doc = "How far a joint in view lies from its place in the grid."]
    FLOOR_TILES_LAYING = "floor_tiles.laying" in "m";
    #[doc = "How far a joint in view is turned against the grid."]
    FLOOR_TILES_LAYING_ANGLE = "floor_tiles.laying_angle" in "rad";
    #[doc = "How far a joint in view departs from a straight line."]
    FLOOR_TILES_STRAIGHTNESS = "floor_tiles.straightness" in "m";
    #[doc = "The forward camera's turn about the body's vertical against its nominal one."]
    FORWARD_CAMERA_YAW = "forward_camera.yaw" in "rad";
    #[doc = "The forward camera's lean against its nominal one."]
    FORWARD_CAMERA_TILT = "forward_camera.tilt" in "rad";
    #[doc = "The forward camera's focal length against its nominal one."]
    FORWARD_CAMERA_FOCAL = "forward_camera.focal" in "1";
    #[doc = "Where the forward camera's optical axis meets the image, against its nominal place."]
    FORWARD_CAMERA_PRINCIPAL_POINT = "forward_camera.principal_point" in "px";
    #[doc = "How far the forward camera's lens moves an image point against its calibration."]
    FORWARD_CAMERA_DISTORTION = "forward_camera.distortion" in "px";
    #[doc = "The stamp of a forward image against the middle of its exposure."]
    FORWARD_CAMERA_STAMP = "forward_camera.stamp" in "s";
    #[doc = "The direction of a wall against the one that the map tells."]
    WALL_DIRECTIONS_DIRECTION = "wall_directions.direction" in "rad";
    #[doc = "How far furniture that stands along walls is turned against the nearest wall's direction."]
    WALL_DIRECTIONS_ASKEW = "wall_directions.askew" in "rad";
    #[doc = "The ceiling camera's place on the body against its nominal one."]
    CEILING_CAMERA_POSITION = "ceiling_camera.position" in "m";
    #[doc = "The ceiling camera's height above the floor against its nominal one."]
    CEILING_CAMERA_HEIGHT = "ceiling_camera.height" in "m";
    #[doc = "The ceiling camera's turn about the vertical against its nominal one."]
    CEILING_CAMERA_YAW = "ceiling_camera.yaw" in "rad";
    #[doc = "The ceiling camera's lean against its nominal one."]
    CEILING_CAMERA_TILT = "ceiling_camera.tilt" in "rad";
    #[doc = "The ceiling camera's focal length against its nominal one."]
    CEILING_CAMERA_FOCAL = "ceiling_camera.focal" in "1";
    #[doc = "Where the ceiling camera's optical axis meets the image, against its nominal place."]
    CEILING_CAMERA_CENTRE = "ceiling_camera.centre" in "px";
    #[doc = "How far the ceiling camera's lens moves an image point against its calibration."]
    CEILING_CAMERA_DISTORTION = "ceiling_camera.distortion" in "px";
    #[doc = "The stamp of a ceiling image against the middle of its exposure."]
    CEILING_CAMERA_STAMP = "ceiling_camera.stamp" in "s";
    #[doc = "The middle of a marker against its place on the map."]
    MARKERS_PLACEMENT = "markers.placement" in "m";
    #[doc = "The direction of a marker against the one on the map."]
    MARKERS_ROTATION = "markers.rotation" in "rad";
    #[doc = "A dot's place on its marker against the printed grid."]
    MARKERS_PRINT = "markers.print" in "m";
    #[doc = "The height of a marker against the one on the map."]
    MARKERS_HEIGHT = "markers.height" in "m";
    #[doc = "The range camera's place on the body against its nominal one."]
    RANGE_CAMERA_POSITION = "range_camera.position" in "m";
    #[doc = "The range camera's direction against its nominal one."]
    RANGE_CAMERA_YAW = "range_camera.yaw" in "rad";
    #[doc = "The angle of the range camera's vertical with the body's."]
    RANGE_CAMERA_TILT = "range_camera.tilt" in "rad";
    #[doc = "The range camera's focal length against its nominal one."]
    RANGE_CAMERA_FOCAL = "range_camera.focal" in "px";
    #[doc = "The distance between the range camera's two views against its nominal one."]
    RANGE_CAMERA_BASELINE = "range_camera.baseline" in "m";
    #[doc = "The noise of a measured column before it is rounded."]
    RANGE_CAMERA_COLUMNS = "range_camera.columns" in "px";
    #[doc = "How far a landmark lies above or below the range camera."]
    RANGE_CAMERA_HEIGHT_SPAN = "range_camera.height_span" in "m";
    #[doc = "The stamp of a range reading against the instant at which it was measured."]
    RANGE_CAMERA_STAMP = "range_camera.stamp" in "s";
    #[doc = "How long a range reading takes to arrive, against its nominal latency."]
    RANGE_CAMERA_LATENCY = "range_camera.latency" in "s";
    #[doc = "Where the antenna is on the robot, against its nominal place."]
    GNSS_ANTENNA = "gnss.antenna" in "m";
    #[doc = "Either coordinate of a position with resolved ambiguities, against the antenna's."]
    GNSS_FIXED = "gnss.fixed" in "m";
    #[doc = "Either coordinate of a position without resolved ambiguities, against the antenna's."]
    GNSS_FLOATING = "gnss.floating" in "m";
    #[doc = "The stamp of a position against the instant at which the antenna was there."]
    GNSS_STAMP = "gnss.stamp" in "s";
    #[doc = "Matches of one reading that belong to another landmark."]
    RANGE_LANDMARKS_Q_ITEMS = "range_landmarks.q_items" in "1";
    #[doc = "Uses of one code between two wrong matches of it."]
    RANGE_LANDMARKS_WRONG_SPACING = "range_landmarks.wrong_spacing" in "1";
}
