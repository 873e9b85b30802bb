//! Quotas of false claims: how many of a method's claims may be false. A scene declares them, and every constraint carries its own.

/// How many of the claims behind one reading's constraint may be false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quota {
    /// Greatest number of false claims of the reading, not counting claims about upright edges.
    pub items: usize,
    /// Greatest number of false claims of the reading about upright edges. If more of them are false, the lean found from them is wrong, and no
    /// claim of the reading counts as true.
    pub upright: usize,
    /// Number of readings of the method whose false claims are counted together, this one included.
    pub n_held: usize,
    /// How the false claims of these readings are counted.
    pub counting: Counting,
}

/// How the false claims of several readings are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Counting {
    /// Each reading is counted by itself.
    Alone,
    /// Of the readings that are counted together, at most this many may have more false claims than their own quota `items`.
    Readings(usize),
    /// The claims of all readings that are counted together are taken as one set, without those about upright edges: `share` of them and `more` in
    /// addition may be false, in at most `readings` of the readings.
    Together {
        /// Share of the claims that may be false.
        share: f64,
        /// Number of claims that may be false in addition to the share.
        more: usize,
        /// Greatest number of readings with any false claim.
        readings: usize,
    },
}

impl Quota {
    /// The quota for a method of which at most `items` claims of each reading are false.
    pub fn of_each(items: usize) -> Quota {
        Quota { items, upright: 0, n_held: 1, counting: Counting::Alone }
    }
}

/// Number of items in a share of `count`, rounded down. The product is raised by 1e-9 first, so that rounding errors do not make a whole number
/// fall short by one.
pub fn share_of(share: f64, count: usize) -> usize {
    ((share * count as f64 + 1e-9).floor() as usize).min(count)
}
