//! A search for failures of the program or the localizer: random scenes, each run in a process of its own and checked for every kind of failure.
//!
//! ```text
//! seed, case number ─> grammar ─> scene ─> child process (probe) ─> hits ─> shrink ─> found/*.toml
//!                                                                    └────> journal ─> summary
//! ```
//!
//! The search's seed and the number of a case determine the scene of the case and the seed of its run, so that every scene can be drawn again
//! from these two numbers. Cases that are done are recorded in a journal: a search that was killed continues where it stopped.

mod child;
mod dice;
mod error;
mod finding;
mod grammar;
mod journal;
mod probe;
mod search;
mod shrink;
mod summary;
mod wish;

pub use child::Ending;
pub use error::FalsifyError;
pub use finding::Finding;
pub use grammar::Profile;
pub use journal::Done;
pub use probe::{Outcome, Told, probe};
pub use search::{Progress, Search, search};
pub use shrink::shrink;
pub use summary::{Summary, upper_bound};
pub use wish::{Hit, Wish, hits};

use toml::Table;

/// Returns the scene of case `number` of a search, as drawn at its `attempt`, and the seed of its run. The scene may be invalid, and is
/// refused in this case.
pub fn drawn(seed: u64, profile: Profile, number: u64, attempt: u64) -> (Table, u64) {
    grammar::scene(&dice::Draws::of(seed, number, attempt), profile)
}

/// Returns every key that scenes have, as dotted paths without indices.
pub fn keys() -> Vec<String> {
    grammar::paths()
}
