// Without a lens the picture is what was drawn. Follows photons.wgsl.

// Whether lamps light what was drawn.
override LAMPLIT: bool = false;

// Places along each side of the lamplight, as in cut.rs.
const LAMPLIGHT_PX: f32 = 65.0;

@group(1) @binding(0) var luminance: texture_2d<f32>;
// A factor on it, from the picture's first pixel to its last.
@group(1) @binding(1) var lamplight: texture_2d<f32>;
@group(1) @binding(2) var between: sampler;

struct Picture {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) key: vec4<u32>,
    @location(1) @interpolate(flat) electrons: vec4<f32>,
    @location(2) @interpolate(flat) levels: vec4<f32>,
    @location(3) @interpolate(flat) own: vec4<f32>,
    // From the picture's first pixel to its last.
    @location(4) @interpolate(flat) size: vec2<f32>,
}

@vertex
fn picture_corner(@builtin(vertex_index) index: u32) -> Picture {
    let sensor = sensor();
    return Picture(whole_picture(index), sensor.key, sensor.electrons, sensor.levels, sensor.own, vec2<f32>(readout.size_px - 1u));
}

@fragment
fn read_out(picture: Picture) -> @location(0) u32 {
    let pixel = vec2<u32>(picture.position.xy);
    let sensor = Sensor(picture.key, picture.electrons, picture.levels, picture.own);
    var light = textureLoad(luminance, pixel, 0).x;
    if (LAMPLIT) {
        let at = (vec2<f32>(pixel) / max(picture.size, vec2(1.0)) * (LAMPLIGHT_PX - 1.0) + 0.5) / LAMPLIGHT_PX;
        light *= textureSampleLevel(lamplight, between, at, 0.0).x;
    }
    return level_at(pixel, light, sensor);
}
