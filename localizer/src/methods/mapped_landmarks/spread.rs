//! The spread of landmarks over a picture.

/// Number of columns and rows of a picture's parts, and number of landmarks of a part below which new ones are made of it.
const PARTS: [usize; 2] = [4, 4];
const ENOUGH: usize = 3;
/// Number of landmarks of a picture below which new ones are made of any part.
const ENOUGH_IN_ALL: usize = 30;

/// The numbers of landmarks of a picture's parts. What is near tells the place, and what is far the heading, so that landmarks are to be found
/// everywhere in a picture.
pub(super) struct Spread {
    size_px: [f64; 2],
    n_landmarks: [[usize; PARTS[1]]; PARTS[0]],
    n_in_all: usize,
}

impl Spread {
    /// The numbers of some landmarks at their places in a picture of a size.
    pub(super) fn new(size_px: [f64; 2], found_px: impl Iterator<Item = [f64; 2]>) -> Spread {
        let mut spread = Spread { size_px, n_landmarks: Default::default(), n_in_all: 0 };
        found_px.for_each(|at_px| spread.add(at_px));
        spread
    }

    fn part(&mut self, at_px: [f64; 2]) -> &mut usize {
        let [column, row] = [0, 1].map(|axis| {
            let part = at_px[axis] / self.size_px[axis] * PARTS[axis] as f64;
            (part.max(0.0) as usize).min(PARTS[axis] - 1)
        });
        &mut self.n_landmarks[column][row]
    }

    fn add(&mut self, at_px: [f64; 2]) {
        *self.part(at_px) += 1;
        self.n_in_all += 1;
    }

    /// Whether the picture or its part with a place lacks landmarks. If so, one is counted there.
    pub(super) fn takes(&mut self, at_px: [f64; 2]) -> bool {
        let lacks = self.n_in_all < ENOUGH_IN_ALL || *self.part(at_px) < ENOUGH;
        if lacks {
            self.add(at_px);
        }
        lacks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_takes_new_landmarks_until_it_has_enough_and_then_each_part_until_it_has() {
        // Twenty-eight of them in one part: two more of any part are taken, and then only of those that have few.
        let mut spread = Spread::new([640.0, 480.0], std::iter::repeat_n([300.0, 200.0], 28));
        assert!(spread.takes([300.0, 201.0]) && spread.takes([5.0, 5.0]) && !spread.takes([300.0, 202.0]));
        assert!(spread.takes([20.0, 100.0]) && spread.takes([150.0, 110.0]) && !spread.takes([5.0, 6.0]));
        // The next part to the right, and places beyond the border, which straightened ones may have.
        assert!((0..ENOUGH).all(|_| spread.takes([170.0, 5.0])) && !spread.takes([170.0, 5.0]));
        assert!((0..ENOUGH).all(|_| spread.takes([645.0, 485.0])) && !spread.takes([639.0, 479.0]));
    }
}
