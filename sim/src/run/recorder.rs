//! Records the history of a run while it happens.

use std::time::Instant;

use localizer::{
    Map, Pose, PoseBox, Reading, RobotModel,
    localizer::{Account, PoseWidth},
    motion::PointOdometry,
    reading::Camera,
};
use sha2::{Digest, Sha256};

use crate::{
    devices::Observation,
    scene::Scene,
    subject::{Answer, AnswerKind, Failure, Stated, Subject},
    truth::Truth,
    world::{Drawn, World},
};

use super::range_baselines::Told;
use super::{
    Clearance, FramesPolicy, ImageRecord, LandmarkBaselines, MotionBaselines, RunOptions, RunRecord, STEP_S, Timing,
    Witness,
};

/// Recorder of a run's history while the run happens.
pub(super) struct Recorder<'a> {
    pub(super) history: RunRecord,
    odometry: PointOdometry,
    map: Map,
    robot: RobotModel,
    readings: Sha256,
    keep_images: FramesPolicy,
    /// Numbers of readings of the methods so far: of readings that are no pictures, and of pictures.
    n_read: [usize; 2],
    asks_baselines: bool,
    /// Time of the run at which the present drive began.
    pub(super) offset_s: f64,
    /// Start of the present drive as the localizer is given it: `start_box` is the box of possible poses, `start` the middle of that box.
    start: Pose,
    start_box: PoseBox,
    pub(super) witness: &'a mut dyn Witness,
    /// Kind of the answers so far.
    kind: Option<AnswerKind>,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(
        scene: &Scene,
        seed: u64,
        drawn: Drawn,
        adapter: Option<String>,
        options: &RunOptions,
        witness: &'a mut dyn Witness,
    ) -> Self {
        // Odometry alone knows no better start than the middle of the start box that the localizer is given.
        let odometry = PointOdometry::new(scene.nominal_start());
        Recorder {
            history: RunRecord {
                motion_baselines: MotionBaselines::new(scene, &scene.robot_model()),
                landmark_baselines: if options.baselines {
                    LandmarkBaselines::new(scene, &scene.start_box())
                } else {
                    LandmarkBaselines::default()
                },
                ..RunRecord::new(seed, adapter, drawn)
            },
            odometry,
            map: scene.map(),
            robot: scene.robot_model(),
            readings: Sha256::new(),
            keep_images: options.keep_images,
            n_read: [0; 2],
            asks_baselines: options.baselines,
            offset_s: 0.0,
            witness,
            kind: None,
            start: scene.nominal_start(),
            start_box: scene.start_box(),
        }
    }

    /// Begins the drive at the station (stated pose) of this index, after the drives at the stations before it.
    pub(super) fn restart(&mut self, index: usize, lasts_s: f64, here: &Scene) {
        self.offset_s = index as f64 * (lasts_s + STEP_S);
        self.start = here.nominal_start();
        self.start_box = here.start_box();
        self.odometry = PointOdometry::new(self.start);
        self.history.range_baselines.restart();
        self.compared(|recorder| recorder.history.landmark_baselines.restart(here, &recorder.start_box));
        self.history.restarts.push(self.history.truths.len());
        self.witness.start(self.offset_s, Some(index));
    }

    /// Runs `work` and adds the wall-clock time that it takes to a stage.
    pub(super) fn timed<T>(&mut self, stage: impl FnOnce(&mut Timing) -> &mut f64, work: impl FnOnce() -> T) -> T {
        let began = Instant::now();
        let answer = work();
        *stage(&mut self.history.timing) += began.elapsed().as_secs_f64();
        answer
    }

    /// Runs `work` on one reading for the localizer under test, and adds the wall-clock time that it takes to a stage and to the times of readings.
    pub(super) fn timed_reading<T>(
        &mut self,
        stage: impl FnOnce(&mut Timing) -> &mut f64,
        work: impl FnOnce() -> T,
    ) -> T {
        let began = Instant::now();
        let answer = work();
        let took_s = began.elapsed().as_secs_f64();
        let timing = &mut self.history.timing;
        *stage(timing) += took_s;
        timing.slowest_reading_s = timing.slowest_reading_s.max(took_s);
        self.history.n_readings += 1;
        answer
    }

    /// Records a reading on its way into the localizer.
    pub(super) fn sense(&mut self, observation: &Observation) {
        let reading = &observation.reading;
        self.witness.sense(observation);
        self.compared(|recorder| {
            recorder.history.motion_baselines.sense(reading);
            recorder.history.landmark_baselines.sense(reading, &observation.truth);
        });
        self.history.bounds.note(&observation.checks, self.offset_s);
        self.readings.update(reading.measured_s().to_le_bytes());
        self.readings.update(reading.arrived_s().to_le_bytes());
        match reading {
            Reading::Wheels { ticks, .. } => {
                ticks.iter().for_each(|count| self.readings.update(count.to_le_bytes()));
                self.odometry.advance(*ticks, &self.robot.wheels);
            }
            Reading::Camera { exposure_s, image, .. } => {
                self.readings.update(exposure_s.to_le_bytes());
                self.readings.update(image.as_raw());
            }
            Reading::Gyro { rate_rad_per_s, .. } => self.readings.update(rate_rad_per_s.to_le_bytes()),
            Reading::Flow { counts, blind_periods, .. } => {
                counts.iter().for_each(|count| self.readings.update(count.to_le_bytes()));
                self.readings.update(blind_periods.to_le_bytes());
            }
            Reading::Range { sightings, .. } => {
                for sighting in sightings {
                    self.readings.update(sighting.landmark.0.to_le_bytes());
                    self.readings.update(sighting.left_px.to_le_bytes());
                    self.readings.update(sighting.right_px.to_le_bytes());
                }
            }
            Reading::Other { device, numbers, .. } => {
                self.readings.update(device);
                numbers.iter().for_each(|number| self.readings.update(number.to_le_bytes()));
            }
        }
    }

    /// Records what the methods of the localizer made of a reading.
    pub(super) fn images(&mut self, observation: Observation, accounts: Vec<Account>) {
        let Observation { reading, mut truth, codes, .. } = observation;
        self.witness.account(&reading, &accounts);
        truth.time_s += self.offset_s;
        let number = self.history.images.last().map_or(0, |image| image.number + 1);
        self.compared(|recorder| recorder.compare(&reading, &accounts, &truth));
        let n_before = &mut self.n_read[usize::from(matches!(reading, Reading::Camera { .. }))];
        let of_its_kind = *n_before;
        *n_before += usize::from(!accounts.is_empty());
        for account in accounts {
            let failed = account.emptied || !account.posterior.contains(truth.pose);
            let kept = self.keep_images.keeps(of_its_kind, failed).then(|| reading.clone());
            if self.keep_images == FramesPolicy::Failures {
                self.history.keep_widest(&reading, &account.posterior);
            }
            self.history.images.push(ImageRecord {
                number,
                measured_s: reading.measured_s() + self.offset_s,
                arrived_s: reading.arrived_s() + self.offset_s,
                truth,
                camera: match reading {
                    Reading::Camera { camera, .. } => Some(camera),
                    _ => None,
                },
                method: account.method,
                claims: account.claims,
                quota: account.quota,
                rejected_px: account.rejected_px,
                alone: account.alone,
                is_held: account.is_held,
                constrained: account.constrained,
                emptied: account.emptied,
                prior: account.prior.hull(),
                posterior: account.posterior,
                landmarks: account.landmarks,
                codes: codes.clone(),
                reading: kept,
            });
        }
    }

    /// Runs `work` of the methods to compare with, if they are asked for, and adds the wall-clock time that it takes to theirs.
    fn compared(&mut self, work: impl FnOnce(&mut Self)) {
        if self.asks_baselines {
            let began = Instant::now();
            work(self);
            *self.history.timing.baselines_s.get_or_insert(0.0) += began.elapsed().as_secs_f64();
        }
    }

    /// Gives a reading to the methods to compare with that read what it shows.
    fn compare(&mut self, reading: &Reading, accounts: &[Account], truth: &Truth) {
        let (history, robot) = (&mut self.history, &self.robot);
        match (reading, accounts) {
            (_, []) => {}
            (Reading::Camera { camera: Camera::Ceiling, image, .. }, _) => {
                history.marker_baselines.observe(image, &self.map, robot, truth.pose);
            }
            (Reading::Camera { camera: Camera::Forward, image, .. }, _) => {
                let heading_rad = truth.pose.heading_rad;
                if let Some(seen_rad) = history.forward_baselines.observe(image, &self.map, robot, heading_rad) {
                    history.motion_baselines.see(reading.measured_s(), seen_rad);
                }
            }
            (Reading::Range { .. }, accounts) => {
                let Some(camera) = &robot.range_camera else { return };
                // The reading is compared with odometry at its stamp. While the step at that time is not recorded yet, the odometry of the last
                // recorded step stands in for it.
                let step = (history.odometry.len() as f64 - 1.0).min((truth.time_s / STEP_S).round());
                let odometry = history.odometry.get(step.max(0.0) as usize).copied().unwrap_or(self.start);
                let told = Told { start: self.start, start_box: &self.start_box, camera, wheels: &robot.wheels };
                let restarted = !history.restarts.is_empty();
                for account in accounts {
                    history.range_baselines.observe(account, &told, odometry, truth.pose, restarted);
                }
            }
            _ => {}
        }
    }

    /// Whether the localizer under test has failed, so that the run ends.
    pub(super) fn has_failed(&self) -> bool {
        self.history.subject_failure.is_some()
    }

    /// Records the true state and the estimate of a step, apart from each other. A localizer under test that fails at the step leaves none.
    pub(super) fn step(&mut self, truth: &Truth, subject: &dyn Subject) {
        let answer = self.timed(|timing| &mut timing.localizer_s, || subject.estimate_at(truth.time_s));
        if let Some(failure) = subject.failure() {
            self.history.subject_failure = Some(failure.clone().begin_later(self.offset_s));
            // A localizer that never answered has given no boxes to be judged.
            self.history.has_boxes &= !self.history.estimates.is_empty();
            return;
        }
        if let Err(reason) = AnswerKind::hold(&mut self.kind, &answer) {
            let reason = format!("it answered with {reason}");
            let failure = Failure { time_s: truth.time_s, reading: None, reason };
            self.history.subject_failure = Some(failure.begin_later(self.offset_s));
            return;
        }
        self.history.stated.push(Stated::of(&answer));
        self.history.ages_s.push(subject.knows_until_s().map(|known_s| truth.time_s - known_s));
        self.history.has_boxes &= matches!(answer, Answer::Boxes(_));
        let mut estimate = answer.into_estimate(truth.time_s);
        estimate.time_s += self.offset_s;
        if let Some(contradiction) = &mut estimate.contradicting {
            contradiction.begin_later(self.offset_s);
            if self.history.contradictions.last() != Some(contradiction) {
                self.history.contradictions.push(contradiction.clone());
            }
        }
        if let Some(width) = subject.width_by_bound() {
            let width = PoseWidth { stamp_s: width.stamp_s + self.offset_s, ..width.clone() };
            if self.history.widths.last().is_none_or(|last| last.stamp_s != width.stamp_s) {
                self.history.widths.push(width);
            }
        }
        let truth = Truth { time_s: truth.time_s + self.offset_s, ..*truth };
        self.witness.step(&truth, &estimate, self.odometry.pose());
        self.history.truths.push(truth);
        self.history.estimates.push(estimate);
        self.history.odometry.push(self.odometry.pose());
        self.compared(|recorder| {
            recorder.history.motion_baselines.step(truth.time_s);
            recorder.history.landmark_baselines.step();
            recorder.history.range_baselines.step(recorder.odometry.pose());
        });
    }

    /// Records the true robot's distances from walls, furniture and people, if the scene has errands.
    pub(super) fn room_left(&mut self, scene: &Scene, world: &World) {
        if scene.has_errands() && !self.has_failed() {
            self.history.clearances.push(Clearance::of(scene, &world.truth(), &world.people()));
        }
    }

    pub(super) fn finish(mut self, began: Instant) -> RunRecord {
        let digest = self.readings.finalize();
        self.history.readings_digest = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        let timing = &mut self.history.timing;
        timing.wall_s = began.elapsed().as_secs_f64() - timing.baselines_s.unwrap_or(0.0);
        self.history
    }
}
