//! The planar range scanner, by which the robot sees what stands in its way and by which it is located among the walls of its map.

mod sensor;

use interval::Interval;
use localizer::{
    Map, Method, Reading, RobotModel,
    bounds::{self, Assumption},
    methods::wall_ranges::{DEVICE, Scan, ScannerModel, WallRanges},
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::{
    scene::{Distribution, MethodName, Scanner, Scene},
    truth::randomness::{draw_within, stream},
};

use super::{Device, Sensor, Surroundings, ToldKey, WatchedBound, farthest};

pub use sensor::ScannerSensor;

/// True mount of the scanner on the robot.
#[derive(Clone, Copy, Debug)]
pub struct DrawnScanner {
    /// Position of the scanner in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Direction of the scanner's forward axis from robot forward, counter-clockwise.
    pub yaw_rad: f64,
    /// Turn of the plane of the scanner's beams about the scanner's own forward axis (roll) and left axis (pitch).
    pub tilt_rad: [f64; 2],
}

impl DrawnScanner {
    /// Pose of the scanner on the body.
    pub(crate) fn body_from_scanner(&self, keys: &Scanner) -> Isometry3<f64> {
        let ([forward_m, left_m], [roll_rad, pitch_rad]) = (self.position_m, self.tilt_rad);
        Isometry3::from_parts(
            Translation3::new(forward_m, left_m, keys.height_m),
            UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, self.yaw_rad),
        )
    }
}

impl Device for Scanner {
    type Drawn = DrawnScanner;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnScanner {
        let mut rng = stream(seed, "scanner.mount");
        let mut within = |tolerance: f64| draw_within(tolerance, errors, &mut rng);
        let position_m = [self.forward_m, self.left_m].map(|nominal_m| nominal_m + within(self.position_tolerance_m));
        let tolerance_rad = self.angle_tolerance_deg.to_radians();
        let yaw_rad = self.yaw_deg.to_radians() + within(tolerance_rad);
        // Roll and pitch together tilt the plane by at most the tolerance.
        let tilt_rad = [0; 2].map(|_| within(tolerance_rad * std::f64::consts::FRAC_1_SQRT_2));
        DrawnScanner { position_m, yaw_rad, tilt_rad }
    }

    fn sensor(&self, drawn: &DrawnScanner, scene: &Scene, seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(ScannerSensor::new(self, drawn, scene, seed)))
    }

    fn method(&self, _name: MethodName, scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        let wrong_share = scene.localizer.wall_ranges().wrong_share;
        Some(Box::new(WallRanges::new(self.model(scene), map.walls.as_ref()?, wrong_share, robot)))
    }

    fn first_arrival_s(&self) -> f64 {
        self.latency_s
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::WallRanges)
    }

    fn constants(&self, drawn: &DrawnScanner, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let off_m = farthest(drawn.position_m, [self.forward_m, self.left_m]);
        let tolerance_rad = self.angle_tolerance_deg.to_radians();
        let [roll_rad, pitch_rad] = drawn.tilt_rad;
        vec![
            (bounds::SCANNER_POSITION, self.position_tolerance_m, off_m),
            (bounds::SCANNER_YAW, tolerance_rad, (drawn.yaw_rad - self.yaw_deg.to_radians()).abs()),
            (bounds::SCANNER_TILT, tolerance_rad, (roll_rad.cos() * pitch_rad.cos()).acos()),
        ]
    }

    /// The distance of the walls from their places on the map.
    fn surroundings(&self, _drawn: &DrawnScanner, scene: &Scene, surroundings: &Surroundings<'_>) -> Vec<WatchedBound> {
        let declared_m = scene.localizer.wall_ranges().placement_tolerance_m;
        let off_m = scene.walls_off_m(surroundings.place);
        vec![WatchedBound::throughout(bounds::WALLS_PLACEMENT, declared_m, off_m, surroundings)]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        vec![
            ToldKey::is(&[bounds::SCANNER_RANGE], &mut self.tolerance_m),
            ToldKey::is(&[bounds::SCANNER_POSITION], &mut self.position_tolerance_m),
            ToldKey::is_in_deg(&[bounds::SCANNER_YAW, bounds::SCANNER_TILT], &mut self.angle_tolerance_deg),
            ToldKey::is(&[bounds::SCANNER_STAMP], &mut self.stamp_tolerance_s),
        ]
    }
}

impl Scanner {
    /// The model of the scanner that the localizer is given. Stamps are those of the scanner's own clock; where the base has another clock, the bound
    /// on their error grows by the bound on that clock.
    pub(crate) fn model(&self, scene: &Scene) -> ScannerModel {
        let around = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        let angle_rad = self.angle_tolerance_deg.to_radians();
        ScannerModel {
            position_m: [around(self.forward_m), around(self.left_m)],
            height_m: self.height_m,
            yaw_rad: Interval::centred(self.yaw_deg.to_radians(), angle_rad),
            tilt_rad: angle_rad,
            range_error_m: self.tolerance_m,
            stamp_error_s: self.stamp_tolerance_s + scene.robot.delivery.stamp_tolerance_s,
        }
    }

    /// The mount of the scanner as the scene states it.
    pub(crate) fn nominal(&self) -> DrawnScanner {
        let (position_m, yaw_rad) = ([self.forward_m, self.left_m], self.yaw_deg.to_radians());
        DrawnScanner { position_m, yaw_rad, tilt_rad: [0.0; 2] }
    }

    /// Angle from one beam of the scanner to the next.
    fn step_rad(&self) -> f64 {
        self.field_deg.to_radians() / (self.beams - 1) as f64
    }
}

/// A scan as the driver uses it: where its beams end, as seen from the robot's origin by the nominal mount of the scanner.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    /// Time at which the scan was made, by its stamp.
    pub measured_s: f64,
    /// The beams of the scan, from right to left.
    pub beams: Vec<Beam>,
}

/// Where one beam of the scanner ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Direction in which the end of the beam is seen from the robot's origin, counter-clockwise from robot forward; for a beam that met nothing, the
    /// direction of the beam.
    pub bearing_rad: f64,
    /// Distance of the end of the beam from the robot's origin; `None` where the beam met nothing within the range.
    pub distance_m: Option<f64>,
}

impl Fan {
    /// The scan that a reading holds; `None` for a reading of anything else.
    pub(crate) fn of(reading: &Reading, scanner: &Scanner) -> Option<Fan> {
        let Reading::Other { measured_s, device, numbers, .. } = reading else { return None };
        let scan = Scan::of(numbers).filter(|_| device == DEVICE)?;
        let is_at_origin = scanner.forward_m == 0.0 && scanner.left_m == 0.0;
        let beam = |(index, distance_m): (usize, &Option<f64>)| {
            let bearing_rad = scan.first_rad + index as f64 * scan.step_rad + scanner.yaw_deg.to_radians();
            match distance_m {
                Some(distance_m) if !is_at_origin => {
                    let (sin, cos) = bearing_rad.sin_cos();
                    let [x_m, y_m] = [scanner.forward_m + distance_m * cos, scanner.left_m + distance_m * sin];
                    Beam { bearing_rad: y_m.atan2(x_m), distance_m: Some(x_m.hypot(y_m)) }
                }
                as_it_is => Beam { bearing_rad, distance_m: *as_it_is },
            }
        };
        Some(Fan { measured_s: *measured_s, beams: scan.distances_m.iter().enumerate().map(beam).collect() })
    }
}
