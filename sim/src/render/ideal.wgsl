// Without a lens the picture is what was drawn. Follows photons.wgsl.

@group(1) @binding(0) var luminance: texture_2d<f32>;

fn luminance_at(place: vec2<u32>) -> f32 {
    return textureLoad(luminance, place, 0).x;
}
