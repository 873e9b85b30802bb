//! All pictures of a drive that teaches a map, by which its landmarks are bounded once more at the end of the drive.
//!
//! While the robot drives, a landmark is bounded by pictures that follow each other closely, from poses that are known as well as they are just then. At
//! the end, poses are known by all that was read before and after, and pictures from farther apart tell the depth better. Of a window of key frames, the
//! landmarks that several pictures show are solved in parts, each together with all poses, ways and positions of the window.

use std::{cmp::Reverse, collections::BTreeMap, sync::Arc};

use crate::{PoseBox, graph::Relations, reading::LandmarkId};

use super::{
    album::Album,
    anywhere::may_be_seen,
    ray::Optics,
    relate::{Points, Sight},
};

/// Greatest number of landmarks of a part: a program of 14 landmarks and 24 key frames has some 250 quantities.
const MOST_OF_PART: usize = 14;
/// Least number of pictures of a window that show a landmark of a part.
const FEWEST_SHOWN: usize = 3;
/// Least distance of the robot, in metres, and least turn, in radians, between two pictures that a map keeps.
const APART_M: f64 = 0.25;
const APART_RAD: f64 = 0.15;

/// The sightings of all pictures of a drive, by their stamps.
#[derive(Clone, Debug, Default)]
pub(super) struct WholeDrive {
    pictures: Vec<(f64, Vec<Sight>)>,
}

impl WholeDrive {
    /// Adds sightings of the latest picture.
    pub(super) fn note(&mut self, stamp_s: f64, sights: &[Sight]) {
        match self.pictures.last_mut() {
            Some((latest_s, all)) if *latest_s == stamp_s => all.extend_from_slice(sights),
            _ => self.pictures.push((stamp_s, sights.to_vec())),
        }
    }

    /// Number of the pictures so far.
    pub(super) fn n_pictures(&self) -> usize {
        self.pictures.len()
    }

    /// Forgets all but the first pictures.
    pub(super) fn truncate(&mut self, n_pictures: usize) {
        self.pictures.truncate(n_pictures);
    }

    /// Pictures of the drive, some way apart: their stamps, the boxes of the poses that they show, and their sightings that agree with what is known of
    /// their landmarks. `shown` are stamps with these boxes.
    pub(super) fn apart(
        &self,
        shown: &[(f64, PoseBox)],
        album: &Album,
        optics: &Optics,
    ) -> Vec<(f64, PoseBox, Vec<Sight>)> {
        let mut apart: Vec<(f64, PoseBox, Vec<Sight>)> = Vec::new();
        for (stamp_s, pose) in shown {
            let Some((_, sights)) = self.pictures.iter().find(|(picture_s, _)| picture_s == stamp_s) else { continue };
            let is_apart = apart.last().is_none_or(|(_, last, _)| {
                let [x_m, y_m, turned] = [0, 1, 2].map(|axis| pose[axis].mid() - last[axis].mid());
                x_m.hypot(y_m) >= APART_M || turned.abs() >= APART_RAD
            });
            if is_apart {
                let known = |sight: &Sight| Some(Sight { point: album.point(sight.landmark)?, ..*sight });
                let agrees = |sight: &Sight| may_be_seen(optics, sight, pose);
                let agreeing = sights.iter().filter_map(known).filter(agrees).collect();
                apart.push((*stamp_s, *pose, agreeing));
            }
        }
        apart
    }

    /// What the pictures with some stamps relate, from poses within boxes, in parts of the landmarks that enough of them show. Sightings that contradict
    /// what is known of their landmark are left out.
    pub(super) fn parts(
        &self,
        shown: &[(f64, PoseBox)],
        album: &Album,
        optics: &Arc<Optics>,
    ) -> Vec<Vec<(f64, Arc<dyn Relations>)>> {
        let agreeing = |(stamp_s, pose): &(f64, PoseBox)| {
            let (_, sights) = self.pictures.iter().find(|(picture_s, _)| picture_s == stamp_s)?;
            let known = |sight: &Sight| Some(Sight { point: album.point(sight.landmark)?, ..*sight });
            let agrees = |sight: &Sight| may_be_seen(optics, sight, pose);
            Some((*stamp_s, sights.iter().filter_map(known).filter(agrees).collect::<Vec<Sight>>()))
        };
        let pictures: Vec<(f64, Vec<Sight>)> = shown.iter().filter_map(agreeing).collect();
        let mut n_shown: BTreeMap<LandmarkId, usize> = BTreeMap::new();
        for sight in pictures.iter().flat_map(|(_, sights)| sights) {
            *n_shown.entry(sight.landmark).or_default() += 1;
        }
        let mut often: Vec<(usize, LandmarkId)> =
            n_shown.into_iter().filter(|(_, n)| *n >= FEWEST_SHOWN).map(|(landmark, n)| (n, landmark)).collect();
        often.sort_by_key(|&(n, landmark)| (Reverse(n), landmark));
        let related = |part: &[(usize, LandmarkId)]| {
            let of_picture = |(stamp_s, sights): &(f64, Vec<Sight>)| {
                let is_of_part = |sight: &&Sight| part.iter().any(|(_, landmark)| *landmark == sight.landmark);
                let seen: Vec<Sight> = sights.iter().filter(is_of_part).copied().collect();
                (!seen.is_empty()).then(|| {
                    let points: Arc<dyn Relations> = Arc::new(Points { optics: Arc::clone(optics), seen });
                    (*stamp_s, points)
                })
            };
            pictures.iter().filter_map(of_picture).collect()
        };
        often.chunks(MOST_OF_PART).map(related).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
