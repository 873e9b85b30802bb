//! A range of seeds in the form in which a user types it.

use std::{ops::Range, str::FromStr};

/// The seeds `A..B`: A is included, B is not, and there is at least one seed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(pub Range<u64>);

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends = text.split_once("..").and_then(|(first, end)| Some((first.parse().ok()?, end.parse().ok()?)));
        match ends {
            Some((first, end)) if first < end => Ok(Seeds(first..end)),
            _ => Err("expected A..B with whole numbers, A less than B: 0..20 are 0 to 19".to_owned()),
        }
    }
}
