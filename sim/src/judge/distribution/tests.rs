use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_distr::{Distribution as _, StandardNormal};

use super::*;
use crate::{
    subject::{Answer, GaussianPose, WeightedPose},
    truth::randomness::stream,
};

/// Number of draws of a test. With the right covariance, the mean of their normalised errors has a standard deviation of √(6 / 100 000) = 0.0077.
const N_DRAWS: usize = 100_000;

fn pose([x_m, y_m, heading_rad]: [f64; 3]) -> Pose {
    Pose { x_m, y_m, heading_rad }
}

fn gaussian(mean: Pose, covariance: Matrix3<f64>) -> Stated {
    let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|column| covariance[(row, column)]));
    Stated::of(&Answer::Gaussian(GaussianPose { mean, covariance: rows })).unwrap()
}

/// A root L of the covariance L·Lᵀ from which the tests draw: 3 cm, 5 cm and 2 degrees or so, with correlations of either sign.
fn root() -> Matrix3<f64> {
    Matrix3::new(0.03, 0.0, 0.0, -0.02, 0.045, 0.0, 0.01, 0.02, 0.025)
}

/// Draws of one normal error each, judged against what a filter states that multiplies its covariance by `factor`.
fn drawn(factor: f64) -> Distribution {
    let mut rng = stream(7, "a filter's errors");
    let mean = pose([1.0, -2.0, 3.1]);
    let stated = gaussian(mean, root() * root().transpose() * factor);
    let mut draw = || {
        let error = root() * Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
        pose([0, 1, 2].map(|axis| mean.to_array()[axis] + error[axis]))
    };
    let truths: Vec<Pose> = (0..N_DRAWS).map(|_| draw()).collect();
    of_steps(&truths.into_iter().map(|truth| (&stated, truth)).collect::<Vec<_>>()).unwrap()
}

/// Whether a share of `N_DRAWS` independent draws, each with this probability, is within four of its standard deviations.
fn is_binomial(share: f64, probability: f64) -> bool {
    (share - probability).abs() <= 4.0 * (probability * (1.0 - probability) / N_DRAWS as f64).sqrt()
}

fn shares(calibration: &Calibration) -> [f64; 5] {
    let Calibration { within_50, within_90, within_95, within_99, within_99_7 } = *calibration;
    [within_50, within_90, within_95, within_99, within_99_7]
}

#[test]
fn the_normalised_error_is_3_for_the_right_covariance_6_for_half_of_it_and_1_5_for_twice() {
    for (factor, nees) in [(1.0, 3.0), (0.5, 6.0), (2.0, 1.5)] {
        let mean = drawn(factor).nees.mean;
        assert!((mean - nees).abs() < 4.0 * 0.0077 / factor, "{mean} for {factor} times the covariance");
    }
}

#[test]
fn a_filter_with_the_right_covariance_is_calibrated_and_one_with_half_of_it_is_not() {
    let right = drawn(1.0);
    for (share, probability) in shares(&right.calibration).into_iter().zip([0.5, 0.9, 0.95, 0.99, 0.997]) {
        assert!(is_binomial(share, probability), "{share} of {probability}");
    }
    assert!(is_binomial(right.nees.in_corridor_share, 0.95) && is_binomial(right.nees.above_corridor_share, 0.025));
    // χ² with 3 degrees of freedom stays below 7.815 / 2 with a probability of 72.85 %: erf(√x) − 2·√(x/π)·e^(−x) at x = 7.815 / 4 = 1.954.
    let within_95 = drawn(0.5).calibration.within_95;
    assert!(is_binomial(within_95, 0.7285), "{within_95}");
}

#[test]
fn normalised_errors_are_as_worked_out_by_hand() {
    let nees = |covariance: Matrix3<f64>, error: [f64; 3]| {
        let stated = gaussian(pose(error), covariance);
        of_steps(&[(&stated, pose([0.0; 3]))]).unwrap().nees.mean
    };
    let plain = Matrix3::from_diagonal(&Vector3::new(0.04, 0.01, 0.0001));
    assert!((nees(plain, [0.2, -0.1, 0.01]) - 3.0).abs() < 1e-9);
    // The inverse of [2 1; 1 2] is [2 −1; −1 2] / 3.
    let correlated = Matrix3::new(2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0);
    assert!((nees(correlated, [1.0, 1.0, 0.0]) - 2.0 / 3.0).abs() < 1e-9);
    assert!((nees(correlated, [1.0, -1.0, 0.5]) - 2.25).abs() < 1e-9);
}

#[test]
fn regions_have_the_sizes_worked_out_by_hand() {
    let stated = gaussian(pose([0.0; 3]), Matrix3::from_diagonal(&Vector3::new(0.01, 0.04, 0.0025)));
    let judged = of_steps(&[(&stated, pose([0.0; 3]))]).unwrap();
    let [narrow, wide] = [&judged.region_95, &judged.region_3_sigma];
    for (width, by_hand) in [
        (narrow.x_m.mean, 2.0 * 1.959964 * 0.1),
        (narrow.heading_rad.mean, 2.0 * 1.959964 * 0.05),
        (narrow.area_m2, 5.991465 * PI * 0.1 * 0.2),
        (wide.y_m.mean, 6.0 * 0.2),
        (wide.area_m2, 9.0 * PI * 0.1 * 0.2),
    ] {
        assert!((width - by_hand).abs() < 1e-6, "{width} instead of {by_hand}");
    }
}

#[test]
fn a_heading_is_off_by_the_turn_of_at_most_half_a_circle() {
    let covariance = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0004));
    for turns in [-3.0, 0.0, 2.0] {
        let stated = gaussian(pose([0.0, 0.0, PI - 0.01 + 2.0 * PI * turns]), covariance);
        let judged = of_steps(&[(&stated, pose([0.0, 0.0, -PI + 0.01]))]).unwrap();
        assert!((judged.nees.mean - 1.0).abs() < 1e-6, "{turns} turns: {}", judged.nees.mean);
    }
    // Half of the sample points just left of π and half just right of it, written as −π: their mean is π, not 0.
    let sample = |heading_rad: f64, x_m: f64| WeightedPose { pose: pose([x_m, x_m * x_m, heading_rad]), weight: 1.0 };
    let around = [sample(PI - 0.1, -1.0), sample(-PI + 0.1, 0.0), sample(PI - 0.1, 1.0), sample(-PI + 0.1, 2.0)];
    let stated = Stated::of(&Answer::Samples(around.to_vec())).unwrap();
    assert!((stated.error(pose([0.5, 1.5, -PI])) - Vector3::zeros()).norm() < 1e-9, "{:?}", stated.mean);
}

#[test]
fn a_covariance_that_cannot_be_one_is_counted_and_holds_no_truth() {
    let right = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0));
    let with = |row: usize, column: usize, value: f64| {
        let mut covariance = right;
        covariance[(row, column)] = value;
        covariance
    };
    // Of the last two, one has heading tied to x without any doubt, and one has correlations that no three quantities can have.
    let impossible = [
        Matrix3::zeros(),
        with(0, 0, f64::NAN),
        with(2, 2, f64::INFINITY),
        with(1, 1, -1.0),
        with(1, 1, 0.0),
        with(0, 1, 0.5),
        Matrix3::new(1.0, 0.0, 2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 4.0),
        Matrix3::new(1.0, 0.9, -0.9, 0.9, 1.0, 0.9, -0.9, 0.9, 1.0),
    ];
    for covariance in impossible {
        let [right, wrong] = [right, covariance].map(|covariance| gaussian(pose([0.0; 3]), covariance));
        let judged = of_steps(&[(&right, pose([0.0; 3])), (&wrong, pose([0.0; 3]))]).unwrap();
        assert_eq!((judged.checks, judged.unusable), (2, 1), "{covariance}");
        assert_eq!((judged.calibration.within_99_7, judged.within_3_sigma_share), (0.5, 0.5), "{covariance}");
        assert_eq!(judged.nees.mean, 0.0, "{covariance}");
    }
}

#[test]
fn a_sample_that_spans_no_region_is_counted_and_holds_no_truth() {
    let sample = |x_m: f64, weight: f64| WeightedPose { pose: pose([x_m, x_m.powi(2), x_m.powi(3)]), weight };
    let spread = |weight: f64| [-2.0, -1.0, 0.5, 1.0, 2.0].map(|x_m| sample(x_m, weight)).to_vec();
    assert!(Stated::of(&Answer::Samples(spread(1.0))).unwrap().spread.is_some());
    for samples in [
        Vec::new(),
        vec![sample(1.0, 1.0); 100],
        spread(0.0),
        spread(f64::NAN),
        spread(-1.0),
        vec![sample(f64::NAN, 1.0), sample(0.0, 1.0)],
    ] {
        let stated = Stated::of(&Answer::Samples(samples)).unwrap();
        let judged = of_steps(&[(&stated, pose([0.0; 3]))]).unwrap();
        assert_eq!((judged.checks, judged.unusable, judged.calibration.within_50), (1, 1, 0.0));
    }
}

#[test]
fn truths_drawn_from_a_filters_own_sample_are_held_as_often_as_it_states() {
    // Two clusters of unequal weight, far from a Gaussian, of 4000 poses.
    let mut rng = stream(8, "a sample");
    let mut near = |at: f64, weight: f64| {
        let off = root() * Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
        WeightedPose { pose: pose([at + off[0], off[1], off[2]]), weight }
    };
    let samples: Vec<WeightedPose> =
        (0..4000).map(|index| if index % 2 == 0 { near(0.0, 3.0) } else { near(1.0, 1.0) }).collect();
    let stated = Stated::of(&Answer::Samples(samples.clone())).unwrap();
    let mut rng = stream(8, "truths");
    let mut draw = || loop {
        let sample = samples[rng.random_range(0..samples.len())];
        if rng.random::<f64>() * 3.0 < sample.weight {
            return sample.pose;
        }
    };
    let truths: Vec<Pose> = (0..N_DRAWS).map(|_| draw()).collect();
    let judged = of_steps(&truths.into_iter().map(|truth| (&stated, truth)).collect::<Vec<_>>()).unwrap();
    for (share, probability) in shares(&judged.calibration).into_iter().zip([0.5, 0.9, 0.95, 0.99, 0.997]) {
        // One pose more or less has a weight of at most 3 in 8000.
        assert!(is_binomial(share, probability) || (share - probability).abs() < 5e-4, "{share} of {probability}");
    }
}

#[test]
fn the_corridor_is_that_of_tables_of_chi_squared() {
    // χ² with 3 degrees of freedom: 0.216 and 9.348; with 30, for ten runs: 16.791 and 46.979.
    for (n_runs, [low, high]) in [(1, [0.216, 9.348]), (10, [1.6791, 4.6979])] {
        let corridor = corridor(n_runs);
        assert!((corridor[0] - low).abs() < 5e-4 && (corridor[1] - high).abs() < 5e-4, "{corridor:?}");
    }
}

#[test]
fn a_heading_that_is_off_by_more_than_3_sigma_is_not_held_whatever_the_position() {
    let stated = gaussian(pose([0.0; 3]), Matrix3::from_diagonal(&Vector3::new(0.01, 0.04, 0.0025)));
    let held = |truth: [f64; 3]| of_steps(&[(&stated, pose(truth))]).unwrap().within_3_sigma_share;
    // 2.9 and 4 standard deviations along one axis at a time.
    for (axis, sigma) in [0.1, 0.2, 0.05].into_iter().enumerate() {
        let off = |sigmas: f64| [0, 1, 2].map(|one| if one == axis { sigmas * sigma } else { 0.0 });
        assert_eq!((held(off(2.9)), held(off(-4.0))), (1.0, 0.0), "axis {axis}");
    }
}

#[test]
fn regions_of_a_sample_have_the_sizes_worked_out_by_hand() {
    // 1000 poses at even areas of a disc with the radius 1 m, at angles that differ by the golden angle of 2.399963 rad. The headings are −0.5,
    // −0.499, … 0.499 rad in mixed order: from the 25th to the 975th there are 0.95 rad.
    let sample = |index: u32| {
        let (radius_m, angle_rad) = ((f64::from(index + 1) / 1000.0).sqrt(), 2.399963 * f64::from(index));
        let heading_rad = f64::from(index * 387 % 1000) / 1000.0 - 0.5;
        WeightedPose { pose: pose([radius_m * angle_rad.cos(), radius_m * angle_rad.sin(), heading_rad]), weight: 1.0 }
    };
    let stated = Stated::of(&Answer::Samples((0..1000).map(sample).collect())).unwrap();
    let region = of_steps(&[(&stated, pose([0.0; 3]))]).unwrap().region_95;
    assert!((region.heading_rad.mean - 0.95).abs() < 1e-9, "{}", region.heading_rad.mean);
    // 95 % of the poses are within 95 % of the disc's area.
    assert!((region.area_m2 - 0.95 * PI).abs() < 0.01 * PI, "{}", region.area_m2);
}
