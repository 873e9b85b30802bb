//! A landmark's templates at the levels of scale at which it is searched.
//!
//! They depend on the landmark and the level alone. To make them takes about a sixth of the time of a search, so that they may be kept from image to image.

use std::{cell::OnceCell, collections::BTreeMap};

use super::landmark::Landmark;
use super::patch::{COARSE, FINE, Template};
use super::posture::LEVEL;
use super::smoothing::{COARSE_VARIANCE_PX2, FINE_VARIANCE_PX2};

/// Variance, in px², by which bilinear interpolation blurs on average.
const BETWEEN_PX2: f64 = 1.0 / 6.0;

/// Templates of one landmark, made when they are first needed: about 32 kB for each level of scale of the latest search.
#[derive(Default)]
pub struct Templates(BTreeMap<i32, AtLevel>);

#[derive(Default)]
struct AtLevel {
    coarse: OnceCell<Template<COARSE>>,
    fine: OnceCell<Template<FINE>>,
}

impl Templates {
    /// Number of levels of which templates are kept; for tests.
    #[cfg(test)]
    pub(super) fn n_levels(&self) -> usize {
        self.0.len()
    }

    /// Keeps the templates of some levels.
    pub(super) fn keep(&mut self, is_kept: impl Fn(i32) -> bool) {
        self.0.retain(|level, _| is_kept(*level));
    }

    /// The template of the coarse alignment at a scale of [`LEVEL`] to the power of a level.
    pub(super) fn coarse(&mut self, landmark: &Landmark, level: i32) -> &Template<COARSE> {
        let make = || Template::coarse(&landmark.patch, landmark.offset_px(), LEVEL.powi(level), COARSE_VARIANCE_PX2);
        self.0.entry(level).or_default().coarse.get_or_init(make)
    }

    /// The template of the fine alignment.
    pub(super) fn fine(&mut self, landmark: &Landmark, level: i32) -> &Template<FINE> {
        let variance_px2 = FINE_VARIANCE_PX2 + BETWEEN_PX2;
        let make = || Template::fine(&landmark.patch, landmark.offset_px(), LEVEL.powi(level), variance_px2);
        self.0.entry(level).or_default().fine.get_or_init(make)
    }
}
