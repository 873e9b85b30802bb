//! The interval localizer of this project as the subject of a run, with the methods that a scene asks for.

use localizer::{Localizer, Method, PoseBox, Reading, localizer::Account, motion::SlipExcess};

use super::{Answer, Subject};
use crate::{devices::method, scene::Scene};

/// The interval localizer of this project as the subject of a run.
pub struct IntervalLocalizer {
    localizer: Localizer,
    /// What the methods made of the latest reading.
    accounts: Vec<Account>,
}

impl IntervalLocalizer {
    /// The interval localizer with the methods that the scene asks for, and with the map, robot and bounds that the scene states.
    pub fn of(scene: &Scene) -> IntervalLocalizer {
        IntervalLocalizer::from(localizer(scene))
    }

    /// The interval localizer for a scene, as a boxed subject that fits [`SubjectOf`](super::SubjectOf).
    pub fn boxed(scene: &Scene) -> Box<dyn Subject> {
        Box::new(IntervalLocalizer::of(scene))
    }
}

impl From<Localizer> for IntervalLocalizer {
    /// Makes a subject of a localizer that was built in another way; the start box that it was built with does not matter.
    fn from(localizer: Localizer) -> IntervalLocalizer {
        IntervalLocalizer { localizer, accounts: Vec::new() }
    }
}

impl Subject for IntervalLocalizer {
    fn start(&mut self, start: &PoseBox) {
        self.localizer.restart(*start);
    }

    fn observe(&mut self, reading: &Reading) {
        self.accounts = self.localizer.observe(reading);
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        Answer::Boxes(self.localizer.estimate_at(time_s))
    }

    fn accounts(&mut self) -> Vec<Account> {
        std::mem::take(&mut self.accounts)
    }

    fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.localizer.expect_slip(excesses);
    }
}

/// The localizer that the scene asks for, with the map, robot and bounds that the scene states.
fn localizer(scene: &Scene) -> Localizer {
    let localizer = Localizer::new(scene.map(), scene.robot_model(), methods(scene), scene.start_box())
        .with_base_clock(scene.robot.delivery.stamp_tolerance_s);
    if scene.localizer.learns_gyro {
        localizer.learning_gyro(scene.bounds.rest_turn_deg.map(f64::to_radians))
    } else {
        localizer
    }
}

/// The methods that the scene asks for, each created by the device that it reads.
fn methods(scene: &Scene) -> Vec<Box<dyn Method>> {
    let (map, robot) = (scene.map(), scene.robot_model());
    scene.localizer.methods.iter().filter_map(|name| method(*name, scene, &map, &robot)).collect()
}
