// The face of one tile: its albedo and its pattern, smeared along the path of the exposure.

struct Tile {
    // Corners (0, 0), (1, 0), (0, 1), (1, 1), two to a vector.
    @location(0) low_corners: vec4<f32>,
    @location(1) high_corners: vec4<f32>,
    // Where the tile's own coordinates begin.
    @location(2) anchor: vec2<f32>,
    @location(3) albedo: f32,
    @location(4) seed: u32,
    // 0 if its corners are nowhere to be seen.
    @location(5) ends: u32,
}

struct Face {
    @builtin(position) position: vec4<f32>,
    // Homographies at the start, in the middle and at the end of the exposure, row by row.
    @location(0) @interpolate(flat) start_x: vec3<f32>,
    @location(1) @interpolate(flat) start_y: vec3<f32>,
    @location(2) @interpolate(flat) start_depth: vec3<f32>,
    @location(3) @interpolate(flat) middle_x: vec3<f32>,
    @location(4) @interpolate(flat) middle_y: vec3<f32>,
    @location(5) @interpolate(flat) middle_depth: vec3<f32>,
    @location(6) @interpolate(flat) end_x: vec3<f32>,
    @location(7) @interpolate(flat) end_y: vec3<f32>,
    @location(8) @interpolate(flat) end_depth: vec3<f32>,
    // Where the tile's own coordinates begin, and the principal point.
    @location(9) @interpolate(flat) anchor_and_centre: vec4<f32>,
    // Of the light its gradient and its luminance at the local origin; the tile's albedo.
    @location(10) @interpolate(flat) light: vec4<f32>,
    // Contrast of the pattern, share of the path in one of its samples, distance between printed stripes.
    @location(11) @interpolate(flat) pattern: vec3<f32>,
    @location(12) @interpolate(flat) seed_and_samples: vec2<u32>,
}

@vertex
fn tile_corner(@builtin(vertex_index) index: u32, tile: Tile) -> Face {
    let pair = select(tile.low_corners, tile.high_corners, index >= 2u);
    let corner = select(pair.xy, pair.zw, (index & 1u) == 1u);
    return Face(
        clip_at(select(corner, on_its_row(corner), tile.ends == 1u)),
        view.start.x.xyz,
        view.start.y.xyz,
        view.start.depth.xyz,
        view.middle.x.xyz,
        view.middle.y.xyz,
        view.middle.depth.xyz,
        view.end.x.xyz,
        view.end.y.xyz,
        view.end.depth.xyz,
        vec4(tile.anchor, view.principal_point_px),
        vec4(view.light_gradient, view.light_at_origin, tile.albedo),
        vec3(view.pattern_contrast, 1.0 / f32(view.pattern_samples), view.stripe_spacing_m),
        vec2(tile.seed, counted.pattern_samples),
    );
}

fn homography(x: vec3<f32>, y: vec3<f32>, depth: vec3<f32>) -> Homography {
    return Homography(vec4(x, 0.0), vec4(y, 0.0), vec4(depth, 0.0));
}

@fragment
fn tile_luminance(face: Face) -> @location(0) vec4<f32> {
    let pixel = vec3(face.position.xy - 0.5 - face.anchor_and_centre.zw, 1.0);
    let in_the_middle = homography(face.middle_x, face.middle_y, face.middle_depth);
    var middle = place_at(in_the_middle, pixel);
    var albedo = face.light.w;
    if (PATTERN != 0u || ROLLING) {
        let start = place_at(homography(face.start_x, face.start_y, face.start_depth), pixel);
        let end = place_at(homography(face.end_x, face.end_y, face.end_depth), pixel);
        let way = way_through(start, middle, end);
        var exposed = vec2(0.0, 1.0);
        if (ROLLING) {
            exposed = vec2(exposed_from(pixel), view.exposed_share);
            middle = on_way(way, exposed.x + 0.5 * exposed.y);
        }
        if (PATTERN != 0u) {
            let sides = sides_at(in_the_middle, pixel, middle);
            let step = face.pattern.y;
            let extent = abs(sides[0]) + abs(sides[1]) + step * exposed.y * abs(end - start);
            let size_m = 0.5 * (extent.x + extent.y);
            var sum = 0.0;
            for (var sample = 0u; sample < face.seed_and_samples.y; sample++) {
                let place = on_way(way, exposed.x + exposed.y * ((f32(sample) + 0.5) * step));
                sum += pattern_at(place - face.anchor_and_centre.xy, face.seed_and_samples.x, size_m, extent.x, face.pattern.z);
            }
            albedo *= 1.0 + face.pattern.x * step * sum;
        }
    }
    return vec4(albedo * face.light.z * exp(dot(face.light.xy, middle)), 0.0, 0.0, 1.0);
}
