// Shadows of people, who are not in the light map: upright cylinders before lamps that are taken to be discs.

// Share of the mapped light that people leave at a place.
fn left_by_people(place: vec3<f32>, normal: vec3<f32>, mapped: f32) -> f32 {
    var hidden = 0.0;
    for (var index = 0u; index < view.lamp_count; index++) {
        let lamp = lamps[index];
        let way = lamp.centre.xyz - place;
        let square = dot(way, way);
        let distance = sqrt(square);
        let is_bulb = lamp.normal.w > 0.0;
        let area = select(4.0 * lamp.side_u.w * lamp.side_v.w, PI * lamp.normal.w * lamp.normal.w, is_bulb);
        let shining = select(max(-dot(way, lamp.normal.xyz), 0.0) / distance, 1.0, is_bulb);
        let lux = lamp.centre.w * area * shining * max(dot(way, normal), 0.0) / (distance * square);
        var open = 1.0;
        for (var person = 0u; person < view.body_count; person++) {
            open *= 1.0 - hidden_behind(view.bodies[person], place, way, sqrt(area) * 0.5);
        }
        hidden += lux * (1.0 - open);
    }
    // Close to feet the room's other light is hidden too.
    var near_feet = 0.0;
    for (var person = 0u; person < view.body_count; person++) {
        let body = view.bodies[person];
        let from_axis = length(place.xy - body.xy);
        near_feet = max(near_feet, 0.35 * exp(-max(from_axis - body.w, 0.0) / 0.15) * step(place.z, body.z));
    }
    return max(1.0 - hidden / max(mapped, 1e-6), 0.05) * (1.0 - near_feet);
}

// Share of a lamp of this radius that a person hides from a place.
fn hidden_behind(body: vec4<f32>, place: vec3<f32>, way: vec3<f32>, lamp_radius: f32) -> f32 {
    let to_axis = body.xy - place.xy;
    let level = max(length(way.xy), 1e-4);
    let direction = way.xy / level;
    let along = dot(to_axis, direction);
    let aside = abs(direction.x * to_axis.y - direction.y * to_axis.x);
    let share = clamp(along / level, 0.0, 1.0);
    // Half of the penumbra at the place.
    let soft = max(lamp_radius * share, 0.02);
    // People are narrower than their shoulders but for these.
    let beside = 0.75 * body.w - aside;
    let below_top = body.z - (place.z + way.z * share);
    let before = step(0.0, along) * step(along, level);
    return before * smoothstep(-soft, soft, beside) * smoothstep(-soft, soft, below_top);
}
