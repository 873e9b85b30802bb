//! True values that a seed draws at random within the declared bounds: of floor, building, the robot's base and its devices. The localizer never
//! sees them.

use localizer::Pose;
use rand::{RngExt, seq::IndexedRandom};

use crate::{
    base::{self, DrawnBase},
    devices::{self, DrawnDevices},
    place::{
        drawn::{self, DrawnPlace},
        navigation::Planner,
    },
    scene::{Person, Scene},
    truth::randomness::{draw_within, stream},
};

/// Everything about a run that is drawn at random once, before the run starts.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// True pose of the robot at time 0.
    pub start: Pose,
    /// Places, drawn at random, to which a robot on errands is sent one after the other, world frame. They are no secret: the driver is given
    /// them.
    pub goals_m: Vec<[f64; 2]>,
    /// Floor, walls, furniture and markers as they truly are.
    pub place: DrawnPlace,
    /// True dimensions of the robot's base, and the error of its clock.
    pub base: DrawnBase,
    /// True mounts, lenses, scales and biases of the robot's devices.
    pub devices: DrawnDevices,
}

impl Drawn {
    /// Draws everything that a seed decides before the run starts, each quantity from a random stream of its own.
    pub fn draw(scene: &Scene, seed: u64) -> Drawn {
        Drawn {
            start: draw_start(scene, seed),
            goals_m: draw_goals(scene, seed),
            place: DrawnPlace::draw(scene, seed),
            base: DrawnBase::draw(&scene.robot, seed),
            devices: DrawnDevices::draw(&scene.robot, seed),
        }
    }

    /// Moves true values that lie beyond the declared bound named `bound` back to that bound; all other values stay as drawn.
    pub(crate) fn clip(&mut self, bound: &str, scene: &Scene) {
        self.place.clip(bound, scene);
        self.base.clip(bound, &scene.robot);
        self.devices.clip(bound, &scene.robot);
    }
}

/// Whether the true value behind a bound is drawn by the simulator or placed by the scene, so that a run can be repeated with the value
/// within its bound. Every other true value emerges from the physics, or is drawn within its bound by construction.
pub(crate) fn is_clipped(bound: &str) -> bool {
    let all = drawn::CLIPPED.iter().chain(&base::CLIPPED).chain(devices::CLIPPED.iter().copied().flatten());
    all.into_iter().any(|clipped| *clipped == bound)
}

/// Greatest angle between the nominal heading and that of a robot that starts anywhere: 170°, as headings are counted beyond half a turn, where the same
/// readings would fit a heading a whole turn away.
const MOST_TURNED_RAD: f64 = 170.0 / 180.0 * std::f64::consts::PI;

fn draw_start(scene: &Scene, seed: u64) -> Pose {
    let (nominal, start, errors) = (scene.nominal_start(), &scene.start, scene.robot.errors);
    let mut rng = stream(seed, "start");
    if start.anywhere {
        let reach = Planner::of(scene).reach([start.x_m, start.y_m]);
        let mut centres_m = reach.map(|reach| reach.centres_m()).unwrap_or_default();
        centres_m.retain(|at_m| is_clear(scene, *at_m));
        let [x_m, y_m] = centres_m.choose(&mut rng).copied().unwrap_or([nominal.x_m, nominal.y_m]);
        let turned_rad = rng.random_range(-MOST_TURNED_RAD..MOST_TURNED_RAD);
        return Pose { x_m, y_m, heading_rad: nominal.heading_rad + turned_rad };
    }
    Pose {
        x_m: nominal.x_m + draw_within(start.tolerance_m, errors, &mut rng),
        y_m: nominal.y_m + draw_within(start.tolerance_m, errors, &mut rng),
        heading_rad: nominal.heading_rad + draw_within(start.tolerance_deg.to_radians(), errors, &mut rng),
    }
}

/// Whether the robot's body touches neither furniture, on the map or not, nor a person who stands where people are at time 0.
fn is_clear(scene: &Scene, at_m: [f64; 2]) -> bool {
    let body_m = scene.robot.body_radius_m;
    let is_off = |person: &Person| {
        let first_m = person.waypoints_m.first().copied().unwrap_or([f64::INFINITY; 2]);
        (first_m[0] - at_m[0]).hypot(first_m[1] - at_m[1]) >= person.radius_m + body_m
    };
    scene.furniture.iter().all(|piece| piece.distance_m(at_m) >= body_m) && scene.people.iter().all(is_off)
}

/// Least distance of a random goal from the goal before; with a smaller one there would be nothing to drive.
const LEAST_LEG_M: f64 = 1.0;

/// Draws the random goals of errands (drives to a goal), each in the middle of a grid cell that the robot can reach.
fn draw_goals(scene: &Scene, seed: u64) -> Vec<[f64; 2]> {
    let n_goals = scene.navigation.as_ref().map_or(0, |navigation| navigation.random_goals);
    let mut from_m = scene.errands.last().map_or([scene.start.x_m, scene.start.y_m], |errand| [errand.x_m, errand.y_m]);
    if n_goals == 0 {
        return Vec::new();
    }
    let centres_m = Planner::of(scene).reach(from_m).map(|reach| reach.centres_m()).unwrap_or_default();
    let mut rng = stream(seed, "navigation.goals");
    let mut goals_m = Vec::new();
    for _ in 0..n_goals {
        let is_far = |at_m: &&[f64; 2]| (at_m[0] - from_m[0]).hypot(at_m[1] - from_m[1]) >= LEAST_LEG_M;
        let far_m: Vec<&[f64; 2]> = centres_m.iter().filter(is_far).collect();
        // In a room too small for the least distance between goals, any position that the robot can reach may be drawn.
        let Some(goal_m) = far_m.choose(&mut rng).copied().or_else(|| centres_m.choose(&mut rng)) else { break };
        goals_m.push(*goal_m);
        from_m = *goal_m;
    }
    goals_m
}
