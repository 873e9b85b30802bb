//! Figures of the headings that images of the forward camera gave: how many gave one on their own, how good these are, and how far headings
//! are off.

use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};

use localizer::{Claim, reading::Camera};

use crate::run::{ForwardBaselines, RunRecord};

use super::{claims::FalseClaims, methods::held_claims, share};

/// An image's own heading interval (one of four a quarter turn apart) counts as a fix when it is no wider than this, about 3°.
const FIX_WIDTH_RAD: f64 = 0.0524;

/// Figures of the headings that the forward camera's images gave; empty for a run without such an image.
pub(super) fn metrics(record: &RunRecord, judged: &[FalseClaims]) -> BTreeMap<String, f64> {
    let images: Vec<_> = record.images.iter().filter(|image| image.camera == Some(Camera::Forward)).collect();
    if images.is_empty() {
        return BTreeMap::new();
    }
    let fixes: Vec<_> = images
        .iter()
        .filter_map(|image| Some((image.alone?[2], image.truth.pose.heading_rad)))
        .filter(|(heading, _)| heading.width() <= FIX_WIDTH_RAD)
        .collect();
    let held = fixes.iter().filter(|(heading, truth_rad)| heading.contains(*truth_rad)).count();
    // Of four headings a quarter turn apart the fix is the one nearest to the prior. A prior that is off by a quarter turn puts the fix off by
    // as much, which is no fault of the image.
    let mut off_rad: Vec<f64> = fixes
        .iter()
        .map(|(heading, truth_rad)| {
            let turn = heading.mid() - truth_rad;
            (turn - (turn / FRAC_PI_2).round() * FRAC_PI_2).abs()
        })
        .collect();
    let heading_off = |(truth, estimate): (&crate::truth::Truth, &localizer::Estimate)| {
        let hull = estimate.pose.hull();
        (!hull.is_empty()).then(|| (hull[2].mid() - truth.pose.heading_rad).abs())
    };
    let mut all_off_rad: Vec<f64> = record.truths.iter().zip(&record.estimates).filter_map(heading_off).collect();
    let widths_rad: f64 = fixes.iter().map(|(heading, _)| heading.width()).sum();
    let is_level = |claim: &&Claim| matches!(claim, Claim::WallLine { .. });
    let lines: usize = images.iter().map(|image| image.claims.iter().filter(is_level).count()).sum();
    let spoilt = held_claims(record, judged).into_iter().flatten().map(|held| held.spoilt).max().unwrap_or(0);
    let wrong_shares = held_claims(record, judged).into_iter().flatten().filter(|held| held.all >= 10);
    let wrong_share_max = wrong_shares.map(|held| held.wrong as f64 / held.all as f64).fold(0.0, f64::max);
    let deg = |name: &str, value_rad: f64| (name.to_owned(), value_rad.to_degrees());
    let paper = &record.forward_baselines;
    let mut paper_off_rad = paper.errors_rad.clone();
    let mut matches: Vec<f64> = paper.matches.iter().map(|&count| count as f64).collect();
    let [matches_median, found_share, off_median_deg, off_p95_deg] = ForwardBaselines::FIGURES;
    let of_paper = [
        (matches_median.to_owned(), quantile(&mut matches, 0.5)),
        (found_share.to_owned(), share(paper.errors_rad.len(), paper.n_asked)),
        deg(off_median_deg, quantile(&mut paper_off_rad, 0.5)),
        deg(off_p95_deg, quantile(&mut paper_off_rad, 0.95)),
    ];
    let mut metrics = BTreeMap::from([
        ("wall_wrong_share_max".to_owned(), wrong_share_max),
        ("wall_spoilt_images_max".to_owned(), spoilt as f64),
        ("wall_images".to_owned(), images.len() as f64),
        ("wall_lines_per_image".to_owned(), lines as f64 / images.len() as f64),
        ("wall_fix_share".to_owned(), share(fixes.len(), images.len())),
        ("wall_fix_contained_share".to_owned(), share(held, fixes.len())),
        deg("wall_fix_width_mean_deg", if fixes.is_empty() { 0.0 } else { widths_rad / fixes.len() as f64 }),
        deg("wall_fix_error_p95_deg", quantile(&mut off_rad, 0.95)),
        deg("wall_fix_error_max_deg", quantile(&mut off_rad, 1.0)),
        deg("heading_error_p95_deg", quantile(&mut all_off_rad, 0.95)),
        deg("heading_error_max_deg", quantile(&mut all_off_rad, 1.0)),
    ]);
    metrics.extend(of_paper.into_iter().filter(|_| paper.n_asked > 0));
    metrics
}

/// The least of the values that a share `wanted` of all values does not exceed; 0 when there are no values.
fn quantile(values: &mut [f64], wanted: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (wanted * values.len() as f64).ceil() as usize;
    values.get(at.saturating_sub(1)).copied().unwrap_or(0.0)
}
