//! Tests of interval functions and random expressions against arithmetic with 160 bits: the real value must be inside the interval.
//!
//! `WHEREIN_INTERVAL_TRIALS` sets the number of function values that are tried, and one expression is tried for every 20 of them; the
//! experiments set 1.4·10⁷.

use std::cell::RefCell;
use std::rc::Rc;

use dashu_float::round::mode::Zero;
use dashu_float::{CachedFBig, ConstCache, FBig};
use interval::Interval;

type Big = CachedFBig<Zero, 2>;

/// Bits of the reference arithmetic. Relative errors of 2⁻¹⁶⁰ are invisible beside the half unit of 2⁻⁵³ by which every interval bound
/// clears the real value.
const PRECISION: usize = 160;

fn n_trials() -> u64 {
    std::env::var("WHEREIN_INTERVAL_TRIALS").ok().and_then(|text| text.parse().ok()).unwrap_or(20_000)
}

/// Random number generator SplitMix64: good enough for tests, and it gives the same numbers on every machine.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Random number, where mistakes are likely: of ordinary size, with any exponent, whole, or next to a multiple of π/4.
    fn number(&mut self) -> f64 {
        match self.below(8) {
            0..4 => 20.0 * self.unit() - 10.0,
            4 => f64::from_bits(self.bits() & !(0x7ff << 52) | ((1023 - 40 + self.below(80)) << 52)),
            5 => self.below(41) as f64 - 20.0,
            6 => {
                let near = (self.below(400) as f64 - 200.0) * std::f64::consts::FRAC_PI_4;
                [near, near.next_up(), near.next_down()][self.below(3) as usize]
            }
            _ => loop {
                let any = f64::from_bits(self.bits());
                if any.is_finite() {
                    return any;
                }
            },
        }
    }

    /// Random interval, a point, thin or wide, and a member of it that is often one of its ends.
    fn interval_with_member(&mut self) -> (Interval, f64) {
        let a = self.number();
        let b = match self.below(4) {
            0 => a,
            1 => (0..=self.below(4)).fold(a, |x, _| x.next_up()),
            2 => a + self.unit(),
            _ => self.number(),
        };
        let (lo, hi) = (a.min(b), a.max(b));
        let member = match self.below(3) {
            0 => lo,
            1 => hi,
            _ => (lo + self.unit() * (hi - lo)).clamp(lo, hi),
        };
        let interval = Interval::new(lo, hi);
        if interval.contains(member) { (interval, member) } else { self.interval_with_member() }
    }
}

fn big(value: f64, cache: &Rc<RefCell<ConstCache>>) -> Big {
    let exact = FBig::<Zero, 2>::try_from(value).unwrap();
    Big::new(exact.with_precision(PRECISION).value(), cache.clone())
}

fn encloses(enclosure: Interval, real: &Big, cache: &Rc<RefCell<ConstCache>>) -> bool {
    !enclosure.is_empty()
        && (enclosure.lo().is_infinite() || big(enclosure.lo(), cache) <= *real)
        && (enclosure.hi().is_infinite() || *real <= big(enclosure.hi(), cache))
}

#[test]
fn functions_enclose_the_real_value() {
    type Function = (&'static str, fn(Interval) -> Interval, fn(&Big) -> Big, fn(f64) -> bool);
    let anywhere: fn(f64) -> bool = |_| true;
    // Arguments of 2^±1000 make the reference arithmetic slow, and the ITF1788 cases cover them.
    let moderate: fn(f64) -> bool = |x| x == 0.0 || (1e-60..1e60).contains(&x.abs());
    let unit: fn(f64) -> bool = |x| x.abs() <= 1.0 && (x == 0.0 || x.abs() > 1e-60);
    let functions: [Function; 12] = [
        ("sqrt", Interval::sqrt, |x| x.sqrt(), |x| x >= 0.0),
        ("sqr", Interval::sqr, |x| x.clone() * x.clone(), |x| x == 0.0 || (1e-150..1e150).contains(&x.abs())),
        ("exp", Interval::exp, |x| x.exp(), |x| x.abs() < 700.0),
        ("log", Interval::log, |x| x.ln(), |x| x > 0.0),
        ("sin", Interval::sin, |x| x.sin(), moderate),
        ("cos", Interval::cos, |x| x.cos(), moderate),
        ("tan", Interval::tan, |x| x.tan(), moderate),
        ("asin", Interval::asin, |x| x.asin(), unit),
        ("acos", Interval::acos, |x| x.acos(), unit),
        ("atan", Interval::atan, |x| x.atan(), moderate),
        ("cube", |x| x.pown(3), |x| x.clone() * x.clone() * x.clone(), moderate),
        ("identity", |x| x, |x| x.clone(), anywhere),
    ];
    let cache = Rc::new(RefCell::new(ConstCache::new()));
    let mut random = Random(1);
    let mut n_checked = 0;
    for _ in 0..n_trials() {
        let (x, member) = random.interval_with_member();
        let (name, function, reference, accepts) = functions[random.below(12) as usize];
        if !accepts(member) {
            continue;
        }
        n_checked += 1;
        let real = reference(&big(member, &cache));
        let enclosure = function(x);
        assert!(encloses(enclosure, &real, &cache), "{name} of {member:e} is outside {name}({x}) = {enclosure}");
    }
    println!("{n_checked} function values inside");
}

/// Random expression that can be evaluated with intervals and with real numbers.
enum Expression {
    Variable(usize),
    Unary(u64, Box<Expression>),
    Binary(u64, Box<Expression>, Box<Expression>),
}

impl Expression {
    fn random(random: &mut Random, depth: usize) -> Expression {
        if depth == 0 || random.below(6) == 0 {
            return Expression::Variable(random.below(3) as usize);
        }
        if random.below(3) == 0 {
            return Expression::Unary(random.below(7), Box::new(Expression::random(random, depth - 1)));
        }
        let (left, right) = (Expression::random(random, depth - 1), Expression::random(random, depth - 1));
        Expression::Binary(random.below(6), Box::new(left), Box::new(right))
    }

    fn enclose(&self, variables: &[Interval; 3]) -> Interval {
        match self {
            Expression::Variable(idx) => variables[*idx],
            Expression::Unary(operation, operand) => {
                let x = operand.enclose(variables);
                match operation {
                    0 => x.sin(),
                    1 => x.cos(),
                    2 => x.sqr(),
                    3 => x.abs().sqrt(),
                    4 => x.atan(),
                    5 => -x,
                    _ => x.pown(3),
                }
            }
            Expression::Binary(operation, left, right) => {
                let (x, y) = (left.enclose(variables), right.enclose(variables));
                match operation {
                    0 => x + y,
                    1 => x - y,
                    2 => x * y,
                    3 => x / y,
                    4 => x.hypot(y),
                    _ => x.atan2(y),
                }
            }
        }
    }

    /// Value of the expression in the reference arithmetic; `None` where the expression has no value.
    fn real(&self, variables: &[Big; 3]) -> Option<Big> {
        let zero = |x: &Big| x.clone() == x.clone() - x.clone();
        Some(match self {
            Expression::Variable(idx) => variables[*idx].clone(),
            Expression::Unary(operation, operand) => {
                let x = operand.real(variables)?;
                match operation {
                    0 => x.sin(),
                    1 => x.cos(),
                    2 => x.clone() * x,
                    3 => {
                        if x.clone() < x.clone() - x.clone() {
                            (-x).sqrt()
                        } else {
                            x.sqrt()
                        }
                    }
                    4 => x.atan(),
                    5 => -x,
                    _ => x.clone() * x.clone() * x,
                }
            }
            Expression::Binary(operation, left, right) => {
                let (x, y) = (left.real(variables)?, right.real(variables)?);
                match operation {
                    0 => x + y,
                    1 => x - y,
                    2 => x * y,
                    3 if zero(&y) => return None,
                    3 => x / y,
                    4 => x.hypot(&y),
                    _ if zero(&x) && zero(&y) => return None,
                    // The reference arithmetic distinguishes −0 from 0, which real numbers do not.
                    _ if zero(&x) => (x.clone() - x).atan2(&y),
                    _ => x.atan2(&y),
                }
            }
        })
    }
}

#[test]
fn random_expressions_enclose_the_real_value() {
    let cache = Rc::new(RefCell::new(ConstCache::new()));
    let mut random = Random(2);
    let mut n_checked = 0;
    for _ in 0..n_trials() / 20 {
        let expression = Expression::random(&mut random, 4);
        let members: [f64; 3] = std::array::from_fn(|_| 6.0 * random.unit() - 3.0);
        let intervals = members.map(|member| {
            let reach = [0.0, 1e-9, 0.1, 2.0][random.below(4) as usize];
            Interval::new(member - reach * random.unit(), member + reach * random.unit())
        });
        let Some(real) = expression.real(&members.map(|member| big(member, &cache))) else {
            continue;
        };
        n_checked += 1;
        let enclosure = expression.enclose(&intervals);
        assert!(encloses(enclosure, &real, &cache), "{real:?} is outside {enclosure}");
    }
    println!("{n_checked} expression values inside");
}

#[test]
fn an_underflow_does_not_cross_zero() {
    // The product of two small positive numbers is positive even where the double underflows to 0: the interval of its reciprocal must stay on one
    // side of zero.
    let tiny = Interval::new(1e-200, 2e-200);
    assert!((tiny * tiny).lo() >= 0.0 && (tiny * -tiny).hi() <= 0.0);
    assert!((tiny * tiny).recip().lo() > 0.0);
    assert!((tiny / Interval::point(1e300)).lo() >= 0.0 && tiny.sqr().lo() >= 0.0);
    let unit = Interval::new(0.0, 1.0);
    assert_eq!((unit * unit).lo(), 0.0);
    assert_eq!(Interval::ENTIRE * Interval::ZERO, Interval::ZERO);
}
