//! The interval localizer of this project, with the methods that a scene asks for, as the subject of a run: the localizer that the run tests.

use localizer::{
    Localizer, Method, PoseBox, Reading,
    localizer::{Account, PoseWidth, PostLocalized},
    map::{SeenAgain, SpacePoint, Views},
    motion::SlipExcess,
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::{Answer, Subject};
use crate::{devices::method, scene::Scene};

/// The interval localizer of this project as the subject of a run, the localizer that the run tests.
pub struct IntervalLocalizer {
    localizer: Localizer,
    /// What the localizer's methods claimed to see in the latest reading, and what followed for the pose.
    accounts: Vec<Account>,
}

impl IntervalLocalizer {
    /// The interval localizer with the methods that the scene asks for, and with the map, robot and bounds that the scene states.
    pub fn of(scene: &Scene) -> IntervalLocalizer {
        IntervalLocalizer::from(localizer(scene))
    }

    /// The interval localizer for a scene, boxed as the trait object that [`SubjectOf`](super::SubjectOf) functions return.
    pub fn boxed(scene: &Scene) -> Box<dyn Subject> {
        Box::new(IntervalLocalizer::of(scene))
    }
}

impl From<Localizer> for IntervalLocalizer {
    /// Makes a localizer that was built in another way the subject of a run. The start box that it was built with does not matter, because every
    /// drive begins with a start box of its own.
    fn from(localizer: Localizer) -> IntervalLocalizer {
        IntervalLocalizer { localizer, accounts: Vec::new() }
    }
}

impl Subject for IntervalLocalizer {
    fn name(&self) -> &str {
        "intervals"
    }

    fn start(&mut self, start: &PoseBox) {
        self.localizer.restart(*start);
    }

    fn observe(&mut self, reading: &Reading) {
        self.accounts = self.localizer.observe(reading).accounts;
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        Answer::Boxes(self.localizer.estimate_at(time_s))
    }

    fn accounts(&mut self) -> Vec<Account> {
        std::mem::take(&mut self.accounts)
    }

    fn width_by_bound(&self) -> Option<&PoseWidth> {
        self.localizer.width_by_bound()
    }

    fn space_points(&mut self) -> Vec<(LandmarkId, SpacePoint)> {
        self.localizer.space_points()
    }

    fn views(&self) -> Option<Views> {
        self.localizer.views()
    }

    fn seen_again(&self) -> Vec<SeenAgain> {
        self.localizer.seen_again()
    }

    fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        self.localizer.looks()
    }

    fn post_localized(&mut self) -> Option<PostLocalized> {
        self.localizer.post_localized()
    }

    fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.localizer.expect_slip(excesses);
    }
}

/// The localizer that the scene asks for, with the map, robot and bounds that the scene states.
fn localizer(scene: &Scene) -> Localizer {
    let mut localizer = Localizer::new(scene.map(), scene.robot_model(), methods(scene), scene.start_box())
        .with_base_clock(scene.robot.delivery.stamp_tolerance_s);
    if let Some(window) = scene.localizer.post_window {
        localizer = localizer.post_localizing(window);
    }
    if scene.localizer.learns_gyro {
        localizer.learning_gyro(scene.bounds.rest_turn_deg.map(f64::to_radians))
    } else {
        localizer
    }
}

/// The localizer's methods that the scene asks for, each created by the device that it reads.
fn methods(scene: &Scene) -> Vec<Box<dyn Method>> {
    let (map, robot) = (scene.map(), scene.robot_model());
    scene.localizer.methods.iter().filter_map(|name| method(*name, scene, &map, &robot)).collect()
}
