//! The paper's methods: contractors on boxes, on each landmark alone (LIC) or on a sliding window of poses and all landmarks (DIGO).

use interval::Interval;
use interval::contractor::{
    Contractor, ForwardBackward, Inverse, Network, Outcome, Pinhole, UnknownVariable, VariableId,
};

use crate::drive::{Drive, FOCAL_PX, LANDMARKS_M, LEAST_DEPTH_M, N_CONVERGING, Step};

/// Contractors are applied until no variable shrinks by more than this share. It is the default of the library IBEX for HC4, the algorithm that the
/// paper names.
pub(crate) const RATIO: f64 = 0.01;

/// What is known after a drive, as boxes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Boxes {
    /// Poses (x, y, heading), from the start on, each as it was last contracted.
    pub(crate) poses: Vec<[Interval; 3]>,
    /// Rays of the landmarks: slopes a (left) and b (up), and inverse depth ρ.
    pub(crate) rays: [[Interval; 3]; LANDMARKS_M.len()],
}

impl Boxes {
    /// What is known at the start, when the first picture is taken: the pose, and every landmark's ray with an unknown depth.
    fn at_start(drive: &Drive) -> Boxes {
        let depth = Interval::new(0.0, 1.0 / LEAST_DEPTH_M);
        let ray = |[u, v]: [Interval; 2]| [u, v].map(|pixel| -pixel / Interval::point(FOCAL_PX));
        let rays = drive.pixels[0].map(ray).map(|[a, b]| [a, b, depth]);
        Boxes { poses: vec![[Interval::ZERO; 3]], rays }
    }

    /// Boxes of the converging landmarks' places in the world: equation (12) of the paper, with inverse depth.
    pub(crate) fn places_m(&self) -> [[Interval; 3]; N_CONVERGING] {
        std::array::from_fn(|landmark| {
            let [a, b, rho] = self.rays[landmark];
            [Interval::ONE, a, b].map(|part| part / rho)
        })
    }
}

/// The chord of a step with a given turn is shorter than the arc by this factor, sin(half)/half of half the turn h, which is in [1 − h²/6, 1].
fn chord_factor(step: &Step) -> Interval {
    let half = Interval::point(step.turn_rad.magnitude()) * 0.5;
    (Interval::ONE - half.sqr() / 6.0).hull(Interval::ONE)
}

/// Equations (11) of the paper: the pose after a step, with the chord of the arc in place of the arc. Variables of the first two: coordinate before
/// and after, heading before, distance and turn; of the third: heading before and after, and turn.
fn motion_contractors(step: &Step) -> ([ForwardBackward<5>; 2], ForwardBackward<3>) {
    let factor = chord_factor(step);
    let along_x = ForwardBackward::new(
        |[x, next_x, heading, distance, turn]| next_x - x - factor * distance * (heading + turn * 0.5).cos(),
        Interval::ZERO,
    );
    let along_y = ForwardBackward::new(
        |[y, next_y, heading, distance, turn]| next_y - y - factor * distance * (heading + turn * 0.5).sin(),
        Interval::ZERO,
    );
    let turned = ForwardBackward::new(|[heading, next, turn]| next - heading - turn, Interval::ZERO);
    ([along_x, along_y], turned)
}

/// The constraint that a landmark is seen at a pixel, in homogeneous form: the landmark's direction from the pose, times its inverse depth, is
/// R(−θ)((1, a, b) − ρ·(x, y, 0)). Variables: x, y, heading θ, a, b, ρ.
fn sight_contractor([u, v]: [Interval; 2]) -> impl Contractor<6> + Send + Sync + 'static {
    Inverse::new(
        |[x, y, heading, a, b, rho]| {
            let (east, north) = (1.0 - rho * x, a - rho * y);
            let ahead = heading.cos() * east + heading.sin() * north;
            let right = heading.sin() * east - heading.cos() * north;
            [right, -b, ahead, x.constant(u), x.constant(v)]
        },
        Pinhole { focal_px: Interval::point(FOCAL_PX) },
    )
}

/// The paper's local contraction (LIC): the pose is predicted by odometry, and then each landmark's constraint is solved for this pose and this
/// landmark alone. Pose and landmarks are handed on as boxes.
pub(crate) fn contract_locally(drive: &Drive) -> Result<Boxes, UnknownVariable> {
    let mut boxes = Boxes::at_start(drive);
    for (step, picture) in drive.steps.iter().zip(&drive.pixels[1..]) {
        let mut window = Window::new(&boxes.rays);
        window.add_pose(boxes.poses[boxes.poses.len() - 1]);
        window.add_step(step)?;
        window.network.contract();
        let mut pose = window.pose(1);
        for (ray, &pixel) in boxes.rays.iter_mut().zip(picture) {
            let mut network = Network::new(RATIO);
            let on = [pose[0], pose[1], pose[2], ray[0], ray[1], ray[2]].map(|domain| network.add_variable(domain));
            network.add_contractor(on, sight_contractor(pixel))?;
            network.contract();
            let [x, y, heading, a, b, rho] = on.map(|id| network.domain(id).unwrap_or(Interval::EMPTY));
            (pose, *ray) = ([x, y, heading], [a, b, rho]);
        }
        boxes.poses.push(pose);
    }
    Ok(boxes)
}

/// The paper's contraction of a graph (DIGO): in each step the new pose and its constraints are added, all constraints of the last `n_window` steps
/// are contracted together, and the oldest pose is removed with the constraints on it.
pub(crate) fn contract_window(drive: &Drive, n_window: usize) -> Result<Boxes, UnknownVariable> {
    let mut boxes = Boxes::at_start(drive);
    let mut window = Window::new(&boxes.rays);
    window.add_pose(boxes.poses[0]);
    window.see(&drive.pixels[0])?;
    for (step, picture) in drive.steps.iter().zip(&drive.pixels[1..]) {
        window.add_step(step)?;
        window.see(picture)?;
        window.network.contract();
        if window.poses.len() > n_window {
            boxes.poses.push(window.pose(0));
            window.remove_oldest();
        }
    }
    boxes.poses.remove(0);
    boxes.poses.extend((0..window.poses.len()).map(|at| window.pose(at)));
    boxes.rays = window.rays.map(|ray| ray.map(|id| window.domain(id)));
    Ok(boxes)
}

/// All constraints of a drive on boxes, with the boxes narrowed by what is known from elsewhere.
pub(crate) fn contract_all(drive: &Drive, known: &Boxes) -> Result<(Boxes, Outcome), UnknownVariable> {
    let mut window = Window::new(&known.rays);
    window.add_pose(known.poses[0]);
    window.see(&drive.pixels[0])?;
    for (at, (step, picture)) in drive.steps.iter().zip(&drive.pixels[1..]).enumerate() {
        window.add_step(step)?;
        window.see(picture)?;
        let ids = window.poses[at + 1].pose;
        for (id, known) in ids.into_iter().zip(known.poses[at + 1]) {
            window.network.narrow(id, known)?;
        }
    }
    let outcome = window.network.contract();
    let poses = (0..window.poses.len()).map(|at| window.pose(at)).collect();
    Ok((Boxes { poses, rays: window.rays.map(|ray| ray.map(|id| window.domain(id))) }, outcome))
}

/// A network of landmarks and successive poses.
struct Window {
    network: Network,
    rays: [[VariableId; 3]; LANDMARKS_M.len()],
    poses: Vec<Member>,
}

/// A pose of the window, with the variables of the step that leads to it.
struct Member {
    pose: [VariableId; 3],
    step: Option<[VariableId; 2]>,
}

impl Window {
    fn new(rays: &[[Interval; 3]; LANDMARKS_M.len()]) -> Window {
        let mut network = Network::new(RATIO);
        let rays = rays.map(|ray| ray.map(|domain| network.add_variable(domain)));
        Window { network, rays, poses: Vec::new() }
    }

    fn domain(&self, id: VariableId) -> Interval {
        self.network.domain(id).unwrap_or(Interval::EMPTY)
    }

    fn pose(&self, at: usize) -> [Interval; 3] {
        self.poses[at].pose.map(|id| self.domain(id))
    }

    fn add_pose(&mut self, known: [Interval; 3]) {
        let pose = known.map(|domain| self.network.add_variable(domain));
        self.poses.push(Member { pose, step: None });
    }

    /// Adds a pose one step after the last one.
    fn add_step(&mut self, step: &Step) -> Result<(), UnknownVariable> {
        let from = self.poses[self.poses.len() - 1].pose;
        self.add_pose([Interval::ENTIRE; 3]);
        let last = self.poses.len() - 1;
        let to = self.poses[last].pose;
        let [distance, turn] = [step.distance_m, step.turn_rad].map(|known| self.network.add_variable(known));
        self.poses[last].step = Some([distance, turn]);
        let (along, turned) = motion_contractors(step);
        self.network.add_contractor([from[2], to[2], turn], turned)?;
        for (axis, contractor) in along.into_iter().enumerate() {
            self.network.add_contractor([from[axis], to[axis], from[2], distance, turn], contractor)?;
        }
        Ok(())
    }

    /// Adds the constraints of the picture taken at the last pose.
    fn see(&mut self, picture: &[[Interval; 2]; LANDMARKS_M.len()]) -> Result<(), UnknownVariable> {
        let [x, y, heading] = self.poses[self.poses.len() - 1].pose;
        for (&[a, b, rho], &pixel) in self.rays.iter().zip(picture) {
            self.network.add_contractor([x, y, heading, a, b, rho], sight_contractor(pixel))?;
        }
        Ok(())
    }

    /// Removes the oldest pose with all constraints on it, and the step that leads away from it.
    fn remove_oldest(&mut self) {
        let oldest = self.poses.remove(0);
        let step = self.poses.first_mut().and_then(|next| next.step.take());
        for id in oldest.pose.into_iter().chain(step.into_iter().flatten()) {
            self.network.remove_variable(id);
        }
    }
}
