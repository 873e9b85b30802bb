//! Pruning of a skeleton: removes small components and spurs (paper 1, section 3.1).

use super::Binary;

/// Least number of pixels of a component of the skeleton; smaller ones are specks. A tile joint that matters crosses more of the image than this.
const COMPONENT_MIN_PX: usize = 40;
/// Greatest length of a spur: a branch of the skeleton with a free end. Spurs are about half a band's width long, or
/// come from the corners of the closed bands.
const SPUR_MAX_PX: usize = 12;

/// Removes spurs from a skeleton, then small components.
pub(super) fn pruned(mut skeleton: Binary) -> Binary {
    for end in (0..skeleton.pixels.len()).filter(|&index| skeleton.pixels[index]).collect::<Vec<_>>() {
        if skeleton.white_neighbours(end).len() == 1 {
            for index in spur(&skeleton, end) {
                skeleton.pixels[index] = false;
            }
        }
    }
    remove_small_components(&mut skeleton);
    skeleton
}

/// Pixels from a free end of the skeleton up to, but without, the junction from which the branch starts; none if the branch is longer than a spur.
fn spur(skeleton: &Binary, end: usize) -> Vec<usize> {
    let mut path = vec![end];
    while path.len() <= SPUR_MAX_PX {
        let here = path[path.len() - 1];
        let ahead: Vec<usize> =
            skeleton.white_neighbours(here).into_iter().filter(|next| !path.contains(next)).collect();
        match ahead.as_slice() {
            [next] => path.push(*next),
            // Two or more pixels ahead mean that this pixel of the skeleton is the junction. No pixel ahead means that the whole component ends here;
            // it is so short that it is removed later because of its size.
            [] => return Vec::new(),
            _ => {
                path.pop();
                return path;
            }
        }
    }
    Vec::new()
}

fn remove_small_components(skeleton: &mut Binary) {
    let mut seen = vec![false; skeleton.pixels.len()];
    for start in 0..skeleton.pixels.len() {
        if seen[start] || !skeleton.pixels[start] {
            continue;
        }
        seen[start] = true;
        let mut component = vec![start];
        let mut next = 0;
        while next < component.len() {
            for neighbour in skeleton.white_neighbours(component[next]) {
                if !seen[neighbour] {
                    seen[neighbour] = true;
                    component.push(neighbour);
                }
            }
            next += 1;
        }
        if component.len() < COMPONENT_MIN_PX {
            for index in component {
                skeleton.pixels[index] = false;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test skeleton: pixels 5 to 94 of one row, plus the given extra pixels.
    fn row_and(extra: impl Iterator<Item = (usize, usize)>) -> Binary {
        let mut picture = Binary { width: 100, height: 60, pixels: vec![false; 6000] };
        for (u, v) in (5..95).map(|u| (u, 30)).chain(extra) {
            picture.pixels[v * 100 + u] = true;
        }
        picture
    }

    #[test]
    fn a_spur_goes_and_its_line_stays() {
        let kept = pruned(row_and((24..30).map(|v| (50, v))));
        assert!((5..95).all(|u| kept.pixels[3000 + u]));
        assert!((24..28).all(|v| !kept.pixels[v * 100 + 50]));
    }

    #[test]
    fn a_speck_goes_and_a_long_branch_stays() {
        let kept = pruned(row_and((10..30).map(|v| (50, v)).chain((70..80).map(|u| (u, 50)))));
        assert!((12..28).all(|v| kept.pixels[v * 100 + 50]));
        assert!((70..80).all(|u| !kept.pixels[5000 + u]));
    }
}
