//! Groups the peaks of the Hough transform that belong to one line (paper 1, equation (14)).

use std::f64::consts::{FRAC_PI_2, PI};

use super::hough::Peak;

/// Tolerance σ_r of the distance by (14a), when Hough peaks are grouped to lines: where the skeleton of a joint is bent or has spurs, the peaks of
/// the one joint spread over about its width. Two joints are a whole tile apart.
const SIGMA_R_PX: f64 = 10.0;
/// Tolerance σ_ϑ of the angle by (14b), when Hough peaks are grouped: ten cells of the accumulator.
const SIGMA_ANGLE_RAD: f64 = 0.045;

/// One line per group of similar Hough peaks: their average, weighted by votes, strongest group first.
///
/// `(r, ϑ)` and `(−r, ϑ ± π)` are the same line. Before a peak is compared and averaged, it is written in the form that is nearer to the
/// first peak of its group. Without this, averaging peaks from both sides of the wrap would give a line that has no votes.
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

/// The same line written with an angle within a quarter turn of another line's angle.
fn written_near(peak: Peak, other: &Peak) -> Peak {
    let half_turns = ((other.angle_rad - peak.angle_rad) / PI).round();
    let sign = if half_turns.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
    Peak { r_px: sign * peak.r_px, angle_rad: peak.angle_rad + half_turns * PI, votes: peak.votes }
}

/// Average of a group of peaks, with its angle in `[−π/2, π/2)` and the votes of the group's strongest peak.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_on_both_sides_of_the_wrap_are_one_line() {
        // The two peaks are the line at a distance of 100 with an angle 0.01 below and 0.01 above ϑ = π/2. Beyond π/2 the angle and the distance are
        // written with the opposite sign.
        let peaks = [
            Peak { r_px: 100.0, angle_rad: FRAC_PI_2 - 0.01, votes: 300 },
            Peak { r_px: -100.0, angle_rad: -FRAC_PI_2 + 0.01, votes: 300 },
        ];
        let lines = clustered(&peaks);
        assert_eq!(lines.len(), 1);
        assert!((lines[0].r_px.abs() - 100.0).abs() < 1e-9);
        assert!((lines[0].angle_rad.abs() - FRAC_PI_2).abs() < 1e-9);
    }

    #[test]
    fn parallel_joints_a_tile_apart_stay_two() {
        let peaks = [100.0, 500.0].map(|r_px| Peak { r_px, angle_rad: 0.1, votes: 200 });
        assert_eq!(clustered(&peaks).len(), 2);
    }
}
