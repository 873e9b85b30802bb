//! Binary descriptors that turn with the image: rotated BRIEF, as of ORB (Rublee et al., *ORB: an efficient alternative to SIFT or SURF*, ICCV
//! 2011).

use crate::vision::{draws::Draws, forward::Picture};

use super::smoothing::{Between, is_inside};

/// Number of comparisons of a descriptor.
pub(super) const BITS: usize = 256;
/// Radius, in pixels of the full image at scale 1, of the disc that a descriptor compares points of.
const RADIUS_PX: f64 = 13.0;

/// A descriptor of the surroundings of a point: 256 comparisons of two grey levels each, and the direction that they are turned by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descriptor {
    bits: [u64; BITS / 64],
}

impl Descriptor {
    /// The comparisons as the bits of some numbers.
    pub(super) fn words(&self) -> &[u64; BITS / 64] {
        &self.bits
    }

    /// The descriptor with these bits.
    pub(super) fn of_words(bits: [u64; BITS / 64]) -> Descriptor {
        Descriptor { bits }
    }

    /// Number of comparisons that differ, from 0 to 256.
    pub fn hamming_distance(&self, other: &Descriptor) -> u32 {
        self.bits.iter().zip(&other.bits).map(|(one, other)| (one ^ other).count_ones()).sum()
    }
}

/// The points that descriptors compare, in pixels of the full image at scale 1 and turn 0.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// First and second points of all comparisons.
    pairs: [[Points; BITS / LANES]; 2],
    disc: Vec<[f32; 2]>,
}

/// Number of points that are looked up side by side, by the vector instructions that the compiler makes of it.
const LANES: usize = 8;

/// Coordinates along u and along v of some points.
type Points<const N: usize = LANES> = [[f32; N]; 2];

impl Pattern {
    /// Random pairs of points, denser near the middle: the mean of two uniform random numbers for each coordinate.
    pub(super) fn new() -> Pattern {
        const STEPS: usize = 1 << 12;
        let mut draws = Draws::new();
        let part = |draws: &mut Draws| {
            let sum = draws.below(STEPS) + draws.below(STEPS);
            (sum as f64 / (STEPS - 1) as f64 - 1.0) * RADIUS_PX
        };
        let mut point = || loop {
            let at = [part(&mut draws), part(&mut draws)];
            if at[0].hypot(at[1]) <= RADIUS_PX {
                return at.map(|part| part as f32);
            }
        };
        let drawn: Vec<[[f32; 2]; 2]> = (0..BITS).map(|_| [point(), point()]).collect();
        let points =
            |one: usize, first: usize| [0, 1].map(|axis| std::array::from_fn(|lane| drawn[first + lane][one][axis]));
        let pairs = [0, 1].map(|one| std::array::from_fn(|at| points(one, LANES * at)));
        // Every second pixel suffices for the centroid, because the coarse image has no finer ones.
        let reach = (RADIUS_PX / 2.0) as i32;
        let lattice = (-reach..=reach).flat_map(|v| (-reach..=reach).map(move |u| [2 * u, 2 * v].map(|at| at as f32)));
        let disc = lattice.filter(|[u, v]| u.hypot(*v) <= RADIUS_PX as f32).collect();
        Pattern { pairs, disc }
    }

    /// Direction from a point to the centroid of the grey levels around it, positive from u towards v; `None` near the border.
    ///
    /// `coarse` is the coarse image, `at_px` the point in the full image, `scale` the size of the described disc as a multiple of [`RADIUS_PX`].
    pub(super) fn direction_rad(&self, coarse: &Picture, at_px: [f64; 2], scale: f64) -> Option<f64> {
        let place = Placed::new(coarse, at_px, scale, 0.0)?;
        let mut moments = [0.0f32; 2];
        for point in &self.disc {
            let level = place.between(&point.map(|part| [part])).value(coarse, 0);
            (0..2).for_each(|axis| moments[axis] += level * point[axis]);
        }
        Some(f64::from(moments[1]).atan2(f64::from(moments[0])))
    }

    /// The descriptor of a point's surroundings, turned by `direction_rad` and enlarged by `scale`; `None` near the border.
    pub(super) fn describe(
        &self,
        coarse: &Picture,
        at_px: [f64; 2],
        scale: f64,
        direction_rad: f64,
    ) -> Option<Descriptor> {
        let place = Placed::new(coarse, at_px, scale, direction_rad)?;
        let [ones, others] = &self.pairs;
        let mut bits = [0u64; BITS / 64];
        for (at, (ones, others)) in ones.iter().zip(others).enumerate() {
            let (ones, others) = (place.between(ones), place.between(others));
            let is_darker = |lane: usize| ones.value(coarse, lane) < others.value(coarse, lane);
            let byte = (0..LANES).fold(0, |byte, lane| byte | u64::from(is_darker(lane)) << lane);
            bits[LANES * at / 64] |= byte << (LANES * at % 64);
        }
        Some(Descriptor { bits })
    }
}

/// A pattern's place in the coarse image.
struct Placed {
    at_px: [f32; 2],
    /// Scale times cosine and sine of the turn, in coarse pixels per full pixel.
    turn: [f32; 2],
}

impl Placed {
    /// `None` if a part of the pattern is outside of the image.
    fn new(coarse: &Picture, at_px: [f64; 2], scale: f64, turn_rad: f64) -> Option<Placed> {
        let (sin, cos) = turn_rad.sin_cos();
        let at_px = at_px.map(|at| 0.5 * (at - 0.5));
        let turn = [cos, sin].map(|part| (0.5 * scale * part) as f32);
        let placed = Placed { at_px: at_px.map(|at| at as f32), turn };
        // One pixel more, because positions are rounded to single precision.
        is_inside(coarse, at_px, 0.5 * scale * RADIUS_PX + 1.0).then_some(placed)
    }

    /// Where some points of the pattern are in the coarse image.
    #[inline]
    fn between<const N: usize>(&self, [x, y]: &Points<N>) -> Between<N> {
        let ([cos, sin], [u, v]) = (self.turn, self.at_px);
        Between::new(&[
            std::array::from_fn(|idx| u + cos * x[idx] - sin * y[idx]),
            std::array::from_fn(|idx| v + sin * x[idx] + cos * y[idx]),
        ])
    }
}
