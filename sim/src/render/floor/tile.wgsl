// The face of one tile: its albedo and its pattern, smeared along the path of the exposure.

struct Tile {
    // Corners (0, 0), (1, 0), (0, 1), (1, 1), two to a vector.
    @location(0) low_corners: vec4<f32>,
    @location(1) high_corners: vec4<f32>,
    // Where the tile's own coordinates begin.
    @location(2) anchor: vec2<f32>,
    @location(3) albedo: f32,
    @location(4) seed: u32,
}

struct Face {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) anchor: vec2<f32>,
    @location(1) @interpolate(flat) albedo: f32,
    @location(2) @interpolate(flat) seed: u32,
    // From storage it would be loaded pixel by pixel.
    @location(3) @interpolate(flat) samples: u32,
}

@vertex
fn tile_corner(@builtin(vertex_index) index: u32, tile: Tile) -> Face {
    let pair = select(tile.low_corners, tile.high_corners, index >= 2u);
    let corner = select(pair.xy, pair.zw, (index & 1u) == 1u);
    return Face(clip_at(corner), tile.anchor, tile.albedo, tile.seed, counted.pattern_samples);
}

@fragment
fn tile_luminance(face: Face) -> @location(0) vec4<f32> {
    let pixel = pixel_at(face.position);
    let middle = place_at(view.middle, pixel);
    var albedo = face.albedo;
    if (PATTERN != 0u) {
        let start = place_at(view.start, pixel);
        let end = place_at(view.end, pixel);
        // The parabola through three points of the path.
        let bend = 2.0 * (start - 2.0 * middle + end);
        let speed = end - start - bend;
        let sides = sides_at(view.middle, pixel, middle);
        let step = 1.0 / f32(view.pattern_samples);
        let extent = abs(sides[0]) + abs(sides[1]) + step * abs(end - start);
        let size_m = 0.5 * (extent.x + extent.y);
        var sum = 0.0;
        for (var sample = 0u; sample < face.samples; sample++) {
            let time = (f32(sample) + 0.5) * step;
            let place = start + time * (speed + time * bend);
            sum += pattern_at(place - face.anchor, face.seed, size_m, extent.x);
        }
        albedo *= 1.0 + view.pattern_contrast * step * sum;
    }
    return vec4(albedo * light_at(middle), 0.0, 0.0, 1.0);
}
