//! The ring of stamped pose unions: predict, hang, contract, account.

use crate::{PoseUnion, method::Assumption};

/// Whether the estimate stands on its declared assumptions alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No assumption is doubted.
    Sound,
    /// An empty intersection certified that an assumption failed; the union grows by reach until enough images agree.
    Recovering,
}

/// The answer at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The time it speaks of.
    pub time_s: f64,
    /// The pose is in one of these boxes.
    pub pose: PoseUnion,
    /// Whether an assumption is doubted.
    pub status: Status,
    /// The declared bounds it stands on.
    pub relies_on: Vec<Assumption>,
}
