//! The readings of a run as kinds of readings, and the true history behind them.

use std::collections::BTreeMap;

use localizer::{Map, Pose, PoseBox, Reading, RobotModel, reading::Camera};

use crate::{
    devices::Observation,
    run::RunRecord,
    scene::{Gyro as Gyroscope, MethodName, Scene},
    truth::Truth,
};

use super::{
    ReadingLog, SAME_S,
    dots::{self, Dots},
    eye::Eye,
    floor::Floor,
    flow::{Counts, Flow},
    gyro::{Gyro, TurnRate},
    history::{History, Quantity},
    joints::Joints,
    kind::{Declared, Kind},
    motion::Motion,
    perceived::Perceived,
    range::{Look, Range},
    rest::Rest,
    walls::Walls,
    wheels::Wheels,
};

/// A key of a scene for which no witness can be checked, its value, and what is expected instead; `None` for a scene that can be measured.
pub(super) fn unsupported(scene: &Scene) -> Option<(&'static str, String, &'static str)> {
    let robot = &scene.robot;
    if !scene.stations.is_empty() {
        return Some(("station", "given".to_owned(), "a drive"));
    }
    let wanders = |gyro: &&Gyroscope| gyro.bias_wander_deg_per_s2 > 0.0 && gyro.angle_floor_deg.is_none();
    if let Some(gyro) = robot.gyro.as_ref().filter(wanders) {
        let value = gyro.bias_wander_deg_per_s2.to_string();
        return Some(("robot.gyro.bias_wander_deg_per_s2", value, "0, or `angle_floor_deg` beside it"));
    }
    let delivery = &robot.delivery;
    for (key, value) in [
        ("robot.delivery.late_s", delivery.late_s),
        ("robot.delivery.dropped_share", delivery.dropped_share),
        ("robot.delivery.duplicated_share", delivery.duplicated_share),
    ] {
        if value > 0.0 {
            return Some((key, value.to_string(), "0, each reading at once and exactly once"));
        }
    }
    if robot.steering_encoder.is_some() {
        return Some(("robot.steering_encoder", "given".to_owned(), "false"));
    }
    for camera in [Camera::Floor, Camera::Ceiling, Camera::Forward] {
        let row_time_s = robot.camera(camera).map_or(0.0, |keys| keys.shared().lens.row_time_s);
        if row_time_s > 0.0 {
            return Some(("lens.row_time_s", row_time_s.to_string(), "0, a global shutter"));
        }
    }
    let other = scene.localizer.methods.iter().find(|method| !CHECKED.contains(method))?;
    let expected = "range_landmarks, floor_tiles, ceiling_markers and wall_directions only";
    let other = serde_json::to_string(other).unwrap_or_default();
    Some(("localizer.methods", other, expected))
}

/// The methods whose claims or readings are checked.
const CHECKED: [MethodName; 4] =
    [MethodName::RangeLandmarks, MethodName::FloorTiles, MethodName::CeilingMarkers, MethodName::WallDirections];

/// The readings of a run with the truth behind them.
pub(super) struct Readings<'a> {
    scene: &'a Scene,
    record: &'a RunRecord,
    observations: &'a [Observation],
    /// True states at all instants at which something was measured or estimated, in ascending order.
    truths: Vec<Truth>,
    landmarks_m: Vec<[f64; 3]>,
    robot: RobotModel,
    map: Map,
    start: PoseBox,
}

impl<'a> Readings<'a> {
    pub(super) fn of(scene: &'a Scene, record: &'a RunRecord, log: &'a ReadingLog) -> Self {
        let behind = log.observations.iter().map(|observation| observation.truth);
        let images = record.images.iter().filter(|image| image.camera.is_some()).map(|image| image.truth);
        let mut truths: Vec<Truth> = behind.chain(images).chain(log.truths.iter().copied()).collect();
        truths.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
        // Instants that differ by rounding are the same.
        truths.dedup_by(|one, other| one.time_s - other.time_s < SAME_S);
        let landmarks_m =
            scene.landmarks.iter().map(|landmark| [landmark.x_m, landmark.y_m, landmark.height_m]).collect();
        Readings {
            scene,
            record,
            observations: &log.observations,
            truths,
            landmarks_m,
            robot: scene.robot_model(),
            map: scene.map(),
            start: scene.start_box(),
        }
    }

    /// The true history up to an instant, and all readings that have arrived by then; `None` where nothing was measured yet.
    pub(super) fn until(&self, time_s: f64) -> Option<(History, Vec<Box<dyn Kind>>)> {
        let whole = self.truth();
        let history = whole.until(whole.stamp_at(time_s)?);
        let kinds = self.kinds(&history, time_s);
        (history.stamps_s.len() > 1).then(|| (self.with_quantities(history, &kinds), kinds))
    }

    /// The true history of the whole run, so far without quantities.
    fn truth(&self) -> History {
        History {
            stamps_s: self.truths.iter().map(|truth| truth.time_s).collect(),
            poses: self.truths.iter().map(|truth| truth.pose).collect::<Vec<Pose>>(),
            wheel_angle_rad: self.truths.iter().map(|truth| truth.wheel_angle_rad).collect(),
            counted: Vec::new(),
            quantities: BTreeMap::new(),
        }
    }

    /// All kinds of readings, with the readings that have arrived by an instant. A new kind gets a line here.
    fn kinds(&self, history: &History, time_s: f64) -> Vec<Box<dyn Kind>> {
        let eye = |camera: Camera| Eye::of(camera, self.scene, &self.robot, &self.record.drawn);
        let (scene, record, map) = (self.scene, self.record, &self.map);
        let reads = |method: MethodName| scene.localizer.methods.contains(&method);
        let range = self.range(history, time_s).filter(|_| reads(MethodName::RangeLandmarks));
        let joints = eye(Camera::Floor)
            .filter(|_| reads(MethodName::FloorTiles))
            .and_then(|eye| Joints::of(scene, record, map, eye, history, time_s));
        let dots = eye(Camera::Ceiling)
            .filter(|_| reads(MethodName::CeilingMarkers))
            .and_then(|eye| Dots::of(record, map, eye, history, time_s));
        let walls = eye(Camera::Forward)
            .filter(|_| reads(MethodName::WallDirections))
            .and_then(|eye| Walls::of(scene, record, eye, history, time_s));
        let mut looks: Vec<usize> = range.iter().flat_map(|range| range.looks.iter().map(|look| look.stamp)).collect();
        looks.extend(joints.iter().flat_map(|joints| joints.looks.iter().map(|look| look.stamp)));
        looks.extend(dots.iter().flat_map(|dots| dots.looks.iter().map(|look| look.stamp)));
        looks.extend(walls.iter().flat_map(|walls| walls.looks.iter().map(|look| look.stamp)));
        looks.sort_unstable();
        looks.dedup();
        let motion = Motion { start: self.start, robot: self.robot.clone(), room_m: self.map.room_m, looks };
        let perceived = Perceived::of(scene, record, time_s);
        let mut kinds: Vec<Box<dyn Kind>> =
            vec![Box::new(motion), Box::new(self.wheels(history, time_s)), Box::new(perceived)];
        kinds.extend(self.gyro(history, time_s).map(|gyro| Box::new(gyro) as Box<dyn Kind>));
        kinds.extend(self.flow(history, time_s).map(|flow| Box::new(flow) as Box<dyn Kind>));
        kinds.extend(self.rest(history, time_s).map(|rest| Box::new(rest) as Box<dyn Kind>));
        kinds.extend(range.map(|range| Box::new(range) as Box<dyn Kind>));
        kinds.extend(joints.map(|joints| Box::new(joints) as Box<dyn Kind>));
        kinds.extend(walls.map(|walls| Box::new(walls) as Box<dyn Kind>));
        kinds.extend(dots.map(|dots| Box::new(dots) as Box<dyn Kind>));
        kinds
    }

    /// Wheel readings up to an instant. Slip is bounded between all of them, whether they have arrived or not.
    fn wheels(&self, history: &History, time_s: f64) -> Wheels {
        let readings = self.observations.iter().filter_map(|observation| {
            let Reading::Wheels { arrived_s, ticks, .. } = observation.reading else { return None };
            let stamp = history.stamp_at(observation.truth.time_s)?;
            Some((stamp, (arrived_s <= time_s).then_some(ticks)))
        });
        let mut readings: Vec<(usize, Option<[i64; 2]>)> = readings.collect();
        readings.sort_unstable_by_key(|(stamp, _)| *stamp);
        readings.dedup_by_key(|(stamp, _)| *stamp);
        Wheels { readings, model: self.robot.wheels.clone(), reach: self.robot.reach }
    }

    fn gyro(&self, history: &History, time_s: f64) -> Option<Gyro> {
        let model = self.robot.gyro?;
        let mut before = history.stamps_s.first().map(|_| 0);
        let mut readings = Vec::new();
        for observation in self.observations {
            let Reading::Gyro { arrived_s, rate_rad_per_s, .. } = observation.reading else { continue };
            let Some(to) = history.stamp_at(observation.truth.time_s) else { continue };
            if let Some(from) = before.replace(to).filter(|_| arrived_s <= time_s) {
                readings.push(TurnRate { from, to, rate_rad_per_s });
            }
        }
        Some(Gyro { readings, model })
    }

    /// Readings of the flow sensor, which the localizer uses only beside a gyroscope.
    fn flow(&self, history: &History, time_s: f64) -> Option<Flow> {
        let (keys, model) = (self.scene.robot.flow.clone()?, self.robot.flow?);
        self.robot.gyro?;
        let mut n_blind = 0;
        let (mut readings, mut travelled) = (Vec::new(), Vec::new());
        for observation in self.observations {
            let Reading::Flow { arrived_s, counts, blind_periods, .. } = observation.reading else { continue };
            let Some(stamp) = history.stamp_at(observation.truth.time_s).filter(|_| arrived_s <= time_s) else {
                continue;
            };
            let is_blind = std::mem::replace(&mut n_blind, blind_periods) != blind_periods;
            readings.push(Counts { stamp, counts, is_blind, beyond_m: [0.0; 2] });
            travelled.push((observation.travel_m, observation.counted));
        }
        if readings.len() < 2 {
            return None;
        }
        let mut flow = Flow { readings, keys, model, truly: Vec::new() };
        let mut truth = history.clone();
        for Declared { quantity, .. } in flow.declared(history) {
            truth.quantities.insert(quantity, self.true_value(quantity).unwrap_or(f64::NAN));
        }
        flow.learn(&truth, &travelled);
        Some(flow)
    }

    /// Times of rest. The localizer relies on how far the body turns meanwhile only where it learns the gyroscope's bias.
    fn rest(&self, history: &History, time_s: f64) -> Option<Rest> {
        let turn_deg = self.scene.bounds.rest_turn_deg.filter(|_| self.scene.localizer.learns_gyro)?;
        let ticks = self.wheels(history, time_s).readings;
        let arrived: Vec<(usize, [i64; 2])> =
            ticks.into_iter().filter_map(|(stamp, ticks)| Some((stamp, ticks?))).collect();
        Some(Rest::of(&arrived, history, turn_deg.to_radians()))
    }

    fn range(&self, history: &History, time_s: f64) -> Option<Range> {
        let model = self.robot.range_camera.clone()?;
        let looks = self.observations.iter().filter_map(|observation| {
            let Reading::Range { measured_s, arrived_s, sightings } = &observation.reading else { return None };
            let stamp = history.stamp_at(observation.truth.time_s).filter(|_| *arrived_s <= time_s)?;
            Some(Look { stamp, measured_s: *measured_s, sightings: sightings.clone() })
        });
        let mut looks: Vec<Look> = looks.collect();
        looks.sort_by_key(|look| look.stamp);
        let stamp_error_s = self.scene.robot.range_camera.as_ref()?.stamp_tolerance_s;
        Some(Range { looks, model, stamp_error_s })
    }

    /// The history with the true values of all quantities that the kinds name.
    fn with_quantities(&self, mut history: History, kinds: &[Box<dyn Kind>]) -> History {
        for kind in kinds {
            for Declared { quantity, .. } in kind.declared(&history) {
                let value = self.true_value(quantity);
                history.quantities.insert(quantity, value.unwrap_or(f64::NAN));
            }
            kind.complete(&mut history);
        }
        history
    }

    /// True value of a quantity; `None` for one that the run does not have.
    fn true_value(&self, quantity: Quantity) -> Option<f64> {
        let drawn = &self.record.drawn;
        let (base, devices, place) = (&drawn.base, &drawn.devices, &drawn.place);
        let gyro = devices.gyro.as_ref();
        let range = devices.range_camera.as_ref();
        let flow = devices.flow.as_ref();
        match quantity {
            Quantity::WheelRadius(wheel) => Some(base.wheel_radius_m[wheel]),
            Quantity::Track => Some(base.track_m),
            Quantity::GyroBias => gyro.map(|gyro| gyro.bias_rad_per_s),
            Quantity::GyroScale => gyro.map(|gyro| gyro.scale),
            Quantity::FlowPosition(axis) => flow.map(|flow| flow.position_m[axis]),
            Quantity::FlowYaw => flow.map(|flow| flow.yaw_rad),
            Quantity::FlowScale => flow.map(|flow| flow.scale),
            Quantity::RangePosition(axis) => range.map(|range| range.position_m[axis]),
            Quantity::RangeYaw => range.map(|range| range.yaw_rad),
            Quantity::RangeTilt(axis) => range.map(|range| range.tilt_rad[axis]),
            Quantity::RangeFocal => range.map(|range| range.focal_px),
            Quantity::RangeBaseline => range.map(|range| range.baseline_m),
            Quantity::Landmark(code, axis) => self.landmarks_m.get(code as usize).map(|landmark_m| landmark_m[axis]),
            Quantity::Camera(camera, part) => {
                Some(Eye::true_value(part, self.scene.robot.camera(camera)?, &devices.camera(camera)?))
            }
            Quantity::JointEnd(axis, index, end) => {
                let floor = Floor::of(&self.map, self.map.tiles.as_ref()?);
                Some(floor.true_end_m(place.tiles.as_ref()?, (axis, index), end))
            }
            Quantity::JointBend(axis, index, crossing) => {
                let laid = place.tiles.as_ref()?;
                let mut floor = Floor::of(&self.map, self.map.tiles.as_ref()?);
                floor.add(laid, (axis, index));
                Some(floor.true_bend_m(laid, (axis, index), crossing))
            }
            Quantity::Marker(..) | Quantity::MarkerTurn(_) | Quantity::MarkerHeight(_) | Quantity::Dot(..) => {
                dots::true_value(quantity, self.map.markers.as_ref()?, &place.markers)
            }
            Quantity::WallsTurn => Some(place.walls_turn_deg.to_radians()),
            // The history begins with the first of the truths and has a stamp for each.
            Quantity::Instant(_, stamp) => Some(self.truths.get(stamp)?.time_s),
            Quantity::Heave(stamp) => Some(self.truths.get(stamp)?.heave_m),
            Quantity::BodyTilt(stamp, axis) => Some(self.truths.get(stamp)?.tilt_rad[axis]),
        }
    }
}
