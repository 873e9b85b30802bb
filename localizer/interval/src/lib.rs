//! Interval arithmetic: computing with sets of numbers, so that the true result is surely among those computed.
//!
//! A measurement is never exact, and neither is arithmetic on a computer. This crate computes with all the numbers that a quantity may be, and
//! never loses one of them: not by an approximation, not by rounding.
//!
//! - An **interval** is the set of all real numbers from one bound to another. It stands for one number of which the bounds are known: a
//!   length measured as 2 m, give or take 1 cm, is in [1.99, 2.01]. An operation on intervals gives an interval that holds every
//!   result of the operation on their members. ([`Interval`])
//! - A **box** is an interval for each of several variables: a rectangle in the plane, a cuboid in space. ([`IntervalBox`])
//! - A **contractor** stands for a constraint on the variables, such as an equation or a measured distance, and makes boxes smaller. It removes
//!   only points that violate the constraint, so that every solution in the box stays in it. ([`Contractor`])
//! - A **separator** stands for a set of points and for its complement: it removes from a box the points that are surely not in the set, and
//!   from a copy of the box the points that surely are. Where one of the two is left empty, the whole box is outside or inside. ([`Separator`])
//! - A **paving** is a picture of a set by boxes: boxes that are surely inside, boxes that are surely outside, and
//!   small ones along the boundary, which are undecided. It is made by a separator and bisection. ([`Paving`])
//!
//! # Example
//!
//! Where is a tree that is 5 m away from two pegs, each distance known to 1 cm, when the pegs are 6 m apart?
//!
//! ```
//! use interval::contractor::{Contractor, ForwardBackward};
//! use interval::{Interval, IntervalBox, paving::Paving, separator::Separator};
//!
//! // Intervals: a distance known to 1 cm, and the area of a square with sides of that length.
//! let distance_m = Interval::centred(5.0, 0.01);
//! assert!(distance_m.sqr().contains(25.0) && distance_m.sqr().width() < 0.21);
//!
//! // A formula and the interval of its value: all places at that distance from a peg at (0, 0), and from a peg at (6, 0).
//! let from_first = ForwardBackward::new(|[x, y]| x.hypot(y), distance_m);
//! let from_second = ForwardBackward::new(|[x, y]| (x - 6.0).hypot(y), distance_m);
//!
//! // A box: anywhere up to 100 m north and east of the first peg. As a contractor, the formula makes the box smaller.
//! let mut place_m = IntervalBox::new([Interval::new(0.0, 100.0); 2]);
//! from_first.contract(&mut place_m);
//! assert!(place_m[0].hi() < 5.02 && place_m[1].hi() < 5.02);
//!
//! // As a separator, the formula tells inside from outside. This paves the intersection of both sets, by boxes of 1 cm along its boundary:
//! let places = Paving::new(&from_first.and(from_second), place_m, &[0, 1], 0.01);
//! let [x_m, y_m] = places.hull().components();
//! // Expected by hand: the tree is 3 m to the east and √(5² − 3²) = 4 m to the north.
//! assert!(x_m.contains(3.0) && x_m.width() < 0.1);
//! assert!(y_m.contains(4.0) && y_m.width() < 0.1);
//! ```
//!
//! # What to start with
//!
//! Start with [`Interval`], which is used like a number. Then read [`contractor`], and take [`ForwardBackward`](contractor::ForwardBackward)
//! for any constraint that you can write as a formula.
//!
//! | to | take |
//! |---|---|
//! | compute with bounds | [`Interval`]; an [`Overlap`] says how two intervals lie on the real line |
//! | read and print bounds | [`Interval`] by `parse`, `{}` and serde; other text is a [`ParseIntervalError`] |
//! | hold bounds of several variables | [`IntervalBox`] |
//! | bound a function more sharply by its derivatives | [`Dual`] |
//! | make boxes smaller by constraints | [`contractor`] |
//! | prove boxes inside or outside of a set | [`separator`] |
//! | cover solutions or a set by boxes | [`paving`] |
//! | bound linear functions over linear rows, whatever solver found the duals | [`linear_program`] |
//!
//! # What is promised
//!
//! Every result contains all possible results, whatever the operands: tiny, huge, unbounded or empty. Bounds of the basic operations are off by
//! at most one unit in the last place, those of elementary functions by at most two. Elementary functions come from the crate `pxfm`, whose error of
//! half a unit is measured and not proven; one unit more is allowed for. No rounding mode is switched, so that
//! intervals may be used in any thread and beside any other code. An empty interval or box is a value, not an error: it says that the
//! constraints contradict each other.
//!
//! Names and corner cases follow IEEE 1788-2015, the standard for interval arithmetic, in its set-based flavour.
//!
//! [`Contractor`]: contractor::Contractor
//! [`Separator`]: separator::Separator
//! [`Paving`]: paving::Paving

mod interval;
mod boxes;
mod dual;
pub mod contractor;
pub mod separator;
pub mod paving;
pub mod linear_program;

pub use boxes::IntervalBox;
pub use dual::Dual;
pub use interval::{Interval, Overlap, ParseIntervalError};

/// Compiles and runs the code examples of the README as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
