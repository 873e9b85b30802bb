//! Headings on which edges of an image, and several images, agree.

use crate::{Contractor, Interval, IntervalBox, Outcome, vision::forward::EdgeLine};

use super::{CLUTTER_RAD, FAR_RAD, FEWEST_FAR, FEWEST_HELD, FEWEST_LINES, WRONG_IMAGES, headings};

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

/// Headings on which enough sets agree.
pub(super) struct WallHeadings {
    /// Headings by set; a heading lies in as many as edges, or images, allow it.
    pub(super) sets: Vec<Vec<Interval>>,
    /// As many must; none says nothing.
    pub(super) needed: Option<usize>,
}

impl WallHeadings {
    /// All but [`wrong_held`] of the edges of several images agree.
    pub(super) fn of_edges(sets: Vec<Vec<Interval>>) -> Self {
        let needed = (sets.len() >= FEWEST_HELD).then(|| sets.len() - wrong_held(sets.len()));
        WallHeadings { sets, needed }
    }

    /// All but [`WRONG_IMAGES`] of several images allow it, each by all but [`wrong_lines`] of its edges.
    pub(super) fn of_images(sets: Vec<Vec<Interval>>) -> Self {
        let needed = (sets.len() > WRONG_IMAGES).then(|| sets.len() - WRONG_IMAGES);
        WallHeadings { sets, needed }
    }

    fn within(&self, heading: Interval) -> Vec<Interval> {
        // Walls say nothing of a heading that may be anything.
        let Some(needed) = self.needed.filter(|_| !heading.is_empty() && heading.width() <= 100.0) else {
            return vec![heading];
        };
        let agreed = headings::agreed(&self.sets, needed);
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
