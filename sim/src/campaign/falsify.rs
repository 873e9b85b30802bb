//! A search for scenes that break the promise: random scenes, each run in a process of its own, held against wishes.
//!
//! ```text
//! seed, case number ─> grammar ─> scene ─> child process (probe) ─> hits ─> shrink ─> found/*.toml
//!                                                                    └────> journal ─> summary
//! ```
//!
//! The number of a case alone determines its scene and the seed of its run, so that any hit is drawn again by its number. A case that
//! is done stands in the journal: a search that was killed goes on where it stopped.

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

/// The scene of case `number` of a search and the seed of its run, at its `attempt`, as text; the scene may be refused.
pub fn drawn(seed: u64, profile: Profile, number: u64, attempt: u64) -> (Table, u64) {
    grammar::scene(&dice::Draws::of(seed, number, attempt), profile)
}

/// Every key that scenes have, as dotted paths without indices.
pub fn keys() -> Vec<String> {
    grammar::paths()
}
