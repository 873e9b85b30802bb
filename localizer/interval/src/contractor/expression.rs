//! Formulas written with ordinary operators, and kept as a list of steps that can be evaluated forward and contracted backward.

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::{Interval, IntervalBox};

/// A value in a formula: a variable, a constant, or the result of an operation on other values. An expression is only a handle, free to copy.
#[derive(Clone, Copy, Debug)]
pub struct Expression<'a> {
    steps: &'a RefCell<Vec<Step>>,
    idx: usize,
}

/// One step of a formula; its operands are indices of earlier steps. The first `N` steps of a formula are its `N` variables.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Variable,
    Constant(Interval),
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Min(usize, usize),
    Max(usize, usize),
    Hypot(usize, usize),
    /// Arc tangent of the operands y (first) and x (second).
    Atan2(usize, usize),
    Pown(usize, i32),
    Neg(usize),
    Abs(usize),
    Sqr(usize),
    Sqrt(usize),
    Exp(usize),
    Log(usize),
    Sin(usize),
    Cos(usize),
    Tan(usize),
    Asin(usize),
    Acos(usize),
    Atan(usize),
}

macro_rules! unary {
    ($($(#[$doc:meta])* $method:ident $step:ident),*) => {$(
        $(#[$doc])*
        pub fn $method(self) -> Self {
            self.push(Step::$step(self.idx))
        }
    )*};
}

macro_rules! binary {
    ($($(#[$doc:meta])* $method:ident $step:ident),*) => {$(
        $(#[$doc])*
        pub fn $method(self, other: Self) -> Self {
            self.push(Step::$step(self.idx, other.idx))
        }
    )*};
}

impl<'a> Expression<'a> {
    unary!(
        /// Absolute value.
        abs Abs,
        /// Square of the value. Its enclosure is narrower than that of a product when the operand's sign is unknown, so `x * x` in a formula is
        /// stored as a square.
        sqr Sqr,
        /// Square root.
        sqrt Sqrt,
        /// Exponential.
        exp Exp,
        /// Natural logarithm.
        log Log,
        /// Sine.
        sin Sin,
        /// Cosine.
        cos Cos,
        /// Tangent.
        tan Tan,
        /// Inverse sine.
        asin Asin,
        /// Inverse cosine.
        acos Acos,
        /// Inverse tangent.
        atan Atan
    );
    binary!(
        /// Smaller of two values.
        min Min,
        /// Greater of two values.
        max Max,
        /// Hypotenuse √(self² + other²).
        hypot Hypot,
        /// Angle in (−π, π] of the vector with x = `other` and y = `self`, as in `f64::atan2`.
        atan2 Atan2
    );

    /// Integer power of the value.
    pub fn pown(self, n: i32) -> Self {
        self.push(Step::Pown(self.idx, n))
    }

    /// A constant of the formula that is known to lie in an interval, such as a measurement or a parameter.
    pub fn constant(self, value: Interval) -> Self {
        self.push(Step::Constant(value))
    }

    fn push(self, step: Step) -> Self {
        let mut steps = self.steps.borrow_mut();
        // A repeated subexpression is stored as one value: it is evaluated once, and going backward it is contracted by all its uses. Two
        // constants known to within the same interval stay two values, though, because two measurement errors are not the same error.
        let is_shared = match step {
            Step::Variable => false,
            Step::Constant(value) => value.is_singleton(),
            _ => true,
        };
        let known = if is_shared { steps.iter().position(|known| *known == step) } else { None };
        let idx = known.unwrap_or(steps.len());
        if idx == steps.len() {
            steps.push(step);
        }
        Expression { steps: self.steps, idx }
    }
}

impl Neg for Expression<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self.push(Step::Neg(self.idx))
    }
}

impl Mul for Expression<'_> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.push(if self.idx == other.idx { Step::Sqr(self.idx) } else { Step::Mul(self.idx, other.idx) })
    }
}

macro_rules! operator {
    ($($operation:ident $method:ident $step:ident),*) => {$(
        impl $operation for Expression<'_> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.push(Step::$step(self.idx, other.idx))
            }
        }
    )*};
}
operator!(Add add Add, Sub sub Sub, Div div Div);

/// Defines the operators between an expression and a number or an interval, which becomes a constant of the formula.
macro_rules! with_constant {
    ($($operation:ident $method:ident),*) => {$(
        impl $operation<Interval> for Expression<'_> {
            type Output = Self;
            fn $method(self, other: Interval) -> Self {
                self.$method(self.constant(other))
            }
        }
        impl<'a> $operation<Expression<'a>> for Interval {
            type Output = Expression<'a>;
            fn $method(self, other: Expression<'a>) -> Expression<'a> {
                other.constant(self).$method(other)
            }
        }
        impl $operation<f64> for Expression<'_> {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                self.$method(Interval::point(other))
            }
        }
        impl<'a> $operation<Expression<'a>> for f64 {
            type Output = Expression<'a>;
            fn $method(self, other: Expression<'a>) -> Expression<'a> {
                Interval::point(self).$method(other)
            }
        }
    )*};
}
with_constant!(Add add, Sub sub, Mul mul, Div div);

/// `M` formulas of `N` variables as one list of steps, ready to be evaluated.
#[derive(Clone, Debug)]
pub(super) struct Program<const N: usize, const M: usize> {
    steps: Vec<Step>,
    outputs: [usize; M],
}

impl<const N: usize, const M: usize> Program<N, M> {
    pub(super) fn record(formulas: impl for<'a> FnOnce([Expression<'a>; N]) -> [Expression<'a>; M]) -> Self {
        let steps = RefCell::new(vec![Step::Variable; N]);
        let outputs =
            formulas(std::array::from_fn(|idx| Expression { steps: &steps, idx })).map(|expression| expression.idx);
        Program { steps: steps.into_inner(), outputs }
    }

    /// Encloses the value of every step of the formulas, given a box of the variables.
    pub(super) fn forward(&self, domain: &IntervalBox<N>) -> Vec<Interval> {
        let mut values = Vec::with_capacity(self.steps.len());
        values.extend(domain.iter());
        for step in &self.steps[N..] {
            values.push(step.forward(&values));
        }
        values
    }

    pub(super) fn outputs(&self, values: &[Interval]) -> IntervalBox<M> {
        IntervalBox::new(self.outputs.map(|idx| values[idx]))
    }

    /// Contracts the interval of every step's value, the last step first, starting from what the formulas' values may be (`outputs`). Returns the
    /// box of the variables that is left.
    pub(super) fn backward(&self, mut values: Vec<Interval>, outputs: &IntervalBox<M>) -> IntervalBox<N> {
        for (idx, output) in self.outputs.iter().zip(outputs) {
            values[*idx] = values[*idx].intersect(*output);
        }
        for idx in (N..self.steps.len()).rev() {
            if values[idx].is_empty() {
                return IntervalBox::EMPTY;
            }
            self.steps[idx].backward(values[idx], &mut values);
        }
        IntervalBox::new(std::array::from_fn(|idx| values[idx]))
    }
}

impl Step {
    fn forward(self, values: &[Interval]) -> Interval {
        match self {
            // A variable's value is filled in from the box before the first step is evaluated, so the whole line stands here only as a placeholder
            // that is never used.
            Step::Variable => Interval::ENTIRE,
            Step::Constant(value) => value,
            Step::Add(a, b) => values[a] + values[b],
            Step::Sub(a, b) => values[a] - values[b],
            Step::Mul(a, b) => values[a] * values[b],
            Step::Div(a, b) => values[a] / values[b],
            Step::Min(a, b) => values[a].min(values[b]),
            Step::Max(a, b) => values[a].max(values[b]),
            Step::Hypot(a, b) => values[a].hypot(values[b]),
            Step::Atan2(y, x) => values[y].atan2(values[x]),
            Step::Pown(a, n) => values[a].pown(n),
            Step::Neg(a) => -values[a],
            Step::Abs(a) => values[a].abs(),
            Step::Sqr(a) => values[a].sqr(),
            Step::Sqrt(a) => values[a].sqrt(),
            Step::Exp(a) => values[a].exp(),
            Step::Log(a) => values[a].log(),
            Step::Sin(a) => values[a].sin(),
            Step::Cos(a) => values[a].cos(),
            Step::Tan(a) => values[a].tan(),
            Step::Asin(a) => values[a].asin(),
            Step::Acos(a) => values[a].acos(),
            Step::Atan(a) => values[a].atan(),
        }
    }

    /// Contracts the intervals of the step's operands, given the interval `z` of its result.
    fn backward(self, z: Interval, values: &mut [Interval]) {
        match self {
            Step::Variable | Step::Constant(_) => {}
            Step::Add(a, b) => {
                values[a] = values[a].intersect(z - values[b]);
                values[b] = values[b].intersect(z - values[a]);
            }
            Step::Sub(a, b) => {
                values[a] = values[a].intersect(z + values[b]);
                values[b] = values[b].intersect(values[a] - z);
            }
            Step::Mul(a, b) => {
                values[a] = z.mul_rev(values[b], values[a]);
                values[b] = z.mul_rev(values[a], values[b]);
            }
            Step::Div(a, b) => {
                values[a] = values[a].intersect(z * values[b]);
                values[b] = values[a].mul_rev(z, values[b]);
            }
            Step::Min(a, b) => {
                let (x, y) = backward_max(-z, -values[a], -values[b]);
                (values[a], values[b]) = (-x, -y);
            }
            Step::Max(a, b) => (values[a], values[b]) = backward_max(z, values[a], values[b]),
            Step::Hypot(a, b) => {
                values[a] = (z.sqr() - values[b].sqr()).sqr_rev(values[a]);
                values[b] = (z.sqr() - values[a].sqr()).sqr_rev(values[b]);
            }
            Step::Atan2(y, x) => {
                // The angle z of the vector (x, y) with the length r satisfies (x, y) = r (cos z, sin z), hence x sin z = y cos z.
                let (cosine, sine) = (z.cos(), z.sin());
                let radius = values[x].hypot(values[y]);
                values[x] = (values[y] * cosine).mul_rev(sine, values[x].intersect(radius * cosine));
                values[y] = (values[x] * sine).mul_rev(cosine, values[y].intersect(radius * sine));
            }
            Step::Pown(a, n) => values[a] = z.pown_rev(values[a], n),
            Step::Neg(a) => values[a] = values[a].intersect(-z),
            Step::Abs(a) => values[a] = z.abs_rev(values[a]),
            Step::Sqr(a) => values[a] = z.sqr_rev(values[a]),
            Step::Sqrt(a) => values[a] = values[a].intersect(z.max(Interval::ZERO).sqr()),
            Step::Exp(a) => values[a] = values[a].intersect(z.log()),
            Step::Log(a) => values[a] = values[a].intersect(z.exp()),
            Step::Sin(a) => values[a] = z.sin_rev(values[a]),
            Step::Cos(a) => values[a] = z.cos_rev(values[a]),
            Step::Tan(a) => values[a] = z.tan_rev(values[a]),
            Step::Asin(a) => values[a] = values[a].intersect(z.sin()),
            Step::Acos(a) => values[a] = values[a].intersect(z.cos()),
            Step::Atan(a) => values[a] = values[a].intersect(within_half_circle(z).tan()),
        }
    }
}

/// Contracts the operands of max(x, y) = z: neither is above z, and when one is surely below z, the other equals z.
fn backward_max(z: Interval, x: Interval, y: Interval) -> (Interval, Interval) {
    let below = Interval::new(f64::NEG_INFINITY, z.hi());
    let other = |this: Interval, other: Interval| this.intersect(if other.hi() < z.lo() { z } else { below });
    (other(x, y), other(y, x))
}

/// The interval of an arc tangent's result if it lies between the tangent's poles ±π/2; the whole line where outward rounding has moved a bound
/// beyond them.
fn within_half_circle(z: Interval) -> Interval {
    let quarter = std::f64::consts::FRAC_PI_2;
    let inside = z.intersect(Interval::new(-quarter, quarter));
    // Beyond the last doubles before the poles ±π/2 the tangent of an angle may be any number, so such an interval must not contract the operand.
    if z.is_subset_of(inside) { inside } else { Interval::ENTIRE }
}
