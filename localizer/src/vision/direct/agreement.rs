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
        // A worn joint is too faint to count as one of them, but stands where a joint should: it speaks against none.
        let members = (0..distinct.len()).filter(|index| winner >> index & 1 == 1);
        if members.into_iter().all(|member| fits(&distinct[member], &distinct[rival], winners.edge_px)) {
            continue;
        }
        let (others, other) = heaviest(1 << rival);
        // What both have in common speaks for neither.
        let common = winner & other;
        let (lost, gained) =
            (winners.weights[winner] - winners.weights[common], others.weights[other] - others.weights[common]);
        if gained > RIVAL_SHARE * lost {
            kept &= common;
        }
    }
    kept = (0..distinct.len())
        .filter(|index| kept >> index & 1 == 1 && is_supported(&distinct, kept, *index))
        .fold(0, |bits, index| bits | 1 << index);
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

/// Whether two joints can be of one grid whose families have these pitches: in their places, and of one kind.
fn agree(a: &Joint, b: &Joint, edge_px: [f64; 2]) -> bool {
    // One floor has one colour of joints, but wear takes some of it.
    let alike = a.line.dark == b.line.dark && (1.0 / DEPTH_RATIO..DEPTH_RATIO).contains(&(a.depth / b.depth));
    alike && fits(a, b, edge_px)
}

/// Whether two joints stand to each other as those of one grid do.
fn fits(a: &Joint, b: &Joint, edge_px: [f64; 2]) -> bool {
    let quarter_turns = f64::from(b.line.family) - f64::from(a.line.family);
    let askew_rad = b.line.normal_rad - a.line.normal_rad - quarter_turns * FRAC_PI_2;
    let scatter_rad = 4.0 * a.direction_sd_rad.hypot(b.direction_sd_rad);
    if askew_rad.abs() > LAID_ASKEW_RAD + scatter_rad {
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
/// Likeness that needs no further support: contrasts within a factor of 1.8.
const LIKENESS_MIN: f64 = 0.3;
/// Share of its visible length that a line unlike its partners must show.
const COVER_MIN: f64 = 0.75;
/// What a line counts without an orthogonal one of its kind, relative to one with it.
const WITHOUT_PARTNER: f64 = 0.25;

/// How much alike two joints look, up to 1: one floor has one colour of joints, and stripes and wires seldom match it.
fn likeness(a: &Joint, b: &Joint) -> f64 {
    // The square of the ratio: half the contrast leaves a quarter.
    let ratio = a.depth.min(b.depth) / a.depth.max(b.depth);
    ratio * ratio
}

/// Whether a member of a set looks like an orthogonal partner, or is at least as long as the picture lets it be.
///
/// A printed stripe ends with its tile, and is fainter than a joint; a worn joint is fainter too, but goes on.
fn is_supported(joints: &[Joint], set: usize, index: usize) -> bool {
    let joint = &joints[index];
    let partners = joints.iter().enumerate().filter(|(other, _)| set >> other & 1 == 1);
    let alike = partners
        .filter(|(_, other)| other.line.family != joint.line.family)
        .any(|(_, other)| likeness(joint, other) > LIKENESS_MIN);
    alike || joint.cover > COVER_MIN
}

/// Sets of joints, as bits.
struct Cliques {
    /// Pitches of the two families.
    edge_px: [f64; 2],
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
        Cliques { edge_px, weights: weights.collect() }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::direct::vote::Candidate;

    fn joint(family: u8, normal_rad: f64, offset_px: f64, depth: f64) -> Joint {
        let (sin, cos) = normal_rad.sin_cos();
        Joint {
            line: Candidate { normal_rad, offset_px, family, dark: true, support: 0.0 },
            points_px: Vec::new(),
            depth,
            direction_sd_rad: 1e-4,
            middle_px: [offset_px * cos, offset_px * sin],
            span_px: 400.0,
            cover: 1.0,
            width_is_sure: true,
        }
    }

    fn kept(joints: Vec<Joint>) -> Vec<(u8, f64)> {
        let view = FloorView { pixels_per_m: 1333.0, edge_px: [400.0, 600.0], joint_width_px: 5.0, q_items: 0 };
        let mut kept: Vec<(u8, f64)> =
            grid(joints, &view).joints.iter().map(|joint| (joint.line.family, joint.line.offset_px)).collect();
        kept.sort_by(|a, b| a.1.total_cmp(&b.1));
        kept
    }

    #[test]
    fn lines_a_pitch_apart_and_across_agree() {
        let joints =
            vec![joint(0, 0.2, -150.0, 0.8), joint(0, 0.201, 250.5, 0.8), joint(1, 0.2 + FRAC_PI_2, 40.0, 0.7)];
        assert_eq!(kept(joints).len(), 3);
    }

    #[test]
    fn one_pitch_cannot_serve_both_families_when_they_differ() {
        // 400 px between the lines of either family, on tiles of 400 × 600 px: one pair of them is no pair of joints.
        let across = 0.2 + FRAC_PI_2;
        let joints = vec![
            joint(0, 0.2, -150.0, 0.8),
            joint(0, 0.2, 250.0, 0.8),
            joint(1, across, -100.0, 0.8),
            joint(1, across, 300.0, 0.8),
        ];
        assert!(kept(joints).len() < 4);
    }

    #[test]
    fn a_line_askew_or_off_the_pitch_leaves_its_family_in_doubt() {
        let across = joint(1, 0.2 + FRAC_PI_2, 40.0, 0.8);
        let askew = vec![joint(0, 0.2, -150.0, 0.8), joint(0, 0.24, 100.0, 0.8), across.clone()];
        assert_eq!(kept(askew), [(0, -150.0), (1, 40.0)]);
        let off_pitch = vec![joint(0, 0.2, -150.0, 0.8), joint(0, 0.2, 100.0, 0.8), across];
        assert_eq!(kept(off_pitch), [(1, 40.0)]);
    }

    #[test]
    fn a_worn_joint_in_its_place_does_not_speak_against_the_others() {
        // Two joints a pitch apart, and an orthogonal one whose contrast has faded to a quarter.
        let joints = vec![joint(0, 0.0, -150.0, 0.8), joint(0, 0.0, 250.0, 0.8), joint(1, FRAC_PI_2, -50.0, 0.19)];
        assert_eq!(kept(joints), [(0, -150.0), (0, 250.0)]);
    }

    #[test]
    fn a_black_wire_does_not_outweigh_a_joint_that_looks_like_its_partner() {
        let joints = vec![joint(0, 0.2, -150.0, 0.8), joint(0, 0.2, 100.0, 1.9), joint(1, 0.2 + FRAC_PI_2, 40.0, 0.8)];
        assert_eq!(kept(joints), [(0, -150.0), (1, 40.0)]);
    }
}
