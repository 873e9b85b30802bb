// The mean of an exposure's plates.

struct Plates {
    // Sub-frames, and the share of one in the exposure.
    count: u32,
    share: f32,
}

// In storage, as loops depend on it.
@group(0) @binding(0) var<storage, read> counted: Plates;
// One layer for each sub-frame.
@group(0) @binding(1) var plates: texture_2d_array<f32>;

struct Plate {
    @builtin(position) position: vec4<f32>,
    // From storage both would be loaded pixel by pixel.
    @location(0) @interpolate(flat) count: u32,
    @location(1) @interpolate(flat) share: f32,
}

@vertex
fn whole_plate(@builtin(vertex_index) index: u32) -> Plate {
    let corner = vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
    return Plate(corner, counted.count, counted.share);
}

@fragment
fn mean_luminance(whole: Plate) -> @location(0) vec4<f32> {
    let place = vec2<u32>(whole.position.xy);
    var sum = 0.0;
    for (var plate = 0u; plate < whole.count; plate++) {
        sum += textureLoad(plates, place, plate, 0).x;
    }
    return vec4(sum * whole.share, 0.0, 0.0, 1.0);
}
