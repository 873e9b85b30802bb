// Direct sunlight outdoors, with shadows whose edges are as sharp as a pixel. Follows world.wgsl and view.wgsl.

// Whether there is a sky.
override SKY: bool = false;

// Share of a pixel at a place of a face that walls and furniture leave in the sun. `at` is where the face's words begin, 0 for a face that the sun
// does not shine on; `across_x` and `across_y` are how far the place moves from pixel to pixel. The words are those of place/light/shadows.rs.
fn sunlit(place: vec2<f32>, across_x: vec2<f32>, across_y: vec2<f32>, at: u32) -> f32 {
    if (at == 0u) {
        return 0.0;
    }
    let count = vec2(sunlight[at], sunlight[at + 1u]);
    let per_m = vec2(bitcast<f32>(sunlight[at + 2u]), bitcast<f32>(sunlight[at + 3u]));
    let cell = vec2<u32>(clamp(vec2<i32>(floor(place * per_m)), vec2(0), vec2<i32>(count) - 1));
    let list = sunlight[at + 4u + cell.y * count.x + cell.x];
    if (list < 2u) {
        return 1.0 - f32(list);
    }
    var shade = 0.0;
    var next = list + 1u;
    for (var polygon = 0u; polygon < sunlight[list]; polygon++) {
        let n_edges = sunlight[next];
        next += 1u;
        var covered_share = 1.0;
        for (var edge = 0u; edge < n_edges; edge++) {
            let inward = vec2(bitcast<f32>(sunlight[next]), bitcast<f32>(sunlight[next + 1u]));
            let inside = dot(inward, place) + bitcast<f32>(sunlight[next + 2u]);
            let wide = max(abs(dot(inward, across_x)) + abs(dot(inward, across_y)), 1e-4);
            covered_share = min(covered_share, clamp(inside / wide + bitcast<f32>(sunlight[next + 3u]), 0.0, 1.0));
            next += 4u;
        }
        shade += covered_share;
    }
    return 1.0 - min(shade, 1.0);
}

// Half of a person's width at a height, as shares of the half width over the shoulders and of the height.
fn half_width(share: f32) -> f32 {
    if (share > 0.87) {
        return 0.42 * sqrt(max(1.0 - pow((share - 0.935) / 0.065, 2.0), 0.0));
    }
    if (share > 0.83) {
        return 0.3;
    }
    return select(0.6, 0.95, share > 0.48);
}

// Share of a place that people leave in the sun, each an upright figure that faces the sun. `pixel_m` is a pixel's extent.
fn left_by_people(world: vec3<f32>, pixel_m: f32) -> f32 {
    var left = 1.0;
    let level = max(length(sun.towards.xy), 1e-3);
    let away = sun.towards.xy / level;
    for (var index = 0u; index < sun.n_people; index++) {
        let person = sun.people[2u * index];
        let middle = person.xy + sun.people[2u * index + 1u].xy * view.bodies_s - world.xy;
        let along = dot(middle, away);
        let height = world.z + along * sun.towards.z / level;
        let aside = abs(middle.x * away.y - middle.y * away.x);
        let half = person.z * half_width(height / person.w);
        let is_between = along > 0.0 && height > 0.0 && height < person.w;
        left *= 1.0 - select(0.0, clamp((half - aside) / pixel_m + 0.5, 0.0, 1.0), is_between);
    }
    return left;
}
