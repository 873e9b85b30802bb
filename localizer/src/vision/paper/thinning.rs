//! Thinning to a skeleton one pixel wide (Zhang and Suen 1984; paper 1, section 3.1: skeletonisation).

use super::Binary;

/// Thins every band to its centre line, keeping what is connected connected.
pub(super) fn skeleton(mut bands: Binary) -> Binary {
    let mut white: Vec<usize> = (0..bands.pixels.len()).filter(|&index| bands.pixels[index]).collect();
    let mut removed = Vec::new();
    loop {
        let before = white.len();
        for pass in 0..2 {
            removed.clear();
            removed.extend(white.iter().copied().filter(|&index| is_removable(&bands.neighbours(index), pass)));
            for &index in &removed {
                bands.pixels[index] = false;
            }
            white.retain(|&index| bands.pixels[index]);
        }
        if white.len() == before {
            return bands;
        }
    }
}

/// Zhang and Suen's conditions (a) to (d), primed in the second pass. `p` is P2 to P9: clockwise from the pixel above.
fn is_removable(p: &[bool; 8], pass: usize) -> bool {
    let count = p.iter().filter(|&&white| white).count();
    let rises = (0..8).filter(|&at| !p[at] && p[(at + 1) % 8]).count();
    let [above, right, below, left] = [p[0], p[2], p[4], p[6]];
    // P2·P4·P6 = P4·P6·P8 = 0, then P2·P4·P8 = P2·P6·P8 = 0.
    let open = if pass == 0 { !(right && below && (above || left)) } else { !(above && left && (right || below)) };
    (2..=6).contains(&count) && rises == 1 && open
}
