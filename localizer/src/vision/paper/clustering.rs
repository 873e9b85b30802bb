//! Clustering of Hough peaks that belong to one line (paper 1, equation (14)).

use std::f64::consts::{FRAC_PI_2, PI};

use super::hough::Peak;

/// σ_r of (14a): a bent or spurred skeleton spreads one line over about a joint's width; two joints are a tile apart.
const SIGMA_R_PX: f64 = 10.0;
/// σ_ϑ of (14b): ten cells of the accumulator.
const SIGMA_ANGLE_RAD: f64 = 0.045;

/// One line per group of similar peaks: their average, weighted by votes, strongest group first.
///
/// `(r, ϑ)` and `(−r, ϑ ± π)` are the same line: each peak is written the way that is nearer to its group's first before it is
/// compared and averaged. Averaged as they stand, the two sides of the wrap would give a line that nobody voted for.
pub(super) fn clustered(peaks: &[Peak]) -> Vec<Peak> {
    let mut groups: Vec<(Peak, Vec<Peak>)> = Vec::new();
    for &peak in peaks {
        let home = groups.iter_mut().find_map(|(first, members)| {
            let near = written_near(peak, first);
            let similar = (near.r_px - first.r_px).abs() <= SIGMA_R_PX
                && (near.angle_rad - first.angle_rad).abs() <= SIGMA_ANGLE_RAD;
            similar.then_some((members, near))
        });
        match home {
            Some((members, near)) => members.push(near),
            None => groups.push((peak, vec![peak])),
        }
    }
    groups.into_iter().map(|(_, members)| average(&members)).collect()
}

/// The same line with its angle within a quarter turn of another's.
fn written_near(peak: Peak, other: &Peak) -> Peak {
    let half_turns = ((other.angle_rad - peak.angle_rad) / PI).round();
    let sign = if half_turns.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
    Peak { r_px: sign * peak.r_px, angle_rad: peak.angle_rad + half_turns * PI, votes: peak.votes }
}

/// Average of a group, back in `ϑ ∈ [−π/2, π/2)`, with the votes of its strongest.
fn average(members: &[Peak]) -> Peak {
    let total: f64 = members.iter().map(|peak| f64::from(peak.votes)).sum();
    let mean =
        |value: fn(&Peak) -> f64| members.iter().map(|peak| value(peak) * f64::from(peak.votes)).sum::<f64>() / total;
    let peak = Peak {
        r_px: mean(|peak| peak.r_px),
        angle_rad: mean(|peak| peak.angle_rad),
        votes: members.iter().map(|peak| peak.votes).max().unwrap_or(0),
    };
    if peak.angle_rad >= FRAC_PI_2 || peak.angle_rad < -FRAC_PI_2 {
        let turn = if peak.angle_rad >= FRAC_PI_2 { -PI } else { PI };
        return Peak { r_px: -peak.r_px, angle_rad: peak.angle_rad + turn, ..peak };
    }
    peak
}
