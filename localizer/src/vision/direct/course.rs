//! The straight course of a joint through its sightings, found against outliers.

use super::measure::Sighting;

/// `across = slope·along + intercept`, both in pixels, relative to the voted line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) slope: f64,
    pub(super) intercept_px: f64,
}

/// Greatest error of the voted direction: ±4 px at the ends of a long line, several times the vote's scatter.
const SLOPE_REACH: f64 = 0.014;
const SLOPE_STEPS: i32 = 14;
/// Width of a bin of the vote on intercepts: stations that agree scatter by less.
const INTERCEPT_BIN_PX: f64 = 0.5;

impl Course {
    /// The course most sightings agree on: a vote on slope and intercept, then two straight fits to what lies near.
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

    /// Least squares through the sightings that are nearer than their reach.
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

    /// Distance of the course from the voted line.
    pub(super) fn across_px(&self, along_px: f64) -> f64 {
        self.slope * along_px + self.intercept_px
    }

    /// Distance of a sighting from the course.
    pub(super) fn distance_px(&self, sighting: &Sighting) -> f64 {
        f64::from(sighting.fit.shift_px) - self.across_px(sighting.along_px)
    }
}
