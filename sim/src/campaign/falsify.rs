//! A search for failures of the program or the localizer: random scenes, each run in a process of its own and checked for every kind of failure.
//!
//! ```text
//! seed, case number ─> grammar ─> scene ─> child process (probe) ─> hits ─> shrink ─> found/*.toml
//!                                                                    └────> journal ─> summary
//! ```
//!
//! In the diagram, `grammar` draws random scenes, hits are failures that a run shows, and `shrink` reduces a failing scene to a small one. The
//! search's seed and the number of a case determine the scene of the case and the seed of its run, so that every scene can be drawn again from these
//! two numbers. Cases that are done are recorded in a journal: a search that was killed continues where it stopped.

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
pub use probe::{Outcome, Told, Witnesses, probe};
pub use search::{Progress, Search, search};
pub use shrink::shrink;
pub use summary::{Summary, upper_bound};
pub use wish::{Hit, Wish, hits, witness_outside};

use toml::Table;

/// Returns the scene of case `number` of a search, and the seed of its run. The scene may be invalid and be refused; then the next `attempt`, counted
/// from 0, draws another.
pub fn drawn(seed: u64, profile: Profile, number: u64, attempt: u64) -> (Table, u64) {
    grammar::scene(&dice::Draws::of(seed, number, attempt), profile)
}

/// Returns every key that scenes can have, as dotted paths without the indices of list items.
pub fn keys() -> Vec<String> {
    grammar::paths()
}
