// Lamps as one sees them when one looks into them.

struct Glow {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) @interpolate(flat) luminance: f32,
    @location(2) @interpolate(flat) normal: vec3<f32>,
}

// Of a diffuser that is off.
const DIFFUSER_ALBEDO: f32 = 0.7;

// Two triangles for each rectangle.
@vertex
fn lamp_corner(@builtin(vertex_index) index: u32, @builtin(instance_index) lamp_index: u32) -> Glow {
    let lamp = lamps[lamp_index];
    let corner = array<vec2<f32>, 6>(
        vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0),
    )[index];
    let world = lamp.centre.xyz + lamp.side_u.xyz * (lamp.side_u.w * corner.x)
        + lamp.side_v.xyz * (lamp.side_v.w * corner.y);
    return Glow(clip_of(in_camera(world)), world, lamp.centre.w * view.lamp_factor, lamp.normal.xyz);
}

@fragment
fn lamp_luminance(glow: Glow) -> @location(0) vec4<f32> {
    var luminance = glow.luminance;
    if (RING) {
        let way = glow.world - view.eye.xyz;
        let cosine = max(-dot(normalize(way), glow.normal), 0.0);
        luminance += DIFFUSER_ALBEDO * ring_lux(way, view.ring_candela.xyz) * cosine / PI;
    }
    return vec4(luminance, 0.0, 0.0, 1.0);
}
