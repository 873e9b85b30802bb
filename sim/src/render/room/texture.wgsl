// What is on surfaces: a factor on their albedo with mean near 1, faded out where it is finer than the pixel.

override TEXTURE: u32 = 0u; // 0 plain, 1 plaster, 2 tiles, 3 concrete, 4 wood, 5 carpet, 6 picture, 7 wet, 8 chessboard, 9 facade, 10 asphalt, 11 books

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

// 1 within a rectangle around the origin, 0 outside, averaged over a pixel.
fn rectangle(at: vec2<f32>, half: vec2<f32>, extent: vec2<f32>) -> f32 {
    let inside = clamp((half - abs(at)) / max(extent, vec2(1e-3)) + 0.5, vec2(0.0), vec2(1.0));
    return inside.x * inside.y;
}

// What of a window or a door is seen, as a factor on the facade's albedo: frame, panes and what is behind them. `at` is from the middle.
fn opening(at: vec2<f32>, half: vec2<f32>, extent: vec2<f32>, pixel_m: f32, seed: u32, is_door: bool) -> f32 {
    let tone = 0.5 + 0.5 * cell_value(vec2(3.0, 1.0), seed);
    let frame = mix(0.5, 2.2, 0.5 + 0.5 * cell_value(vec2(4.0, 1.0), seed));
    let mirrored = 0.4 * noise(at * 2.5, seed) + 0.3 * noise(at * 9.0, seed + 1u) * resolved(pixel_m, 0.1);
    var inner = mix(0.12, 0.45, tone) * (1.0 + mirrored);
    if (is_door) {
        // Panels of wood, and a handle.
        inner = mix(0.35, 1.3, tone) * (1.0 + 0.12 * noise(at * vec2(30.0, 2.0), seed) * resolved(pixel_m, 0.03));
        let panel = rectangle(vec2(abs(at.x) - 0.5 * half.x, abs(at.y) - 0.5 * half.y), 0.33 * half, extent);
        inner *= 1.0 - 0.35 * panel * (0.6 + 0.4 * cell_value(sign(at), seed + 5u));
        inner = mix(inner, 2.4, rectangle(at - vec2(0.75 * half.x, -0.05), vec2(0.05, 0.02), extent));
        return mix(frame, inner, rectangle(at, half - 0.07, extent));
    }
    // A curtain or a blind, lowered to some height.
    let lowered = half.y * (1.0 - 1.7 * max(cell_value(vec2(5.0, 2.0), seed), 0.0));
    let curtain = 1.5 + 0.3 * noise(at * vec2(14.0, 1.0), seed + 2u) * resolved(pixel_m, 0.07);
    inner = mix(inner, curtain, clamp((at.y - lowered) / max(extent.y, 0.01) + 0.5, 0.0, 1.0));
    // Bars: one upright in the middle, one across above it.
    let upright = rectangle(vec2(at.x, 0.0), vec2(0.03, 1.0), extent);
    let bars = max(upright, rectangle(vec2(0.0, at.y - 0.3 * half.y), vec2(1.0, 0.03), extent));
    return mix(frame, mix(inner, frame, bars), rectangle(at, half - 0.06, extent));
}

// Tone of one brick: each has its own, and some are burnt darker or were replaced by paler ones.
fn brick_tone(brick: vec2<f32>, seed: u32) -> f32 {
    let own = cell_value(brick, seed + 1u);
    return 0.2 * own + select(0.0, 0.4 * sign(own), abs(cell_value(brick, seed + 2u)) > 0.93);
}

// The tones of the bricks of one row, averaged over `wide` metres around x.
fn row_tone(x: f32, row: f32, wide: f32, seed: u32) -> f32 {
    let shifted = x + 0.12 * (row - 2.0 * floor(0.5 * row));
    let high = floor((shifted + 0.5 * wide) / 0.24);
    let share = clamp((shifted + 0.5 * wide - 0.24 * high) / wide, 0.0, 1.0);
    return mix(brick_tone(vec2(high - 1.0, row), seed), brick_tone(vec2(high, row), seed), share);
}

// Bricks of 0.24 by 0.08 m, laid in halves, with windows at irregular distances, doors at the ground, plinth and stains.
fn facade(place: vec2<f32>, extent: vec2<f32>, pixel_m: f32, size: vec2<f32>, seed: u32) -> f32 {
    let row = floor(place.y / 0.08);
    let shifted = place.x + 0.12 * (row - 2.0 * floor(0.5 * row));
    // Averaged over the pixel's extent: steps from pixel to pixel would flicker as the camera moves.
    let wide = clamp(extent, vec2(1e-3), vec2(0.24, 0.08));
    let high = floor((place.y + 0.5 * wide.y) / 0.08);
    let share = clamp((place.y + 0.5 * wide.y - 0.08 * high) / wide.y, 0.0, 1.0);
    let tone = mix(row_tone(place.x, high - 1.0, wide.x, seed), row_tone(place.x, high, wide.x, seed), share);
    let seams = max(bands_share(place.y, extent.y, 0.08, 0.01), bands_share(shifted, extent.x, 0.24, 0.01));
    var wall = 1.0 + tone * resolved(pixel_m, 0.1) + 0.06 * noise(place / 0.02, seed + 3u) * resolved(pixel_m, 0.02);
    wall = mix(wall, 1.35, seams * 0.8);
    // Patches of render, stains and damp.
    let stain = 0.14 * noise(place / vec2(0.35, 0.6), seed + 5u) * resolved(pixel_m, 0.3);
    wall *= 1.0 + 0.18 * noise(place / vec2(1.7, 1.1), seed + 4u) + stain;
    let render_edge = noise(place / 0.9, seed + 6u) + 0.35 * noise(place / 0.21, seed + 7u) - 0.5;
    let render = 1.5 + 0.1 * noise(place / 0.1, seed + 8u) * resolved(pixel_m, 0.1);
    wall = mix(wall, render, clamp(render_edge / max(2.0 * pixel_m, 0.03), 0.0, 1.0));
    let plinth = clamp((0.45 - place.y) / max(extent.y, 1e-3) + 0.5, 0.0, 1.0);
    wall = mix(wall, 0.62 + 0.1 * noise(place / 0.25, seed + 9u), plinth);
    // A bay of 2.6 m has a window in most storeys of 3 m, and at the ground sometimes a door or nothing.
    let bay = floor(place.x / 2.6);
    let storey = floor(place.y / 3.0);
    let here = vec2(bay, storey);
    let is_door = storey == 0.0 && cell_value(here, seed + 20u) > 0.45;
    let is_over = (bay + 1.0) * 2.6 > size.x || (storey + 1.0) * 3.0 > size.y + 0.9;
    let is_bare = is_over || cell_value(here, seed + 21u) > 0.72;
    let jitter = vec2(cell_value(here, seed + 22u), cell_value(here, seed + 23u));
    let own_seed = seed * 31u + u32(i32(bay) * 17 + i32(storey) * 7 + 4000);
    var half = vec2(0.52 + 0.16 * cell_value(here, seed + 24u), 0.7 + 0.12 * cell_value(here, seed + 25u));
    var middle = vec2((bay + 0.5) * 2.6 + 0.3 * jitter.x, storey * 3.0 + 1.75 + 0.1 * jitter.y);
    if (is_door) {
        half = vec2(0.55 + 0.1 * cell_value(here, seed + 24u), 1.1);
        middle.y = 1.1;
    }
    let at = place - middle;
    if (!is_bare) {
        // A lintel of stone above, a sill below.
        let lintel = rectangle(at - vec2(0.0, half.y + 0.09), vec2(half.x + 0.14, 0.09), extent);
        let sill = rectangle(at + vec2(0.0, half.y + 0.04), vec2(half.x + 0.1, 0.04), extent);
        wall = mix(wall, 1.75 + 0.25 * cell_value(here, seed + 26u), max(lintel, select(sill, 0.0, is_door)));
        wall = mix(wall, opening(at, half, extent, pixel_m, own_seed, is_door), rectangle(at, half, extent));
    }
    return clamp(wall, 0.05, 2.6);
}

// Asphalt: stones in tar, worn and oily spots, mended patches, and cracks along the borders of irregular cells.
fn asphalt(place: vec2<f32>, pixel_m: f32, seed: u32) -> f32 {
    let grit = 0.3 * noise(place / 0.009, seed + 30u) * resolved(pixel_m, 0.009);
    let stones = grit + 0.16 * noise(place / 0.03, seed + 31u) * resolved(pixel_m, 0.03);
    let worn = 0.14 * noise(place / 1.9, seed + 32u) + 0.1 * noise(place / 0.45, seed + 33u) * resolved(pixel_m, 0.45);
    var tone = 1.0 + stones + worn;
    let cell = floor(place / 0.8);
    var nearest = 9.0;
    var second = 9.0;
    for (var dy = -1; dy <= 1; dy++) {
        for (var dx = -1; dx <= 1; dx++) {
            let other = cell + vec2(f32(dx), f32(dy));
            let jitter = vec2(cell_value(other, seed + 34u), cell_value(other, seed + 35u));
            let centre = (other + 0.5 + 0.42 * jitter) * 0.8;
            let away = length(centre - place);
            // A spot of oil or of chewing gum, or a leaf, around some centres.
            let kind = cell_value(other, seed + 36u);
            let radius = 0.025 + 0.11 * pow(abs(cell_value(other, seed + 37u)), 3.0);
            let ragged = away + 0.5 * radius * noise(place / (0.8 * radius), seed + 45u);
            let spot = clamp((radius - ragged) / max(pixel_m, 0.4 * radius) + 0.5, 0.0, 1.0);
            tone = mix(tone, select(0.5, 1.55, kind > 0.3) + 0.5 * stones, spot * select(0.0, 0.8, abs(kind) > 0.55));
            second = min(second, max(nearest, away));
            nearest = min(nearest, away);
        }
    }
    // Cracks only where the ground has settled.
    let settled = smoothstep(0.0, 0.3, noise(place / 3.1, seed + 38u));
    let wander = 0.03 * noise(place / 0.07, seed + 39u);
    let fine = max(pixel_m, 0.004);
    let crack = clamp((0.014 - abs(second - nearest + wander)) / fine + 0.5, 0.0, 1.0) * min(1.0, 0.03 / fine);
    tone = mix(tone, 0.35, settled * crack * 0.9);
    // Patches of newer asphalt, 1.2 by 0.9 m and larger.
    let square = floor(place / 5.0);
    let middle = (square + 0.5 + 0.25 * vec2(cell_value(square, seed + 40u), cell_value(square, seed + 41u))) * 5.0;
    let half = 0.6 + 0.5 * abs(vec2(cell_value(square, seed + 42u), cell_value(square, seed + 43u)));
    let is_mended = cell_value(square, seed + 44u) > -0.2;
    let patch_share = rectangle(place - middle, half, vec2(max(pixel_m, 0.01))) * select(0.0, 1.0, is_mended);
    return clamp(mix(tone, 0.6 * (0.9 + stones), patch_share), 0.1, 2.6);
}

// Where the book with this number begins on its board: books are 0.03 to 0.06 m thick.
fn book_begins(book: f32, board: f32, seed: u32) -> f32 {
    return (book + 0.3 * cell_value(vec2(book, board), seed)) * 0.045;
}

// The back of one book, as a factor on the mean, with its title as a lighter or darker field; above it the shadow of the board. `up` is from the board
// that it stands on, in a compartment of this height.
fn book(number: f32, board: f32, up: f32, high: f32, extent: vec2<f32>, seed: u32) -> f32 {
    let here = vec2(number, board);
    // Here and there a book has been taken out.
    let tall = select(high * (0.72 + 0.2 * cell_value(here, seed + 1u)), 0.0, cell_value(here, seed + 2u) > 0.84);
    let tone = 1.15 + 0.85 * cell_value(here, seed + 3u);
    let title_at = tall * (0.66 + 0.14 * cell_value(here, seed + 4u));
    let in_title = clamp((0.1 * tall - abs(up - title_at)) / max(extent.y, 1e-3) + 0.5, 0.0, 1.0);
    let back = mix(tone, select(0.35, 1.9, cell_value(here, seed + 5u) > 0.0), 0.8 * in_title);
    return mix(0.25, back, clamp((tall - up) / max(extent.y, 1e-3) + 0.5, 0.0, 1.0));
}

// Books on boards 0.32 m above each other, between upright boards of 0.03 m at both sides.
fn books(place: vec2<f32>, extent: vec2<f32>, pixel_m: f32, size: vec2<f32>, seed: u32) -> f32 {
    let boards = max(floor(size.y / 0.32), 1.0);
    let spacing = size.y / boards;
    let board = floor(place.y / spacing);
    let up = place.y - board * spacing - 0.02;
    // The nearest beginning of a book, and the books on both sides of it.
    var nearest = floor(place.x / 0.045 + 0.5);
    let off = abs(place.x - book_begins(nearest, board, seed));
    if (abs(place.x - book_begins(nearest - 1.0, board, seed)) < off) {
        nearest -= 1.0;
    } else if (abs(place.x - book_begins(nearest + 1.0, board, seed)) < off) {
        nearest += 1.0;
    }
    let share = clamp((place.x - book_begins(nearest, board, seed)) / max(extent.x, 1e-3) + 0.5, 0.0, 1.0);
    let left = book(nearest - 1.0, board, up, spacing - 0.02, extent, seed);
    let right = book(nearest, board, up, spacing - 0.02, extent, seed);
    let shelved = mix(1.0, mix(left, right, share), resolved(pixel_m, 0.045));
    // Boards are centred on multiples of the spacing, so that the lowest and the highest show half.
    let level = bands_share(place.y, extent.y, spacing, 0.04);
    let side = 1.0 - rectangle(place - 0.5 * size, vec2(0.5 * size.x - 0.03, size.y), extent);
    return mix(shelved, 1.3, max(level, side));
}
