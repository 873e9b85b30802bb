// The mean of an exposure's plates.

struct Sheet {
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    per_size: vec2<f32>,
    n_plates: u32,
    share: f32,
}

// In storage, as loops depend on it.
@group(0) @binding(0) var<storage, read> sheet: Sheet;
// One layer for each sub-frame.
@group(0) @binding(1) var plates: texture_2d_array<f32>;

@vertex
fn whole_plate(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn mean_luminance(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let place = vec2<u32>(position.xy);
    var sum = 0.0;
    for (var plate = 0u; plate < sheet.n_plates; plate++) {
        sum += textureLoad(plates, place, plate, 0).x;
    }
    return vec4(sum * sheet.share, 0.0, 0.0, 1.0);
}
