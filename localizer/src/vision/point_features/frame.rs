//! One image, prepared once, in which landmarks are created and found.

use std::collections::BTreeMap;

use image::GrayImage;

use crate::vision::forward::Picture;

use super::alignment::{Aligned, Plane, Warp, align, align_coarsely};
use super::claim::{Accuracy, ImageBounds, allowed_share};
use super::correlation;
use super::descriptor::{Descriptor, Pattern};
use super::keypoint::{Keypoint, keypoints};
use super::landmark::Landmark;
use super::patch::{FINE, Patch, Template};
use super::posture::{LEVEL, Posture, TURN_RAD, postures, turn_within};
use super::search::{Refusal, Region, Search, Sighting};
use super::smoothing::{self, FINE_VARIANCE_PX2};
use super::templates::Templates;

/// Greatest number of keypoints of an image.
const MOST_KEYPOINTS: usize = 1000;
/// Greatest number of differing comparisons of descriptors that may show the same point. Chance gives 128 ± 8.
const MOST_BITS: u32 = 84;
/// Candidates with more differing comparisons than the best one by this number are not aligned.
const MORE_BITS: u32 = 26;
/// Greatest number of candidates that are aligned.
const MOST_CANDIDATES: usize = 3;
/// Distance of a keypoint from the region of a search, at scale 1, up to which it may belong to a landmark within: corners are found to one or two
/// pixels again.
const SLACK_PX: f64 = 3.0;
/// Least zero-mean normalised cross-correlation of a landmark that is found.
const LEAST_ZNCC: f64 = 0.97;
/// Least share of a patch that counts as unexplained when two candidates are compared: less is the chance of the noise.
const LEAST_UNEXPLAINED: f64 = 2e-3;
/// Second candidates at another place whose patch is left unexplained by less than this multiple of the best one's share make a search ambiguous.
const AMBIGUOUS: f64 = 4.0;
/// Observations with a greater half width are refused.
const WIDEST_PX: f64 = 1.0;
/// Greatest standard deviation of the linear change of a new landmark's patch. A patch that shows a single corner looks the same after some changes,
/// and the same as any other corner.
const MOST_CHANGE: f64 = 0.05;
/// Two keypoints of one image with no more differing comparisons than this look alike: neither becomes a landmark.
const LOOKALIKE_BITS: u32 = 40;

/// An image with its keypoints. Descriptors are computed when a search first needs them.
pub struct Frame<'a> {
    image: &'a GrayImage,
    bounds: ImageBounds,
    fine: Picture,
    coarse: Picture,
    pattern: Pattern,
    keypoints: Vec<Keypoint>,
    /// Column of each keypoint and its index, by increasing columns.
    by_column: Vec<(f64, usize)>,
    /// For each posture, the direction and descriptor of each keypoint, once they are computed; keypoints near the border have none.
    described: BTreeMap<Posture, Vec<Option<Option<Described>>>>,
}

/// Direction of a keypoint and the descriptor that is turned by it.
pub(super) type Described = (f64, Descriptor);

/// A keypoint that may show a landmark.
struct Candidate {
    bits: u32,
    keypoint_idx: usize,
    posture: Posture,
    turn_rad: f64,
}

impl<'a> Frame<'a> {
    /// Prepares an image of any size.
    pub fn new(image: &'a GrayImage, bounds: &ImageBounds) -> Frame<'a> {
        let fine = smoothing::fine(image);
        let coarse = smoothing::coarse(&fine);
        let keypoints = keypoints(&fine, MOST_KEYPOINTS);
        let mut by_column: Vec<(f64, usize)> =
            keypoints.iter().enumerate().map(|(idx, keypoint)| (keypoint.position_px[0], idx)).collect();
        by_column.sort_by(|a, b| a.0.total_cmp(&b.0));
        let described = BTreeMap::new();
        Frame { image, bounds: *bounds, fine, coarse, pattern: Pattern::new(), keypoints, by_column, described }
    }

    /// Corners of the image, spread over it by a grid, the best of each cell first.
    pub fn keypoints(&self) -> &[Keypoint] {
        &self.keypoints
    }

    /// At most `most` new landmarks, spread over the image. Corners are left out near the border, where their patch does not determine how it is
    /// placed and changed, and where another corner of the image looks alike.
    pub fn landmarks(&mut self, most: usize) -> Vec<Landmark> {
        self.landmarks_where(most, |_| true)
    }

    /// The same of the corners at places `[u, v]` that are wanted, which are asked for one after the other.
    pub fn landmarks_where(&mut self, most: usize, mut is_wanted: impl FnMut([f64; 2]) -> bool) -> Vec<Landmark> {
        let mut landmarks = Vec::new();
        let [upright, turned] =
            [Posture { level: 0, turn: Some(0) }, Posture { level: 0, turn: None }].map(|posture| {
                (0..self.keypoints.len()).map(|idx| self.described(idx, posture)).collect::<Vec<Option<Described>>>()
            });
        let has_double = |all: &[Option<Described>], idx: usize, descriptor: &Descriptor| {
            all.iter().enumerate().any(|(other_idx, other)| {
                let is_alike = |(_, other): &Described| other.hamming_distance(descriptor) <= LOOKALIKE_BITS;
                other_idx != idx && other.as_ref().is_some_and(is_alike)
            })
        };
        for (idx, keypoint) in self.keypoints.iter().enumerate() {
            if landmarks.len() >= most {
                break;
            }
            let position_px = keypoint.position_px;
            let (Some((_, upright_one)), Some((direction_rad, turned_one)), Some(patch)) =
                (upright[idx], turned[idx], Patch::cut(self.image, position_px))
            else {
                continue;
            };
            let is_single = !has_double(&upright, idx, &upright_one) && !has_double(&turned, idx, &turned_one);
            let landmark = Landmark {
                position_px,
                focal_px: Some(self.bounds.focal_px),
                direction_rad,
                upright: upright_one,
                turned: turned_one,
                patch,
            };
            if is_single && self.is_determined(&landmark) && is_wanted(position_px) {
                landmarks.push(landmark);
            }
        }
        landmarks
    }

    /// Whether another image like this one would determine the landmark's position.
    fn is_determined(&self, landmark: &Landmark) -> bool {
        let template = Template::fine(&landmark.patch, landmark.offset_px(), 1.0, FINE_VARIANCE_PX2);
        let mean_grey = landmark.patch.mean();
        let warp = Warp::similarity(landmark.position_px, 1.0, 0.0);
        let aligned = Aligned { warp, zncc: 1.0, gain: 1.0, residual: 0.0, mean_grey };
        Accuracy::of(&template, &aligned, &self.bounds, mean_grey, 1.0).is_some_and(|accuracy| {
            accuracy.half_widths_px(&warp).iter().all(|half| *half < WIDEST_PX) && accuracy.change < MOST_CHANGE
        })
    }

    /// Searches a landmark.
    ///
    /// # Errors
    ///
    /// When it is not found or cannot be told from something else.
    pub fn find(&mut self, landmark: &Landmark, search: &Search) -> Result<Sighting, Refusal> {
        self.find_by(&mut Templates::default(), landmark, search)
    }

    /// Searches a landmark, with templates that may be left from searches for the same landmark in earlier images.
    ///
    /// # Errors
    ///
    /// As for [`find`](Self::find).
    pub fn find_by(
        &mut self,
        templates: &mut Templates,
        landmark: &Landmark,
        search: &Search,
    ) -> Result<Sighting, Refusal> {
        let Some(region) = Region::of(search) else { return Err(Refusal::NothingAlike) };
        let postures = postures(search);
        templates.keep(|level| postures.iter().any(|posture| posture.level == level));
        let starts = self
            .candidates(landmark, search, &postures, &region)
            .iter()
            .map(|candidate| self.start(candidate))
            .collect();
        let mut found = self.try_all(landmark, &region, templates, starts);
        // Corners are not always found again, and what looks like the landmark elsewhere need not have been found as a corner either.
        let is_new = |(_, start): &(i32, Warp)| {
            found.iter().flatten().all(|sighting| {
                let apart = [0, 1].map(|axis| sighting.position_px[axis] - start.origin_px[axis]);
                apart[0].hypot(apart[1]) > SLACK_PX * start.image_from_patch.determinant().sqrt()
            })
        };
        let peaks = self.peaks(landmark, search, &postures, &region, templates);
        let others: Vec<_> = peaks.into_iter().filter(is_new).collect();
        if !others.is_empty() {
            match (&mut found, self.try_all(landmark, &region, templates, others)) {
                (Ok(found), Ok(others)) => found.extend(others),
                (Ok(_), Err(_)) => {}
                (Err(_), others) => found = others,
            }
        }
        distinct(found?)
    }

    /// Aligns the landmark's patch from each of some warps: what was found, or why the last of them shows nothing.
    fn try_all(
        &self,
        landmark: &Landmark,
        region: &Region,
        templates: &mut Templates,
        starts: Vec<(i32, Warp)>,
    ) -> Result<Vec<Sighting>, Refusal> {
        let mut found = Vec::new();
        let mut refusal = Refusal::NothingAlike;
        for (level, start) in starts {
            match self.seen_from(start, landmark, level, templates, region) {
                Ok(sighting) => found.push(sighting),
                Err(why) => refusal = why,
            }
        }
        if found.is_empty() { Err(refusal) } else { Ok(found) }
    }

    /// The warp from which a candidate is aligned, and its level of scale.
    fn start(&self, candidate: &Candidate) -> (i32, Warp) {
        let level = candidate.posture.level;
        let position_px = self.keypoints[candidate.keypoint_idx].position_px;
        (level, Warp::similarity(position_px, LEVEL.powi(level), candidate.turn_rad))
    }

    /// Warps at the peaks of the correlation in a small region.
    fn peaks(
        &self,
        landmark: &Landmark,
        search: &Search,
        postures: &[Posture],
        region: &Region,
        templates: &mut Templates,
    ) -> Vec<(i32, Warp)> {
        let Some(Posture { level, turn: Some(_) }) = postures.get(postures.len() / 2).copied() else {
            return Vec::new();
        };
        if !correlation::is_small(region) {
            return Vec::new();
        }
        let warp = Warp::similarity([0.0; 2], LEVEL.powi(level), search.turn_rad.mid());
        let peaks = correlation::peaks(templates.coarse(landmark, level), &self.coarse, region, &warp);
        peaks.into_iter().map(|origin_px| (level, Warp { origin_px, ..warp })).collect()
    }

    /// Keypoints in the region whose descriptors are like the landmark's, the most alike first.
    fn candidates(
        &mut self,
        landmark: &Landmark,
        search: &Search,
        postures: &[Posture],
        region: &Region,
    ) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        let mut near: (f64, Vec<usize>) = (f64::NAN, Vec::new());
        for &posture in postures {
            let slack = SLACK_PX * LEVEL.powi(posture.level).max(1.0);
            // Postures of one level follow each other.
            if near.0 != slack {
                near = (slack, self.near(region, slack));
            }
            let described = self.described.entry(posture).or_insert_with(|| vec![None; self.keypoints.len()]);
            for &keypoint_idx in &near.1 {
                let known = described[keypoint_idx].get_or_insert_with(|| {
                    describe(&self.pattern, &self.coarse, self.keypoints[keypoint_idx].position_px, posture)
                });
                let Some((direction_rad, descriptor)) = known else { continue };
                let (of_landmark, turn_rad) = match posture.turn {
                    Some(_) => (&landmark.upright, *direction_rad),
                    None => (&landmark.turned, *direction_rad - landmark.direction_rad),
                };
                let bits = descriptor.hamming_distance(of_landmark);
                if bits > MOST_BITS {
                    continue;
                }
                if let Some(turn_rad) = turn_within(turn_rad, search) {
                    candidates.push(Candidate { bits, keypoint_idx, posture, turn_rad });
                }
            }
        }
        candidates.sort_by_key(|candidate| (candidate.bits, candidate.keypoint_idx, candidate.posture));
        // A keypoint is tried in the posture in which it is most alike.
        let mut kept: Vec<Candidate> = Vec::new();
        for candidate in candidates {
            let is_new = kept.iter().all(|other| other.keypoint_idx != candidate.keypoint_idx);
            let is_near = kept.first().is_none_or(|best| candidate.bits <= best.bits + MORE_BITS);
            if is_new && is_near && kept.len() < MOST_CANDIDATES {
                kept.push(candidate);
            }
        }
        kept
    }

    /// Indices of the keypoints that may be in a region, or beside it by a slack in pixels.
    fn near(&self, region: &Region, slack: f64) -> Vec<usize> {
        let [low, high] = region.hull_px.map(|[u, _]| u);
        let first = self.by_column.partition_point(|(u, _)| *u < low - slack);
        let to_right = self.by_column[first..].iter().take_while(|(u, _)| *u <= high + slack);
        let is_near = |idx: &usize| region.may_meet(self.keypoints[*idx].position_px, [slack; 2]);
        to_right.map(|(_, idx)| *idx).filter(is_near).collect()
    }

    /// The sighting to which an alignment leads from a warp, or why there is none.
    fn seen_from(
        &self,
        start: Warp,
        landmark: &Landmark,
        level: i32,
        templates: &mut Templates,
        region: &Region,
    ) -> Result<Sighting, Refusal> {
        let scale = start.image_from_patch.determinant().sqrt();
        let coarse = templates.coarse(landmark, level);
        let warp = align_coarsely(coarse, &ImageBounds::coarse_prior(), Plane::coarse(&self.coarse), start)
            .ok_or(Refusal::NotAligned)?;
        let fine = templates.fine(landmark, level);
        let prior = self.bounds.prior(scale, landmark.enlargement(self.bounds.focal_px));
        let aligned = align(fine, &prior, Plane::fine(&self.fine), warp).ok_or(Refusal::NotAligned)?;
        self.judged(landmark, fine, &aligned, region)
    }

    /// The sighting that an aligned patch is, or why it is none.
    fn judged(
        &self,
        landmark: &Landmark,
        template: &Template<FINE>,
        aligned: &Aligned,
        region: &Region,
    ) -> Result<Sighting, Refusal> {
        let patch_grey = landmark.patch.mean();
        let unexplained = 1.0 - aligned.zncc * aligned.zncc;
        if aligned.zncc < LEAST_ZNCC || unexplained > allowed_share(template, aligned, &self.bounds, patch_grey) {
            return Err(Refusal::Unlike { zncc: aligned.zncc });
        }
        let enlargement = landmark.enlargement(self.bounds.focal_px);
        let accuracy = Accuracy::of(template, aligned, &self.bounds, patch_grey, enlargement);
        let half_width_px = accuracy.map_or([f64::INFINITY; 2], |accuracy| accuracy.half_widths_px(&aligned.warp));
        let widest = half_width_px[0].max(half_width_px[1]);
        if widest > WIDEST_PX {
            return Err(Refusal::Vague { half_width_px: widest });
        }
        let position_px = aligned.warp.origin_px;
        if !region.may_meet(position_px, half_width_px) {
            return Err(Refusal::NotAligned);
        }
        let m = aligned.warp.image_from_patch;
        let image_from_patch = [[m.m11, m.m12], [m.m21, m.m22]];
        Ok(Sighting { position_px, half_width_px, zncc: aligned.zncc, image_from_patch })
    }

    /// Direction and descriptor of a keypoint in a posture; `None` near the border.
    pub(super) fn described(&mut self, keypoint_idx: usize, posture: Posture) -> Option<Described> {
        let n_keypoints = self.keypoints.len();
        let known = self.described.entry(posture).or_insert_with(|| vec![None; n_keypoints]);
        *known[keypoint_idx].get_or_insert_with(|| {
            describe(&self.pattern, &self.coarse, self.keypoints[keypoint_idx].position_px, posture)
        })
    }
}

/// Direction and descriptor of a point of an image in a posture; `None` near the border.
fn describe(pattern: &Pattern, coarse: &Picture, at_px: [f64; 2], posture: Posture) -> Option<Described> {
    let scale = LEVEL.powi(posture.level);
    let direction_rad = match posture.turn {
        Some(turn) => f64::from(turn) * TURN_RAD,
        None => pattern.direction_rad(coarse, at_px, scale)?,
    };
    let descriptor = pattern.describe(coarse, at_px, scale, direction_rad)?;
    Some((direction_rad, descriptor))
}

/// The best of several sightings, unless another one is nearly as good at another place.
fn distinct(mut found: Vec<Sighting>) -> Result<Sighting, Refusal> {
    found.sort_by(|a, b| b.zncc.total_cmp(&a.zncc));
    let Some(best) = found.first().copied() else { return Err(Refusal::NothingAlike) };
    let unexplained = |sighting: &Sighting| (1.0 - sighting.zncc * sighting.zncc).max(LEAST_UNEXPLAINED);
    let is_other = |other: &&Sighting| {
        let apart = [0, 1].map(|axis| (other.position_px[axis] - best.position_px[axis]).abs());
        (0..2).any(|axis| apart[axis] > best.half_width_px[axis] + other.half_width_px[axis])
    };
    match found.iter().find(is_other) {
        Some(other) if unexplained(other) < AMBIGUOUS * unexplained(&best) => {
            Err(Refusal::Ambiguous { positions_px: [best.position_px, other.position_px] })
        }
        _ => Ok(best),
    }
}
