//! Student's t distribution.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The value below which Student's t, with `degrees` of freedom of at least 1, stays with probability `p`, 0.5 ≤ p < 1.
pub fn quantile(p: f64, degrees: f64) -> f64 {
    // The library gives an error only for degrees of freedom that are not above 0, which does not occur here.
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |student| student.inverse_cdf(p))
}
