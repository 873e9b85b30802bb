//! Interval analysis: intervals, boxes, contractors, separators and pavings. Names are those of the field, as Codac has them.

mod contractor;
mod interval;
pub(crate) mod raised;
mod separator;
mod vector;
mod watched;

pub(crate) use contractor::{Ctc, ctc_box, ctc_dist, ctc_inter, ctc_polar, ctc_q_inter, ctc_union, on_pose};
pub(crate) use interval::{Given, PyInterval, shown};
pub(crate) use separator::{Sep, sep_dist, sivia};
pub(crate) use vector::PyBox;
