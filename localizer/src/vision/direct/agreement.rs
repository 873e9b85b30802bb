//! Agreement of a grid: joints are parallel or orthogonal, and parallel ones are whole pitches apart. Accidents are not.

use std::f64::consts::FRAC_PI_2;

use super::measure::Joint;
use crate::vision::FloorView;

/// Joints that agree with each other, and the weight of their evidence.
#[derive(Debug, Default)]
pub(super) struct Grid {
    joints: Vec<Joint>,
    evidence: f64,
}

/// Angle between true joints beyond their measured scatter: each may be laid half a millimetre askew over one tile.
const LAID_ASKEW_RAD: f64 = 0.007;
/// Error of the distance between two true joints: laying of both, in pixels at the usual 1–1.5 px/mm, and of the scale.
const PITCH_ERROR_PX: f64 = 2.0;
const PITCH_ERROR_RATIO: f64 = 0.004;
/// Ratio of contrast between joints of one floor: worn ones are fainter, black wires are more than that stronger.
const DEPTH_RATIO: f64 = 2.5;
/// A rival with this share of the evidence leaves it open which of the two is a joint.
const RIVAL_SHARE: f64 = 0.4;

/// The joints of one angle that agree, without those that a rival leaves in doubt.
pub(super) fn grid(mut joints: Vec<Joint>, view: &FloorView) -> Grid {
    joints.sort_by(|a, b| b.span_px.total_cmp(&a.span_px));
    let mut distinct: Vec<Joint> = Vec::new();
    for joint in joints {
        let same = |known: &Joint| {
            known.line.family == joint.line.family && distance_px(known, &joint).abs() < view.joint_width_px
        };
        if distinct.len() < MOST_JOINTS && !distinct.iter().any(same) {
            distinct.push(joint);
        }
    }
    let [first, second] = view.edge_px;
    let cliques = [[first, second], [second, first]].map(|edge_px| Cliques::new(&distinct, edge_px));
    let heaviest = |containing: usize| {
        let [a, b] = cliques.each_ref().map(|cliques| (cliques, cliques.heaviest(containing)));
        if a.0.weights[a.1] >= b.0.weights[b.1] { a } else { b }
    };
    let (winners, winner) = heaviest(0);
    let mut kept = winner;
    for rival in (0..distinct.len()).filter(|index| winner >> index & 1 == 0) {
        let (others, other) = heaviest(1 << rival);
        // What both have in common speaks for neither.
        let common = winner & other;
        let (lost, gained) =
            (winners.weights[winner] - winners.weights[common], others.weights[other] - others.weights[common]);
        if gained > RIVAL_SHARE * lost {
            kept &= common;
        }
    }
    let evidence = winners.weights[kept];
    let joints =
        distinct.into_iter().enumerate().filter(|(index, _)| kept >> index & 1 == 1).map(|(_, joint)| joint).collect();
    Grid { joints, evidence }
}

/// The grid with the most evidence; nothing if another at another angle comes close.
pub(super) fn best(mut grids: Vec<Grid>) -> Vec<Joint> {
    grids.retain(|grid| !grid.joints.is_empty());
    grids.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let rival = grids.get(1).map_or(0.0, |grid| grid.evidence);
    let best = grids.into_iter().next().filter(|best| rival <= RIVAL_SHARE * best.evidence);
    best.map_or_else(Vec::new, |best| best.joints)
}

/// Distance from joint `a`'s line to the middle of joint `b`, along the normal of `a`; both in one family.
fn distance_px(a: &Joint, b: &Joint) -> f64 {
    let (sin, cos) = a.line.normal_rad.sin_cos();
    b.middle_px[0] * cos + b.middle_px[1] * sin - a.line.offset_px
}

/// Whether two joints can be of one grid whose families have these pitches.
fn agree(a: &Joint, b: &Joint, edge_px: [f64; 2]) -> bool {
    let quarter_turns = f64::from(b.line.family) - f64::from(a.line.family);
    let askew_rad = b.line.normal_rad - a.line.normal_rad - quarter_turns * FRAC_PI_2;
    let scatter_rad = 4.0 * a.direction_sd_rad.hypot(b.direction_sd_rad);
    // One floor has one colour of joints, but wear takes some of it.
    let alike = a.line.dark == b.line.dark && (1.0 / DEPTH_RATIO..DEPTH_RATIO).contains(&(a.depth / b.depth));
    if !alike || askew_rad.abs() > LAID_ASKEW_RAD + scatter_rad {
        return false;
    }
    if a.line.family != b.line.family {
        return true;
    }
    let edge_px = edge_px[usize::from(a.line.family)];
    // The mean of both ways of measuring halves the effect of their angle.
    let apart_px = 0.5 * (distance_px(a, b).abs() + distance_px(b, a).abs());
    let pitches = (apart_px / edge_px).round();
    let sideways_px = (a.middle_px[0] - b.middle_px[0]).hypot(a.middle_px[1] - b.middle_px[1]);
    let error_px = PITCH_ERROR_PX + PITCH_ERROR_RATIO * apart_px + 0.5 * sideways_px * scatter_rad;
    pitches >= 1.0 && (apart_px - pitches * edge_px).abs() < error_px
}

/// Joints looked at together: all their subsets are tried.
const MOST_JOINTS: usize = 12;
/// What a line counts without an orthogonal one of its kind, relative to one with it.
const WITHOUT_PARTNER: f64 = 0.25;

/// How much alike two joints look, up to 1: one floor has one colour of joints, and stripes and wires seldom match it.
fn likeness(a: &Joint, b: &Joint) -> f64 {
    // The square of the ratio: half the contrast leaves a quarter.
    let ratio = a.depth.min(b.depth) / a.depth.max(b.depth);
    ratio * ratio
}

/// Sets of joints, as bits.
struct Cliques {
    /// Evidence of each set, negative where two of its members disagree; indexed by the bits.
    weights: Vec<f64>,
}

impl Cliques {
    fn new(joints: &[Joint], edge_px: [f64; 2]) -> Self {
        let friends: Vec<usize> = joints
            .iter()
            .map(|a| {
                (0..joints.len())
                    .filter(|&index| agree(a, &joints[index], edge_px))
                    .fold(0, |bits, index| bits | 1 << index)
            })
            .collect();
        let mut agreed = vec![true];
        for set in 1_usize..1 << joints.len() {
            let newest = set.ilog2() as usize;
            let rest = set & !(1 << newest);
            agreed.push(agreed[rest] && friends[newest] & rest == rest);
        }
        let weights = agreed.iter().enumerate().map(|(set, &agreed)| if agreed { evidence(joints, set) } else { -1.0 });
        Cliques { weights: weights.collect() }
    }

    /// The heaviest set that contains these members.
    fn heaviest(&self, containing: usize) -> usize {
        let sets = (0..self.weights.len()).filter(|set| set & containing == containing);
        sets.max_by(|&a, &b| self.weights[a].total_cmp(&self.weights[b])).unwrap_or(0)
    }
}

/// Evidence of a set: the lengths of its members, each as far as it looks like its orthogonal partners.
fn evidence(joints: &[Joint], set: usize) -> f64 {
    let members = || joints.iter().enumerate().filter(|(index, _)| set >> index & 1 == 1).map(|(_, joint)| joint);
    members()
        .map(|joint| {
            let partners = members().filter(|other| other.line.family != joint.line.family);
            let best = partners.map(|other| likeness(joint, other)).fold(WITHOUT_PARTNER, f64::max);
            joint.span_px * best * if joint.width_is_sure { 1.0 } else { 0.5 }
        })
        .sum()
}
