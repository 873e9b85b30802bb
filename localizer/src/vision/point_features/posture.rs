//! The scales and turns at which keypoints are described, and those of them that a search covers.

use interval::Interval;

use super::search::Search;

/// Ratio of the scales of two successive levels. A descriptor tolerates about a fifth.
pub(super) const LEVEL: f64 = 1.2;
/// Step between the turns at which keypoints are described where the search knows the turn. A descriptor tolerates about a tenth of a radian.
pub(super) const TURN_RAD: f64 = 0.2;
/// Greatest width of the interval of turns within which the turns of a search are tried; where less is known, each keypoint is described along the
/// direction to the centroid of its surroundings, which is less certain.
const KNOWN_TURN_RAD: f64 = 0.8;
/// Error allowed for the direction of a descriptor beside the declared turn: slant and noise move the centroid.
const SLACK_RAD: f64 = 0.6;

/// How a descriptor is laid over an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Posture {
    /// Scale, as a power of [`LEVEL`].
    pub(super) level: i32,
    /// Turn against the image's own axes in steps of [`TURN_RAD`]; `None` for the direction to the centroid of the surroundings.
    pub(super) turn: Option<i32>,
}

/// Postures that a search covers. Scales beyond a factor of three are not searched: the patch has not the pixels for them.
pub(super) fn postures(search: &Search) -> Vec<Posture> {
    const MOST_LEVELS: f64 = 6.0;
    // An interval that is hardly wider than a step needs one posture.
    let steps = |[lo, hi]: [f64; 2]| {
        let [lo, hi] = if hi - lo <= 1.25 { [0.5 * (lo + hi); 2] } else { [lo, hi] };
        lo.round() as i32..=hi.round() as i32
    };
    let scale = search.scale.intersect(Interval::new(f64::MIN_POSITIVE, f64::INFINITY));
    if scale.is_empty() || search.turn_rad.is_empty() {
        return Vec::new();
    }
    let level = |scale: f64| (scale.ln() / LEVEL.ln()).clamp(-MOST_LEVELS, MOST_LEVELS);
    let levels = steps([level(scale.lo()), level(scale.hi())]);
    let turns: Vec<Option<i32>> = if search.turn_rad.width() <= KNOWN_TURN_RAD {
        steps([search.turn_rad.lo() / TURN_RAD, search.turn_rad.hi() / TURN_RAD]).map(Some).collect()
    } else {
        vec![None]
    };
    levels.flat_map(|level| turns.iter().map(move |&turn| Posture { level, turn })).collect()
}

/// The turn, among all that differ by full turns, that is within the search's or nearest to it; `None` if it is off by more than the slack.
pub(super) fn turn_within(turn_rad: f64, search: &Search) -> Option<f64> {
    let allowed = search.turn_rad;
    let turn_rad = turn_rad - ((turn_rad - allowed.mid()) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    allowed.inflate(SLACK_RAD).contains(turn_rad).then_some(turn_rad.clamp(allowed.lo(), allowed.hi()))
}
