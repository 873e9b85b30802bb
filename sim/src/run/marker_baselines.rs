//! Point estimates from pictures of the ceiling, to compare with the method `ceiling_markers`: the pipeline of Zhou et al. 2016 as
//! printed, and a least-squares fit to all markers that it can read, given the direction of the vertical.

use std::{f64::consts::TAU, time::Instant};

use image::GrayImage;
use localizer::{
    Map, Pose, RobotModel,
    baselines::locate_upright,
    methods::ceiling_markers::paper::{self, PaperFix},
};

/// Results of the pipeline of paper 5 on the ceiling pictures of one run.
#[derive(Clone, Debug, Default)]
pub struct MarkerBaselines {
    /// Answers of paper 5's pipeline, one for each picture, in the order of the pictures.
    pub answers: Vec<PaperAnswer>,
    /// Wall-clock time that the paper's pipeline took.
    pub spent_s: f64,
    /// Wall-clock time that the fit with a known vertical took.
    pub spent_upright_s: f64,
}

/// Answer of paper 5's pipeline to one picture.
#[derive(Clone, Copy, Debug)]
pub struct PaperAnswer {
    /// True pose of the robot at the picture.
    pub truth: Pose,
    /// The marker that the pipeline read and the pose that follows from it, with the heading in the same turn as the true one; none when
    /// no marker of the map was read.
    pub fix: Option<PaperFix>,
    /// Pose by a least-squares fit to the markers of the picture, given the direction of the vertical, with the heading in the same turn
    /// as the true one; none when no marker of the map was read.
    pub upright: Option<Pose>,
}

impl MarkerBaselines {
    /// Gives a picture to the paper's pipeline and to the fit with a known vertical, and keeps their answers.
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
