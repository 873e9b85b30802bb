//! Headings on which edges of an image, and several images, agree.

use crate::{Contractor, Interval, IntervalBox, Outcome, vision::forward::EdgeLine};

use super::{CLUTTER_RAD, FAR_RAD, FEWEST_FAR, FEWEST_LINES, WRONG_IMAGES, headings};

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

/// Headings that all but q edges of an image allow.
pub(super) fn of_image(azimuths_rad: &[Interval], directions_rad: &[Interval], within: Interval) -> Vec<Interval> {
    let sets: Vec<Vec<Interval>> =
        azimuths_rad.iter().map(|&azimuth| headings::of_line(azimuth, directions_rad, within)).collect();
    headings::agreed(&sets, sets.len() - wrong_lines(sets.len()))
}

/// Headings that all but [`WRONG_IMAGES`] of the images allow.
pub(super) struct WallHeadings {
    /// Azimuths of each image's edges, from robot forward at the stamp.
    pub(super) images: Vec<Vec<Interval>>,
    pub(super) directions_rad: Vec<Interval>,
}

impl WallHeadings {
    fn within(&self, heading: Interval) -> Vec<Interval> {
        // Fewer images than may be wrong say nothing; and neither do walls of a heading that may be anything.
        if self.images.len() <= WRONG_IMAGES || heading.is_empty() || heading.width() > 100.0 {
            return vec![heading];
        }
        let sets: Vec<Vec<Interval>> =
            self.images.iter().map(|image| of_image(image, &self.directions_rad, heading)).collect();
        headings::agreed(&sets, sets.len() - WRONG_IMAGES)
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
