//! Limits how freely the robot may drive when its pose is uncertain.

use localizer::PoseBox;

use crate::{
    place::building::GroundPlan,
    scene::{Route, Scene},
};

/// Least share of the full speed at which a robot may drive whose pose stays uncertain, so that it still gets somewhere.
const LEAST_SHARE: f64 = 0.25;

/// Distance that a robot keeps from walls while its localizer recovers from a contradiction.
const WALL_MARGIN_M: f64 = 0.05;

/// How long a robot near a wall looks around while its localizer recovers from a contradiction, before it creeps on.
const PATIENCE_S: f64 = 10.0;

/// Turn rate at which a robot that is unsure of its pose looks around, over its greatest turn rate.
const LOOK_AROUND_SHARE: f64 = 0.3;

/// Decides from the estimate how freely the robot may drive.
#[derive(Clone, Debug)]
pub(super) struct Caution {
    ground_plan: GroundPlan,
    clearance_m: f64,
    look_around_rad_per_s: f64,
    /// Width of the estimate's hull (the smallest box around all boxes of the estimate) up to which the robot drives at full speed.
    sure_width_m: f64,
    waiting_since_s: Option<f64>,
}

/// What the robot is allowed to do while its pose is uncertain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    /// The robot may follow the route at a share of its speed.
    Drive { speed_share: f64 },
    /// The robot may turn in place to see more.
    LookAround { turn_rad_per_s: f64 },
    /// The robot may not move, because the estimate holds no pose.
    Halt,
}

impl Caution {
    /// The rules by which a robot in the scene's room limits its driving while its pose is uncertain.
    pub(super) fn new(scene: &Scene) -> Self {
        Caution {
            ground_plan: GroundPlan::of(scene),
            clearance_m: scene.robot.body_radius_m + WALL_MARGIN_M,
            look_around_rad_per_s: LOOK_AROUND_SHARE * scene.robot.max_turn_rate_rad_per_s,
            sure_width_m: scene.route.as_ref().map_or(Route::SURE_WIDTH_M, |route| route.sure_width_m),
            waiting_since_s: None,
        }
    }

    /// Decides how freely the robot may drive, from the hull of the estimate (the smallest box around all its boxes) and from whether the
    /// localizer is recovering from a contradiction.
    pub(super) fn judge(&mut self, hull: &PoseBox, recovering: bool, time_s: f64) -> Freedom {
        if hull.is_empty() {
            return Freedom::Halt;
        }
        if !(recovering && self.may_be_by_a_wall(hull)) {
            self.waiting_since_s = None;
            return Freedom::Drive { speed_share: self.share(hull) };
        }
        let since_s = *self.waiting_since_s.get_or_insert(time_s);
        if time_s - since_s < PATIENCE_S {
            Freedom::LookAround { turn_rad_per_s: self.look_around_rad_per_s }
        } else {
            Freedom::Drive { speed_share: LEAST_SHARE }
        }
    }
}

impl Caution {
    /// The share of its speed at which the robot drives.
    fn share(&self, hull: &PoseBox) -> f64 {
        let width_m = hull.width(0).max(hull.width(1));
        (self.sure_width_m / width_m.max(self.sure_width_m)).max(LEAST_SHARE)
    }

    /// Whether a wall may be within the robot's clearance at some pose of the hull.
    fn may_be_by_a_wall(&self, hull: &PoseBox) -> bool {
        if self.ground_plan.has_further_rooms() {
            let middle_m = [hull[0].mid(), hull[1].mid()];
            let reach_m = hull[0].radius().hypot(hull[1].radius());
            return self.ground_plan.wall_distance_m(middle_m) < self.clearance_m + reach_m;
        }
        let [_, room_m] = self.ground_plan.extents_m();
        (0..2).any(|axis| hull[axis].lo() < self.clearance_m || hull[axis].hi() > room_m[axis] - self.clearance_m)
    }
}
