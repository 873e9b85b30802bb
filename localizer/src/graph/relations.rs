//! What a reading relates, in a form from which its rows can be made anew about any reference values.

use interval::Interval;

use crate::{PoseBox, bounds::Assumption};

use super::{Domain, Row, Stray, Variable};

/// Two quantities that are together within a radius of (0, 0).
pub type Disc = ([Variable; 2], f64);

/// What one reading says about the pose at its stamp together with other quantities.
///
/// The rows of a linear program hold near reference values only: what is not linear in them is enclosed over the boxes of the quantities. As these
/// boxes become narrower, rows are made anew.
pub trait Relations: Send + Sync {
    /// The quantities that the rows of the key frame with the given number name beside its pose and the constants of the robot, each with an interval
    /// that the declared bounds and the box of poses at the reading's stamp imply.
    fn quantities(&self, frame: usize, pose: &PoseBox) -> Vec<(Variable, Interval)>;

    /// Pairs of quantities that are together within a radius of (0, 0), such as the two components of a tilt.
    fn discs(&self, _frame: usize) -> Vec<Disc> {
        Vec::new()
    }

    /// Whether the reading shows things of the map, so that the constraint on the pose alone tells nearly as much as the rows.
    fn is_of_the_map(&self) -> bool {
        false
    }

    /// Whether quantities and rows are found anew each time, so that they can be made about several boxes that one pose may be in. They cannot where
    /// something is kept from the first box on, such as which joint of the map a line shows.
    fn is_found_anew(&self) -> bool {
        false
    }

    /// Whether enough is certain of what the reading shows for its rows to be worth a key frame.
    fn is_worth_a_key_frame(&self) -> bool {
        true
    }

    /// Greatest error of the reading's stamp.
    fn stamp_error_s(&self) -> f64;

    /// The declared bound on that error.
    fn stamp_bound(&self) -> Assumption;

    /// Greatest horizontal distance by which everything that the reading shows is displaced in common, such as by the motion within the stamp's
    /// error, which `stray` bounds.
    fn shift_m(&self, stray: &Stray) -> f64;

    /// The declared bounds that make [`Relations::shift_m`], each with the part that grows with it. Parts may overlap: what a stamp's error makes grows
    /// with the robot's greatest speed, too.
    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)>;

    /// A declared bound without which the rows say nothing at all, such as the number of wrong codes in a reading.
    fn void_without(&self) -> Option<Assumption> {
        None
    }

    /// The rows of the reading at the key frame with the given number. The domain has the pose of that key frame, the constants of the robot, and the
    /// reading's quantities; rows of a landmark that the domain does not have are left out. The pose is that which the reading shows: it is displaced
    /// from the pose at the stamp by at most [`Relations::shift_m`], and turned by what the robot turns within the stamp's error.
    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row>;
}
