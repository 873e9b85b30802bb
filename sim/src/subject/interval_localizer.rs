//! The interval localizer of this project as a subject, with the methods that a scene asks for.

use localizer::{Localizer, Method, PoseBox, Reading, localizer::Account, motion::SlipExcess};

use super::{Answer, Subject};
use crate::{devices::method, scene::Scene};

/// The interval localizer as a subject.
pub struct IntervalLocalizer {
    localizer: Localizer,
    /// Of the latest reading.
    accounts: Vec<Account>,
}

impl IntervalLocalizer {
    /// With the methods that the scene asks for, told what the scene tells it.
    pub fn of(scene: &Scene) -> IntervalLocalizer {
        IntervalLocalizer::from(localizer(scene))
    }

    /// The same, as [`SubjectOf`](super::SubjectOf) wants it.
    pub fn boxed(scene: &Scene) -> Box<dyn Subject> {
        Box::new(IntervalLocalizer::of(scene))
    }
}

impl From<Localizer> for IntervalLocalizer {
    /// A localizer that was made otherwise; where it was made to start does not matter.
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

/// The localizer that the scene asks for, told what the scene tells it.
fn localizer(scene: &Scene) -> Localizer {
    let localizer = Localizer::new(scene.map(), scene.robot_model(), methods(scene), scene.start_box())
        .with_base_clock(scene.robot.delivery.stamp_tolerance_s);
    if scene.localizer.learns_gyro {
        localizer.learning_gyro(scene.bounds.rest_turn_deg.map(f64::to_radians))
    } else {
        localizer
    }
}

/// The methods that the scene asks for, each made by the device that it reads.
fn methods(scene: &Scene) -> Vec<Box<dyn Method>> {
    let (map, robot) = (scene.map(), scene.robot_model());
    scene.localizer.methods.iter().filter_map(|name| method(*name, scene, &map, &robot)).collect()
}
