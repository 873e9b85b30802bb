//! Fits the straight course of a tile joint through the positions measured along it, in spite of outliers.

use super::joint_filter::Fit;

/// One measured position of a tile joint: the fit of the joint's model to the profile at one position along the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    pub(super) along_px: f64,
    pub(super) blur_px: f64,
    pub(super) fit: Fit,
}

/// Straight line fitted to a tile joint, relative to the roughly known candidate line of the joint: `across = slope·along + intercept`, both in
/// pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) slope: f64,
    pub(super) intercept_px: f64,
}

/// Greatest slope of the line fitted to a tile joint against the joint's roughly known candidate line. The candidate line errs by at most ±4 px at
/// the ends of a long line; that is several times its standard deviation.
const SLOPE_REACH: f64 = 0.014;
const SLOPE_STEPS: i32 = 14;
/// Width of a bin in the vote on the intercept of a line through measured positions; positions that agree scatter by less.
const INTERCEPT_BIN_PX: f64 = 0.5;

impl Course {
    /// Finds the straight line that most of the measured positions agree on: a vote on slope and intercept, then two
    /// straight fits to the positions near the result.
    pub(super) fn through(sightings: &[Sighting]) -> Option<Course> {
        const BINS: usize = 64;
        let mut best = (0, Course { slope: 0.0, intercept_px: 0.0 });
        for step in -SLOPE_STEPS..=SLOPE_STEPS {
            let slope = SLOPE_REACH * f64::from(step) / f64::from(SLOPE_STEPS);
            let mut bins = [0u32; BINS];
            for sighting in sightings {
                let intercept_px = f64::from(sighting.fit.shift_px) - slope * sighting.along_px;
                let bin = (intercept_px / INTERCEPT_BIN_PX + 0.5 * BINS as f64).floor();
                if (0.0..BINS as f64).contains(&bin) {
                    bins[bin as usize] += 1;
                }
            }
            for bin in 1..BINS {
                let votes = bins[bin - 1] + bins[bin];
                if votes > best.0 {
                    best = (votes, Course { slope, intercept_px: (bin as f64 - 0.5 * BINS as f64) * INTERCEPT_BIN_PX });
                }
            }
        }
        let mut course = best.1;
        for reach_px in [0.9, 0.7] {
            course = course.refitted(sightings, |_| reach_px)?;
        }
        Some(course)
    }

    /// Fits a straight line by least squares to those measured positions whose distance from this line is less than `reach_px` gives for them.
    pub(super) fn refitted(&self, sightings: &[Sighting], reach_px: impl Fn(&Sighting) -> f64) -> Option<Course> {
        let (mut n, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for sighting in sightings.iter().filter(|sighting| self.distance_px(sighting).abs() < reach_px(sighting)) {
            let (along, across) = (sighting.along_px, f64::from(sighting.fit.shift_px));
            n += 1.0;
            x += along;
            y += across;
            xx += along * along;
            xy += along * across;
        }
        let spread = n * xx - x * x;
        if n < 4.0 || spread <= 0.0 {
            return None;
        }
        let slope = (n * xy - x * y) / spread;
        Some(Course { slope, intercept_px: (y - slope * x) / n })
    }

    /// Distance of the line fitted to a tile joint from the joint's roughly known candidate line, at a position along the candidate line.
    pub(super) fn across_px(&self, along_px: f64) -> f64 {
        self.slope * along_px + self.intercept_px
    }

    /// Signed distance of a measured position of a tile joint from the line fitted to the joint.
    pub(super) fn distance_px(&self, sighting: &Sighting) -> f64 {
        f64::from(sighting.fit.shift_px) - self.across_px(sighting.along_px)
    }
}
