//! One binary for all integration tests; each module states what belongs in it.

/// Contractors and pavings on problems worked out by hand.
mod contractor_by_hand;
/// Attempts to make the rigid contractors lose the truth.
mod contractor_falsification;
/// Laws that every contractor keeps.
mod contractor_laws;
/// Interval arithmetic against the ITF1788 collection of cases from outside.
mod interval_itf1788;
/// Interval arithmetic against arithmetic with many more bits.
mod interval_precision;
/// Printing and reading intervals.
mod interval_text;
