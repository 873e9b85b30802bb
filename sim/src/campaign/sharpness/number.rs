//! Numbers that the formulas of a history are computed with: `f64` where a history is sought, intervals where one is checked.

use std::ops::{Add, Mul, Neg, Sub};

use interval::Interval;

/// A number of a formula.
pub(super) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The number that is exactly `value`.
    fn of(value: f64) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;
    /// sin a / a, which is 1 at a = 0.
    fn sinc(self) -> Self;
    /// Quotient of two numbers.
    fn over(self, divisor: Self) -> Self;
}

impl Number for f64 {
    fn of(value: f64) -> f64 {
        value
    }

    fn sin(self) -> f64 {
        f64::sin(self)
    }

    fn cos(self) -> f64 {
        f64::cos(self)
    }

    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    fn sinc(self) -> f64 {
        // Below this angle 1 − a²/6 rounds to 1.
        if self.abs() < 1e-9 { 1.0 } else { self.sin() / self }
    }

    fn over(self, divisor: f64) -> f64 {
        self / divisor
    }
}

impl Number for Interval {
    fn of(value: f64) -> Interval {
        Interval::point(value)
    }

    fn sin(self) -> Interval {
        Interval::sin(self)
    }

    fn cos(self) -> Interval {
        Interval::cos(self)
    }

    fn sqrt(self) -> Interval {
        Interval::sqrt(self)
    }

    fn sinc(self) -> Interval {
        if self.mignitude() < 1e-9 {
            // 1 − a²/6 ≤ sin a / a ≤ 1 for every a.
            return (Interval::ONE - self.sqr() * (1.0 / 6.0)).hull(Interval::ONE);
        }
        Interval::sin(self) / self
    }

    fn over(self, divisor: Interval) -> Interval {
        self / divisor
    }
}

/// A vector in space.
pub(super) type Vector<T> = [T; 3];

/// The vector turned by `angle_rad` about the axis with the given index, counter-clockwise seen from the axis's end.
pub(super) fn turned_about<T: Number>(axis: usize, angle_rad: T, vector: Vector<T>) -> Vector<T> {
    let (sin, cos) = (angle_rad.sin(), angle_rad.cos());
    let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turned = vector;
    turned[one] = cos * vector[one] - sin * vector[other];
    turned[other] = sin * vector[one] + cos * vector[other];
    turned
}

/// The vector turned by a rotation vector with components along the first two axes: by its length, about its direction.
///
/// Rodrigues' formula: v cos a + (sin a / a) w × v + ½ (sin ½a / ½a)² w (w·v), with a = |w|.
pub(super) fn turned_by<T: Number>([x, y]: [T; 2], vector: Vector<T>) -> Vector<T> {
    let angle_rad = (x * x + y * y).sqrt();
    let half = T::of(0.5);
    let half_sinc = (half * angle_rad).sinc();
    let across = [y * vector[2], -(x * vector[2]), x * vector[1] - y * vector[0]];
    let along = half * half_sinc * half_sinc * (x * vector[0] + y * vector[1]);
    let (cos, sinc) = (angle_rad.cos(), angle_rad.sinc());
    [
        vector[0] * cos + sinc * across[0] + along * x,
        vector[1] * cos + sinc * across[1] + along * y,
        vector[2] * cos + sinc * across[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, vector};

    /// nalgebra's rotations are an outside source.
    #[test]
    fn rotations_are_those_of_the_linear_algebra_library_and_enclosed() {
        for [x, y, angle_rad] in [[0.0, 0.0, 0.0], [0.001, -0.0007, 1.3], [0.3, 0.5, -2.0], [-1e-12, 0.0, 3.0]] {
            let before = [0.7, -1.1, 0.4];
            let expected = UnitQuaternion::from_scaled_axis(vector![x, y, 0.0])
                * UnitQuaternion::from_euler_angles(0.0, 0.0, angle_rad)
                * vector![before[0], before[1], before[2]];
            let number = turned_by([x, y], turned_about(2, angle_rad, before));
            let point = Interval::point;
            let enclosed =
                turned_by([point(x), point(y)], turned_about(2, point(angle_rad), before.map(Interval::point)));
            for axis in 0..3 {
                assert!((number[axis] - expected[axis]).abs() < 1e-14, "{number:?} {expected}");
                assert!(enclosed[axis].inflate(1e-15).contains(expected[axis]) && enclosed[axis].width() < 1e-14);
            }
        }
    }
}
