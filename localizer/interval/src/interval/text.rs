//! Text and serde forms of intervals. What is printed reads back as the same interval, and an interval that is read contains the numbers
//! written.
//!
//! The forms that are read are `[1, 2]`, `[0.1]`, `[-inf, 2]`, `[, 2]`, `[1/3, 2/3]`, `[0x1.8p-1, 1]`, `[empty]`, `[]`, `[entire]`, `[,]`, in
//! upper or lower case and with spaces anywhere around the numbers (the interval literals of IEEE 1788-2015, without the uncertain form `2.5?`).

use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

use super::Interval;

/// Error for a text that is not an interval.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("read interval from {text:?}: expected [lower, upper], [number], [empty] or [entire] with lower ≤ upper")]
pub struct ParseIntervalError {
    text: String,
}

impl FromStr for Interval {
    type Err = ParseIntervalError;
    fn from_str(text: &str) -> Result<Interval, ParseIntervalError> {
        parse_interval(text).ok_or_else(|| ParseIntervalError { text: text.to_owned() })
    }
}

impl fmt::Display for Interval {
    /// Writes the shortest decimals that read back as the same bounds; with a precision, as in `{:.3}`, decimals rounded outward to that
    /// precision.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return formatter.write_str("[empty]");
        }
        let lower = |bound: f64| match formatter.precision() {
            Some(n_decimals) => rounded_down(bound, n_decimals),
            None => lower_text(bound),
        };
        write!(formatter, "[{}, {}]", lower(self.lo), negated_text(lower(-self.hi)))
    }
}

impl fmt::Debug for Interval {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// An interval is serialised as text, because numbers in JSON cannot be infinite.
#[cfg(feature = "serde")]
impl serde::Serialize for Interval {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Interval {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Interval, D::Error> {
        let text = <String as serde::Deserialize>::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

fn parse_interval(text: &str) -> Option<Interval> {
    let inside = text.trim().strip_prefix('[')?.strip_suffix(']')?.trim().to_ascii_lowercase();
    match inside.as_str() {
        "" | "empty" => return Some(Interval::EMPTY),
        "entire" => return Some(Interval::ENTIRE),
        _ => {}
    }
    let Some((lower, upper)) = inside.split_once(',') else {
        return enclose_number(&inside);
    };
    let lo = match lower.trim() {
        "" | "-inf" | "-infinity" => f64::NEG_INFINITY,
        number => enclose_number(number)?.lo,
    };
    let hi = match upper.trim() {
        "" | "inf" | "+inf" | "infinity" | "+infinity" => f64::INFINITY,
        number => enclose_number(number)?.hi,
    };
    let interval = Interval::new(lo, hi);
    // In the text of an interval, a lower bound above the upper one is a mistake of the writer and does not stand for an empty interval.
    (!interval.is_empty()).then_some(interval)
}

/// Tightest interval around the number that a decimal, hexadecimal or rational literal stands for.
fn enclose_number(literal: &str) -> Option<Interval> {
    let literal = literal.trim();
    if let Some((numerator, denominator)) = literal.split_once('/') {
        let quotient = enclose_number(numerator)? / enclose_number(denominator)?;
        return (!quotient.is_empty()).then_some(quotient);
    }
    let (is_negative, magnitude) = match literal.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, literal.strip_prefix('+').unwrap_or(literal)),
    };
    let enclosure = match magnitude.strip_prefix("0x") {
        Some(hexadecimal) => enclose_hexadecimal(hexadecimal)?,
        None => enclose_decimal(magnitude)?,
    };
    Some(if is_negative { -enclosure } else { enclosure })
}

/// Tightest interval around the number that a hexadecimal literal stands for: `1.8p-1` is 1.5 · 2⁻¹. At most 16 digits are read.
fn enclose_hexadecimal(literal: &str) -> Option<Interval> {
    let (significand, exponent) = literal.split_once('p').unwrap_or((literal, "0"));
    let (whole, fraction) = significand.split_once('.').unwrap_or((significand, ""));
    let digits = format!("{whole}{fraction}");
    let bits = u64::from_str_radix(&digits, 16).ok()?;
    let exponent = exponent.parse::<i32>().ok()?.checked_sub(4 * i32::try_from(fraction.len()).ok()?)?;
    // The power of two is applied as two factors, because a whole number times 2⁻¹⁰⁷⁴ may be exact while 2¹⁰⁷⁴ overflows.
    let (first, second) = (2f64.powi(exponent / 2), 2f64.powi(exponent - exponent / 2));
    let nearest = bits as f64 * first * second;
    Some(around(nearest, u128::from(bits).cmp(&((nearest / second / first) as u128))))
}

/// Tightest interval around a non-negative real number, given the double nearest to it and how the number compares with that double.
fn around(nearest: f64, real_to_nearest: Ordering) -> Interval {
    match real_to_nearest {
        Ordering::Less => Interval::from_bounds(nearest.next_down(), nearest),
        Ordering::Equal => Interval::from_bounds(nearest, nearest),
        Ordering::Greater => Interval::from_bounds(nearest, nearest.next_up()),
    }
}

/// Tightest interval around an unsigned decimal literal: the nearest double, and its neighbour on the side of the decimal.
fn enclose_decimal(literal: &str) -> Option<Interval> {
    if !literal.starts_with(|first: char| first.is_ascii_digit() || first == '.') {
        return None;
    }
    let nearest = literal.parse::<f64>().ok()?;
    if nearest.is_infinite() {
        return Some(around(nearest, Ordering::Less));
    }
    // 767 significant decimal digits are enough to write any double exactly.
    let exact = format!("{nearest:.766e}");
    Some(around(nearest, Decimal::parse(literal)?.cmp(&Decimal::parse(&exact)?)))
}

/// A decimal number 0.d₁d₂d₃… · 10^exponent with d₁ ≠ 0 and no zero at the end; the number zero has no digit.
#[derive(PartialEq, Eq)]
struct Decimal {
    digits: Vec<u8>,
    exponent: i64,
}

impl Decimal {
    fn parse(literal: &str) -> Option<Decimal> {
        let (significand, exponent) = literal.split_once('e').unwrap_or((literal, "0"));
        let (whole, fraction) = significand.split_once('.').unwrap_or((significand, ""));
        let digits: Vec<u8> = whole.bytes().chain(fraction.bytes()).collect();
        let leading = digits.iter().take_while(|digit| **digit == b'0').count();
        let trailing = digits[leading..].iter().rev().take_while(|digit| **digit == b'0').count();
        let exponent = exponent.parse::<i64>().ok()? + whole.len() as i64 - leading as i64;
        Some(Decimal { digits: digits[leading..digits.len() - trailing].to_vec(), exponent })
    }

    fn cmp(&self, other: &Decimal) -> Ordering {
        match (self.digits.is_empty(), other.digits.is_empty()) {
            (true, true) => Ordering::Equal,
            (true, false) => Ordering::Less,
            (false, true) => Ordering::Greater,
            (false, false) => self.exponent.cmp(&other.exponent).then_with(|| self.digits.cmp(&other.digits)),
        }
    }
}

/// Shortest decimal text that reads back as this lower bound.
fn lower_text(bound: f64) -> String {
    if bound.is_infinite() {
        return "-inf".to_owned();
    }
    let reads_back = |text: &String| enclose_number(text).is_some_and(|read| read.lo == bound);
    let shortest = format!("{bound:?}");
    if reads_back(&shortest) {
        return shortest;
    }
    // The shortest decimal may lie on the wrong side of the double. Decimals with more digits come closer to the double, and in the end are
    // exact.
    let is_ordinary = (1e-5..1e16).contains(&bound.abs());
    let leading = bound.abs().log10().floor();
    let written = |n_digits: usize| match is_ordinary {
        true => format!("{bound:.*}", (n_digits as f64 - leading).max(1.0) as usize),
        false => format!("{bound:.n_digits$e}"),
    };
    (16..40).map(written).find(reads_back).unwrap_or_else(|| format!("{bound:.766e}"))
}

/// Text of a bound with this many decimals, rounded so that the text is not above the bound.
fn rounded_down(bound: f64, n_decimals: usize) -> String {
    if bound.is_infinite() {
        return "-inf".to_owned();
    }
    let step = 10f64.powi(-i32::try_from(n_decimals).unwrap_or(i32::MAX));
    let is_below = |text: &String| enclose_number(text).is_some_and(|read| read.hi <= bound);
    // Rounded to the nearest decimal, the text may be above the bound. Written from one unit of the last decimal lower it cannot be, unless that
    // unit is too small to change the bound.
    let candidates = [bound, bound - step, bound - 2.0 * step].map(|value| format!("{value:.n_decimals$}"));
    candidates.into_iter().find(is_below).unwrap_or_else(|| lower_text(bound))
}

fn negated_text(text: String) -> String {
    match text.strip_prefix('-') {
        Some(magnitude) => magnitude.to_owned(),
        // Zero, with any number of decimals, is written without a sign.
        None if text.bytes().all(|byte| matches!(byte, b'0' | b'.')) => text,
        None => format!("-{text}"),
    }
}
