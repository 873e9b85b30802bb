// What is printed or grown on a tile: a relative change of albedo in [-1, 1] with mean near 0, faded out where it is
// finer than the pixel.

override PATTERN: u32 = 0u; // 0 plain, 1 speckle, 2 marble, 3 stripes

// One round of Chris Wellons' "lowbias32" hash; the lattice's products are mixed already.
fn lattice_value(h: u32) -> f32 {
    let m = (h ^ (h >> 15u)) * 0x846ca68bu;
    return f32(m >> 8u) * (2.0 / 16777216.0) - 1.0;
}

// Smooth noise in [-1, 1] on a unit lattice, interpolated with zero slope at its nodes.
fn value_noise(place: vec2<f32>, seed: u32) -> f32 {
    let cell = floor(place);
    let f = place - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let x0 = bitcast<u32>(i32(cell.x)) * 0x9e3779b1u;
    let y0 = bitcast<u32>(i32(cell.y)) * 0x85ebca77u + seed;
    let x1 = x0 + 0x9e3779b1u;
    let y1 = y0 + 0x85ebca77u;
    let low = mix(lattice_value(x0 ^ y0), lattice_value(x1 ^ y0), s.x);
    let high = mix(lattice_value(x0 ^ y1), lattice_value(x1 ^ y1), s.x);
    return mix(low, high, s.y);
}

// Weight of noise with this cell: all of it while the footprint is half a cell, nothing when it is a cell and a half.
fn band_limit(footprint_m: f32, cell_m: f32) -> f32 {
    return 1.0 - smoothstep(0.5, 1.5, footprint_m / cell_m);
}

// Grains of 5 mm with finer ones of 2.2 mm on them, as in stoneware.
fn speckle(place_m: vec2<f32>, footprint_m: f32, seed: u32) -> f32 {
    return 0.6 * value_noise(place_m / 0.005, seed) * band_limit(footprint_m, 0.005)
        + 0.4 * value_noise(place_m / 0.0022, seed + 0x51u) * band_limit(footprint_m, 0.0022);
}

// Clouds of 9 cm, bent by a second noise, with dark veins along their zero line.
fn marble(place_m: vec2<f32>, footprint_m: f32, seed: u32) -> f32 {
    let broad = value_noise(place_m / 0.09, seed);
    let bend = value_noise(place_m / 0.035, seed + 0x51u);
    let fine = value_noise(place_m / 0.012, seed + 0xa3u) * band_limit(footprint_m, 0.012);
    let cloud = 0.7 * broad + 0.3 * bend;
    // A vein is 3 to 10 mm wide where the cloud's slope is 1/9 cm; its mean, about 0.15, is put back.
    let from_vein = (cloud + 0.08 * fine) / 0.08;
    let vein = 1.0 / (1.0 + from_vein * from_vein);
    return 0.45 * cloud + 0.15 * fine - 0.6 * vein + 0.1;
}

// Integral from 0 of the printed stripe profile of period 1: -1 within 1/8 of the middle, +1/3 elsewhere, mean 0,
// so that whole periods add nothing.
fn stripe_integral(x: f32) -> f32 {
    let f = x - floor(x);
    return f / 3.0 - (4.0 / 3.0) * clamp(f - 0.375, 0.0, 0.25);
}

// Five dark stripes a tile, averaged over the footprint's width across them.
fn stripes(across_m: f32, width_m: f32, spacing_m: f32) -> f32 {
    let x = across_m / spacing_m;
    let half = 0.5 * width_m / spacing_m;
    return (stripe_integral(x + half) - stripe_integral(x - half)) / (2.0 * half);
}

// The pattern at a place counted from the tile's corner; every tile, by its seed, is cut from another place of the stone.
fn pattern_at(place_m: vec2<f32>, seed: u32, footprint_m: f32, across_m: f32, spacing_m: f32) -> f32 {
    if (PATTERN == 1u) {
        return speckle(place_m, footprint_m, seed);
    }
    if (PATTERN == 2u) {
        return marble(place_m, footprint_m, seed);
    }
    if (PATTERN == 3u) {
        return stripes(place_m.x, across_m, spacing_m);
    }
    return 0.0;
}
