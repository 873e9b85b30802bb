// People: lit corner by corner.

struct Corner {
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // Albedo times equivalent lux, and albedo.
    @location(2) lit: f32,
    @location(3) albedo: f32,
    @location(4) velocity: vec3<f32>,
}

struct Skin {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) lit: vec2<f32>,
}

@vertex
fn body_corner(corner: Corner) -> Skin {
    let world = corner.world + corner.velocity * view.bodies_s;
    return Skin(clip_of(moving_in_camera(corner.world, corner.velocity)), world, corner.normal, vec2(corner.lit, corner.albedo));
}

@fragment
fn body_luminance(skin: Skin) -> @location(0) vec4<f32> {
    var luminance = skin.lit.x * view.luminance_per_lux;
    if (RING) {
        let way = skin.world - view.eye.xyz;
        let cosine = max(-dot(normalize(way), normalize(skin.normal)), 0.0);
        luminance += skin.lit.y * ring_lux(way, view.ring_candela.xyz) * cosine / PI;
    }
    return vec4(luminance, 0.0, 0.0, 1.0);
}
