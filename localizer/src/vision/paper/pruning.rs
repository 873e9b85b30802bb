//! Pruning of a skeleton: small components and spurs (paper 1, section 3.1).

use super::Binary;

/// Components with fewer pixels are specks: a joint that matters crosses more of the picture than this.
const COMPONENT_MIN_PX: usize = 40;
/// Branches up to this length that end blind at a junction are spurs: half a band's width, and the corners of its closing.
const SPUR_MAX_PX: usize = 12;

/// Removes spurs, then small components.
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

/// Pixels from a blind end up to, without, the junction it hangs on; nothing if the branch is longer than a spur.
fn spur(skeleton: &Binary, end: usize) -> Vec<usize> {
    let mut path = vec![end];
    while path.len() <= SPUR_MAX_PX {
        let here = path[path.len() - 1];
        let ahead: Vec<usize> =
            skeleton.white_neighbours(here).into_iter().filter(|next| !path.contains(next)).collect();
        match ahead.as_slice() {
            [next] => path.push(*next),
            // Two ways on: this pixel is the junction. None: the whole component is this short, and goes by its size.
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
