//! Student's t distribution.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The value that Student's t with `degrees` of freedom, at least 1, stays below with probability `p`, 0.5 ≤ p < 1.
pub fn quantile(p: f64, degrees: f64) -> f64 {
    // Refused are only degrees of freedom that are not above 0.
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |student| student.inverse_cdf(p))
}
