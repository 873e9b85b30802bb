//! Headings on which the edges of an image, and of several images, agree.

use interval::contractor::{Contractor, Outcome};
use interval::{Interval, IntervalBox};

use crate::vision::forward::EdgeLine;

use super::{CLUTTER_RAD, FAR_RAD, FEWEST_FAR, FEWEST_HELD, FEWEST_LINES, Quotas, headings};

/// Range of headings in which edges are claimed: near the prior's headings, or a wider range where few edges agree with those nearby and
/// many edges agree with headings farther off.
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

/// Rule that keeps the headings which lie in enough of a number of sets.
#[derive(Clone, Debug)]
struct Rule {
    /// Headings that each edge, or each image, allows; a heading is counted once for every set that it lies in.
    sets: Vec<Vec<Interval>>,
    /// Number of sets that a heading must lie in.
    needed: usize,
}

/// Contractor for the headings that all rules allow; without a rule, walls rule nothing out.
#[derive(Clone, Debug)]
pub(super) struct WallHeadings {
    rules: Vec<Rule>,
}

impl WallHeadings {
    /// Makes a contractor by two rules: all but a declared number of the edges of several images agree, and all but a declared number of
    /// the images have no wrong edge. The declared number is a share of `n_edges`, the edges of all images that are counted together. Some of these
    /// images may no longer be held, and all wrong edges may be in those that are.
    pub(super) fn of_edges(images: Vec<Vec<Vec<Interval>>>, n_edges: usize, quotas: &Quotas) -> Self {
        let whole: Vec<Vec<Interval>> =
            images.iter().map(|by_count| by_count.last().cloned().unwrap_or_default()).collect();
        let sets: Vec<Vec<Interval>> = images.into_iter().flatten().collect();
        let mut rules = Vec::new();
        if sets.len() >= FEWEST_HELD {
            rules.push(Rule { needed: sets.len().saturating_sub(quotas.wrong_of_held(n_edges.max(sets.len()))), sets });
        }
        if whole.len() > quotas.spoilt_images {
            rules.push(Rule { needed: whole.len() - quotas.spoilt_images, sets: whole });
        }
        WallHeadings { rules }
    }

    /// Makes a contractor by one rule: all but a declared number of several images allow the heading, each by all but a declared share of
    /// its edges.
    pub(super) fn of_images(sets: Vec<Vec<Interval>>, quotas: &Quotas) -> Self {
        let says = sets.len() > quotas.images;
        let rule = || Rule { needed: sets.len() - quotas.images, sets };
        WallHeadings { rules: says.then(rule).into_iter().collect() }
    }

    /// Contractor that rules no heading out, whatever the walls look like.
    pub(super) fn silent() -> Self {
        WallHeadings { rules: Vec::new() }
    }

    /// Whether the walls in the images may rule out any heading at all.
    pub(super) fn says_something(&self) -> bool {
        !self.rules.is_empty()
    }

    fn within(&self, heading: Interval) -> Vec<Interval> {
        // Walls say nothing about a heading that may have any value.
        if heading.is_empty() || heading.width() > 100.0 {
            return vec![heading];
        }
        self.rules.iter().fold(vec![heading], |left, rule| {
            let agreed = headings::agreed(&rule.sets, rule.needed);
            let pairs = left.iter().flat_map(|set| agreed.iter().map(|other| set.intersect(*other)));
            pairs.filter(|set| !set.is_empty()).collect()
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: of 20 edges 6 agree on one heading and 14 on another. Of 20 edges a sixth and five may be wrong, 8, and of 60 edges 15: where the edges of
    /// images that were forgotten count, too, all wrong edges may be among those that are left.
    #[test]
    fn edges_of_forgotten_images_count_for_the_share_that_may_be_wrong() {
        let (few, many) = (Interval::new(0.1, 0.2), Interval::new(0.5, 0.6));
        let held: Vec<Vec<Vec<Interval>>> = [few, many, many]
            .into_iter()
            .zip([6, 7, 7])
            .map(|(heading, n_edges)| vec![vec![heading]; n_edges])
            .collect();
        let left = |n_edges: usize| {
            WallHeadings::of_edges(held.clone(), n_edges, &Quotas::default()).within(Interval::new(-1.0, 1.0))
        };
        assert_eq!(left(20), [many]);
        assert_eq!(left(60), [few, many]);
    }
}
