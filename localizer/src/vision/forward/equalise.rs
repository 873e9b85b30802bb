//! Histogram equalisation, over the whole image or by tiles with limited contrast (CLAHE; Zuiderveld, Graphics Gems IV, 1994).

use super::Picture;

/// Number of grey levels that the equalisation distinguishes.
const LEVELS: usize = 256;

/// Equalises an image: every value is replaced by the share of pixels that are not brighter, scaled to 0 to 255.
pub fn equalised(picture: &Picture) -> Picture {
    let scale = Scale::of(picture);
    let ranks = ranks(picture.values.iter().map(|&value| scale.level(value)), f64::INFINITY);
    picture.map(|value| ranks[scale.level(value)])
}

/// Equalises an image tile by tile, with the histogram's counts limited to `limit` times their mean; results are interpolated between tiles.
pub fn equalised_by_tiles(picture: &Picture, tiles: [usize; 2], limit: f64) -> Picture {
    let scale = Scale::of(picture);
    let (wide, high) = (picture.width.div_ceil(tiles[0]), picture.height.div_ceil(tiles[1]));
    let of_tile = |column: usize, row: usize| {
        let rows = (row * high).min(picture.height)..((row + 1) * high).min(picture.height);
        let columns = (column * wide).min(picture.width)..((column + 1) * wide).min(picture.width);
        let levels = rows.flat_map(|v| columns.clone().map(move |u| (u, v)));
        ranks(levels.map(|(u, v)| scale.level(picture.at(u, v))), limit)
    };
    let maps: Vec<Vec<f32>> = (0..tiles[1])
        .flat_map(|row| (0..tiles[0]).map(move |column| (column, row)))
        .map(|(c, r)| of_tile(c, r))
        .collect();
    let mut values = Vec::with_capacity(picture.values.len());
    for v in 0..picture.height {
        let [top, bottom, below] = between(v, high, tiles[1]);
        for u in 0..picture.width {
            let [left, right, beside] = between(u, wide, tiles[0]);
            let level = scale.level(picture.at(u, v));
            let at = |row: f32, column: f32| maps[row as usize * tiles[0] + column as usize][level];
            values.push(
                (at(top, left) * (1.0 - beside) + at(top, right) * beside) * (1.0 - below)
                    + (at(bottom, left) * (1.0 - beside) + at(bottom, right) * beside) * below,
            );
        }
    }
    Picture { values, ..*picture }
}

/// Along one image axis, the two tiles of the equalisation whose middles lie before and after a pixel, and the weight of the second tile in the
/// interpolation between them.
fn between(at: usize, size: usize, tiles: usize) -> [f32; 3] {
    let place = ((at as f32 + 0.5) / size as f32 - 0.5).clamp(0.0, tiles as f32 - 1.0);
    let first = place.floor();
    [first, (first + 1.0).min(tiles as f32 - 1.0), place - first]
}

/// Mapping of an image's values to the grey levels of the histogram.
struct Scale {
    least: f32,
    levels_per_value: f32,
}

impl Scale {
    fn of(picture: &Picture) -> Scale {
        let least = picture.values.iter().copied().fold(f32::INFINITY, f32::min);
        let greatest = picture.values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        // If the image's values differ by less than the number of grey levels, a difference of 1 in value stays a difference of one grey level.
        let levels_per_value =
            if greatest - least < LEVELS as f32 { 1.0 } else { (LEVELS - 1) as f32 / (greatest - least) };
        Scale { least, levels_per_value }
    }

    fn level(&self, value: f32) -> usize {
        (((value - self.least) * self.levels_per_value) as usize).min(LEVELS - 1)
    }
}

/// For each grey level, 255 times the share of pixels at or below that level. The histogram's counts are limited to `limit` times their mean, and
/// what exceeds the limit is spread evenly over all levels.
fn ranks(levels: impl Iterator<Item = usize>, limit: f64) -> Vec<f32> {
    let mut counts = vec![0.0_f64; LEVELS];
    levels.for_each(|level| counts[level] += 1.0);
    let total: f64 = counts.iter().sum();
    let most = limit * total / LEVELS as f64;
    let cut: f64 = counts.iter().map(|count| (count - most).max(0.0)).sum();
    let mut sum = 0.0;
    counts
        .iter()
        .map(|count| {
            sum += count.min(most) + cut / LEVELS as f64;
            (255.0 * sum / total.max(1.0)) as f32
        })
        .collect()
}
