//! Quotas of false claims. A claim is a method's assertion of what it saw in a reading; a quota says how many claims may be false. A scene declares
//! the quotas, and every constraint carries the quota of its own claims.

/// Quota: how many of the claims (assertions of what was seen) behind one reading's constraint may be false, by itself and together with earlier
/// readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quota {
    /// Greatest number of the reading's claims that may be false, not counting claims about upright edges.
    pub items: usize,
    /// Greatest number of things, such as paintings or shelves, of which all claims may be false in addition, as where they have moved since they were
    /// mapped. Claims about landmarks in space say on which thing the landmark is.
    pub things: usize,
    /// Greatest number of the reading's claims about upright edges that may be false. If more of them are false, the lean of robot and camera that
    /// was found from the upright edges is wrong, and no claim of the reading counts as true.
    pub upright: usize,
    /// Rule by which the false claims of the readings that are counted together are counted.
    pub counting: Counting,
}

/// Rule by which the false claims (wrong assertions of what was seen) of several readings are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Counting {
    /// The false claims of each reading are counted by themselves.
    Alone,
    /// Of the method's latest readings, at most some may have more false claims than their own quota `items`.
    Readings {
        /// Number of the latest readings that are counted together, the present one included.
        of: usize,
        /// Greatest number of them that may have more false claims than their own quota.
        most: usize,
    },
    /// The claims of the method's latest readings form one set, without the claims about upright edges. Of this set, a share of `share` and in
    /// addition `more` claims may be false, and they may come from at most `readings` of the readings.
    Together {
        /// Number of the latest readings that are counted together, the present one included.
        of: usize,
        /// Share of the claims of all readings counted together that may be false.
        share: f64,
        /// Number of claims, of all readings counted together, that may be false in addition to the share.
        more: usize,
        /// Greatest number of the readings counted together that may have any false claim.
        readings: usize,
    },
}

impl Quota {
    /// The quota for a method that makes at most `items` false claims for each reading; every reading is counted by itself.
    pub fn of_each(items: usize) -> Quota {
        Quota { items, things: 0, upright: 0, counting: Counting::Alone }
    }
}

/// Number of items in a share of `count`, rounded down. The product is raised by 1e-9 first, so that rounding errors do not make a whole number
/// fall short by one.
pub fn share_of(share: f64, count: usize) -> usize {
    ((share * count as f64 + 1e-9).floor() as usize).min(count)
}
