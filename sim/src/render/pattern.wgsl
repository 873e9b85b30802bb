// What pixels of a sensor differ by: the same in every image of a seed. Follows readout.wgsl.

// Takes the place of an image's number in what all images share.
const PATTERN_KEY: u32 = 0xFFFFFFFFu;

struct Sheet {
    @builtin(position) position: vec4<f32>,
    // Width of the picture, and both halves of the seed.
    @location(0) @interpolate(flat) key: vec3<u32>,
}

@vertex
fn pattern_corner(@builtin(vertex_index) index: u32) -> Sheet {
    return Sheet(whole_picture(index), vec3(readout.size_px.x, readout.seed));
}

// Two normal variables of every pixel, for its sensitivity and its offset, in bytes.
@fragment
fn lay_pattern(sheet: Sheet) -> @location(0) vec2<f32> {
    let place = vec2<u32>(sheet.position.xy);
    let own = pcg4d(vec4(place.y * sheet.key.x + place.x, PATTERN_KEY, sheet.key.yz));
    let size = sqrt(-2.0 * log(unit(own.x)));
    let turn = 6.2831853 * unit(own.y);
    return (MIDDLE + DEVIATION * clamp(size * vec2(cos(turn), sin(turn)), vec2(-4.0), vec2(4.0))) / 255.0;
}
