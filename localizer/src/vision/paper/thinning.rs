//! Thinning of bands to a skeleton one pixel wide (Zhang and Suen 1984; the skeletonisation of paper 1, section 3.1).

use super::Binary;

/// Thins every white band to its centre line; connected bands stay connected.
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

/// Whether a white pixel can be removed, by Zhang and Suen's conditions (a) to (d), or the primed ones in the second pass. `p` contains the
/// neighbours P2 to P9, clockwise from the pixel above.
fn is_removable(p: &[bool; 8], pass: usize) -> bool {
    let count = p.iter().filter(|&&white| white).count();
    let rises = (0..8).filter(|&at| !p[at] && p[(at + 1) % 8]).count();
    let [above, right, below, left] = [p[0], p[2], p[4], p[6]];
    // Zhang and Suen's thinning conditions are P2·P4·P6 = P4·P6·P8 = 0 in the first pass, and P2·P4·P8 = P2·P6·P8 = 0 in the second.
    let open = if pass == 0 { !(right && below && (above || left)) } else { !(above && left && (right || below)) };
    (2..=6).contains(&count) && rises == 1 && open
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_thinned_to_its_middle_row() {
        let mut band = Binary { width: 80, height: 40, pixels: vec![false; 3200] };
        for index in (16..23).flat_map(|v| (10..70).map(move |u| v * 80 + u)) {
            band.pixels[index] = true;
        }
        let thin = skeleton(band);
        for u in 16..64 {
            let column: Vec<usize> = (0..40).filter(|v| thin.pixels[v * 80 + u]).collect();
            assert!(column.len() == 1 && column[0].abs_diff(19) <= 1, "column {u}: {column:?}");
        }
    }
}
