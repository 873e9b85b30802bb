//! The range camera: which landmarks both of its views see, at which columns, and for which landmarks they are taken.

use std::collections::{BTreeMap, VecDeque};

use localizer::{
    Reading,
    reading::{LandmarkId, Sighting},
};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    drawn::{Drawn, DrawnRangeCamera, Repeated},
    randomness,
    scene::{RangeCamera, Scene},
    truth::Truth,
    world::Bystander,
};

use super::{Observation, sight::Obstacles};

/// Time of the first reading: no stamp is to lie before the start of the clock, whatever its error.
pub(crate) const FIRST_S: f64 = 0.1;

/// A range camera that measures every period.
pub struct RangeCameraSensor {
    camera: RangeCamera,
    mount: DrawnRangeCamera,
    landmarks: Vec<Point3<f64>>,
    obstacles: Obstacles,
    confusion: Confusion,
    clock: Repeated,
    /// Of the columns in the first and in the second view. In a drift they go to opposite sides, so that distances are all wrong alike.
    noise: Repeated,
    n_readings: u64,
}

impl RangeCameraSensor {
    /// The scene's range camera, or `None` if the robot has none.
    pub fn new(scene: &Scene, seed: u64, drawn: &Drawn) -> Option<Self> {
        let (camera, mount) = (scene.robot.range_camera.clone()?, drawn.range_camera?);
        let landmarks: Vec<Point3<f64>> =
            scene.landmarks.iter().map(|landmark| Point3::new(landmark.x_m, landmark.y_m, landmark.height_m)).collect();
        Some(RangeCameraSensor {
            confusion: Confusion::new(&camera, landmarks.len(), randomness::stream(seed, "range_camera.confusion")),
            obstacles: Obstacles::new(scene),
            clock: Repeated::new(scene.robot.errors, randomness::stream(seed, "range_camera.clock")),
            noise: Repeated::new(scene.robot.errors, randomness::stream(seed, "range_camera.columns")),
            n_readings: 0,
            landmarks,
            camera,
            mount,
        })
    }

    /// Looks at one physics step; answers with a reading when one is due.
    pub fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack, so that a period in decimal seconds falls on its step.
        if truth.time_s + 0.0005 < FIRST_S + self.n_readings as f64 * self.camera.period_s {
            return None;
        }
        self.n_readings += 1;
        let world_from_sensor = world_from_range_camera(truth, &self.mount, self.camera.height_m);
        let exact: Vec<(u32, [f64; 2])> = self
            .landmarks
            .iter()
            .zip(0..)
            .filter_map(|(landmark, code)| Some((code, self.columns(landmark, &world_from_sensor, people)?)))
            .collect();
        let (mut seen, mut greatest_noise_px) = (Vec::with_capacity(exact.len()), 0.0);
        for (code, columns_px) in exact {
            let noise_px = [1.0, -1.0].map(|side| side * self.noise.one_way(self.camera.column_noise_px));
            greatest_noise_px = noise_px.iter().fold(greatest_noise_px, |most: f64, noise_px| most.max(noise_px.abs()));
            seen.push((code, self.rounded([0, 1].map(|view| columns_px[view] + noise_px[view]))));
        }
        let sightings = self.confusion.name(&seen);
        let codes = seen
            .iter()
            .zip(&sightings)
            .map(|((truly, _), sighting)| (sighting.landmark, sighting.landmark.0 == *truly))
            .collect();
        let measured_s = truth.time_s + self.clock.one_way(self.camera.stamp_tolerance_s);
        let late_s = self.camera.latency_s + self.clock.in_turn(self.camera.latency_tolerance_s);
        let arrived_s = truth.time_s + late_s.max(0.0);
        let reading = Reading::Range { measured_s, arrived_s, sightings };
        Some(Observation { codes, range_noise_px: greatest_noise_px, ..Observation::new(reading, *truth) })
    }

    /// Columns rounded as each view rounds them.
    fn rounded(&self, columns_px: [f64; 2]) -> [f64; 2] {
        [rounded(columns_px[0], self.camera.column_step_px), rounded(columns_px[1], self.camera.match_step_px)]
    }

    /// Exact columns of a landmark in both views; `None` when one of them does not see it.
    fn columns(
        &self,
        landmark: &Point3<f64>,
        world_from_sensor: &Isometry3<f64>,
        people: &[Bystander],
    ) -> Option<[f64; 2]> {
        let camera = &self.camera;
        let in_sensor = world_from_sensor.inverse_transform_point(landmark);
        let range_m = in_sensor.coords.norm();
        if in_sensor.z <= 0.0 || range_m < camera.least_range_m || range_m > camera.greatest_range_m {
            return None;
        }
        let views = [0.0, self.mount.baseline_m].map(|x_m| Point3::new(x_m, 0.0, 0.0));
        let columns = views.map(|view| camera.centre_px() + self.mount.focal_px * (in_sensor.x - view.x) / in_sensor.z);
        let is_in_image = |column_px: f64| (-0.5..=f64::from(camera.width_px) - 0.5).contains(&column_px);
        let is_free = |view: &Point3<f64>| self.obstacles.leave_free(world_from_sensor * view, *landmark, people);
        if !columns.into_iter().all(is_in_image) || !views.iter().all(is_free) {
            return None;
        }
        Some(columns)
    }
}

/// The nearest multiple of the step.
fn rounded(column_px: f64, step_px: f64) -> f64 {
    (column_px / step_px).round() * step_px
}

/// `world_from_sensor` of the first view at `truth`: sensor x right, y down, z forward.
pub fn world_from_range_camera(truth: &Truth, mount: &DrawnRangeCamera, height_m: f64) -> Isometry3<f64> {
    let [forward_m, left_m] = mount.position_m;
    let tilt = vector![mount.tilt_rad[0], mount.tilt_rad[1], 0.0];
    let body_from_mount = Isometry3::from_parts(
        Translation3::new(forward_m, left_m, height_m),
        UnitQuaternion::from_scaled_axis(tilt) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), mount.yaw_rad),
    );
    // Columns are sensor x, y, z in the robot frame: right is −y, down is −z, forward is x.
    let columns = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let ahead = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns));
    truth.world_from_body() * body_from_mount * ahead
}

/// Takes a landmark for another one now and then, within the bounds that the scene declares.
struct Confusion {
    camera: RangeCamera,
    n_landmarks: usize,
    rng: ChaCha8Rng,
    /// For each code, how its last uses were: wrong or right. The newest is at the back.
    uses: BTreeMap<u32, VecDeque<bool>>,
}

impl Confusion {
    fn new(camera: &RangeCamera, n_landmarks: usize, rng: ChaCha8Rng) -> Self {
        Confusion { camera: camera.clone(), n_landmarks, rng, uses: BTreeMap::new() }
    }

    /// Gives each of the landmarks seen a code, mostly its own.
    fn name(&mut self, seen: &[(u32, [f64; 2])]) -> Vec<Sighting> {
        let mut n_wrong = 0;
        let mut sightings = Vec::with_capacity(seen.len());
        for &(code, [left_px, right_px]) in seen {
            let wanted = self.camera.wrong_share > 0.0 && self.rng.random::<f64>() < self.camera.wrong_share;
            let other = if wanted && n_wrong < self.camera.wrong_items_max { self.other_than(code) } else { None };
            n_wrong += usize::from(other.is_some());
            let given = other.unwrap_or(code);
            self.note(given, other.is_some());
            sightings.push(Sighting { landmark: LandmarkId(given), left_px, right_px });
        }
        sightings
    }

    /// Another landmark's code among those that may be used wrongly again; `None` if there is none.
    fn other_than(&mut self, code: u32) -> Option<u32> {
        let was_wrong = |other: &u32| self.uses.get(other).is_some_and(|uses| uses.iter().any(|is_wrong| *is_wrong));
        let allowed: Vec<u32> =
            (0..self.n_landmarks as u32).filter(|other| *other != code && !was_wrong(other)).collect();
        (!allowed.is_empty()).then(|| allowed[self.rng.random_range(0..allowed.len())])
    }

    fn note(&mut self, code: u32, is_wrong: bool) {
        let uses = self.uses.entry(code).or_default();
        uses.push_back(is_wrong);
        while uses.len() > self.camera.wrong_spacing {
            uses.pop_front();
        }
    }
}
