//! The closed loop: the one screen where everything meets.

mod clearance;
mod forward_baselines;
mod history;
mod marker_baselines;
mod motion_baselines;
mod motion_sensors;
mod range_baselines;
mod witness;

use std::time::Instant;

use localizer::{
    Estimate, Interval, Localizer, Map, Method, Pose, PoseBox, PoseUnion, Reading, RobotModel, Status,
    methods::{
        ceiling_markers::CeilingMarkers,
        floor_tiles::{Chain, FloorTiles},
        range_landmarks::{Freedom, RangeLandmarks, Solver},
        wall_directions::{self, WallDirections},
    },
    motion::PointOdometry,
    reading::Camera,
};
use sha2::{Digest, Sha256};

use crate::{
    drawn::Drawn,
    driver::Pilot,
    frames::FramesPolicy,
    render::{RenderError, Renderer},
    scene::{FloorTilesChain, MethodName, RangeLandmarksFreedom, RangeLandmarksSolver, Scene, WallDirectionsChain},
    sensors::{Observation, Sensors, Stage},
    truth::Truth,
    world::World,
};

pub use clearance::Clearance;
pub use forward_baselines::ForwardBaselines;
pub use history::{ImageRecord, RunRecord, Timing};
pub use marker_baselines::{MarkerBaselines, PaperAnswer};
pub use motion_baselines::MotionBaselines;
pub use motion_sensors::{FlowSight, MotionSensors};
pub use range_baselines::{Answers, RangeBaselines};
pub use witness::Witness;

/// Time between two estimates, two commands and two checks.
const STEP_S: f64 = 0.01;
/// Physics steps in that time.
const PHYSICS_STEPS: usize = 10;

/// What a run keeps besides its figures.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions {
    /// Which images stay in the record, for debug frames.
    pub keep_images: FramesPolicy,
}

/// Runs the scene with one seed: its route, or its stations one after another. `progress` is told the simulated time now and then.
///
/// Errors when a camera cannot be rendered; a robot without a camera needs no renderer.
pub fn run(
    scene: &Scene,
    seed: u64,
    renderer: Option<&mut Renderer>,
    options: &RunOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<RunRecord, RenderError> {
    run_witnessed(scene, seed, renderer, options, &mut (), progress)
}

/// Runs like [`run`] while `witness` looks on.
pub fn run_witnessed(
    scene: &Scene,
    seed: u64,
    renderer: Option<&mut Renderer>,
    options: &RunOptions,
    witness: &mut dyn Witness,
    progress: &mut dyn FnMut(f64),
) -> Result<RunRecord, RenderError> {
    let began = Instant::now();
    let drawn = Drawn::draw(scene, seed);
    let adapter = renderer.as_deref().map(Renderer::adapter);
    let mut record = Recorder::new(scene, seed, drawn.clone(), adapter, options, witness);
    let mut localizer = localizer(scene);
    let mut stage = renderer.map(|renderer| Stage::new(scene, &drawn, renderer)).transpose()?;
    if scene.stations.is_empty() {
        record.witness.start(0.0, None);
        drive(scene, seed, &drawn, stage.as_mut(), &mut localizer, &mut record, progress)?;
    }
    for (index, station) in scene.stations.iter().enumerate() {
        let here = scene.at_station(station);
        // The robot and the floor are the same at every station; where in its box it stands and the noise are not.
        let noise_seed = seed.wrapping_add((index as u64 + 1) << 32);
        let drawn_here = Drawn { start: Drawn::draw(&here, noise_seed).start, ..drawn.clone() };
        record.restart(index, here.duration_s, &here);
        localizer.restart(here.start_box());
        drive(&here, noise_seed, &drawn_here, stage.as_mut(), &mut localizer, &mut record, progress)?;
    }
    Ok(record.finish(began))
}

/// One uninterrupted drive.
fn drive(
    scene: &Scene,
    seed: u64,
    drawn: &Drawn,
    mut stage: Option<&mut Stage<'_>>,
    localizer: &mut Localizer,
    record: &mut Recorder<'_>,
    progress: &mut dyn FnMut(f64),
) -> Result<(), RenderError> {
    let mut world = World::new(scene, drawn);
    let mut sensors = Sensors::new(scene, seed, drawn, stage.as_deref());
    let mut pilot = Pilot::new(scene, drawn);
    look(&world, &mut sensors, stage.as_deref_mut(), localizer, record)?;
    record.step(&world.truth(), localizer);
    record.room_left(scene, &world);
    for step in 0..(scene.duration_s / STEP_S).round() as usize {
        let time_s = step as f64 * STEP_S;
        if pilot.is_done(time_s) {
            break;
        }
        let fan = sensors.look_out(&world.truth(), &world.people());
        let believed = if scene.is_led() { seen(&world.truth()) } else { localizer.estimate_at(world.truth().time_s) };
        let command = pilot.command(&believed, fan.as_ref(), time_s);
        for _ in 0..PHYSICS_STEPS {
            record.timed(|timing| &mut timing.world_s, || world.step(command));
            look(&world, &mut sensors, stage.as_deref_mut(), localizer, record)?;
        }
        record.step(&world.truth(), localizer);
        record.room_left(scene, &world);
        if step % 50 == 0 {
            progress(record.offset_s + time_s);
        }
    }
    record.history.errands = pilot.into_log(world.truth().time_s);
    Ok(())
}

/// What somebody who leads the robot sees of it.
fn seen(truth: &Truth) -> Estimate {
    let pose = PoseUnion::single(PoseBox::from(truth.pose.to_array().map(Interval::point)));
    Estimate { time_s: truth.time_s, pose, status: Status::Sound, relies_on: Vec::new() }
}

/// Hands what arrives at one instant to the localizer.
fn look(
    world: &World,
    sensors: &mut Sensors,
    stage: Option<&mut Stage<'_>>,
    localizer: &mut Localizer,
    record: &mut Recorder<'_>,
) -> Result<(), RenderError> {
    let arrived =
        record.timed(|timing| &mut timing.render_s, || sensors.observe(&world.truth(), &world.people(), stage))?;
    for observation in arrived {
        record.sense(&observation);
        let accounts = record.timed(
            |timing| match observation.reading {
                Reading::Camera { .. } => &mut timing.vision_s,
                _ => &mut timing.localizer_s,
            },
            || localizer.observe(&observation.reading),
        );
        record.images(observation, accounts);
    }
    Ok(())
}

/// The localizer that the scene asks for, told what the scene tells it.
pub(crate) fn localizer(scene: &Scene) -> Localizer {
    let localizer = Localizer::new(scene.map(), scene.robot_model(), methods(scene), scene.start_box());
    match scene.localizer.gyro_bias_wander_deg_per_s2 {
        Some(wander_deg_per_s2) => localizer.learning_gyro_bias(wander_deg_per_s2.to_radians()),
        None => localizer,
    }
}

/// The methods that the scene asks for; a new method is one line here.
fn methods(scene: &Scene) -> Vec<Box<dyn Method>> {
    let (map, robot) = (scene.map(), scene.robot_model());
    let chain = match scene.localizer.floor_tiles_chain {
        FloorTilesChain::Direct => Chain::Direct,
        FloorTilesChain::Paper => Chain::Paper,
    };
    let freedom = match scene.localizer.range_landmarks_freedom {
        RangeLandmarksFreedom::Line => Freedom::Line,
        RangeLandmarksFreedom::Translation => Freedom::Translation,
        RangeLandmarksFreedom::Full => Freedom::Full,
    };
    let solver = match scene.localizer.range_landmarks_solver {
        RangeLandmarksSolver::OneShot => Solver::OneShot,
        RangeLandmarksSolver::Polar => Solver::Polar,
        RangeLandmarksSolver::TableIv => Solver::TableIv,
        RangeLandmarksSolver::Sivia => Solver::Sivia { resolution: 0.05 },
    };
    let setup = scene.localizer.wall_directions();
    let walls = wall_directions::Setup {
        chain: match setup.chain {
            WallDirectionsChain::Direct => wall_directions::Chain::Direct,
            WallDirectionsChain::Paper => wall_directions::Chain::Paper,
            WallDirectionsChain::PaperByTiles => wall_directions::Chain::PaperByTiles,
        },
        learns: setup.learns,
        decides: scene.localizer.methods == [MethodName::WallDirections],
    };
    let build = |name: &MethodName| -> Option<Box<dyn Method>> {
        match name {
            MethodName::FloorTiles => {
                FloorTiles::new(&map, &robot, chain).map(|method| Box::new(method) as Box<dyn Method>)
            }
            MethodName::RangeLandmarks => {
                RangeLandmarks::new(&robot, freedom, solver).map(|method| Box::new(method) as Box<dyn Method>)
            }
            MethodName::CeilingMarkers => {
                CeilingMarkers::new(&map, &robot).map(|method| Box::new(method) as Box<dyn Method>)
            }
            MethodName::WallDirections => {
                WallDirections::new(&map, &robot, walls).map(|method| Box::new(method) as Box<dyn Method>)
            }
        }
    };
    scene.localizer.methods.iter().filter_map(build).collect()
}

/// Writes the run's history down while it happens.
struct Recorder<'a> {
    history: RunRecord,
    odometry: PointOdometry,
    map: Map,
    robot: RobotModel,
    readings: Sha256,
    keep_images: FramesPolicy,
    /// Time at which the present drive began.
    offset_s: f64,
    /// Where the localizer is told that it began, in the middle.
    start: Pose,
    witness: &'a mut dyn Witness,
}

impl<'a> Recorder<'a> {
    fn new(
        scene: &Scene,
        seed: u64,
        drawn: Drawn,
        adapter: Option<String>,
        options: &RunOptions,
        witness: &'a mut dyn Witness,
    ) -> Self {
        // Odometry alone knows no better start than the middle of the box that the localizer is given.
        let odometry = PointOdometry::new(scene.nominal_start());
        Recorder {
            history: RunRecord {
                motion_baselines: MotionBaselines::new(scene, &scene.robot_model()),
                ..RunRecord::new(seed, adapter, drawn)
            },
            odometry,
            map: scene.map(),
            robot: scene.robot_model(),
            readings: Sha256::new(),
            keep_images: options.keep_images,
            offset_s: 0.0,
            witness,
            start: scene.nominal_start(),
        }
    }

    /// Begins the drive of a station after those before it.
    fn restart(&mut self, index: usize, lasts_s: f64, here: &Scene) {
        self.offset_s = index as f64 * (lasts_s + STEP_S);
        self.start = here.nominal_start();
        self.odometry = PointOdometry::new(self.start);
        self.history.range_baselines.restart();
        self.history.motion_sensors.restart();
        self.history.restarts.push(self.history.truths.len());
        self.witness.start(self.offset_s, Some(index));
    }

    /// Runs `work` and adds its wall-clock time to a stage.
    fn timed<T>(&mut self, stage: impl FnOnce(&mut Timing) -> &mut f64, work: impl FnOnce() -> T) -> T {
        let began = Instant::now();
        let answer = work();
        *stage(&mut self.history.timing) += began.elapsed().as_secs_f64();
        answer
    }

    /// Notes a reading on its way into the localizer.
    fn sense(&mut self, observation: &Observation) {
        let reading = &observation.reading;
        self.witness.sense(reading);
        self.history.motion_baselines.sense(reading);
        self.history.motion_sensors.note(observation, self.offset_s);
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
        }
    }

    /// Notes what the methods made of a reading.
    fn images(&mut self, observation: Observation, accounts: Vec<localizer::localizer::Account>) {
        let Observation { reading, mut truth, codes, .. } = observation;
        self.witness.account(&reading, &accounts);
        truth.time_s += self.offset_s;
        let number = self.history.images.last().map_or(0, |image| image.number + 1);
        if let (Reading::Camera { camera: Camera::Ceiling, image, .. }, false) = (&reading, accounts.is_empty()) {
            self.history.marker_baselines.observe(image, &self.map, &self.robot, truth.pose);
        }
        if let (Reading::Camera { camera: Camera::Forward, image, .. }, false) = (&reading, accounts.is_empty()) {
            self.history.forward_baselines.observe(image, &self.map, &self.robot, truth.pose.heading_rad);
        }
        for account in accounts {
            if matches!(reading, Reading::Range { .. }) {
                // Odometry stands still until the stamp's own step has been recorded.
                let step = (self.history.odometry.len() as f64 - 1.0).min((truth.time_s / STEP_S).round());
                let odometry = self.history.odometry.get(step.max(0.0) as usize).copied().unwrap_or(self.start);
                let (start, truth, restarted) = (self.start, truth.pose, !self.history.restarts.is_empty());
                self.history.range_baselines.observe(&account, start, odometry, truth, restarted);
            }
            let failed = account.emptied || !account.posterior.contains(truth.pose);
            let kept = self.keep_images.keeps(number, failed).then(|| reading.clone());
            if self.keep_images == FramesPolicy::Failures {
                self.history.keep_widest(&reading, &account.posterior);
            }
            self.history.images.push(ImageRecord {
                number,
                measured_s: reading.measured_s() + self.offset_s,
                arrived_s: reading.arrived_s() + self.offset_s,
                truth,
                method: account.method,
                claims: account.claims,
                q_items: account.q_items,
                rejected_px: account.rejected_px,
                alone_heading_rad: account.alone_heading_rad,
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

    /// Notes truth and estimate, apart from each other.
    fn step(&mut self, truth: &Truth, localizer: &Localizer) {
        let mut estimate = localizer.estimate_at(truth.time_s);
        estimate.time_s += self.offset_s;
        let truth = Truth { time_s: truth.time_s + self.offset_s, ..*truth };
        self.witness.step(&truth, &estimate, self.odometry.pose());
        self.history.truths.push(truth);
        self.history.estimates.push(estimate);
        self.history.odometry.push(self.odometry.pose());
        self.history.motion_baselines.step();
        self.history.range_baselines.step(self.odometry.pose());
    }

    /// Notes how much room the true robot has on an errand.
    fn room_left(&mut self, scene: &Scene, world: &World) {
        if scene.has_errands() {
            self.history.clearances.push(Clearance::of(scene, &world.truth(), &world.people()));
        }
    }

    fn finish(mut self, began: Instant) -> RunRecord {
        let digest = self.readings.finalize();
        self.history.readings_digest = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        self.history.timing.wall_s = began.elapsed().as_secs_f64();
        self.history
    }
}
