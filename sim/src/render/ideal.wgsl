// Without a lens the picture is what was drawn. Follows photons.wgsl.

@group(1) @binding(0) var luminance: texture_2d<f32>;

fn optics() -> Optics {
    return Optics(vec4(0.0), vec4(0.0), vec2(0.0));
}

fn luminance_at(place: vec2<u32>, lens: Optics) -> f32 {
    return textureLoad(luminance, place, 0).x;
}
