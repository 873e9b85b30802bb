// Faces of things that are hardly wider than a pixel, laid over what is behind them by the share of each pixel that they cover. Follows
// edge.wgsl and disc.wgsl.

// A strip is drawn this much nearer than it is, so that the wall on which it stands, which comes nearer from pixel to pixel, does not hide it.
const BEFORE: f32 = 1.005;

struct Strip {
    @location(0) surface: u32,
    // 0 where the face's first side is the long one, 1 where its second is.
    @location(1) long_side: u32,
    // From 0 to 1 along that.
    @location(2) from_to: vec2<f32>,
}

struct Sliver {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) world: vec3<f32>,
    // In the light map, from 0 to 1, with the first and the last node.
    @location(1) node: vec2<f32>,
    @location(2) @interpolate(flat) nodes: vec4<f32>,
    @location(3) @interpolate(flat) normal: vec3<f32>,
    // Albedo and mirrored share.
    @location(4) @interpolate(flat) material: vec2<f32>,
    // Both long edges: unit normal inwards in pixels, and what makes the distance from the edge 0 on it.
    @location(5) @interpolate(flat) edge: vec3<f32>,
    @location(6) @interpolate(flat) other_edge: vec3<f32>,
    // In metres along both sides, and where its words of `sunlight` begin.
    @location(7) place: vec2<f32>,
    @location(8) @interpolate(flat) shadows: f32,
}

// Line through two places, whose unit normal points to the same side as `inwards`.
fn line_through(start: vec2<f32>, end: vec2<f32>, inwards: vec2<f32>) -> vec3<f32> {
    let along = end - start;
    let left = vec2(-along.y, along.x) / max(length(along), 1e-6);
    let normal = left * select(-1.0, 1.0, dot(left, inwards) >= 0.0);
    return vec3(normal, -dot(normal, start));
}

@vertex
fn strip_corner(@builtin(vertex_index) index: u32, strip: Strip) -> Sliver {
    let surface = surfaces[strip.surface];
    // Corners in the order of `index`: its first bit tells the end, its second the side.
    var world: array<vec3<f32>, 4>;
    var seen: array<vec3<f32>, 4>;
    var at_px: array<vec2<f32>, 4>;
    var shares: array<vec2<f32>, 4>;
    var behind = false;
    for (var corner = 0u; corner < 4u; corner++) {
        let along = select(strip.from_to.x, strip.from_to.y, (corner & 1u) == 1u);
        let across = f32(corner >> 1u);
        shares[corner] = select(vec2(across, along), vec2(along, across), strip.long_side == 0u);
        world[corner] = surface.corner.xyz + surface.along.xyz * shares[corner].x + surface.up.xyz * shares[corner].y;
        seen[corner] = in_camera(world[corner]);
        behind = behind || seen[corner].z <= BEFORE * NEAR_M;
        at_px[corner] = on_plate(seen[corner]);
    }
    let inwards = at_px[2] + at_px[3] - at_px[0] - at_px[1];
    let edge = line_through(at_px[0], at_px[1], inwards);
    // Opposite to the first also where the face is seen from its side and has no width.
    let other_edge = line_through(at_px[2], at_px[3], -edge.xy);
    let outwards = -select(edge.xy, other_edge.xy, index >= 2u);
    let at = (at_px[index] + outwards * REACH_PX + 0.5) * 2.0 / view.plate_size_px - 1.0;
    let depth = seen[index].z;
    let per_size = 1.0 / vec2<f32>(textureDimensions(light_map));
    return Sliver(
        select(vec4(at.x * depth, -at.y * depth, BEFORE * NEAR_M, depth), vec4(2.0, 2.0, 2.0, 1.0), behind),
        world[index],
        (surface.nodes.xy + surface.nodes.zw * shares[index] + 0.5) * per_size,
        vec4((surface.nodes.xy + 0.5) * per_size, (surface.nodes.xy + surface.nodes.zw + 0.5) * per_size),
        normalize(cross(surface.along.xyz, surface.up.xyz)),
        vec2(surface.corner.w, surface.along.w),
        edge,
        other_edge,
        surface.size.xy * shares[index],
        surface.size.w,
    );
}

// Blended as luminance + (1 − share)·what was there.
@fragment
fn strip_luminance(sliver: Sliver) -> @location(0) vec4<f32> {
    let pixel = sliver.position.xy - 0.5;
    let inside = vec2(dot(sliver.edge.xy, pixel) + sliver.edge.z, dot(sliver.other_edge.xy, pixel) + sliver.other_edge.z);
    // What two parallel edges have between them: what is inside of one, less what is outside of the other.
    let share = max(covered(inside.x, abs(sliver.edge.xy)) + covered(inside.y, abs(sliver.other_edge.xy)) - 1.0, 0.0);
    let node = clamp(sliver.node, sliver.nodes.xy, sliver.nodes.zw);
    var lux = textureSampleLevel(light_map, between_nodes, node, 0.0).x;
    if (SKY) {
        let fine = vec2(0.01, 0.0);
        lux += sunlit(sliver.place, fine, fine.yx, u32(sliver.shadows)) * sun.towards.w
            * max(dot(sliver.normal, sun.towards.xyz), 0.0);
    }
    let matt = lux * view.luminance_per_lux;
    var lit = matt;
    if (RING) {
        let way = sliver.world - view.eye.xyz;
        lit += ring_lux(way, view.ring_candela.xyz) * max(-dot(normalize(way), sliver.normal), 0.0) / PI;
    }
    // Of the room a glossy face mirrors some mean, as in surface.wgsl; lamps are not looked for in a strip.
    let luminance = mix(sliver.material.x * lit, 0.5 * matt, sliver.material.y);
    return vec4(luminance * share, 0.0, 0.0, share);
}
