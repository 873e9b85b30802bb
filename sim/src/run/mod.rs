//! The closed loop of a run: world, sensors, localizer under test, driver and recorder, step by step.

mod baselines;
mod clearance;
mod counterfactual;
mod forward_baselines;
mod frames_policy;
mod history;
mod landmark_baselines;
mod marker_baselines;
mod motion_baselines;
mod range_baselines;
mod recorder;
pub mod sensors;
mod witness;

use std::time::Instant;

use localizer::{PoseBox, Reading, motion::SlipExcess};

use crate::{
    base::DriveCommand,
    driver::Pilot,
    render::{RenderError, Renderer},
    run::sensors::{Sensors, Stage},
    scene::Scene,
    subject::{Subject, SubjectOf, exactly_at},
    world::{Drawn, World},
};

pub use baselines::{BASELINES, BaselineAnswers, Told, needs_baselines};
pub use clearance::Clearance;
pub use counterfactual::{Change, Counterfactual};
pub use forward_baselines::ForwardBaselines;
pub use frames_policy::FramesPolicy;
pub use history::{CheckedBounds, ImageRecord, RunRecord, Timing};
pub use landmark_baselines::LandmarkBaselines;
pub use marker_baselines::{MarkerBaselines, PaperAnswer};
pub use motion_baselines::MotionBaselines;
pub use range_baselines::{Answers, RangeBaselines};
pub use witness::Witness;

use counterfactual::Otherwise;
use recorder::Recorder;

/// Time between two steps of the simulation loop. Each step has one estimate, one command and one check against the true pose.
const STEP_S: f64 = 0.01;
/// Number of physics steps in one step of 10 ms of the simulation loop.
const PHYSICS_STEPS: usize = 10;

/// Options of a run: what its record keeps in addition to the results.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions {
    /// Which images the record keeps, so that debug frames can be drawn from them.
    pub keep_images: FramesPolicy,
    /// Whether the methods to compare with (baselines) are run on the readings, too. Without it, odometry alone is.
    pub baselines: bool,
}

/// Runs a scene with one seed: its route, or its stations (stated poses at which the robot stands still) one after another. `subject`, the
/// localizer under test, is given all readings. Where the scene drives by estimates, the driver steers by the estimates of `subject`. `progress`
/// is called now and then with the simulated time.
///
/// Errors when a camera cannot be rendered; a robot without a camera needs no renderer.
pub fn run(
    scene: &Scene,
    seed: u64,
    subject: &mut dyn Subject,
    renderer: Option<&mut Renderer>,
    options: &RunOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<RunRecord, RenderError> {
    run_witnessed(scene, seed, subject, renderer, options, &mut (), progress)
}

/// Runs a scene like [`run`], and reports each event of the run to the observer `witness`.
pub fn run_witnessed(
    scene: &Scene,
    seed: u64,
    subject: &mut dyn Subject,
    renderer: Option<&mut Renderer>,
    options: &RunOptions,
    witness: &mut dyn Witness,
    progress: &mut dyn FnMut(f64),
) -> Result<RunRecord, RenderError> {
    let drawn = Drawn::draw(scene, seed);
    let asked = Counterfactual::default();
    let as_it_is = Simulation { seed, otherwise: asked.of(scene, &drawn), asked: &asked, commands: None };
    as_it_is.run(subject, renderer, options, witness, progress)
}

/// Simulates a recorded run again by its recorded commands, with the changes that the counterfactual asks for, to the true values or to what the
/// localizer is given. The repetition keeps no images and computes no baselines. `subject_of` makes a new localizer from the values that the
/// changed scene gives it.
///
/// Errors when a camera cannot be rendered; a robot without a camera needs no renderer.
pub fn run_otherwise(
    scene: &Scene,
    record: &RunRecord,
    asked: &Counterfactual,
    subject_of: &SubjectOf<'_>,
    renderer: Option<&mut Renderer>,
    progress: &mut dyn FnMut(f64),
) -> Result<RunRecord, RenderError> {
    let otherwise = asked.of(scene, &record.drawn);
    let again = Simulation { seed: record.seed, otherwise, asked, commands: Some(&record.commands) };
    let mut subject = subject_of(&again.otherwise.told);
    again.run(&mut *subject, renderer, &RunOptions::default(), &mut (), progress)
}

/// One simulation of a run: what is simulated, what the localizer under test is given, and who commands the base.
struct Simulation<'a> {
    seed: u64,
    otherwise: Otherwise<'a>,
    asked: &'a Counterfactual,
    /// The recorded drive commands of the run that is repeated. Without them the scene's own driver commands the base.
    commands: Option<&'a [DriveCommand]>,
}

/// One uninterrupted drive: the scene's route or errands, or one of its stations (stated poses at which the robot stands still).
struct Drive<'a> {
    scene: &'a Scene,
    seed: u64,
    drawn: &'a Drawn,
    /// Box of poses in which the drive starts, as the localizer under test is given it.
    start: PoseBox,
}

impl Simulation<'_> {
    fn run(
        &self,
        subject: &mut dyn Subject,
        renderer: Option<&mut Renderer>,
        options: &RunOptions,
        witness: &mut dyn Witness,
        progress: &mut dyn FnMut(f64),
    ) -> Result<RunRecord, RenderError> {
        let began = Instant::now();
        let Otherwise { world: scene, told, drawn } = &self.otherwise;
        let adapter = renderer.as_deref().map(Renderer::adapter);
        let mut record = Recorder::new(scene, self.seed, drawn.clone(), adapter, options, witness);
        record.history.subject = subject.name().to_owned();
        record.history.subject_is_elsewhere = subject.is_elsewhere();
        let built = scene.as_built(&drawn.place);
        let mut stage = renderer.map(|renderer| Stage::new(&built, drawn, renderer)).transpose()?;
        if scene.stations.is_empty() {
            record.witness.start(0.0, None);
            let all = Drive { scene, seed: self.seed, drawn, start: told.start_box() };
            self.drive(&all, stage.as_mut(), subject, &mut record, progress)?;
        }
        for (index, station) in scene.stations.iter().enumerate() {
            let here = scene.at_station(station);
            // The true robot and floor are the same at every station, the stated poses at which the robot stands still. The robot's true pose
            // within the station's start box and the noise are drawn anew.
            let noise_seed = self.seed.wrapping_add((index as u64 + 1) << 32);
            let drawn_here = Drawn { start: Drawn::draw(&here, noise_seed).start, ..drawn.clone() };
            record.restart(index, here.duration_s, &here);
            if record.has_failed() || self.has_ended(&record, 0.0) {
                break;
            }
            let one = Drive { scene: &here, seed: noise_seed, drawn: &drawn_here, start: here.start_box() };
            self.drive(&one, stage.as_mut(), subject, &mut record, progress)?;
        }
        record.history.space_points = subject.space_points();
        record.history.seen_again = subject.seen_again();
        record.history.looks = subject.looks();
        record.history.views = subject.views();
        if self.commands.is_none() {
            record.history.post_localized = subject.post_localized();
        }
        record.history.subject_log = subject.end();
        Ok(record.finish(began))
    }

    /// Simulates one uninterrupted drive, step by step.
    fn drive(
        &self,
        &Drive { scene, seed, drawn, start }: &Drive<'_>,
        mut stage: Option<&mut Stage<'_>>,
        subject: &mut dyn Subject,
        record: &mut Recorder<'_>,
        progress: &mut dyn FnMut(f64),
    ) -> Result<(), RenderError> {
        let built = scene.as_built(&drawn.place);
        let mut world = World::new(&built, drawn);
        let mut sensors = Sensors::new(&built, seed, drawn, stage.as_deref());
        let mut pilot = Pilot::new(scene, drawn);
        subject.start(&start);
        subject.expect_slip(self.slips(record.offset_s));
        self.look(&world, &mut sensors, stage.as_deref_mut(), subject, record)?;
        record.step(&world.truth(), subject);
        record.room_left(&built, &world);
        for step in 0..(scene.duration_s / STEP_S).round() as usize {
            let time_s = step as f64 * STEP_S;
            if record.has_failed() {
                break;
            }
            let command = match self.commands {
                Some(commands) => commands.get(record.history.commands.len()).copied(),
                None => self.ask(&mut pilot, scene, &world, &mut sensors, subject, time_s),
            };
            let Some(command) = command.filter(|_| !self.has_ended(record, time_s)) else { break };
            record.history.commands.push(command);
            for _ in 0..PHYSICS_STEPS {
                record.timed(|timing| &mut timing.world_s, || world.step(command));
                self.look(&world, &mut sensors, stage.as_deref_mut(), subject, record)?;
            }
            record.step(&world.truth(), subject);
            record.room_left(&built, &world);
            if step % 50 == 0 {
                progress(record.offset_s + time_s);
            }
        }
        record.history.errands = pilot.into_log(world.truth().time_s);
        Ok(())
    }

    /// Returns the driver's next drive command, or `None` when the errands are done.
    fn ask(
        &self,
        pilot: &mut Pilot,
        scene: &Scene,
        world: &World,
        sensors: &mut Sensors,
        subject: &dyn Subject,
        time_s: f64,
    ) -> Option<DriveCommand> {
        if pilot.is_done(time_s) {
            return None;
        }
        let fan = sensors.look_out();
        let truth = world.truth();
        let believed = if scene.is_led() {
            exactly_at(truth.time_s, truth.pose)
        } else {
            subject.estimate_at(truth.time_s).into_estimate(truth.time_s)
        };
        Some(pilot.command(&believed, fan.as_ref(), time_s))
    }

    /// Returns the spans of time of a drive in which the localizer is given wider bounds on wheel slip.
    fn slips(&self, offset_s: f64) -> Vec<SlipExcess> {
        self.asked.slips(offset_s, self.otherwise.told.robot.delivery.stamp_tolerance_s)
    }

    /// Whether the simulation ends before this step, because it has reached the time or the loss up to which the run was to be simulated again.
    fn has_ended(&self, record: &Recorder<'_>, time_s: f64) -> bool {
        // Half a step is added for rounding, as times are sums of decimal numbers that are not exact in binary.
        self.asked.until_s.is_some_and(|until_s| record.offset_s + time_s > until_s + 0.5 * STEP_S)
            || self.asked.until_lost_after_s.is_some_and(|after_s| time_s > after_s - 0.5 * STEP_S)
                && record.history.lost_at_last_step()
    }

    /// Observes the sensors at one instant and hands the readings that arrive to the localizer under test.
    fn look(
        &self,
        world: &World,
        sensors: &mut Sensors,
        stage: Option<&mut Stage<'_>>,
        subject: &mut dyn Subject,
        record: &mut Recorder<'_>,
    ) -> Result<(), RenderError> {
        let arrived =
            record.timed(|timing| &mut timing.render_s, || sensors.observe(&world.truth(), &world.people(), stage))?;
        for observation in arrived {
            record.sense(&observation);
            if self.asked.withholds(&observation.reading, observation.reading.measured_s() + record.offset_s) {
                continue;
            }
            let accounts = record.timed_reading(
                |timing| match observation.reading {
                    Reading::Camera { .. } => &mut timing.vision_s,
                    _ => &mut timing.localizer_s,
                },
                || {
                    subject.observe(&observation.reading);
                    subject.accounts()
                },
            );
            record.images(observation, accounts);
        }
        Ok(())
    }
}
