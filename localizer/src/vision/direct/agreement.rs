//! Selects the tile joints that agree with each other as a grid: true joints are parallel or orthogonal, and parallel joints are whole pitches apart.
//! Lines of other origin (wires, printed stripes, shadows) rarely fit this.

use std::f64::consts::FRAC_PI_2;

use super::measure::Joint;
use crate::vision::FloorView;

/// Tile joints that form a grid, and the weight of the evidence for that grid: essentially the sum of the joints' lengths in pixels.
#[derive(Debug, Default)]
pub(super) struct Grid {
    joints: Vec<Joint>,
    evidence: f64,
}

/// Greatest angle between two true tile joints, beyond what errors of measurement add: each joint may be laid half a millimetre askew over one tile.
const LAID_ASKEW_RAD: f64 = 0.007;
/// Greatest error of the distance between two true parallel tile joints. The constant part, in pixels at the usual 1–1.5 px/mm, is for the laying of
/// both joints; the part relative to the distance is for the error of the image's scale.
const PITCH_ERROR_PX: f64 = 2.0;
const PITCH_ERROR_RATIO: f64 = 0.004;
/// Greatest ratio of contrast between joints of one floor: worn joints are fainter, but black wires are stronger by more than this ratio.
const DEPTH_RATIO: f64 = 2.5;
/// A rival is a line that does not fit the grid found, or the best grid at another angle. If the evidence (weighted length of lines) that a rival
/// brings is at least this share of the evidence that it would displace, what the two cannot share is dropped: it stays undecided which is right.
const RIVAL_SHARE: f64 = 0.4;

/// Selects, among the lines found at one angle, the tile joints that form a grid. Joints that a contradicting line leaves in doubt are dropped.
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
        // A worn tile joint is too faint to agree with the others in contrast, but lies where a joint of the grid should be. It is therefore no
        // reason to doubt the others.
        let members = (0..distinct.len()).filter(|index| winner >> index & 1 == 1);
        if members.into_iter().all(|member| fits(&distinct[member], &distinct[rival], winners.edge_px)) {
            continue;
        }
        let (others, other) = heaviest(1 << rival);
        // If two sets of joints contradict each other, the joints that belong to both do not help to decide between them.
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

/// The tile joints of the grid with the most evidence; none if another grid at another angle has nearly as much evidence.
pub(super) fn best(mut grids: Vec<Grid>) -> Vec<Joint> {
    grids.retain(|grid| !grid.joints.is_empty());
    grids.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let rival = grids.get(1).map_or(0.0, |grid| grid.evidence);
    let best = grids.into_iter().next().filter(|best| rival <= RIVAL_SHARE * best.evidence);
    best.map_or_else(Vec::new, |best| best.joints)
}

/// Distance from the line of tile joint `a` to the middle of joint `b`, along the normal of `a`; the two joints are parallel, of one family.
fn distance_px(a: &Joint, b: &Joint) -> f64 {
    let (sin, cos) = a.line.normal_rad.sin_cos();
    b.middle_px[0] * cos + b.middle_px[1] * sin - a.line.offset_px
}

/// Whether two lines can be tile joints of one floor with the given pitches, by their positions and by their contrast.
fn agree(a: &Joint, b: &Joint, edge_px: [f64; 2]) -> bool {
    // The tile joints of a floor have one colour, but wear takes away some of their contrast.
    let alike = a.line.dark == b.line.dark && (1.0 / DEPTH_RATIO..DEPTH_RATIO).contains(&(a.depth / b.depth));
    alike && fits(a, b, edge_px)
}

/// Whether the angle between two lines and the distance between them are those of two tile joints of one floor.
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
    // The distance between two nearly parallel joints is measured from either of them, and the mean is used: it halves the effect of the angle
    // between them.
    let apart_px = 0.5 * (distance_px(a, b).abs() + distance_px(b, a).abs());
    let pitches = (apart_px / edge_px).round();
    let sideways_px = (a.middle_px[0] - b.middle_px[0]).hypot(a.middle_px[1] - b.middle_px[1]);
    let error_px = PITCH_ERROR_PX + PITCH_ERROR_RATIO * apart_px + 0.5 * sideways_px * scatter_rad;
    pitches >= 1.0 && (apart_px - pitches * edge_px).abs() < error_px
}

/// Greatest number of tile joints that are examined together, because all their subsets are tried.
const MOST_JOINTS: usize = 12;
/// A tile joint counts as supported by an orthogonal joint if their likeness (square of the ratio of their contrasts) is above this: if the contrasts
/// are within a factor of 1.8.
const LIKENESS_MIN: f64 = 0.3;
/// Least share of its visible length over which a tile joint must be found if its contrast is like that of no orthogonal joint.
const COVER_MIN: f64 = 0.75;
/// Weight, in the evidence for a grid, of a tile joint without an orthogonal joint of similar contrast; with a partner of equal contrast it is 1.
const WITHOUT_PARTNER: f64 = 0.25;

/// Similarity of the contrast of two tile joints, at most 1: one floor has joints of one colour, and stripes and wires seldom match it.
fn likeness(a: &Joint, b: &Joint) -> f64 {
    // The likeness is the square of the ratio of contrasts: a joint with half the contrast of another has a likeness of a quarter.
    let ratio = a.depth.min(b.depth) / a.depth.max(b.depth);
    ratio * ratio
}

/// Whether a line may be kept as a tile joint of the given set: an orthogonal joint of the set has similar contrast, or the line is found over most
/// of its visible length.
///
/// A printed stripe ends with its tile and is fainter than a joint; a worn joint is fainter, too, but continues across the image.
fn is_supported(joints: &[Joint], set: usize, index: usize) -> bool {
    let joint = &joints[index];
    let partners = joints.iter().enumerate().filter(|(other, _)| set >> other & 1 == 1);
    let alike = partners
        .filter(|(_, other)| other.line.family != joint.line.family)
        .any(|(_, other)| likeness(joint, other) > LIKENESS_MIN);
    alike || joint.cover > COVER_MIN
}

/// All subsets of the tile joints, as bit masks, with the evidence for each of them.
struct Cliques {
    /// Pitches (distances between neighbouring joints) of the two families of parallel tile joints.
    edge_px: [f64; 2],
    /// Evidence of each subset of the tile joints (weighted sum of lengths), indexed by the subset's bit mask; negative if two joints of the subset
    /// cannot belong to one grid.
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

    /// The subset of tile joints with the most evidence among the subsets that contain all joints of the given bit mask.
    fn heaviest(&self, containing: usize) -> usize {
        let sets = (0..self.weights.len()).filter(|set| set & containing == containing);
        sets.max_by(|&a, &b| self.weights[a].total_cmp(&self.weights[b])).unwrap_or(0)
    }
}

/// Evidence of a set of tile joints for a grid: the sum of their lengths in pixels, each weighted by the joint's similarity of contrast to its most
/// similar orthogonal partner, and halved if the joint's width is not certain.
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
        // Two lines of each of the two families, 400 px apart, on tiles of 400 × 600 px: in one family joints have to be 600 px apart, so that not
        // all four lines can be joints.
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
        // Set-up: two tile joints a pitch apart, and an orthogonal joint whose contrast has faded to a quarter. The two are kept, the faint one is
        // not.
        let joints = vec![joint(0, 0.0, -150.0, 0.8), joint(0, 0.0, 250.0, 0.8), joint(1, FRAC_PI_2, -50.0, 0.19)];
        assert_eq!(kept(joints), [(0, -150.0), (0, 250.0)]);
    }

    #[test]
    fn a_black_wire_does_not_outweigh_a_joint_that_looks_like_its_partner() {
        let joints = vec![joint(0, 0.2, -150.0, 0.8), joint(0, 0.2, 100.0, 1.9), joint(1, 0.2 + FRAC_PI_2, 40.0, 0.8)];
        assert_eq!(kept(joints), [(0, -150.0), (1, 40.0)]);
    }
}
