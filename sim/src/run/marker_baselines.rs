//! Point estimates from pictures of the ceiling to compare `ceiling_markers` with: the pipeline of Zhou et al. 2016 as printed, and a least-squares fit to the
//! markers that it reads in which the direction of the vertical is known.

use std::{f64::consts::TAU, time::Instant};

use image::GrayImage;
use localizer::{
    Map, Pose, RobotModel,
    baselines::locate_upright,
    methods::ceiling_markers::paper::{self, PaperFix},
};

/// What the paper's pipeline made of a run's pictures.
#[derive(Clone, Debug, Default)]
pub struct MarkerBaselines {
    /// One for each picture, in their order.
    pub answers: Vec<PaperAnswer>,
    /// Wall-clock time spent.
    pub spent_s: f64,
    /// Wall-clock time spent on the same with the vertical known.
    pub spent_upright_s: f64,
}

/// The paper's answer to one picture.
#[derive(Clone, Copy, Debug)]
pub struct PaperAnswer {
    /// Where the robot truly was.
    pub truth: Pose,
    /// What it read and where that puts the robot, heading in the turn of the truth; none without a marker of the map.
    pub fix: Option<PaperFix>,
    /// Where all markers put the robot if its camera's vertical is known, heading likewise.
    pub upright: Option<Pose>,
}

impl MarkerBaselines {
    /// Puts a picture to the paper's pipeline.
    pub(super) fn observe(&mut self, image: &GrayImage, map: &Map, robot: &RobotModel, truth: Pose) {
        let Some(markers) = &map.markers else { return };
        let near = |pose: Pose| {
            let turns = ((pose.heading_rad - truth.heading_rad) / TAU).round();
            Pose { heading_rad: pose.heading_rad - turns * TAU, ..pose }
        };
        let began = Instant::now();
        let fix = paper::locate(image, markers, robot);
        self.spent_s += began.elapsed().as_secs_f64();
        let fix = fix.map(|fix| PaperFix { pose: near(fix.pose), ..fix });
        let began = Instant::now();
        let upright = locate_upright(image, markers, robot);
        self.spent_upright_s += began.elapsed().as_secs_f64();
        self.answers.push(PaperAnswer { truth, fix, upright: upright.map(near) });
    }
}
