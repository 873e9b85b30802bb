//! Edges of an image, sorted into level edges, upright edges and others.

use interval::Interval;

use crate::vision::forward::EdgeLine;

use super::{
    NEW_DIRECTION_RAD, WallDirections,
    agreement::about,
    distinct::distinct,
    headings,
    sight::{self, SightPlane},
};

/// Least length of an upright edge that is used, in pixels. A long one is a corner, a door post or a shelf's side; shorter ones may be
/// parts of anything.
const UPRIGHT_PX: f64 = 100.0;
/// Factor on the bound of upright edges. An image has so few of them that none may be wrong, so they are claimed with a wider bound.
const UPRIGHT_BOUNDS: f64 = 1.5;

/// Edges of an image, sorted by what they may be.
pub(super) struct Edges {
    /// Range of headings at which level edges were looked for in the image.
    pub(super) about: Interval,
    /// Edges that are level and, at a heading of that range, run along a direction of the building.
    pub(super) level: Vec<EdgeLine>,
    pub(super) upright: Vec<EdgeLine>,
    /// Directions from robot forward of level image edges that run along no known wall.
    pub(super) strange_rad: Vec<Interval>,
    /// Segments of all edges that are neither level along a known direction nor upright.
    pub(super) rejected_px: Vec<[f64; 4]>,
}

impl WallDirections {
    /// Sorts edges into level ones, upright ones and those that are neither, and keeps one edge of each thing.
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
                    // An edge that a lean may turn far is too inaccurate for a new direction to be learnt from it.
                    edges.strange_rad.extend((azimuth.width() <= NEW_DIRECTION_RAD).then_some(azimuth));
                    edges.rejected_px.push(segment_px(&line));
                }
                Some(_) => edges.level.push(line),
                None => edges.rejected_px.push(segment_px(&line)),
            }
        }
        edges
    }

    /// Whether an image edge may be an upright line at some lean of robot and camera.
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
