//! What the localizer relies on in the robot's surroundings when it uses a device's readings: declared bounds on floor, walls and markers, which are
//! compared with what truly stands there.

use localizer::{Claim, bounds::Assumption, reading::Camera};

use crate::{place::drawn::DrawnPlace, truth::Truth};

use super::BoundCheck;

/// The surroundings of the robot over a run, and the pictures in which it saw them.
pub struct Surroundings<'a> {
    /// Floor, walls, furniture and markers as they truly are.
    pub place: &'a DrawnPlace,
    /// Time at which the run ended.
    pub end_s: f64,
    /// Pictures of all cameras and readings of the range camera, in the order in which they were used.
    pub looks: Vec<Look<'a>>,
}

/// A picture of the surroundings.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    /// Camera that took the picture; none for a reading of a range camera.
    pub camera: Option<Camera>,
    /// True state of the robot at the middle of the exposure.
    pub truth: &'a Truth,
    /// Time at which the localizer received the picture.
    pub arrived_s: f64,
    /// What a method of the localizer claims to have seen in the picture.
    pub claims: &'a [Claim],
}

/// A declared bound on the surroundings, with its comparisons with true values.
pub struct WatchedBound {
    /// Name of the bound.
    pub bound: Assumption,
    /// Comparisons in the order of the ends of their time spans.
    pub checks: Vec<BoundCheck>,
}

impl<'a> Surroundings<'a> {
    /// The pictures of one camera.
    pub(super) fn looks_of(&self, camera: Camera) -> impl Iterator<Item = &Look<'a>> {
        self.looks.iter().filter(move |look| look.camera == Some(camera))
    }
}

impl Look<'_> {
    /// Time span over which the localizer relies on what the picture shows: from the exposure to the picture's arrival.
    pub(super) fn span_s(&self) -> [f64; 2] {
        [self.truth.time_s, self.arrived_s]
    }
}

impl WatchedBound {
    /// A bound that has not been compared with anything yet.
    pub(super) fn new(bound: Assumption) -> Self {
        WatchedBound { bound, checks: Vec::new() }
    }

    /// A bound on a value that is the same over the whole run.
    pub(super) fn throughout(bound: Assumption, declared: f64, true_value: f64, surroundings: &Surroundings) -> Self {
        let mut watched = WatchedBound::new(bound);
        watched.compare([0.0, surroundings.end_s], declared, true_value);
        watched
    }

    /// Compares the bound with the true value of what it limits, over a time span.
    pub(super) fn compare(&mut self, span_s: [f64; 2], declared: f64, true_value: f64) {
        self.checks.push(BoundCheck { bound: self.bound, span_s, declared, true_value });
    }
}
