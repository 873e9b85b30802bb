//! How many claims may be false: what a scene declares of vision, as it goes with every constraint.

/// How many of the claims behind a constraint may be false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quota {
    /// At most this many of the reading's own claims, those about upright edges apart.
    pub items: usize,
    /// At most this many of its claims about upright edges: with more of them false there is no right lean, and no claim of the reading counts as
    /// true.
    pub upright: usize,
    /// Readings of the method that count together, with this one.
    pub n_held: usize,
    /// How they do.
    pub counting: Counting,
}

/// How the false claims of several readings count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Counting {
    /// Each reading for itself.
    Alone,
    /// Of the readings held so many may have more false claims than their own `items`.
    Readings(usize),
    /// Of the claims of all readings held, upright edges apart, this share and so many more may be false, in so many of the readings.
    Together {
        /// Share of the claims,
        share: f64,
        /// how many more,
        more: usize,
        /// and in how many of the readings there may be any.
        readings: usize,
    },
}

impl Quota {
    /// At most so many claims of each reading are false.
    pub fn of_each(items: usize) -> Quota {
        Quota { items, upright: 0, n_held: 1, counting: Counting::Alone }
    }
}

/// How many of so many a share is: a hair more than the product, as a share of a third is a third, however it is rounded.
pub fn share_of(share: f64, count: usize) -> usize {
    ((share * count as f64 + 1e-9).floor() as usize).min(count)
}
