//! Headings on which edges of an image, and several images, agree.

use crate::{Contractor, Interval, IntervalBox, Outcome, vision::forward::EdgeLine};

use super::{CLUTTER_RAD, FAR_RAD, FEWEST_FAR, FEWEST_HELD, FEWEST_LINES, headings};

/// The headings at which edges are claimed: near the prior's, or farther off where hardly any edge is near and many are not.
pub(super) fn about(
    heading: Interval,
    sighted: &[(EdgeLine, Option<Interval>)],
    directions_rad: &[Interval],
) -> Interval {
    let within = |beyond_rad: f64| Interval::centred(heading.mid(), heading.radius() + beyond_rad);
    let count = |about: Interval| {
        let azimuths = sighted.iter().filter_map(|(_, azimuth)| *azimuth);
        azimuths.filter(|azimuth| !headings::of_line(*azimuth, directions_rad, about).is_empty()).count()
    };
    let (near, far) = (within(CLUTTER_RAD), within(FAR_RAD));
    if count(near) < FEWEST_LINES && count(far) >= FEWEST_FAR { far } else { near }
}

/// At most this many of an image's edges run along none of the directions: on rendered rooms with people and boxes at odd angles,
/// 0 loses the heading in a fifth of the images with a fix.
pub fn wrong_lines(lines: usize) -> usize {
    lines / 3
}

/// At most this many of the level edges of [`super::IMAGES`] images together run along none of the directions.
pub fn wrong_held(lines: usize) -> usize {
    lines / 4 + 1
}

/// Headings that all but [`wrong_held`] of the edges of several images allow.
pub(super) struct WallHeadings {
    /// For every image and count, the headings at which as many of its edges agree: a heading lies in as many sets as edges allow it.
    pub(super) sets: Vec<Vec<Interval>>,
}

impl WallHeadings {
    fn within(&self, heading: Interval) -> Vec<Interval> {
        // Few edges say nothing; and neither do walls of a heading that may be anything.
        let n_lines = self.sets.len();
        if n_lines < FEWEST_HELD || heading.is_empty() || heading.width() > 100.0 {
            return vec![heading];
        }
        let agreed = headings::agreed(&self.sets, n_lines - wrong_held(n_lines));
        agreed.into_iter().map(|set| set.intersect(heading)).filter(|set| !set.is_empty()).collect()
    }
}

impl Contractor<3> for WallHeadings {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let hull = self.within(domain[2]).into_iter().fold(Interval::EMPTY, Interval::hull);
        if hull.is_empty() || domain.is_empty() {
            *domain = IntervalBox::EMPTY;
            return Outcome::Empty("walls agree on no heading");
        }
        domain[2] = hull;
        Outcome::Feasible
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let branch = |heading| IntervalBox::from([domain[0], domain[1], heading]);
        self.within(domain[2]).into_iter().map(branch).filter(|branch| !branch.is_empty()).collect()
    }
}
