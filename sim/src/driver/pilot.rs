//! The driver of a run: either along the scene's route or on errands.

use localizer::Estimate;

use crate::{base::DriveCommand, devices::scanner::Fan, scene::Scene, world::Drawn};

use super::{Driver, ErrandDriver, ErrandLog};

/// The driver that a scene asks for, on a route or on errands.
#[derive(Clone, Debug)]
pub enum Pilot {
    /// A driver along the scene's route; without a route the robot stands.
    Route(Box<Driver>),
    /// A driver on errands, which plans its paths from goal to goal itself.
    Errands(Box<ErrandDriver>),
}

impl Pilot {
    /// The driver of a scene, with the goals that a seed has drawn at random.
    pub fn new(scene: &Scene, drawn: &Drawn) -> Pilot {
        if scene.has_errands() {
            Pilot::Errands(Box::new(ErrandDriver::new(scene, &drawn.goals_m)))
        } else {
            Pilot::Route(Box::new(Driver::new(scene)))
        }
    }

    /// The motion that the base is commanded for the next [`PERIOD_S`](super::PERIOD_S). `fan` is the scanner's scan, if a new one has arrived.
    pub fn command(&mut self, estimate: &Estimate, fan: Option<&Fan>, time_s: f64) -> DriveCommand {
        match self {
            Pilot::Route(driver) => driver.command(estimate, time_s),
            Pilot::Errands(driver) => driver.command(estimate, fan, time_s),
        }
    }

    /// Whether there is nothing left to drive, so that the run may end early. On a route this is never the case.
    pub fn is_done(&self, time_s: f64) -> bool {
        matches!(self, Pilot::Errands(driver) if driver.is_done(time_s))
    }

    /// The log of what became of the errands until `time_s`; `None` on a route.
    pub fn into_log(self, time_s: f64) -> Option<ErrandLog> {
        match self {
            Pilot::Route(_) => None,
            Pilot::Errands(driver) => Some(driver.into_log(time_s)),
        }
    }
}
