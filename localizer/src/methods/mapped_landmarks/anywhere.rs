//! Poses anywhere in a wide box from which a picture can have been taken, such as after the robot was put down somewhere with nothing but the map.
//!
//! The box is bisected. A part is left out where more sightings than may be wrong cannot be right: their image points are too far from where the
//! landmarks are seen from the part. What is left, once it is small enough for rows to be of use, is contracted by them.

use interval::Interval;

use crate::{PoseBox, graph::is_linear_over};

use super::{
    ray::{N_PARAMETERS, Optics, Parameters},
    relate::Sight,
};

/// Sides of a part, in metres and in radians, that is contracted by rows, and of one that is not bisected any more after that.
const SMALL: [f64; 3] = [0.5, 0.5, 0.15];
const SMALLEST: [f64; 3] = [0.2, 0.2, 0.06];
/// Greatest number of parts that are examined. Where more are needed, the whole box is left, so that a reading does not take for ever.
const MOST_PARTS: usize = 40_000;
/// The same for parts that are contracted, each by some programs.
const MOST_CONTRACTED: usize = 600;
/// Greatest number of boxes of poses that are told apart.
const MOST_FOUND: usize = 32;
/// Boxes that are no farther apart than this, in metres and radians, are taken together.
const APART: f64 = 0.02;

/// Whether poses in a box are known too vaguely for landmarks to be searched where they should be seen.
pub(super) fn is_vague(pose: &PoseBox) -> bool {
    !is_linear_over(pose) || (0..2).any(|axis| pose.width(axis) > WIDEST_M)
}

/// Widest box of positions, in metres, in which landmarks are searched where they should be seen.
const WIDEST_M: f64 = 1.5;

/// Boxes that hold all poses of a box that `may_be` does not exclude and `contract` leaves. Where too much is possible, that is the whole box.
pub(super) fn anywhere(
    domain: &PoseBox,
    may_be: impl Fn(&PoseBox) -> bool,
    contract: impl Fn(&mut PoseBox),
) -> Vec<PoseBox> {
    if (0..3).any(|axis| !domain[axis].is_bounded()) {
        return vec![*domain];
    }
    let (mut parts, mut found) = (vec![*domain], Vec::new());
    let (mut n_parts, mut n_contracted) = (0, 0);
    while let Some(mut part) = parts.pop() {
        n_parts += 1;
        if n_parts > MOST_PARTS || n_contracted > MOST_CONTRACTED {
            return vec![*domain];
        }
        if !may_be(&part) {
            continue;
        }
        let mut split = longest(&part, SMALL);
        if split.is_none() {
            n_contracted += 1;
            contract(&mut part);
            split = longest(&part, SMALLEST);
        }
        match split {
            _ if part.is_empty() => {}
            Some(axis) => {
                let (low, high) = part.bisect(axis);
                parts.extend([high, low]);
            }
            None => join(&mut found, part),
        }
    }
    if found.len() > MOST_FOUND { vec![*domain] } else { found }
}

/// Whether a landmark may be seen where a sighting has it, from some pose of a box: the equations of its image point, as mean value forms.
pub(super) fn may_be_seen(optics: &Optics, sight: &Sight, pose: &PoseBox) -> bool {
    let over_box = optics.parameters(pose, sight.point.value);
    let middle = over_box.map(|value| Interval::point(value.mid()));
    let deviations: Parameters = std::array::from_fn(|k| over_box[k] - middle[k]);
    let wide = optics.equations::<N_PARAMETERS>(&over_box, &sight.point.anchor, sight.at_px);
    let exact = optics.equations::<0>(&middle, &sight.point.anchor, sight.at_px);
    let depth = wide.1.around(exact.1.value, &deviations).value.intersect(Interval::new(0.0, f64::INFINITY));
    !depth.is_empty()
        && (0..2).all(|k| {
            let off = wide.0[k].around(exact.0[k].value, &deviations).value;
            !off.intersect(Interval::centred(0.0, sight.error_px[k]) * depth).is_empty()
        })
}

/// The longest side of a box, in multiples of given ones, if it is longer than that.
fn longest(part: &PoseBox, sides: [f64; 3]) -> Option<usize> {
    let times = |axis: usize| part.width(axis) / sides[axis];
    (0..3).filter(|&axis| times(axis) > 1.0).max_by(|&a, &b| times(a).total_cmp(&times(b)))
}

/// Adds a box to others, taking those together that touch.
fn join(found: &mut Vec<PoseBox>, mut one: PoseBox) {
    while let Some(at) =
        found.iter().position(|other| (0..3).all(|axis| !other[axis].inflate(APART).intersect(one[axis]).is_empty()))
    {
        one = one.hull(&found.swap_remove(at));
    }
    found.push(one);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_excluded_is_found_and_no_more() {
        // A diagonal strip: |x − y| ≤ 0.1 m, at a heading of 1 rad.
        let near = |part: &PoseBox| !(part[0] - part[1]).intersect(Interval::centred(0.0, 0.1)).is_empty();
        let heading = |part: &mut PoseBox| part[2] = part[2].intersect(Interval::point(1.0));
        let domain = PoseBox::from([Interval::new(0.0, 3.0), Interval::new(2.0, 5.0), Interval::new(-2.0, 2.0)]);
        let found = anywhere(&domain, near, heading);
        assert!(found.iter().any(|one| one[0].contains(2.5) && one[1].contains(2.5) && one[2].contains(1.0)));
        assert!(found.iter().all(|one| one[0].lo() > 1.5 && one[1].hi() < 3.5), "{found:?}");
        // Where nothing is excluded and nothing contracted, the whole box is left.
        assert_eq!(anywhere(&domain, |_| true, |_| {}), [domain]);
        assert!(anywhere(&domain, |_| false, |_| {}).is_empty());
    }

    #[test]
    fn boxes_that_touch_are_taken_together() {
        let at = |x: f64| PoseBox::from([Interval::new(x, x + 1.0), Interval::ZERO, Interval::ZERO]);
        let mut found = Vec::new();
        [0.0, 5.0, 2.005, 1.01].into_iter().for_each(|x| join(&mut found, at(x)));
        assert_eq!(found.len(), 2);
        assert!(found.iter().any(|one| one[0] == Interval::new(0.0, 3.005)), "{found:?}");
    }
}
