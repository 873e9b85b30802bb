//! Sighting of a landmark by a range camera: from the columns in the two views to a box in the robot frame.
//!
//! **Columns.** The true column is within half a step of the reading, so that a sighting is the quadrilateral of the paper's Fig. 2: z =
//! f·b/(left − right), x = b·(left − centre)/(left − right). With u = left − centre and w = right − centre, the coordinate along any
//! direction α forward + β right is b·(α f + β u)/(u − w), whose derivatives by u and by w have the signs of −(α f + β w) and of α f + β u,
//! neither of which depends on its own variable. So the hull is taken over the four corners of the cell, and is tight for every yaw.
//!
//! **Tilt.** Let p be the vector from sensor to landmark, of horizontal length r and height |h| ≤ H, and let the vertical be turned by
//! tilts τ₁, τ₂, … about horizontal axes. A tilt by τᵢ moves a horizontal unit vector horizontally by at most 1 − cos τᵢ and raises it by
//! at most sin τᵢ; a later tilt τⱼ turns that height into a horizontal shift of sin τᵢ sin τⱼ. All these shifts together are at most (Σ
//! τᵢ)²/2. The vertical unit vector moves horizontally by the sine of the angle between the verticals, at most sin Σ τᵢ. So
//! |Δp| ≤ H sin τ + r τ²/2 in any direction. A body's roll and pitch are two tilts of at most √2 times the body's tilt together, and with
//! them the heading is that of the forward axis, hence τ² instead of τ²/2, with τ = body tilt + mount tilt. The mount itself stands at a
//! height z and a distance a from the origin, about which the body tilts; this adds z sin τ + a τ² likewise.
//!
//! For the graph the tilt of the mount is told from that of the body. Let ẑ be the vertical, β ≤ τ_b the angle by which the body tilts it, M the mount's
//! tilt by τ_m at most, and h the landmark's height above the sensor at rest. A body that tilts and heaves raises the sensor by at most ε = heave + a
//! sin τ_b + z (1 − cos τ_b). With n horizontal, the sensor sees the height (h ± ε)·ẑ as (h ± ε)·M⁻¹(ẑ cos β + n sin β). The horizontal part of
//! h·M⁻¹ẑ is the same whenever the landmark is seen and no longer than H sin τ_m; what is left is at most ε sin τ_m + (H + ε)·(sin τ_b + (1 − cos τ_b)
//! sin τ_m).
//!
//! **Stamp.** Between the true instant and the stamped one the robot moves by at most v·e and turns by at most ω·e: a landmark at q of the
//! robot frame moves there by at most (v + ω|q|)·e. The box is inflated, and not the pose, because the same box is claimed, contracts the
//! pose at the stamp, and is used to learn the landmark.

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseBox, RobotModel,
    bounds::{self, Assumption},
    graph::{Columns, Disc, Domain, Relations, Row, Stray, Variable, sighting_rows},
    reading::{LandmarkId, Sighting},
    robot::{BodyModel, RangeCameraModel, Reach},
};

use super::codes::RightCodes;

/// Landmark seen in a reading, with its box in the robot frame at the reading's stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Code of the landmark that the sighting is attributed to; a wrong match has the wrong code.
    pub landmark: LandmarkId,
    /// Box of the landmark forward and left of the robot origin; unbounded when its disparity may be 0.
    pub in_robot_m: [Interval; 2],
}

/// Range camera on a robot, with every declared error.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    pub(super) camera: RangeCameraModel,
    pub(super) body: BodyModel,
    pub(super) reach: Reach,
}

/// Greatest tilt of body and mount together for which a sighting is evaluated; beyond it nothing is said about the landmark's place.
const MOST_TILT_RAD: f64 = 0.5;
/// Factor that makes up for the few roundings of a sum of positive terms.
const ABOVE: f64 = 1.0 + 1e-12;

impl Sensor {
    /// Makes the sensor from a robot's range camera, if the robot has one.
    pub fn new(robot: &RobotModel) -> Option<Self> {
        Some(Sensor { camera: robot.range_camera.clone()?, body: robot.body, reach: robot.reach })
    }

    /// Box at which a sighting puts its landmark in the robot frame.
    pub fn seen(&self, sighting: &Sighting) -> Seen {
        let in_robot_m = self.in_robot(sighting).unwrap_or([Interval::ENTIRE; 2]);
        Seen { landmark: sighting.landmark, in_robot_m }
    }

    fn in_robot(&self, sighting: &Sighting) -> Option<[Interval; 2]> {
        self.in_robot_by(&Columns::of(&self.camera, sighting))
    }

    /// Box in the robot frame of a landmark with the given columns.
    fn in_robot_by(&self, columns: &Columns) -> Option<[Interval; 2]> {
        let camera = &self.camera;
        let in_view = self.in_view(columns, camera.yaw_rad)?;
        let blur_m = self.displacement(in_view, &Stray::by_reach(camera.stamp_error_s, &self.reach))?;
        Some([0, 1].map(|axis| (in_view[axis] + camera.position_m[axis]).inflate(blur_m)))
    }

    /// Box of a landmark in the sensor frame: x right, z forward. `None` when the disparity may be 0.
    pub fn in_sensor(&self, sighting: &Sighting) -> Option<[Interval; 2]> {
        let [forward_m, left_m] = self.in_view(&Columns::of(&self.camera, sighting), Interval::ZERO)?;
        Some([-left_m, forward_m])
    }

    /// Hull of the places with the given columns along the axes turned back by `yaw_rad`: forward and left of the optical centre.
    pub(super) fn in_view(&self, columns: &Columns, yaw_rad: Interval) -> Option<[Interval; 2]> {
        let camera = &self.camera;
        if columns.disparity_px.lo() <= 0.0 {
            return None;
        }
        let (cosine, sine) = (yaw_rad.cos(), yaw_rad.sin());
        Some(columns.hull_over(|first_px, disparity_px| {
            let along = [camera.focal_px * cosine + sine * first_px, camera.focal_px * sine - cosine * first_px];
            along.map(|side| camera.baseline_m / disparity_px * side)
        }))
    }

    /// Greatest distance by which the body's tilt and heave and the stamp's error move a landmark in the robot frame, beside what the tilt of the mount
    /// makes whenever it is seen.
    pub(super) fn sway_m(&self, in_view: [Interval; 2], stray: &Stray) -> Option<f64> {
        let by_tilts_m: f64 = self.blur_m(in_view)?.iter().sum();
        let shift_m = self.shift_m(stray);
        let away_m =
            length(self.camera.position_m) + length(in_view) + by_tilts_m + self.mount_displacement_m() + shift_m;
        Some((by_tilts_m + shift_m + stray.radians * away_m) * ABOVE)
    }

    /// Greatest distance by which tilts and stamp error move a landmark in the robot frame, in any direction. `stray` bounds the robot's motion
    /// within the stamp's error.
    fn displacement(&self, in_view: [Interval; 2], stray: &Stray) -> Option<f64> {
        let tilted_m = self.tilt_displacement(in_view)?;
        let away_m = length(self.camera.position_m) + length(in_view) + tilted_m + self.shift_m(&Stray::default());
        Some((tilted_m + stray.radians * away_m + self.shift_m(stray)) * ABOVE)
    }

    /// Greatest distance by which tilts and stamp error displace all landmarks in common: the robot moves, and the mount moves with the body's tilt.
    fn shift_m(&self, stray: &Stray) -> f64 {
        let (camera, tilt_rad) = (&self.camera, self.body.tilt_rad);
        (camera.height_m * tilt_rad.sin() + length(camera.position_m) * tilt_rad * tilt_rad + stray.metres) * ABOVE
    }

    /// Greatest distance by which tilts move a landmark in the robot frame beside what they displace all landmarks in common.
    fn tilt_displacement(&self, in_view: [Interval; 2]) -> Option<f64> {
        let tilt_rad = self.body.tilt_rad + self.camera.tilt_rad;
        let raised_m = self.camera.height_span_m * tilt_rad.sin();
        Some((raised_m + self.foreshortening(in_view)?) * ABOVE)
    }

    /// Greatest distance by which tilts move what is at the sensor's own height, beside what they displace all landmarks in common: r τ².
    fn foreshortening(&self, in_view: [Interval; 2]) -> Option<f64> {
        let tilt_rad = self.body.tilt_rad + self.camera.tilt_rad;
        if tilt_rad > MOST_TILT_RAD {
            return None;
        }
        // The measured length is that of the tilted vector: r ≤ r′ + H sin τ + r τ².
        let raised_m = self.camera.height_span_m * tilt_rad.sin();
        let range_m = (length(in_view) + raised_m) / (1.0 - tilt_rad * tilt_rad);
        Some(range_m * tilt_rad * tilt_rad * ABOVE)
    }

    /// Greatest distance by which the tilt of the mount alone moves a landmark in the robot frame, in the same way whenever it is seen.
    pub(super) fn mount_displacement_m(&self) -> f64 {
        self.camera.height_span_m * self.camera.tilt_rad.sin() * ABOVE
    }

    /// Greatest distances by which tilts move a landmark in the robot frame beside what they displace all landmarks in common and beside what the tilt of
    /// the mount alone does: by the heights of landmark and sensor, and by foreshortening.
    fn blur_m(&self, in_view: [Interval; 2]) -> Option<[f64; 2]> {
        let (camera, body) = (&self.camera, &self.body);
        let foreshortened_m = self.foreshortening(in_view)?;
        let (sine, cosine) = body.tilt_rad.sin_cos();
        let rises_m = body.heave_m + length(camera.position_m) * sine + camera.height_m * (1.0 - cosine);
        let mount = camera.tilt_rad.sin();
        let by_height_m = rises_m * mount + (camera.height_span_m + rises_m) * (sine + (1.0 - cosine) * mount);
        Some([by_height_m * ABOVE, foreshortened_m])
    }
}

/// The sightings of one reading as relations between the pose, the landmarks and the constants of the camera.
pub(super) struct Sightings {
    sensor: Sensor,
    /// In the order of the sightings in the reading.
    sighted: Vec<Sighted>,
    codes: Arc<RightCodes>,
    /// Whether a code may be wrong.
    may_be_wrong: bool,
}

/// Least number of landmarks that are certain in a reading for it to be worth a key frame where codes may be wrong: two give a pose, and the more there
/// are, the narrower it is.
const FEWEST_CERTAIN: usize = 4;

/// A sighting of a reading.
struct Sighted {
    /// Where it puts the landmark if its code is right; `None` where the disparity may be 0.
    if_right: Option<Place>,
    /// Where the landmark certainly is, although the code of a sighting may be wrong.
    despite_wrong: Option<Place>,
}

/// Where a reading shows a landmark.
#[derive(Clone, Copy)]
struct Place {
    columns: Columns,
    /// Box in which the landmark is seen from the camera, along the axes of the robot frame.
    in_view: [Interval; 2],
    /// The landmark with its box in the robot frame.
    seen: Seen,
    /// What share of the columns' widths comes from carrying earlier readings, by the robot's motion, tilts and stamps. The graph's rows put all of it
    /// down to the slip of the wheels.
    by_carrying: f64,
}

impl Place {
    fn new(sensor: &Sensor, landmark: LandmarkId, columns: Columns) -> Option<Place> {
        let in_view = sensor.in_view(&columns, sensor.camera.yaw_rad)?;
        let in_robot_m = sensor.in_robot_by(&columns)?;
        let by_carrying = (1.0 - sensor.camera.step_px[0] / columns.first_px.width()).max(0.0);
        Some(Place { columns, in_view, seen: Seen { landmark, in_robot_m }, by_carrying })
            .filter(|place| place.seen.is_bounded())
    }
}

impl Sightings {
    /// The relations of those sightings whose disparity cannot be 0. `codes` says which of them certainly have the right code, by the time at which
    /// it is asked; `despite_wrong` has, for each sighting, the columns at which the reading certainly shows the landmark that its code names, where
    /// that is known.
    pub(super) fn new(
        sensor: &Sensor,
        sightings: &[Sighting],
        codes: Arc<RightCodes>,
        despite_wrong: &[Option<Columns>],
    ) -> Sightings {
        let place = |landmark, columns| Place::new(sensor, landmark, columns);
        let sighted = sightings.iter().enumerate().map(|(number, sighting)| {
            let landmark = sighting.landmark;
            let despite_wrong = despite_wrong.get(number).copied().flatten();
            Sighted {
                if_right: place(landmark, Columns::of(&sensor.camera, sighting)),
                despite_wrong: despite_wrong.and_then(|columns| place(landmark, columns)),
            }
        });
        let may_be_wrong = sensor.camera.q_items > 0;
        Sightings { sighted: sighted.collect(), sensor: sensor.clone(), codes, may_be_wrong }
    }

    /// Where landmarks certainly are seen: by sightings that certainly have the right code, and despite those that may have a wrong one.
    fn certain(&self) -> impl Iterator<Item = &Place> {
        self.sighted.iter().enumerate().filter_map(|(number, sighted)| match self.codes.is_right(number) {
            true => sighted.if_right.as_ref(),
            false => sighted.despite_wrong.as_ref(),
        })
    }
}

impl Relations for Sightings {
    fn quantities(&self, _frame: usize, pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let tilted = Interval::centred(0.0, self.sensor.mount_displacement_m());
        let of_landmark = |place: &Place| {
            let (landmark, in_world) = (place.seen.landmark, place.seen.in_world(pose));
            let at = |axis: usize| (Variable::Landmark(landmark, axis), in_world[axis]);
            let by_tilt = |axis: usize| (Variable::TiltedLandmark(landmark, axis), tilted);
            [at(0), at(1), by_tilt(0), by_tilt(1)]
        };
        self.certain().flat_map(of_landmark).collect()
    }

    fn discs(&self, _frame: usize) -> Vec<Disc> {
        let pair = |place: &Place| [0, 1].map(|axis| Variable::TiltedLandmark(place.seen.landmark, axis));
        self.certain().map(|place| (pair(place), self.sensor.mount_displacement_m())).collect()
    }

    fn is_worth_a_key_frame(&self) -> bool {
        !self.may_be_wrong || self.certain().count() >= FEWEST_CERTAIN
    }

    fn is_found_anew(&self) -> bool {
        true
    }

    fn stamp_error_s(&self) -> f64 {
        self.sensor.camera.stamp_error_s
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        self.sensor.shift_m(stray)
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        let by_carrying = [bounds::RANGE_CAMERA_STAMP, bounds::REACH_SPEED].map(|bound| (bound, stray.metres));
        let by_tilt_m = self.sensor.shift_m(&Stray::default());
        by_carrying.into_iter().chain([(bounds::BODY_TILT, by_tilt_m)]).collect()
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::RANGE_CAMERA_STAMP
    }

    fn void_without(&self) -> Option<Assumption> {
        Some(bounds::RANGE_LANDMARKS_Q_ITEMS)
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let is_known =
            |seen: &Seen| (0..2).all(|axis| !domain.value(Variable::Landmark(seen.landmark, axis)).is_empty());
        let rows = |place: &Place| {
            let [by_height_m, foreshortened_m] = self.sensor.blur_m(place.in_view)?;
            let label = |row: Row| {
                row.with_share_of(bounds::RANGE_CAMERA_COLUMNS, bounds::WHEELS_SLIP, place.by_carrying)
                    .with_part(bounds::BODY_TILT, by_height_m)
                    .with_part(bounds::RANGE_CAMERA_TILT, foreshortened_m)
            };
            let blur_m = by_height_m + foreshortened_m;
            let rows = sighting_rows(place.seen.landmark, place.columns, blur_m, frame, domain);
            Some(rows.into_iter().map(label).collect::<Vec<Row>>())
        };
        self.certain().filter(|place| is_known(&place.seen)).filter_map(rows).flatten().collect()
    }
}

impl Seen {
    /// Whether the sighting says anything about the landmark's place.
    pub fn is_bounded(&self) -> bool {
        self.in_robot_m.iter().all(|side| side.is_bounded())
    }

    /// Box of the landmark's place in the world, as seen from a box of poses: t + R(θ) b.
    pub fn in_world(&self, pose: &PoseBox) -> [Interval; 2] {
        if !self.is_bounded() {
            return [Interval::ENTIRE; 2];
        }
        let (cosine, sine) = (pose[2].cos(), pose[2].sin());
        let [forward_m, left_m] = self.in_robot_m;
        [pose[0] + (cosine * forward_m - sine * left_m), pose[1] + (sine * forward_m + cosine * left_m)]
    }
}

/// Greatest length of a vector in a given box.
pub(super) fn length(vector: [Interval; 2]) -> f64 {
    vector[0].hypot(vector[1]).hi()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod remainders;
