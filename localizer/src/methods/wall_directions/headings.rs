//! Sets of headings on the real line, and where enough of them agree.

use std::f64::consts::FRAC_PI_2;

use interval::Interval;

/// Headings in `within` at which a line seen at `azimuth` runs along one of the building's `directions`, up to quarter turns: θ = direction
/// + k·π/2 − azimuth.
pub(super) fn of_line(azimuth: Interval, directions: &[Interval], within: Interval) -> Vec<Interval> {
    let quarter = Interval::PI * 0.5;
    // An interval of headings that spans more turns than matter, as recovery gives, is returned whole: the headings that a line allows
    // recur in it every quarter turn.
    if !(within.width() < WIDEST_RAD && within.magnitude() < FARTHEST_RAD) {
        return if within.is_empty() { Vec::new() } else { vec![within] };
    }
    let sets = directions.iter().flat_map(|&direction| {
        let heading = direction - azimuth;
        let (first, last) =
            (((within.lo() - heading.hi()) / FRAC_PI_2).floor(), ((within.hi() - heading.lo()) / FRAC_PI_2).ceil());
        (first as i64..=last as i64).map(move |k| (heading + quarter * k as f64).intersect(within))
    });
    joined(sets.filter(|set| !set.is_empty()).collect())
}

/// Widest interval of headings that is searched quarter turn by quarter turn, a little more than fifteen turns: what a robot may have
/// turned since its heading was last known is less.
const WIDEST_RAD: f64 = 100.0;
/// Greatest heading up to which intervals are searched quarter turn by quarter turn: doubles of this size are 10⁻⁷ apart, less than the
/// accuracy of any line.
const FARTHEST_RAD: f64 = 1e9;

/// Headings at which at least `needed` of the sets agree; each set is a union of disjoint intervals.
pub(super) fn agreed(sets: &[Vec<Interval>], needed: usize) -> Vec<Interval> {
    if needed == 0 {
        return vec![Interval::ENTIRE];
    }
    // At the same place, ends of intervals sort after beginnings, because closed intervals that touch agree where they touch.
    let mut events: Vec<(f64, bool)> =
        sets.iter().flatten().flat_map(|set| [(set.lo(), false), (set.hi(), true)]).collect();
    events.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut depth, mut begun, mut found) = (0, 0.0, Vec::new());
    for (at, ends) in events {
        if ends {
            if depth == needed {
                found.push(Interval::new(begun, at));
            }
            depth -= 1;
        } else {
            depth += 1;
            if depth == needed {
                begun = at;
            }
        }
    }
    joined(found)
}

/// Union of intervals as sorted disjoint intervals.
pub(super) fn joined(mut sets: Vec<Interval>) -> Vec<Interval> {
    sets.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
    let mut disjoint: Vec<Interval> = Vec::new();
    for set in sets {
        match disjoint.last_mut() {
            Some(last) if set.lo() <= last.hi() => *last = last.hull(set),
            _ => disjoint.push(set),
        }
    }
    disjoint
}
