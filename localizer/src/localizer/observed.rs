//! What became of a reading: the methods' accounts of it, or why it was dropped.

use std::fmt;

use super::{Account, REMEMBER_S, SAME_S};

/// What became of a reading that the localizer was given.
#[derive(Clone, Debug, Default)]
pub struct Observed {
    /// For each method that used the reading, an account of what came of it. Empty for readings of motion sensors, which no method reads.
    pub accounts: Vec<Account>,
    /// Why the localizer did not use the reading; `None` for a reading that was used.
    pub dropped: Option<Dropped>,
}

/// Why the localizer did not use a reading.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Dropped {
    /// The robot model has no such device, or no method reads it.
    UnknownDevice,
    /// One of its numbers or its stamp is not finite.
    NotFinite,
    /// Its stamp is before the start of the drive.
    BeforeStart,
    /// Its stamp is older than the localizer remembers poses.
    TooOld {
        /// Age of the stamp at the time of the latest wheel reading.
        age_s: f64,
        /// Age up to which a reading is used.
        limit_s: f64,
    },
    /// Its stamp is before the end of the latest doubt about a failed assumption, so that what was known at its stamp is not to be relied on.
    BeforeDoubtEnded {
        /// Stamp of the reading that ended the doubt.
        ended_s: f64,
    },
    /// A reading of the same device with the same or a later stamp came before it, so that it says nothing new.
    Overtaken,
    /// No wheel reading has come yet that reaches from the poses before to its stamp.
    NoMotion,
}

impl Observed {
    pub(super) fn used(accounts: Vec<Account>) -> Observed {
        Observed { accounts, dropped: None }
    }

    pub(super) fn dropped(dropped: Dropped) -> Observed {
        Observed { accounts: Vec::new(), dropped: Some(dropped) }
    }

    /// A reading of a motion sensor: `is_new` is whether it was added to the history of its device, if there is such a device.
    pub(super) fn of_motion(is_new: Option<bool>) -> Observed {
        match is_new {
            Some(true) => Observed::default(),
            Some(false) => Observed::dropped(Dropped::Overtaken),
            None => Observed::dropped(Dropped::UnknownDevice),
        }
    }
}

impl Dropped {
    /// Why there is no pose at a stamp that a constraint could be applied to.
    pub(super) fn for_want_of_pose(stamp_s: f64, now_s: f64, doubt_ended_s: f64) -> Dropped {
        if stamp_s < -SAME_S {
            Dropped::BeforeStart
        } else if stamp_s < now_s - REMEMBER_S {
            Dropped::TooOld { age_s: now_s - stamp_s, limit_s: REMEMBER_S }
        } else if stamp_s < doubt_ended_s {
            Dropped::BeforeDoubtEnded { ended_s: doubt_ended_s }
        } else {
            Dropped::NoMotion
        }
    }
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Dropped::UnknownDevice => write!(f, "the robot model has no such device, or no method reads it"),
            Dropped::NotFinite => write!(f, "one of its numbers or its stamp is not finite"),
            Dropped::BeforeStart => write!(f, "its stamp is before the start"),
            Dropped::TooOld { age_s, limit_s } => {
                write!(f, "its stamp is {age_s:.3} s old, and poses are remembered for {limit_s} s")
            }
            Dropped::BeforeDoubtEnded { ended_s } => {
                write!(f, "its stamp is before {ended_s:.3} s, when a doubt about an earlier contradiction ended")
            }
            Dropped::Overtaken => write!(f, "a reading of the device with the same or a later stamp came before it"),
            Dropped::NoMotion => write!(f, "no wheel reading reaches from the poses before to its stamp"),
        }
    }
}
