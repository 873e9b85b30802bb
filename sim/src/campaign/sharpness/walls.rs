//! Images of the forward camera: what the method claims of level edges along walls, and of upright edges.
//!
//! An edge has a direction and a place that nobody knows, so that its image is any image line whose plane through the optical centre contains the
//! direction. A claim is checked by two points of one such plane, each of which is seen near enough to one end of the claimed line.
//!
//! As many claims may be false as the scene's quotas allow, whichever they are.

mod edge;
mod false_claims;

use interval::Interval;
use localizer::{Claim, bounds, reading::Camera};

use crate::{
    judge,
    place::drawn::turn_from_nearest_deg,
    run::{ImageRecord, RunRecord},
    scene::Scene,
};

use super::{
    eye::Eye,
    history::{History, Quantity},
    kind::{Broken, Declared, Kind, Linearised},
};
pub(super) use edge::{Edge, Way};
pub(super) use false_claims::Images;

/// What is broken when more edges are not what was claimed than the scene's quotas allow.
pub(super) const FALSE_EDGES: &str = "wall_directions edges";

/// Number of edges of an image that the search keeps in view on either side: those that leave the heading the least room, and as many of the upright
/// ones. Others are kept in view once a candidate breaks them.
const N_TIGHTEST: usize = 5;

/// What was claimed of one image.
pub(super) struct Look {
    pub(super) stamp: usize,
    pub(super) measured_s: f64,
    /// Place of the image among all images that have arrived.
    pub(super) image: usize,
    /// The claimed lines that are true.
    pub(super) edges: Vec<Edge>,
}

/// All images of the forward camera that have arrived by an instant.
pub(super) struct Walls {
    pub(super) eye: Eye,
    pub(super) looks: Vec<Look>,
    /// Interval of the angle by which all walls stand turned.
    pub(super) turn_rad: Interval,
    /// Greatest angle of a piece of furniture to the wall along which it stands.
    pub(super) askew_rad: f64,
    /// All images, also those of which nothing true was claimed, with the claims that are truly false. A witness has the same false claims and others.
    pub(super) images: Images,
}

impl Walls {
    /// What the method claimed of the images of the forward camera that have arrived by an instant.
    pub(super) fn of(scene: &Scene, record: &RunRecord, eye: Eye, history: &History, time_s: f64) -> Option<Walls> {
        let arrived = |image: &&ImageRecord| image.camera == Some(Camera::Forward) && image.arrived_s <= time_s;
        let mut looks = Vec::new();
        for (at, image) in record.images.iter().filter(arrived).enumerate() {
            let Some(stamp) = history.stamp_at(image.truth.time_s) else { continue };
            let edges: Vec<Edge> = image.claims.iter().filter_map(|claim| edge(claim, scene, record, image)).collect();
            if !edges.is_empty() {
                looks.push(Look { stamp, measured_s: image.measured_s, image: at, edges });
            }
        }
        let judged = judge::false_claims(scene, record);
        let mut images = Images::default();
        for (image, judged) in record.images.iter().zip(judged).filter(|(image, _)| arrived(image)) {
            images.push(image.measured_s, image.into(), judged);
        }
        let setup = scene.localizer.wall_directions();
        let mapped_deg = scene.mapped_wall_directions_deg();
        let turn_rad = scene.stated_wall_directions_deg().iter().fold(Interval::ENTIRE, |turn_rad, stated_deg| {
            // A direction that no map gives bounds nothing.
            let off_deg = turn_from_nearest_deg(*stated_deg, &mapped_deg).unwrap_or(0.0);
            if scene.is_learnt_at(off_deg.abs()) {
                return turn_rad;
            }
            turn_rad.intersect(Interval::centred(-off_deg.to_radians(), setup.tolerance_deg.to_radians()))
        });
        let askew_rad = setup.askew_deg.to_radians();
        (!looks.is_empty()).then_some(Walls { eye, looks, turn_rad, askew_rad, images })
    }

    /// How much each edge uses of its bound in a history.
    fn used(&self, history: &History) -> Vec<Vec<f64>> {
        let turn_rad = history.value(Quantity::WallsTurn);
        let of_look = |look: &Look| {
            let sight = self.eye.sight(history, look.stamp);
            look.edges.iter().map(|edge| edge.shown(&sight, turn_rad, self.askew_rad).used).collect()
        };
        self.looks.iter().map(of_look).collect()
    }

    /// For each edge of each image whether it is given up: a history that goes on as from the search's start to where it is now would break it before
    /// others. As many are given up as the quotas allow.
    fn given_up(&self, near: &Linearised<'_>) -> Vec<Vec<bool>> {
        let (now, before) = (self.used(near.history), self.used(near.start));
        let mut soonest = Vec::new();
        for (look, (now, before)) in now.iter().zip(&before).enumerate() {
            for (edge, (now, before)) in now.iter().zip(before).enumerate() {
                // How often the way from the start leads once more until the edge breaks.
                let ahead = (1.0 - (now - before).signum() * now) / (now - before).abs();
                if ahead.is_finite() {
                    soonest.push((ahead, look, edge));
                }
            }
        }
        soonest.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut images = self.images.clone();
        let mut given_up: Vec<Vec<bool>> = now.iter().map(|edges| vec![false; edges.len()]).collect();
        for (_, look, edge) in soonest {
            let (image, way) = (self.looks[look].image, self.looks[look].edges[edge].way);
            given_up[look][edge] = images.give_up(image, way);
        }
        given_up
    }

    /// Edges of an image that limit a history the most: of the level ones those that leave the heading the least room on either side, and of the upright
    /// ones those that use most of their bound.
    fn tightest(&self, edges: &[Edge], used: &[f64], by_heading: &[f64], is_given_up: &[bool]) -> Vec<usize> {
        let kept = |is_wanted: &dyn Fn(Way) -> bool| -> Vec<usize> {
            (0..edges.len()).filter(|at| !is_given_up[*at] && is_wanted(edges[*at].way)).collect()
        };
        let mut chosen = Vec::new();
        for side in [-1.0, 1.0] {
            let room = |at: usize| (1.0 - side * by_heading[at].signum() * used[at]) / by_heading[at].abs();
            let mut level: Vec<usize> = kept(&|way| way != Way::Upright);
            level.sort_by(|a, b| room(*a).total_cmp(&room(*b)));
            chosen.extend(level.into_iter().take(N_TIGHTEST));
        }
        let mut upright: Vec<usize> = kept(&|way| way == Way::Upright);
        upright.sort_by(|a, b| used[*b].abs().total_cmp(&used[*a].abs()));
        chosen.extend(upright.into_iter().take(N_TIGHTEST));
        chosen.sort_unstable();
        chosen.dedup();
        chosen
    }
}

/// The edge that a claim is about; `None` for a false claim.
fn edge(claim: &Claim, scene: &Scene, record: &RunRecord, image: &ImageRecord) -> Option<Edge> {
    let (drawn, truth) = (&record.drawn, &image.truth);
    match *claim {
        Claim::UprightLine { ends_px, bound_px } => {
            judge::is_true(claim, scene, drawn, truth).then_some(Edge { ends_px, bound_px, way: Way::Upright })
        }
        Claim::WallLine { ends_px, bound_px } => {
            let runs_deg = judge::wall_line_deg(ends_px, bound_px, scene, drawn, truth)?;
            let turn_deg = drawn.place.walls_turn_deg;
            let stated_deg = scene.stated_wall_directions_deg();
            let turned_deg: Vec<f64> = stated_deg.iter().map(|stated_deg| stated_deg + turn_deg).collect();
            // The direction is one of these or at right angles to it.
            let is_near =
                |others_deg: &[f64]| turn_from_nearest_deg(runs_deg, others_deg).is_some_and(|off| off.abs() < 1e-9);
            let turns = is_near(&turned_deg);
            let stated_rad = (runs_deg - if turns { turn_deg } else { 0.0 }).to_radians();
            Some(Edge { ends_px, bound_px, way: Way::Level { stated_rad, turns } })
        }
        _ => None,
    }
}

impl Kind for Walls {
    fn declared(&self, history: &History) -> Vec<Declared> {
        let mut all = self.eye.declared(history, self.looks.iter().map(|look| (look.stamp, look.measured_s)));
        let bound = bounds::WALL_DIRECTIONS_DIRECTION;
        all.push(Declared { quantity: Quantity::WallsTurn, interval: self.turn_rad, bound });
        all
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        self.eye.check_tilt(history, slack)?;
        let turn_rad = history.value(Quantity::WallsTurn);
        let mut images = self.images.clone();
        for look in &self.looks {
            let sights = (self.eye.sight(history, look.stamp), self.eye.sight(history, look.stamp));
            for edge in &look.edges {
                if let Err([value, allowed]) = edge.holds(&sights, [turn_rad, self.askew_rad], slack) {
                    images.add_false(look.image, edge.way);
                    if images.is_exceeded_by(look.image) {
                        let time_s = history.stamps_s[look.stamp];
                        return Err(Broken { bound: FALSE_EDGES, time_s, value, allowed });
                    }
                }
            }
        }
        images.exceeded_s().map_or(Ok(()), |time_s| {
            Err(Broken { bound: FALSE_EDGES, time_s, value: Interval::ONE, allowed: Interval::ZERO })
        })
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        /// Step of the numeric differentiation: near the cube root of the rounding unit, for central differences.
        const STEP_RAD: f64 = 1e-6;
        let history = near.history;
        self.eye.add_tilt_rows(near);
        let turn_rad = history.value(Quantity::WallsTurn);
        let given_up = self.given_up(near);
        for (look, is_given_up) in self.looks.iter().zip(given_up) {
            let slopes = self.eye.slopes(history, look.stamp);
            let used = |edge: &Edge, turn_rad: f64| edge.shown(&slopes.sight, turn_rad, self.askew_rad).used;
            let uses: Vec<f64> = look.edges.iter().map(|edge| used(edge, turn_rad)).collect();
            // A turn of the robot is a turn of all directions the other way.
            let by_heading: Vec<f64> = look
                .edges
                .iter()
                .map(|edge| {
                    let turned = |step_rad: f64| match edge.way {
                        Way::Level { stated_rad, .. } => {
                            let way = Way::Level { stated_rad: stated_rad - step_rad, turns: true };
                            used(&Edge { way, ..*edge }, turn_rad)
                        }
                        Way::Upright => 0.0,
                    };
                    (turned(STEP_RAD) - turned(-STEP_RAD)) / (2.0 * STEP_RAD)
                })
                .collect();
            for at in self.tightest(&look.edges, &uses, &by_heading, &is_given_up) {
                let edge = &look.edges[at];
                let mut terms = slopes.terms_of(near, &|sight| edge.shown(sight, turn_rad, self.askew_rad).used);
                let by_turn = match edge.way {
                    Way::Level { turns: true, .. } => {
                        (used(edge, turn_rad + STEP_RAD) - used(edge, turn_rad - STEP_RAD)) / (2.0 * STEP_RAD)
                    }
                    _ => 0.0,
                };
                terms.push(near.quantity(Quantity::WallsTurn, by_turn));
                near.add(terms, uses[at], Interval::new(-1.0, 1.0));
            }
        }
    }
}
