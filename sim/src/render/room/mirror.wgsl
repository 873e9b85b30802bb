// What is seen in a mirror: lamps through a blur, or whatever stands there.

// Distribution function of a smooth bump of standard deviation 1, whose density is a parabola: 6t(1 − t) over a width of √20.
fn below(deviations: f32) -> f32 {
    let t = clamp(0.5 + deviations / 4.4721360, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Farther than anything.
const FAR_M: f32 = 1e9;

// Luminance of lamps along a ray whose direction is spread by `roughness` (standard deviation, rad) about both axes: each lamp's share of
// the spread, so that over all directions no light is lost or won. `range` tells the first lamp to look for, the first bulb of all, and
// where lamps to look for end; what is farther than `farthest` is hidden.
fn lamps_along(from_place: vec3<f32>, direction: vec3<f32>, roughness: f32, range: vec3<u32>, farthest: f32) -> f32 {
    var sum = 0.0;
    for (var index = range.x; index < min(range.y, range.z); index++) {
        let lamp = lamps[index];
        let way = lamp.centre.xyz - from_place;
        let height = -dot(way, lamp.normal.xyz);
        let towards = min(dot(direction, lamp.normal.xyz), -1e-4);
        let distance = -height / towards;
        let beside = direction * distance - way;
        let at = vec2(dot(beside, lamp.side_u.xyz), dot(beside, lamp.side_v.xyz));
        let half = vec2(lamp.side_u.w, lamp.side_v.w);
        let per_spread = 1.0 / max(max(roughness, 0.002) * distance, 1e-4);
        let share = (below((at.x + half.x) * per_spread) - below((at.x - half.x) * per_spread))
            * (below((at.y + half.y) * per_spread) - below((at.y - half.y) * per_spread));
        sum += select(0.0, lamp.centre.w * share, height > 0.0 && towards < -1e-4 && distance < farthest);
    }
    for (var index = max(range.x, range.y); index < range.z; index++) {
        let lamp = lamps[index];
        let way = lamp.centre.xyz - from_place;
        let along = dot(way, direction);
        let aside = way - direction * along;
        let spread = max(roughness * along, 0.5 * lamp.normal.w);
        let share = lamp.normal.w * lamp.normal.w / (2.0 * spread * spread)
            * exp(-0.5 * dot(aside, aside) / (spread * spread));
        sum += select(0.0, lamp.centre.w * min(share, 1.0), along > 0.0 && along < farthest);
    }
    return sum;
}

// Luminance of the nearest face or lamp along a ray from a face.
fn nearest_along(face: Face, direction: vec3<f32>) -> f32 {
    let from_place = face.world + face.normal * 0.002;
    var nearest = FAR_M;
    var seen = select(0.0, view.sky, SKY);
    for (var index = 0u; index < face.counts.w; index++) {
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
            let node = (surface.nodes.xy + surface.nodes.zw * share + 0.5) / vec2<f32>(textureDimensions(light_map));
            var lux = textureSampleLevel(light_map, between_nodes, node, 0.0).x;
            if (SKY) {
                let fine = vec2(0.01, 0.0);
                lux += sunlit(share * surface.size.xy, fine, fine.yx, u32(surface.size.w)) * sun.towards.w
                    * dot(normalize(normal), sun.towards.xyz);
            }
            seen = surface.corner.w * lux * face.eye.w;
        }
    }
    let lamp_light = face.lamplight.w * lamps_along(from_place, direction, 0.002, face.counts.xyz, nearest);
    return max(seen, lamp_light);
}
