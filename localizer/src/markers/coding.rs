//! Sets of marker identities in use, chosen so that a damaged marker is not taken for another one.

use super::{MarkerId, N_CODED};

/// A set of marker identities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coding {
    /// All 4096 identities, as in the paper: no error is detected.
    Plain,
    /// Marker identities that are the words of the lexicode of distance 4 (any two differ in at least four dots): 128 identities, up to 3 wrong
    /// dots are detected.
    Lexicode,
    /// Marker identities that are 118 of the 132 hexads of the Steiner system S(5, 6, 12): six coded dots each, and any two differ in at least four
    /// dots. Up to 3 wrong dots are detected. If dots are only missing, or only added, as by dirt and covers, any number of them is detected. No
    /// identity's pattern is the mirror image of another identity's, so that a film pasted with the wrong side up is refused.
    #[default]
    Hexads,
}

impl Coding {
    /// All marker identities of this set, in rising order.
    pub fn identities(self) -> Vec<MarkerId> {
        let words = match self {
            Coding::Plain => (0..1 << N_CODED).collect(),
            Coding::Lexicode => lexicode(4),
            Coding::Hexads => without_mirror_images(hexads()),
        };
        words.into_iter().map(MarkerId).collect()
    }

    /// For each of the 4096 possible marker identities, whether it belongs to this set.
    pub fn table(self) -> Vec<bool> {
        let mut table = vec![false; 1 << N_CODED];
        self.identities().iter().for_each(|id| table[usize::from(id.0)] = true);
        table
    }
}

/// Lexicode of 12-bit words: every word, in rising order, that differs from all accepted before it in at least `distance` bits (J. Conway, N.
/// Sloane, IEEE Trans. Inf. Theory 32, 1986).
fn lexicode(distance: u32) -> Vec<u16> {
    let mut words: Vec<u16> = Vec::new();
    for word in 0..1 << N_CODED {
        if words.iter().all(|other| (word ^ other).count_ones() >= distance) {
            words.push(word);
        }
    }
    words
}

/// Leaves out words that are their own mirror image, and of two words that are mirror images of each other the greater one.
fn without_mirror_images(words: Vec<u16>) -> Vec<u16> {
    let mirrored = |word: u16| MarkerId::from_dots(MarkerId(word).dots().map(|[i, j]| [j, i])).0;
    let is_kept = |word: &u16| mirrored(*word) > *word || !words.contains(&mirrored(*word));
    words.iter().copied().filter(|word| mirrored(*word) != *word && is_kept(word)).collect()
}

/// The 132 words of 12 bits called hexads, six of them 1: all images of {∞, 1, 3, 4, 5, 9} under z → z + 1, z → 3z and z → −1/z modulo 11, applied
/// repeatedly; bit 11 stands for ∞ (J. Conway, N. Sloane, *Sphere Packings, Lattices and Groups*, chapter 11).
fn hexads() -> Vec<u16> {
    const P: u16 = 11;
    let inverse = |z: u16| (1..P).find(|other| z * other % P == 1).unwrap_or(P);
    let moves: [&dyn Fn(u16) -> u16; 3] =
        [&|z| if z == P { P } else { (z + 1) % P }, &|z| if z == P { P } else { 3 * z % P }, &|z| match z {
            0 => P,
            P => 0,
            _ => P - inverse(z),
        }];
    let mut words = vec![[P, 1, 3, 4, 5, 9].into_iter().fold(0u16, |word, z| word | 1 << z)];
    let mut next = 0;
    while next < words.len() {
        for step in moves {
            let image = (0..=P).filter(|z| words[next] & (1 << z) != 0).fold(0, |word, z| word | 1 << step(z));
            if !words.contains(&image) {
                words.push(image);
            }
        }
        next += 1;
    }
    words.sort_unstable();
    words
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::*;

    fn distance(words: &[MarkerId]) -> u32 {
        let pairs =
            words.iter().enumerate().flat_map(|(idx, a)| words[..idx].iter().map(move |b| (a.0 ^ b.0).count_ones()));
        pairs.min().expect("at least two words")
    }

    #[test]
    fn the_lexicode_has_128_words_at_distance_4() {
        let words = Coding::Lexicode.identities();
        assert_eq!((words.len(), distance(&words)), (128, 4));
    }

    #[test]
    fn the_hexads_are_132_at_distance_4_and_five_points_lie_in_exactly_one() {
        let words: Vec<MarkerId> = hexads().into_iter().map(MarkerId).collect();
        assert_eq!((words.len(), distance(&words)), (132, 4));
        assert!(words.iter().all(|word| word.0.count_ones() == 6));
        for points in (0u16..4096).filter(|points| points.count_ones() == 5) {
            assert_eq!(words.iter().filter(|word| word.0 & points == points).count(), 1);
        }
    }

    #[test]
    fn no_mirror_image_of_a_hexad_given_out_is_given_out() {
        let words = Coding::Hexads.identities();
        assert!(words.len() >= 100);
        for word in &words {
            // A mirror exchanges the places (i, j) and (j, i) of a marker's dots: corners X and Y change roles.
            let mirrored = MarkerId::from_dots(word.dots().map(|[i, j]| [j, i]));
            assert!(!words.contains(&mirrored), "{word:?}");
        }
    }

    #[test]
    fn no_number_of_covered_dots_turns_one_hexad_into_another() {
        let words = Coding::Hexads.identities();
        for word in &words {
            assert!(words.iter().all(|other| other == word || other.0 & word.0 != other.0));
        }
        // Unlike the hexads, the lexicode contains the identity 0, without any coded dot, which any marker becomes when all its coded dots are
        // covered.
        assert!(Coding::Lexicode.identities().contains(&MarkerId(0)));
    }

    #[test]
    fn the_table_knows_exactly_the_identities() {
        for (coding, count) in [(Coding::Plain, 4096), (Coding::Lexicode, 128), (Coding::Hexads, 118)] {
            assert_eq!(coding.table().iter().filter(|known| **known).count(), count);
        }
    }
}
