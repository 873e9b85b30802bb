//! The readings of a run as kinds of readings, and the true history behind them.

use std::collections::BTreeMap;

use localizer::{Map, Pose, PoseBox, Reading, RobotModel};

use crate::{devices::Observation, run::RunRecord, scene::Scene, truth::Truth, world::Drawn};

use super::{
    ReadingLog,
    gyro::{Gyro, TurnRate},
    history::{History, Quantity},
    kind::Kind,
    motion::Motion,
    range::{Look, Range},
    wheels::Wheels,
};

/// A key of a scene for which no witness can be checked, its value, and what is expected instead; `None` for a scene that can be measured.
pub(super) fn unsupported(scene: &Scene) -> Option<(&'static str, String, &'static str)> {
    let robot = &scene.robot;
    if !scene.stations.is_empty() {
        return Some(("station", "given".to_owned(), "a drive"));
    }
    if robot.delivery.stamp_tolerance_s > 0.0 {
        let value = robot.delivery.stamp_tolerance_s.to_string();
        return Some(("robot.delivery.stamp_tolerance_s", value, "0, as the error of the base's clock is held fixed"));
    }
    if let Some(gyro) = robot.gyro.as_ref().filter(|gyro| gyro.bias_wander_deg_per_s2 > 0.0) {
        let value = gyro.bias_wander_deg_per_s2.to_string();
        return Some(("robot.gyro.bias_wander_deg_per_s2", value, "0, a constant bias"));
    }
    let known = "localizer.methods";
    let other = scene.localizer.methods.iter().find(|method| **method != crate::scene::MethodName::RangeLandmarks)?;
    Some((known, format!("{other:?}"), "only the method of the range camera"))
}

/// The readings of a run with the truth behind them.
pub(super) struct Readings<'a> {
    observations: &'a [Observation],
    /// True states at all instants at which something was measured or estimated, in ascending order.
    truths: Vec<Truth>,
    drawn: &'a Drawn,
    landmarks_m: Vec<[f64; 3]>,
    robot: RobotModel,
    map: Map,
    start: PoseBox,
}

impl<'a> Readings<'a> {
    pub(super) fn of(scene: &Scene, record: &'a RunRecord, log: &'a ReadingLog) -> Self {
        let behind = log.observations.iter().map(|observation| observation.truth);
        let mut truths: Vec<Truth> = behind.chain(log.truths.iter().copied()).collect();
        truths.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
        truths.dedup_by(|one, other| one.time_s == other.time_s);
        let landmarks_m =
            scene.landmarks.iter().map(|landmark| [landmark.x_m, landmark.y_m, landmark.height_m]).collect();
        Readings {
            observations: &log.observations,
            truths,
            drawn: &record.drawn,
            landmarks_m,
            robot: scene.robot_model(),
            map: scene.map(),
            start: scene.start_box(),
        }
    }

    /// The true history up to an instant, and all readings that have arrived by then; `None` where nothing was measured yet.
    pub(super) fn until(&self, time_s: f64) -> Option<(History, Vec<Box<dyn Kind>>)> {
        let history = self.truth().until(self.truths.iter().position(|truth| truth.time_s == time_s)?);
        let kinds = self.kinds(&history, time_s);
        (history.stamps_s.len() > 1).then(|| (self.with_quantities(history, &kinds), kinds))
    }

    /// The true history of the whole run, so far without quantities.
    fn truth(&self) -> History {
        History {
            stamps_s: self.truths.iter().map(|truth| truth.time_s).collect(),
            poses: self.truths.iter().map(|truth| truth.pose).collect::<Vec<Pose>>(),
            wheel_angle_rad: self.truths.iter().map(|truth| truth.wheel_angle_rad).collect(),
            heave_m: self.truths.iter().map(|truth| truth.heave_m).collect(),
            quantities: BTreeMap::new(),
        }
    }

    /// All kinds of readings, with the readings that have arrived by an instant. A new kind gets a line here.
    fn kinds(&self, history: &History, time_s: f64) -> Vec<Box<dyn Kind>> {
        let motion = Motion { start: self.start, robot: self.robot.clone(), room_m: self.map.room_m };
        let mut kinds: Vec<Box<dyn Kind>> = vec![Box::new(motion), Box::new(self.wheels(history, time_s))];
        kinds.extend(self.gyro(history, time_s).map(|gyro| Box::new(gyro) as Box<dyn Kind>));
        kinds.extend(self.range(history, time_s).map(|range| Box::new(range) as Box<dyn Kind>));
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

    fn range(&self, history: &History, time_s: f64) -> Option<Range> {
        let model = self.robot.range_camera.clone()?;
        let looks = self.observations.iter().filter_map(|observation| {
            let Reading::Range { measured_s, arrived_s, sightings } = &observation.reading else { return None };
            let stamp = history.stamp_at(observation.truth.time_s).filter(|_| *arrived_s <= time_s)?;
            let own = sightings.iter().zip(&observation.codes).filter(|(_, (_, is_own))| *is_own);
            let sightings = own.map(|(sighting, _)| *sighting).collect();
            Some(Look { stamp, measured_s: *measured_s, sightings })
        });
        Some(Range { looks: looks.collect(), model, body: self.robot.body })
    }

    /// The history with the true values of all quantities that the kinds name.
    fn with_quantities(&self, mut history: History, kinds: &[Box<dyn Kind>]) -> History {
        for kind in kinds {
            for declared in kind.declared(&history) {
                history.quantities.insert(declared.quantity, self.true_value(declared.quantity));
            }
        }
        history
    }

    /// True value of a quantity; NaN for one that the run does not have.
    fn true_value(&self, quantity: Quantity) -> f64 {
        let (base, devices) = (&self.drawn.base, &self.drawn.devices);
        let gyro = devices.gyro.as_ref();
        let range = devices.range_camera.as_ref();
        let value = match quantity {
            Quantity::WheelRadius(wheel) => Some(base.wheel_radius_m[wheel]),
            Quantity::Track => Some(base.track_m),
            Quantity::GyroBias => gyro.map(|gyro| gyro.bias_rad_per_s),
            Quantity::GyroScale => gyro.map(|gyro| gyro.scale),
            Quantity::RangePosition(axis) => range.map(|range| range.position_m[axis]),
            Quantity::RangeYaw => range.map(|range| range.yaw_rad),
            Quantity::RangeTilt(axis) => range.map(|range| range.tilt_rad[axis]),
            Quantity::RangeFocal => range.map(|range| range.focal_px),
            Quantity::RangeBaseline => range.map(|range| range.baseline_m),
            Quantity::Landmark(code, axis) => self.landmarks_m.get(code as usize).map(|landmark_m| landmark_m[axis]),
            Quantity::BodyTilt(stamp, axis) => {
                // The history begins with the first of the truths and has a stamp for each.
                self.truths.get(stamp).map(|truth| truth.tilt_rad[axis])
            }
        };
        value.unwrap_or(f64::NAN)
    }
}
