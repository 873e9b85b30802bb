//! The false claims of a reading, by name.

use serde::Serialize;

/// The false claims of one reading, the worst of them by name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedClaims {
    /// Name of the method that made them.
    pub method: &'static str,
    /// Number of the reading in the run, which its debug frames have in their names.
    pub image: usize,
    /// Stamp of the reading.
    pub measured_s: f64,
    /// The worst false claims: those that are farthest off, as far as that is known.
    pub worst: Vec<NamedClaim>,
    /// Number of the reading's other false claims.
    pub more: usize,
}

/// A false claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedClaim {
    /// What was claimed to be seen.
    pub what: String,
    /// Column and row in the picture where it was claimed to be, or the middle of the places; left out for a reading that is no picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_px: Option<[f64; 2]>,
    /// For a landmark in space the greater of the distances, along u and along v, from the nearest place at which the true camera shows a point of
    /// its box; left out where it shows none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_px: Option<f64>,
}
