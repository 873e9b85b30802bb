//! Tests of the interval operations against the ITF1788 cases: expected results from an outside source, tight to the last bit.
//!
//! The case files lie beside the project and not in it (`../shared/data/itf1788` from the project's root, in their own format).

use std::collections::BTreeMap;
use std::path::PathBuf;

use interval::{Interval, Overlap};

/// Argument or expected result of a test case.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Interval(Interval),
    Number(f64),
    Word(String),
    Text(String),
}

struct Case {
    statement: String,
    operation: String,
    arguments: Vec<Value>,
    expected: Vec<Value>,
}

/// Largest allowed excess of a computed bound over the tight one, in units in the last place.
const BASIC: u64 = 1;
const ELEMENTARY: u64 = 2;
/// Largest allowed excess, in units in the last place, for reverse operations: reverses of periodic functions add a multiple of π to an
/// inverse function, and cos near −1 subtracts it from 2π.
const REVERSE: u64 = 3;

#[test]
fn every_applicable_case_is_contained_and_nearly_tight() {
    let Some(cases) = read_cases() else { return };
    let (mut n_run, mut skipped) = (0, BTreeMap::<String, usize>::new());
    let mut failures = Vec::new();
    let mut worst = BTreeMap::<String, u64>::new();
    for case in &cases {
        let Some((actual, allowed)) = evaluate(&case.operation, &case.arguments) else {
            *skipped.entry(case.operation.clone()).or_default() += 1;
            continue;
        };
        n_run += 1;
        match excess(&actual, &case.expected) {
            Some(ulps) if ulps <= allowed => {
                let entry = worst.entry(case.operation.clone()).or_default();
                *entry = ulps.max(*entry);
            }
            Some(ulps) => failures.push(format!("{}: got {actual:?}, {ulps} ulps too wide", case.statement)),
            None => failures.push(format!("{}: got {actual:?}", case.statement)),
        }
    }
    println!("ITF1788: {n_run} cases run, {} skipped", cases.len() - n_run);
    println!("skipped, operation and number of cases: {skipped:?}");
    println!("largest excess in units in the last place: {worst:?}");
    assert!(n_run > 3600, "only {n_run} cases were recognised");
    assert!(failures.is_empty(), "{} of {n_run} fail:\n{}", failures.len(), failures.join("\n"));
}

/// Result of the library's operation and the excess over the tight result that it is allowed; `None` when the library does not offer the
/// operation.
fn evaluate(operation: &str, arguments: &[Value]) -> Option<(Vec<Value>, u64)> {
    use Value::{Interval as I, Number as N, Text, Word};
    let interval = |value: Interval, allowed| Some((vec![I(value)], allowed));
    let truth = |value: bool| Some((vec![Word(value.to_string())], 0));
    let number = |value: f64, allowed| Some((vec![N(value)], allowed));
    let integer = |value: f64| (value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX)).then_some(value as i32);
    match (operation, arguments) {
        ("pos", [I(x)]) => interval(*x, 0),
        ("neg", [I(x)]) => interval(-*x, 0),
        ("abs", [I(x)]) => interval(x.abs(), 0),
        ("sqr", [I(x)]) => interval(x.sqr(), BASIC),
        ("sqrt", [I(x)]) => interval(x.sqrt(), BASIC),
        ("recip", [I(x)]) => interval(x.recip(), BASIC),
        ("exp", [I(x)]) => interval(x.exp(), ELEMENTARY),
        ("log", [I(x)]) => interval(x.log(), ELEMENTARY),
        ("sin", [I(x)]) => interval(x.sin(), ELEMENTARY),
        ("cos", [I(x)]) => interval(x.cos(), ELEMENTARY),
        ("tan", [I(x)]) => interval(x.tan(), ELEMENTARY),
        ("asin", [I(x)]) => interval(x.asin(), ELEMENTARY),
        ("acos", [I(x)]) => interval(x.acos(), ELEMENTARY),
        ("atan", [I(x)]) => interval(x.atan(), ELEMENTARY),
        ("atan2", [I(y), I(x)]) => interval(y.atan2(*x), ELEMENTARY),
        ("pown", [I(x), N(n)]) => interval(x.pown(integer(*n)?), ELEMENTARY),
        ("add", [I(x), I(y)]) => interval(*x + *y, BASIC),
        ("sub", [I(x), I(y)]) => interval(*x - *y, BASIC),
        ("mul", [I(x), I(y)]) => interval(*x * *y, BASIC),
        ("div", [I(x), I(y)]) => interval(*x / *y, BASIC),
        ("min", [I(x), I(y)]) => interval(x.min(*y), 0),
        ("max", [I(x), I(y)]) => interval(x.max(*y), 0),
        ("intersection", [I(x), I(y)]) => interval(x.intersect(*y), 0),
        ("convexHull", [I(x), I(y)]) => interval(x.hull(*y), 0),
        ("cancelPlus", [I(x), I(y)]) => interval(x.cancel_plus(*y), BASIC),
        ("cancelMinus", [I(x), I(y)]) => interval(x.cancel_minus(*y), BASIC),
        ("mulRevToPair", [I(b), I(c)]) => {
            let (first, second) = c.div2(*b);
            Some((vec![I(first), I(second)], BASIC))
        }
        ("mulRev", [I(b), I(c)]) => interval(c.mul_rev(*b, Interval::ENTIRE), BASIC),
        ("mulRev" | "mulRevTen", [I(b), I(c), I(x)]) => interval(c.mul_rev(*b, *x), BASIC),
        ("sqrRev", [I(c)]) => interval(c.sqr_rev(Interval::ENTIRE), BASIC),
        ("sqrRevBin", [I(c), I(x)]) => interval(c.sqr_rev(*x), BASIC),
        ("absRev", [I(c)]) => interval(c.abs_rev(Interval::ENTIRE), 0),
        ("absRevBin", [I(c), I(x)]) => interval(c.abs_rev(*x), 0),
        ("pownRev", [I(c), N(n)]) => interval(c.pown_rev(Interval::ENTIRE, integer(*n)?), REVERSE),
        ("pownRevBin", [I(c), I(x), N(n)]) => interval(c.pown_rev(*x, integer(*n)?), REVERSE),
        ("sinRev", [I(c)]) => interval(c.sin_rev(Interval::ENTIRE), REVERSE),
        ("sinRevBin", [I(c), I(x)]) => interval(c.sin_rev(*x), REVERSE),
        ("cosRev", [I(c)]) => interval(c.cos_rev(Interval::ENTIRE), REVERSE),
        ("cosRevBin", [I(c), I(x)]) => interval(c.cos_rev(*x), REVERSE),
        ("tanRev", [I(c)]) => interval(c.tan_rev(Interval::ENTIRE), REVERSE),
        ("tanRevBin", [I(c), I(x)]) => interval(c.tan_rev(*x), REVERSE),
        ("inf", [I(x)]) => number(if x.is_empty() { f64::INFINITY } else { x.lo() }, 0),
        ("sup", [I(x)]) => number(if x.is_empty() { f64::NEG_INFINITY } else { x.hi() }, 0),
        ("mid", [I(x)]) => number(x.mid(), 0),
        ("rad", [I(x)]) => number(x.radius(), BASIC),
        ("midRad", [I(x)]) => Some((vec![N(x.mid()), N(x.radius())], BASIC)),
        ("wid", [I(x)]) => number(x.width(), BASIC),
        ("mag", [I(x)]) => number(x.magnitude(), 0),
        ("mig", [I(x)]) => number(x.mignitude(), 0),
        ("isEmpty", [I(x)]) => truth(x.is_empty()),
        ("isEntire", [I(x)]) => truth(x.is_entire()),
        ("isSingleton", [I(x)]) => truth(x.is_singleton()),
        ("isCommonInterval", [I(x)]) => truth(x.is_bounded()),
        ("isMember", [N(m), I(x)]) => truth(x.contains(*m)),
        ("equal", [I(x), I(y)]) => truth(x == y),
        ("subset", [I(x), I(y)]) => truth(x.is_subset_of(*y)),
        ("interior", [I(x), I(y)]) => truth(x.is_interior_of(*y)),
        ("disjoint", [I(x), I(y)]) => truth(x.is_disjoint_from(*y)),
        ("less", [I(x), I(y)]) => truth(x.is_less(*y)),
        ("strictLess", [I(x), I(y)]) => truth(x.is_strictly_less(*y)),
        ("precedes", [I(x), I(y)]) => truth(x.precedes(*y)),
        ("strictPrecedes", [I(x), I(y)]) => truth(x.strictly_precedes(*y)),
        ("overlap", [I(x), I(y)]) => Some((vec![Word(overlap_name(x.overlap(*y)))], 0)),
        ("b-numsToInterval", [N(lo), N(hi)]) => interval(Interval::new(*lo, *hi), 0),
        ("b-textToInterval", [Text(text)]) if !text.contains('?') => {
            interval(text.parse().unwrap_or(Interval::EMPTY), if text.contains('/') { BASIC } else { 0 })
        }
        _ => None,
    }
}

/// Name of an overlap state as the case files write it, with a small first letter: `FirstEmpty` is `firstEmpty` there.
fn overlap_name(state: Overlap) -> String {
    let name = format!("{state:?}");
    name[..1].to_ascii_lowercase() + &name[1..]
}

/// Number of units in the last place by which a result is wider than the expected one; `None` when the result is wrong.
fn excess(actual: &[Value], expected: &[Value]) -> Option<u64> {
    if actual.len() != expected.len() {
        return None;
    }
    let mut largest = 0;
    for pair in actual.iter().zip(expected) {
        let ulps = match pair {
            (Value::Interval(actual), Value::Interval(expected)) if expected.is_empty() => {
                // Where the expected result is the empty interval, only the empty interval is right; how much too wide another result is cannot be
                // counted in units in the last place.
                actual.is_empty().then_some(0)?
            }
            (Value::Interval(actual), Value::Interval(expected)) if expected.is_subset_of(*actual) => {
                ulps_between(actual.lo(), expected.lo()).max(ulps_between(expected.hi(), actual.hi()))
            }
            (Value::Number(actual), Value::Number(expected)) if actual.is_nan() && expected.is_nan() => 0,
            (Value::Number(actual), Value::Number(expected)) if actual >= expected => ulps_between(*expected, *actual),
            (Value::Word(actual), Value::Word(expected)) if actual == expected => 0,
            _ => return None,
        };
        largest = ulps.max(largest);
    }
    Some(largest)
}

/// Number of steps from one double to the next between `low` and `high`.
fn ulps_between(low: f64, high: f64) -> u64 {
    let rank = |x: f64| {
        let bits = x.abs().to_bits() as i64;
        if x < 0.0 { -bits } else { bits }
    };
    (rank(high) - rank(low)).unsigned_abs()
}

fn read_cases() -> Option<Vec<Case>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/itf1788");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("ITF1788: no data in {}: nothing was checked", folder.display());
        return None;
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "itl"));
    paths.sort();
    Some(paths.iter().flat_map(|path| parse_cases(&std::fs::read_to_string(path).unwrap())).collect())
}

/// Parses a file of test cases of interval arithmetic, in which statements are `operation argument… = result…;` inside `testcase name { … }`.
fn parse_cases(text: &str) -> Vec<Case> {
    let mut code = String::new();
    let mut rest = text;
    while let Some((before, comment)) = rest.split_once("/*") {
        code.push_str(before);
        rest = comment.split_once("*/").map_or("", |(_, after)| after);
    }
    code.push_str(rest);
    let code: String = code.lines().map(|line| line.split("//").next().unwrap_or("").to_owned() + "\n").collect();
    code.split([';', '{', '}']).filter_map(parse_statement).collect()
}

fn parse_statement(statement: &str) -> Option<Case> {
    let (left, right) = statement.split_once(" = ")?;
    let (operation, arguments) = left.trim().split_once(char::is_whitespace)?;
    // In a case file, the word `signal` after the expected result announces a warning, which is not compared.
    let expected = parse_values(right.split("signal").next()?)?;
    Some(Case {
        statement: statement.split_whitespace().collect::<Vec<_>>().join(" "),
        operation: operation.to_owned(),
        arguments: parse_values(arguments)?,
        expected,
    })
}

/// Parses the arguments or results of a test case; `None` for values that exist only in decorated interval arithmetic and have no counterpart as
/// plain intervals.
fn parse_values(text: &str) -> Option<Vec<Value>> {
    let mut values = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        if let Some(inside) = rest.strip_prefix('"') {
            let (string, after) = inside.split_once('"')?;
            values.push(Value::Text(string.to_owned()));
            rest = after;
        } else if let Some(inside) = rest.strip_prefix('[') {
            let (bounds, after) = inside.split_once(']')?;
            values.push(Value::Interval(parse_interval(bounds)?));
            // In a case file, the decoration of an interval, as in `[1, 2]_com`, says how the interval was computed and does not change it.
            rest = after.trim_start_matches(|c: char| c == '_' || c.is_ascii_alphabetic());
        } else {
            let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            values.push(parse_number(word).map_or_else(|| Value::Word(word.to_owned()), Value::Number));
            rest = after;
        }
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
    }
    Some(values)
}

fn parse_interval(bounds: &str) -> Option<Interval> {
    match bounds.trim() {
        "empty" => Some(Interval::EMPTY),
        "entire" => Some(Interval::ENTIRE),
        "nai" => None,
        bounds => {
            let (lo, hi) = bounds.split_once(',')?;
            Some(Interval::new(parse_number(lo.trim())?, parse_number(hi.trim())?))
        }
    }
}

/// Parses a decimal or hexadecimal floating-point number, independently of the library's own reader.
fn parse_number(word: &str) -> Option<f64> {
    let lower = word.to_ascii_lowercase();
    let (sign, magnitude) = match lower.strip_prefix('-') {
        Some(magnitude) => (-1.0, magnitude),
        None => (1.0, lower.strip_prefix('+').unwrap_or(&lower)),
    };
    let Some(hexadecimal) = magnitude.strip_prefix("0x") else {
        return magnitude.parse::<f64>().ok().map(|value| sign * value);
    };
    let (significand, exponent) = hexadecimal.split_once('p').unwrap_or((hexadecimal, "0"));
    let mut value = 0.0;
    let mut place = 1.0;
    let (whole, fraction) = significand.split_once('.').unwrap_or((significand, ""));
    for digit in whole.chars() {
        value = 16.0 * value + f64::from(digit.to_digit(16)?);
    }
    for digit in fraction.chars() {
        place /= 16.0;
        value += place * f64::from(digit.to_digit(16)?);
    }
    let exponent: i32 = exponent.parse().ok()?;
    // The power of two is applied in two steps, because 2⁻¹⁰⁷⁴ cannot be formed as the reciprocal of a double.
    Some(sign * value * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2))
}
