// What is on surfaces: a factor on their albedo with mean near 1, faded out where it is finer than the pixel.

override TEXTURE: u32 = 0u; // 0 plain, 1 plaster, 2 tiles, 3 concrete, 4 wood, 5 carpet, 6 picture, 7 wet, 8 chessboard

// Chris Wellons' "lowbias32", one round, as in the floor's pattern.
fn lattice_value(h: u32) -> f32 {
    let m = (h ^ (h >> 15u)) * 0x846ca68bu;
    return f32(m >> 8u) * (2.0 / 16777216.0) - 1.0;
}

fn cell_value(cell: vec2<f32>, seed: u32) -> f32 {
    return lattice_value((bitcast<u32>(i32(cell.x)) * 0x9e3779b1u) ^ (bitcast<u32>(i32(cell.y)) * 0x85ebca77u + seed * 0xc2b2ae35u));
}

// Smooth noise in [-1, 1] on a unit lattice.
fn noise(place: vec2<f32>, seed: u32) -> f32 {
    let cell = floor(place);
    let f = place - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let low = mix(cell_value(cell, seed), cell_value(cell + vec2(1.0, 0.0), seed), s.x);
    let high = mix(cell_value(cell + vec2(0.0, 1.0), seed), cell_value(cell + vec2(1.0, 1.0), seed), s.x);
    return mix(low, high, s.y);
}

// 1 where a grain of this size is resolved, 0 from two grains a pixel on.
fn resolved(pixel_m: f32, grain_m: f32) -> f32 {
    return clamp(1.5 - pixel_m / grain_m, 0.0, 1.0);
}

// Integral from 0 of the indicator of bands of a width around all multiples of a spacing.
fn bands_integral(x: f32, spacing: f32, width: f32) -> f32 {
    let nearest = floor(x / spacing + 0.5);
    return nearest * width + clamp(x - nearest * spacing, -0.5 * width, 0.5 * width);
}

// Share of a pixel of this extent that such bands cover.
fn bands_share(x: f32, extent: f32, spacing: f32, width: f32) -> f32 {
    let wide = max(extent, 1e-5);
    return (bands_integral(x + 0.5 * wide, spacing, width) - bands_integral(x - 0.5 * wide, spacing, width)) / wide;
}

fn plaster(place: vec2<f32>, pixel_m: f32, seed: u32) -> f32 {
    return 1.0 + 0.015 * noise(place * 2.3, seed) + 0.02 * noise(place / 0.012, seed) * resolved(pixel_m, 0.012);
}

// In infrared as much brighter as the surface's own mean is.
fn tiles(world: vec2<f32>, extent: vec2<f32>, pixel_m: f32, grid: Grid) -> f32 {
    let turned = vec2(grid.turn.x * world.x + grid.turn.y * world.y, grid.turn.x * world.y - grid.turn.y * world.x);
    let place = turned - grid.phase_m;
    // The extents along world axes, turned, bound those along the grid's.
    let wide = abs(grid.turn.x) * extent + abs(grid.turn.y) * extent.yx;
    let joint = 1.0 - (1.0 - bands_share(place.x, wide.x, grid.edge_m.x, grid.joint_width_m))
        * (1.0 - bands_share(place.y, wide.y, grid.edge_m.y, grid.joint_width_m));
    let tile = vec2<i32>(floor(place / grid.edge_m));
    let index = clamp(tile - grid.first, vec2(0), grid.count - 1);
    let own = tile_albedo[index.x * grid.count.y + index.y];
    let known = mix(grid.mean_albedo, own, resolved(pixel_m, 0.5 * grid.edge_m.x));
    var albedo = known;
    if (grid.pattern_contrast > 0.0) {
        let seed = u32(tile.x * 131 + tile.y + 70000);
        let fine = noise(place / 0.006, seed) * resolved(pixel_m, 0.006);
        let broad = noise(place / 0.05, seed + 7u) * resolved(pixel_m, 0.05);
        albedo *= 1.0 + grid.pattern_contrast * (0.6 * fine + 0.4 * broad);
    }
    return mix(albedo, grid.joint_albedo, joint) / max(grid.mean_albedo, 1e-3);
}

fn concrete(place: vec2<f32>, pixel_m: f32, seed: u32) -> f32 {
    let clouds = noise(place / 0.7, seed) + 0.5 * noise(place / 0.23, seed + 1u);
    let fine = noise(place / 0.03, seed + 2u) * resolved(pixel_m, 0.03) + noise(place / 0.008, seed + 3u) * resolved(pixel_m, 0.008);
    return 1.0 + 0.1 * clouds + 0.05 * fine;
}

// Boards of 0.14 m by 1.6 m along x, laid in thirds, with grain and dark seams.
fn wood(place: vec2<f32>, extent: vec2<f32>, pixel_m: f32) -> f32 {
    let row = floor(place.y / 0.14);
    let shifted = place.x + 1.6 * fract(row * 0.37);
    let board = vec2(floor(shifted / 1.6), row);
    let tone = cell_value(board, 11u) * resolved(pixel_m, 0.07);
    let bend = noise(vec2(place.x / 0.5, place.y / 0.05), u32(i32(row) + 9000));
    let grain = noise(vec2(place.x / 0.25, place.y / 0.006 + 3.0 * bend), u32(i32(board.x) * 57 + i32(row) + 5000));
    let seams = bands_share(place.y, extent.y, 0.14, 0.0015) + bands_share(shifted, extent.x, 1.6, 0.0015);
    return (1.0 + 0.16 * tone + 0.1 * grain * resolved(pixel_m, 0.006) + 0.05 * bend * resolved(pixel_m, 0.05)) * (1.0 - 0.7 * min(seams, 1.0));
}

// Loops of 5 mm that shade each other, a woven figure, and a border.
fn carpet(world: vec2<f32>, place: vec2<f32>, size: vec2<f32>, pixel_m: f32) -> f32 {
    let loops = noise(world / vec2(0.005, 0.004), 3u) * resolved(pixel_m, 0.005);
    let tufts = noise(world / 0.02, 4u) * resolved(pixel_m, 0.02);
    let trodden = noise(world / 0.35, 5u);
    let from_edge = min(min(place.x, size.x - place.x), min(place.y, size.y - place.y));
    let soft = max(pixel_m, 0.004);
    let border = smoothstep(0.08 - soft, 0.08 + soft, from_edge) - smoothstep(0.13 - soft, 0.13 + soft, from_edge);
    let diamond = abs(fract(place.x / 0.32) - 0.5) + abs(fract(place.y / 0.32) - 0.5);
    let figure = smoothstep(0.24, 0.24 + soft / 0.32, diamond) * resolved(pixel_m, 0.08) * step(0.16, from_edge);
    return (1.0 + 0.9 * border + 0.35 * figure) * (1.0 + 0.45 * loops + 0.18 * tufts + 0.07 * trodden);
}

// A dark frame, a white mount, and hills under a sky.
fn picture(place: vec2<f32>, size: vec2<f32>, pixel_m: f32, seed: u32) -> f32 {
    let from_edge = min(min(place.x, size.x - place.x), min(place.y, size.y - place.y));
    let soft = max(0.7 * pixel_m, 0.0005);
    let in_mount = smoothstep(0.025 - soft, 0.025 + soft, from_edge);
    let in_paint = smoothstep(0.09 - soft, 0.09 + soft, from_edge);
    let at = place / size;
    var paint = 1.5 - 0.5 * at.y + 0.15 * noise(at * vec2(3.0, 7.0), seed);
    for (var hill = 0u; hill < 3u; hill++) {
        let base = 0.62 - 0.17 * f32(hill);
        let edge = base + 0.1 * noise(vec2(at.x * (3.0 + f32(hill)), 0.5), seed * 7u + hill);
        let below = smoothstep(0.006, -0.006, at.y - edge);
        let tone = 0.9 - 0.3 * f32(hill) + 0.25 * noise(at * 22.0, seed + hill) * resolved(pixel_m, 0.03);
        paint = mix(paint, max(tone, 0.1), below);
    }
    return mix(0.2, mix(1.8, paint, in_paint), in_mount);
}

// 1 within a puddle that fills most of its rectangle, 0 outside; its edge is as wide as a pixel's extent where that is more than its own.
fn puddle(place: vec2<f32>, extent: vec2<f32>, size: vec2<f32>) -> f32 {
    let from_middle = length((place / size - 0.5) * 2.0);
    let ragged = 0.82 + 0.16 * noise(place / 0.35, 21u) + 0.05 * noise(place / 0.09, 22u);
    let soft = max(0.02, length(extent / size));
    return smoothstep(soft, -soft, from_middle - ragged);
}

// Integral from 0 of the indicator of [0, end].
fn within_integral(x: f32, end: f32) -> f32 {
    return clamp(x, 0.0, end);
}

// Integral from 0 of 1 on even and −1 on odd unit cells of [0, end], 0 outside.
fn alternating_integral(x: f32, end: f32) -> f32 {
    let at = clamp(x, 0.0, end);
    return 1.0 - abs(at - 2.0 * floor(0.5 * at) - 1.0);
}

// Squares of albedo 0.05 and 0.85, black at the corner where the face begins, averaged over the pixel's extent along both sides;
// `seed` is 256 times the columns plus the rows.
fn chessboard(place: vec2<f32>, extent: vec2<f32>, size: vec2<f32>, seed: u32) -> f32 {
    let count = vec2(f32(seed / 256u), f32(seed % 256u));
    let square_m = size.y / (count.y + 2.0);
    // In squares from the first one's corner, the margin even on both sides.
    let at = (place - 0.5 * size) / square_m + 0.5 * count;
    let half = max(0.5 * extent / square_m, vec2(1e-4));
    let low = at - half;
    let high = at + half;
    let within_x = (within_integral(high.x, count.x) - within_integral(low.x, count.x)) / (2.0 * half.x);
    let within_y = (within_integral(high.y, count.y) - within_integral(low.y, count.y)) / (2.0 * half.y);
    let sign_x = (alternating_integral(high.x, count.x) - alternating_integral(low.x, count.x)) / (2.0 * half.x);
    let sign_y = (alternating_integral(high.y, count.y) - alternating_integral(low.y, count.y)) / (2.0 * half.y);
    // As factors on the mean of both albedos, which is the face's.
    return 1.0 + (0.4 / 0.45) * (1.0 - within_x * within_y - sign_x * sign_y);
}
