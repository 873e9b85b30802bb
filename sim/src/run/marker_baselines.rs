//! Point estimates from pictures of the ceiling, to compare with the method `ceiling_markers`: the pipeline of Zhou et al. 2016 as
//! printed, and a least-squares fit to all markers that it can read, given the direction of the vertical.

use std::{f64::consts::TAU, time::Instant};

use image::GrayImage;
use localizer::{
    Map, Pose, RobotModel,
    baselines::locate_upright,
    methods::ceiling_markers::paper::{self, PaperFix},
};

/// Name of paper 5's pipeline, which reads the marker nearest to the image's centre.
pub(super) const NEAREST_MARKER: &str = "nearest_marker";
/// Name of the fit to all markers, given the direction of the vertical.
pub(super) const VERTICAL_KNOWN: &str = "vertical_known";

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

/// The pose that one of the two methods gives for a picture, taken from the answers of both.
type ToldPose = fn(&PaperAnswer) -> Option<Pose>;

impl MarkerBaselines {
    /// Names of the figures of paper 5's pipeline in a summary: share of the pictures that it read rightly, number that it misread, and the
    /// correlations of its confidence with its errors in position and in heading.
    pub const FIGURES: [&str; 4] = [
        "nearest_marker_read_share",
        "nearest_marker_misread",
        "nearest_marker_confidence_position_correlation",
        "nearest_marker_confidence_heading_correlation",
    ];

    /// The poses of both methods by their names, each with the true pose at the same time; a method that read no picture is left out.
    pub(super) fn named(&self) -> Vec<(&'static str, Vec<(Pose, Pose)>)> {
        let told: [(&str, ToldPose); 2] =
            [(NEAREST_MARKER, |answer| Some(answer.fix?.pose)), (VERTICAL_KNOWN, |answer| answer.upright)];
        let fixes = |told: ToldPose| -> Vec<(Pose, Pose)> {
            self.answers.iter().filter_map(|answer| Some((told(answer)?, answer.truth))).collect()
        };
        let named = told.into_iter().map(|(name, told)| (name, fixes(told)));
        named.filter(|(_, fixes)| !fixes.is_empty()).collect()
    }

    /// Mean time in microseconds that each method took for one picture, by the method's name; empty where there was no picture.
    pub(crate) fn solve_us(&self) -> Vec<(&'static str, f64)> {
        let mean_us = |spent_s: f64| 1e6 * spent_s / self.answers.len() as f64;
        let all = [(NEAREST_MARKER, self.spent_s), (VERTICAL_KNOWN, self.spent_upright_s)];
        all.into_iter().filter(|_| !self.answers.is_empty()).map(|(name, spent_s)| (name, mean_us(spent_s))).collect()
    }

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
