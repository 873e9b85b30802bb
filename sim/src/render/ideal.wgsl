// Without a lens the picture is what was drawn. Follows photons.wgsl.

@group(1) @binding(0) var luminance: texture_2d<f32>;

struct Picture {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) key: vec4<u32>,
    @location(1) @interpolate(flat) electrons: vec4<f32>,
    @location(2) @interpolate(flat) levels: vec4<f32>,
    @location(3) @interpolate(flat) own: vec4<f32>,
}

@vertex
fn picture_corner(@builtin(vertex_index) index: u32) -> Picture {
    let sensor = sensor();
    return Picture(whole_picture(index), sensor.key, sensor.electrons, sensor.levels, sensor.own);
}

@fragment
fn read_out(picture: Picture) -> @location(0) u32 {
    let pixel = vec2<u32>(picture.position.xy);
    let sensor = Sensor(picture.key, picture.electrons, picture.levels, picture.own);
    return level_at(pixel, textureLoad(luminance, pixel, 0).x, sensor);
}
