//! The part of a sweep that one machine runs.

use std::{fmt, str::FromStr};

/// Part number `number` of `of` parts of a sweep, counted from 1. It consists of every `of`-th case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// The whole sweep as its only part.
    pub const WHOLE: Shard = Shard { number: 1, of: 1 };

    /// Whether the case with this index, counted from 0, belongs to this part.
    pub fn holds(self, index: usize) -> bool {
        index % self.of == self.number - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((number, of)) if 1 <= number && number <= of => Ok(Shard { number, of }),
            _ => Err("expected I/N with I from 1 to N: 3/16 is the third of 16 parts".to_owned()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}
