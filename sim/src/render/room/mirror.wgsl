// What is seen in a mirror: lamps through a blur, or whatever stands there.

// Distribution function of a normal variable, nearly: the logistic one of the same spread.
fn below(deviations: f32) -> f32 {
    return 1.0 / (1.0 + exp(clamp(-1.702 * deviations, -60.0, 60.0)));
}

// Luminance of lamps along a ray whose direction is spread normally by `roughness` about both axes: each lamp's share of
// the spread, so that over all directions no light is lost or won.
fn lamps_along(from_place: vec3<f32>, direction: vec3<f32>, roughness: f32) -> f32 {
    var sum = 0.0;
    for (var index = 0u; index < view.lamp_count; index++) {
        let lamp = lamps[index];
        let way = lamp.centre.xyz - from_place;
        if (lamp.half_u.w > 0.0) {
            let along = dot(way, direction);
            let aside = way - direction * along;
            let spread = max(roughness * along, 0.5 * lamp.half_u.w);
            let area = lamp.half_u.w * lamp.half_u.w;
            let share = area / (2.0 * spread * spread) * exp(-0.5 * dot(aside, aside) / (spread * spread));
            sum += select(0.0, lamp.centre.w * min(share, 1.0), along > 0.0);
            continue;
        }
        let normal = normalize(cross(lamp.half_u.xyz, lamp.half_v.xyz));
        let towards = dot(direction, normal);
        let distance = dot(way, normal) / min(towards, -1e-4);
        let beside = direction * distance - way;
        let half = vec2(length(lamp.half_u.xyz), length(lamp.half_v.xyz));
        let at = vec2(dot(beside, lamp.half_u.xyz), dot(beside, lamp.half_v.xyz)) / half;
        let spread = max(roughness, 0.002) * distance;
        let share = (below((at.x + half.x) / spread) - below((at.x - half.x) / spread))
            * (below((at.y + half.y) / spread) - below((at.y - half.y) / spread));
        sum += select(0.0, lamp.centre.w * share, towards < 0.0 && dot(way, normal) < 0.0);
    }
    return sum * view.lamp_factor;
}

// Luminance of the nearest face or lamp along a ray.
fn nearest_along(from_place: vec3<f32>, direction: vec3<f32>) -> f32 {
    var nearest = 1e9;
    var seen = 0.0;
    for (var index = 0u; index < view.surface_count; index++) {
        let surface = surfaces[index];
        let normal = cross(surface.along.xyz, surface.up.xyz);
        let towards = dot(direction, normal);
        let distance = dot(surface.corner.xyz - from_place, normal) / select(towards, -1e-9, towards > -1e-9);
        let hit = from_place + direction * distance - surface.corner.xyz;
        let share = vec2(
            dot(hit, surface.along.xyz) / dot(surface.along.xyz, surface.along.xyz),
            dot(hit, surface.up.xyz) / dot(surface.up.xyz, surface.up.xyz),
        );
        let inside = all(share >= vec2(0.0)) && all(share <= vec2(1.0));
        if (towards < 0.0 && inside && distance > 0.0 && distance < nearest) {
            nearest = distance;
            seen = surface.corner.w * mapped_lux(surface.nodes.xy + surface.nodes.zw * share) * view.luminance_per_lux;
        }
    }
    let lamp_light = lamps_along(from_place, direction, 0.002);
    return max(seen, lamp_light);
}
