//! A key that varies and its values, in the form in which a user types them: `key=a,b,c` or `key=lo..hi/n`.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use toml::Value;

use crate::loading::{shown, value_of};

/// A key of the scene and the values that it takes in a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variable {
    /// Dotted path of the key, such as `floor.region.carpet.friction`.
    pub key: String,
    /// Values of the key, in the order in which they were stated.
    pub values: Vec<Value>,
}

impl Variable {
    /// Returns the values in the form in which a user types them.
    pub fn shown_values(&self) -> String {
        self.values.iter().map(shown).collect::<Vec<_>>().join(", ")
    }
}

impl FromStr for Variable {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected KEY=A,B,C or KEY=LOW..HIGH/N, such as floor.friction=0.1..0.8/8";
        let (key, values) = text.split_once('=').ok_or(EXPECTED)?;
        let (key, values) = (key.trim(), values.trim());
        if key.is_empty() || values.is_empty() {
            return Err(EXPECTED.to_owned());
        }
        Ok(Variable { key: key.to_owned(), values: values_of(values)? })
    }
}

/// Parses the values in a text, which lists them or gives a range in which they are evenly spaced.
pub(super) fn values_of(text: &str) -> Result<Vec<Value>, String> {
    if let Some((low, rest)) = text.split_once("..").filter(|_| !text.contains(['"', '\'', '['])) {
        return range(low, rest);
    }
    let parts = split(text);
    if parts.iter().any(|part| part.is_empty()) {
        return Err(format!("expected values between the commas of `{text}`"));
    }
    Ok(parts.into_iter().map(value_of).collect())
}

/// Parses `low..high/n`: n values from low to high, both included.
fn range(low: &str, rest: &str) -> Result<Vec<Value>, String> {
    let wrong = || format!("expected LOW..HIGH/N with N at least 2, such as 0.1..0.8/8, found `{low}..{rest}`");
    let (high, n) = rest.split_once('/').ok_or_else(wrong)?;
    let n: i64 = n.trim().parse().ok().filter(|n| (2..=10_000).contains(n)).ok_or_else(wrong)?;
    let last = n - 1;
    if let (Ok(low), Ok(high)) = (low.trim().parse::<i64>(), high.trim().parse::<i64>())
        && let Some(span) = high.checked_sub(low).filter(|span| span % last == 0)
    {
        return Ok((0..n).map(|step| Value::Integer(low + span / last * step)).collect());
    }
    let end = |text: &str| text.trim().parse::<f64>().ok().filter(|end| end.is_finite()).ok_or_else(wrong);
    let (low, high) = (end(low)?, end(high)?);
    let at = |step: i64| low + (high - low) * step as f64 / last as f64;
    Ok((0..n).map(|step| Value::Float(rounded(at(step)))).collect())
}

/// Rounds to twelve significant digits, so that the third value of 0.1..0.8/8 is 0.3 and not 0.30000000000000004.
fn rounded(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

/// Splits a text at the commas that stand outside quotes and brackets.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut quote) = (Vec::new(), 0, 0, None);
    for (at, character) in text.char_indices() {
        match (character, quote) {
            (_, Some(open)) if character == open => quote = None,
            (_, Some(_)) => {}
            ('"' | '\'', None) => quote = Some(character),
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth -= 1,
            (',', None) if depth == 0 => {
                parts.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}
