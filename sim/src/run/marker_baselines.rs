//! Beside `ceiling_markers`: paper 5's own pipeline on the same pictures.

use std::{f64::consts::TAU, time::Instant};

use image::GrayImage;
use localizer::{
    Map, Pose, RobotModel,
    methods::ceiling_markers::paper::{self, PaperFix},
};

/// What the paper's pipeline made of a run's pictures.
#[derive(Clone, Debug, Default)]
pub struct MarkerBaselines {
    /// One for each picture, in their order.
    pub answers: Vec<PaperAnswer>,
    /// Wall-clock time spent.
    pub spent_s: f64,
}

/// The paper's answer to one picture.
#[derive(Clone, Copy, Debug)]
pub struct PaperAnswer {
    /// Where the robot truly was.
    pub truth: Pose,
    /// What it read and where that puts the robot, heading in the turn of the truth; none without a marker of the map.
    pub fix: Option<PaperFix>,
}

impl MarkerBaselines {
    /// Puts a picture to the paper's pipeline.
    pub(super) fn observe(&mut self, image: &GrayImage, map: &Map, robot: &RobotModel, truth: Pose) {
        let Some(markers) = &map.markers else { return };
        let began = Instant::now();
        let fix = paper::locate(image, markers, robot);
        self.spent_s += began.elapsed().as_secs_f64();
        let fix = fix.map(|fix| {
            let turns = ((fix.pose.heading_rad - truth.heading_rad) / TAU).round();
            PaperFix { pose: Pose { heading_rad: fix.pose.heading_rad - turns * TAU, ..fix.pose }, ..fix }
        });
        self.answers.push(PaperAnswer { truth, fix });
    }
}
