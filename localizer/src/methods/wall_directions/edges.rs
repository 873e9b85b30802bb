//! An image's edges, sorted by what they may be.

use interval::Interval;

use crate::vision::forward::EdgeLine;

use super::{
    NEW_DIRECTION_RAD, WallDirections,
    agreement::about,
    distinct::distinct,
    headings,
    sight::{self, SightPlane},
};

/// An upright edge is a corner, a door post or a shelf's side; shorter ones are parts of anything.
const UPRIGHT_PX: f64 = 100.0;
/// So few of them are in an image that none may be wrong: they are claimed with bounds as many times as wide.
const UPRIGHT_BOUNDS: f64 = 1.5;

/// The edges of an image by what they may be.
pub(super) struct Edges {
    /// Headings at which level ones were looked for.
    pub(super) about: Interval,
    /// Level, and along a direction of the building there.
    pub(super) level: Vec<EdgeLine>,
    pub(super) upright: Vec<EdgeLine>,
    /// Directions from robot forward of level ones that run along no wall known.
    pub(super) strange_rad: Vec<Interval>,
    /// All that are neither.
    pub(super) rejected_px: Vec<[f64; 4]>,
}

impl WallDirections {
    /// Sorts edges into level and upright ones and those that are neither, one of each thing.
    pub(super) fn sorted(&self, lines: &[EdgeLine], heading: Interval, directions_rad: &[Interval]) -> Edges {
        let focal_px = self.camera.focal_px.mid();
        let (upright, others): (Vec<EdgeLine>, Vec<EdgeLine>) = lines.iter().partition(|line| self.is_upright(line));
        let upright = upright.iter().map(|line| EdgeLine { bound_px: UPRIGHT_BOUNDS * line.bound_px, ..*line });
        let known_to = |line: &EdgeLine| {
            Some(line.bound_px / sight::length_px(line)).filter(|_| sight::length_px(line) >= UPRIGHT_PX)
        };
        let upright: Vec<_> = upright.map(|line| (line, known_to(&line))).collect();
        let kept = distinct(&upright, focal_px);
        let upright = upright.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|((line, _), _)| line).collect();

        let azimuth = |line: &EdgeLine| {
            let (is_on_floor, is_short) = sight::on_floor(line, &self.camera);
            if is_on_floor && (is_short || !self.floor_edges) {
                return None;
            }
            let azimuth = sight::azimuth(line, &self.camera, self.body_tilt_rad, self.widest_rad)?;
            let azimuth = azimuth.inflate(self.stamp_turn_rad);
            (self.solves_lean || azimuth.width() <= sight::WIDEST_RAD).then_some(azimuth)
        };
        let mut sighted: Vec<(EdgeLine, Option<Interval>)> =
            others.into_iter().map(|line| (line, azimuth(&line))).collect();
        let widths: Vec<_> =
            sighted.iter().map(|(line, azimuth)| (*line, azimuth.map(|azimuth| azimuth.width()))).collect();
        for ((_, azimuth), kept) in sighted.iter_mut().zip(distinct(&widths, focal_px)) {
            *azimuth = azimuth.filter(|_| kept);
        }
        let about = about(heading, &sighted, directions_rad);
        let mut edges = Edges { about, level: Vec::new(), upright, strange_rad: Vec::new(), rejected_px: Vec::new() };
        for (line, azimuth) in sighted {
            match azimuth {
                Some(azimuth) if headings::of_line(azimuth, directions_rad, about).is_empty() => {
                    // What a lean may turn far tells no direction to learn.
                    edges.strange_rad.extend((azimuth.width() <= NEW_DIRECTION_RAD).then_some(azimuth));
                    edges.rejected_px.push(segment_px(&line));
                }
                Some(_) => edges.level.push(line),
                None => edges.rejected_px.push(segment_px(&line)),
            }
        }
        edges
    }

    /// Whether the edge may be an upright one at some lean.
    fn is_upright(&self, line: &EdgeLine) -> bool {
        let tilt_rad = self.camera.tilt_error_rad + self.body_tilt_rad;
        sight::crosses_horizon(line, &self.camera, tilt_rad)
            && SightPlane::of(line, &self.camera).is_some_and(|plane| plane.may_be_upright(tilt_rad))
    }
}

fn segment_px(line: &EdgeLine) -> [f64; 4] {
    let [[u0, v0], [u1, v1]] = line.ends_px;
    [u0, v0, u1, v1]
}
