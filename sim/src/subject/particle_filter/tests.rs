use super::resampling::{N_SAMPLES, low_variance, n_by_kld};

#[test]
fn low_variance_resampling_draws_each_sample_as_often_as_its_weight_says() {
    // Steps of 1 from 0.5 on: 0.5, 1.5, 2.5, 3.5 along the sums 1, 1, 4.
    assert_eq!(low_variance(&[1.0, 0.0, 3.0], 4.0, 4, 0.5), [0, 2, 2, 2]);
    assert_eq!(low_variance(&[1.0, 1.0], 2.0, 6, 0.1), [0, 0, 0, 1, 1, 1]);
}

#[test]
fn the_number_of_samples_is_that_of_kld_sampling() {
    // Eq. 8 of Fox (2003) for k = 101 bins, ε = 0.05 and z = 2.326: 1000·(1 − 1/450 + √(1/450)·2.326)³ = 1000·1.10743³ = 1358.2.
    assert_eq!(n_by_kld(101), 1359);
    assert_eq!((n_by_kld(1), n_by_kld(1_000_000)), (N_SAMPLES[0], N_SAMPLES[1]));
}
