//! A drive made by hand, with readings that are computed from it by the formulas of school geometry.

use std::{collections::BTreeMap, f64::consts::TAU, path::Path};

use interval::Interval;
use localizer::{
    Pose, PoseBox,
    bounds::Assumption,
    reading::{LandmarkId, Sighting},
    robot::RobotModel,
};

use super::super::{
    gyro::{Gyro, TurnRate},
    history::{History, Looker, Quantity},
    kind::Kind,
    motion::Motion,
    range::{Look, Range},
    search::check,
    wheels::Wheels,
};
use crate::scene::Scene;

/// Time between two stamps.
pub(super) const STEP_S: f64 = 0.01;
/// Number of steps of the drive.
pub(super) const N_STEPS: usize = 200;
pub(super) const SPEED_M_PER_S: f64 = 0.2;
pub(super) const TURN_RAD_PER_S: f64 = 0.3;

pub(super) fn scene() -> Scene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/papers/rigid_transform_loop.toml");
    Scene::load(Path::new(path)).unwrap()
}

/// A drive on a circle with nominal devices and readings without error, and what is broken of it.
pub(super) struct Drive {
    pub(super) robot: RobotModel,
    pub(super) history: History,
    looks: Vec<usize>,
}

impl Drive {
    /// The drive for two seconds, with a look at two landmarks at each stamp of `looks`.
    pub(super) fn on_circle(looks: &[usize]) -> Drive {
        let robot = scene().robot_model();
        let camera = robot.range_camera.clone().unwrap();
        let times_s: Vec<f64> = (0..=N_STEPS).map(|step| step as f64 * STEP_S).collect();
        let radius_m = SPEED_M_PER_S / TURN_RAD_PER_S;
        let poses = times_s.iter().map(|time_s| {
            let heading_rad = TURN_RAD_PER_S * time_s;
            let (sin, cos) = heading_rad.sin_cos();
            Pose { x_m: 2.0 + radius_m * sin, y_m: 1.0 + radius_m * (1.0 - cos), heading_rad }
        });
        let [wheel_m, track_m] = [robot.wheels.radius_m[0].mid(), robot.wheels.track_m.mid()];
        let angles = times_s
            .iter()
            .map(|time_s| [-0.5, 0.5].map(|side| (SPEED_M_PER_S + side * track_m * TURN_RAD_PER_S) * time_s / wheel_m));
        let mut quantities = BTreeMap::from([
            (Quantity::WheelRadius(0), wheel_m),
            (Quantity::WheelRadius(1), wheel_m),
            (Quantity::Track, track_m),
            (Quantity::GyroBias, 0.0),
            (Quantity::GyroScale, 1.0),
            (Quantity::RangePosition(0), camera.position_m[0].mid()),
            (Quantity::RangePosition(1), camera.position_m[1].mid()),
            (Quantity::RangeYaw, 0.0),
            (Quantity::RangeTilt(0), 0.0),
            (Quantity::RangeTilt(1), 0.0),
            (Quantity::RangeFocal, camera.focal_px.mid()),
            (Quantity::RangeBaseline, camera.baseline_m.mid()),
        ]);
        for (code, place_m) in [(7, [4.2, 1.3]), (9, [4.0, 0.6])] {
            quantities.insert(Quantity::Landmark(code, 0), place_m[0]);
            quantities.insert(Quantity::Landmark(code, 1), place_m[1]);
            quantities.insert(Quantity::Landmark(code, 2), camera.height_m);
        }
        for &stamp in looks {
            quantities.insert(Quantity::BodyTilt(stamp, 0), 0.0);
            quantities.insert(Quantity::BodyTilt(stamp, 1), 0.0);
            quantities.insert(Quantity::Heave(stamp), 0.0);
            quantities.insert(Quantity::Instant(Looker::Range, stamp), times_s[stamp]);
        }
        let history = History {
            poses: poses.collect(),
            wheel_angle_rad: angles.collect(),
            counted: Vec::new(),
            stamps_s: times_s,
            quantities,
        };
        Drive { robot, history, looks: looks.to_vec() }
    }

    /// All kinds with readings that the drive gives without any error.
    pub(super) fn kinds(&self) -> Vec<Box<dyn Kind>> {
        vec![Box::new(self.motion()), Box::new(self.wheels()), Box::new(self.gyro()), Box::new(self.range())]
    }

    pub(super) fn motion(&self) -> Motion {
        let start = PoseBox::from(self.history.poses[0].to_array().map(Interval::point));
        Motion {
            start,
            robot: self.robot.clone(),
            room_m: [Interval::new(0.0, 5.0), Interval::new(0.0, 4.0)],
            looks: self.looks.clone(),
        }
    }

    pub(super) fn wheels(&self) -> Wheels {
        let per_turn = self.robot.wheels.ticks_per_turn;
        let ticks = |angle_rad: &[f64; 2]| angle_rad.map(|angle_rad| (angle_rad / TAU * per_turn + 0.5).floor() as i64);
        let readings = self.history.wheel_angle_rad.iter().map(ticks).enumerate();
        let readings = readings.map(|(stamp, ticks)| (stamp, Some(ticks))).collect();
        Wheels { readings, model: self.robot.wheels.clone(), reach: self.robot.reach }
    }

    pub(super) fn gyro(&self) -> Gyro {
        let readings =
            (0..N_STEPS).map(|from| TurnRate { from, to: from + 1, rate_rad_per_s: TURN_RAD_PER_S }).collect();
        Gyro { readings, model: self.robot.gyro.unwrap() }
    }

    /// The columns by the pinhole camera's formula in the plane: f·right/ahead, and f·(right − b)/ahead.
    pub(super) fn range(&self) -> Range {
        let model = self.robot.range_camera.clone().unwrap();
        let sighting = |stamp: usize, code: u32| {
            let pose = self.history.poses[stamp];
            let (sin, cos) = pose.heading_rad.sin_cos();
            let [east_m, north_m] = [0, 1].map(|axis| self.history.value(Quantity::Landmark(code, axis)));
            let [dx, dy] = [east_m - pose.x_m, north_m - pose.y_m];
            let ahead_m = cos * dx + sin * dy - model.position_m[0].mid();
            let right_m = sin * dx - cos * dy + model.position_m[1].mid();
            let column = |right_m: f64| model.centre_px + model.focal_px.mid() * right_m / ahead_m;
            let [left_px, right_px] = [column(right_m), column(right_m - model.baseline_m.mid())];
            Sighting { landmark: LandmarkId(code), left_px, right_px }
        };
        let looks = self.looks.iter().map(|&stamp| Look {
            stamp,
            measured_s: self.history.stamps_s[stamp],
            sightings: vec![sighting(stamp, 7), sighting(stamp, 9)],
        });
        Range { looks: looks.collect(), stamp_error_s: model.stamp_error_s, model }
    }

    /// The bound that a changed history breaks, with the readings of the unchanged one.
    pub(super) fn broken_by(&self, change: impl Fn(&mut History)) -> Option<Assumption> {
        let mut changed = self.history.clone();
        change(&mut changed);
        check(&changed, &self.kinds(), 0.0).err().map(|broken| broken.bound)
    }
}
