//! Interval arithmetic.

mod interval;
mod dual;
mod boxes;
pub mod contractor;
pub mod separator;
pub mod paving;

pub use boxes::IntervalBox;
pub use dual::Dual;
pub use interval::{Interval, Overlap, ParseIntervalError};
