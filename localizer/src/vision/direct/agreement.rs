//! Agreement of a grid: joints are parallel or orthogonal, and parallel ones are whole pitches apart. Accidents are not.

use std::f64::consts::FRAC_PI_2;

use super::measure::Joint;
use crate::vision::FloorView;

/// Joints that agree with each other, and the weight of their evidence.
#[derive(Debug, Default)]
pub(super) struct Grid {
    pub(super) joints: Vec<Joint>,
    evidence: f64,
    /// Nothing else in the picture looked like a joint.
    undisputed: bool,
}

/// Angle between true joints beyond their measured scatter: each may be laid half a millimetre askew over one tile.
const LAID_ASKEW_RAD: f64 = 0.007;
/// Error of the distance between two true joints: laying of both, in pixels at the usual 1–1.5 px/mm, and of the scale.
const PITCH_ERROR_PX: f64 = 2.0;
const PITCH_ERROR_RATIO: f64 = 0.004;
/// A rival with this share of the evidence leaves it open which of the two is a joint.
const RIVAL_SHARE: f64 = 0.6;
/// A line without any other to support it must cross at least this share of the picture's shorter side.
const LONE_SPAN: f64 = 0.6;

/// The joints of one hypothesis that agree, without those that a rival leaves in doubt.
pub(super) fn grid(mut joints: Vec<Joint>, view: &FloorView) -> Grid {
    joints.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    let mut distinct: Vec<Joint> = Vec::new();
    for joint in joints {
        let double = |known: &Joint| {
            known.line.family == joint.line.family && distance_px(known, &joint).abs() < view.joint_width_px
        };
        if distinct.len() < MOST_JOINTS && !distinct.iter().any(double) {
            distinct.push(joint);
        }
    }
    let [first, second] = view.edge_px;
    let cliques = [[first, second], [second, first]].map(|edge_px| Cliques::new(&distinct, edge_px));
    let best = |containing: u32| {
        let heaviest = |cliques: &Cliques| cliques.heaviest(containing);
        cliques.iter().map(heaviest).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    };
    let (mut kept, _) = best(0);
    let total = |members: u32| {
        (0..distinct.len()).filter(|index| members >> index & 1 == 1).map(|index| weight(&distinct[index])).sum::<f64>()
    };
    let winner = kept;
    for rival in (0..distinct.len()).filter(|index| winner >> index & 1 == 0) {
        let (others, _) = best(1 << rival);
        let (lost, gained) = (winner & !others, others & !winner);
        if total(gained) > RIVAL_SHARE * total(lost) {
            kept &= !lost;
        }
    }
    let undisputed = kept.count_ones() as usize == distinct.len();
    let evidence = total(kept);
    let joints =
        distinct.into_iter().enumerate().filter(|(index, _)| kept >> index & 1 == 1).map(|(_, joint)| joint).collect();
    Grid { joints, evidence, undisputed }
}

/// The grid with the most evidence; nothing if another at another angle comes close, or if it is a single doubtful line.
pub(super) fn best(mut grids: Vec<Grid>, shorter_side_px: f64) -> Vec<Joint> {
    grids.retain(|grid| !grid.joints.is_empty());
    grids.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let rival = grids.get(1).map_or(0.0, |grid| grid.evidence);
    let Some(best) = grids.into_iter().next() else { return Vec::new() };
    if rival > RIVAL_SHARE * best.evidence {
        return Vec::new();
    }
    if let [lone] = best.joints.as_slice() {
        let certain =
            best.undisputed && rival == 0.0 && lone.width_is_sure && lone.span_px > LONE_SPAN * shorter_side_px;
        if !certain {
            return Vec::new();
        }
    }
    best.joints
}

/// Evidence of a joint: how long and how strongly it is seen.
fn weight(joint: &Joint) -> f64 {
    joint.span_px * joint.depth
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

/// Sets of joints, as bits, that agree pairwise.
struct Cliques {
    /// Weight of each set, or `None` where two of its members disagree; indexed by the bits.
    weights: Vec<Option<f64>>,
}

impl Cliques {
    fn new(joints: &[Joint], edge_px: [f64; 2]) -> Self {
        let friends: Vec<u32> = joints
            .iter()
            .map(|a| {
                joints
                    .iter()
                    .enumerate()
                    .filter(|(_, b)| agree(a, b, edge_px))
                    .fold(0, |bits, (index, _)| bits | 1 << index)
            })
            .collect();
        let mut weights = vec![Some(0.0)];
        for set in 1_u32..1 << joints.len() {
            let newest = set.ilog2() as usize;
            let rest = set & !(1 << newest);
            let agreed = friends[newest] & rest == rest;
            weights.push(weights[rest as usize].filter(|_| agreed).map(|sum: f64| sum + weight(&joints[newest])));
        }
        Cliques { weights }
    }

    /// The heaviest set that contains these members.
    fn heaviest(&self, containing: u32) -> (u32, f64) {
        let sets = self.weights.iter().enumerate().filter(|(set, _)| *set as u32 & containing == containing);
        sets.filter_map(|(set, weight)| weight.map(|weight| (set as u32, weight)))
            .fold((0, -1.0), |best, set| if set.1 > best.1 { set } else { best })
    }
}
