// Faces of the building: mapped light on a texture, the ring's light, and what mirrors.

override GLOSS: bool = false;

struct Node {
    @location(0) surface: u32,
    // From 0 to 1 along both sides.
    @location(1) share: vec2<f32>,
}

// What is the same all over a face travels with its corners: a software driver gathers from memory lane by lane.
struct Face {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) world: vec3<f32>,
    // In metres along both sides.
    @location(1) place: vec2<f32>,
    // In the light map, at a place that the face covers: beyond its edge are another face's nodes.
    @location(2) @interpolate(perspective, centroid) node: vec2<f32>,
    // Albedo, mirrored share, roughness, seed.
    @location(3) @interpolate(flat) material: vec4<f32>,
    @location(4) @interpolate(flat) normal: vec3<f32>,
    @location(5) @interpolate(flat) size: vec2<f32>,
    // First and last node: some drivers interpolate a little beyond the edge all the same.
    @location(6) @interpolate(flat) nodes: vec4<f32>,
}

@vertex
fn surface_node(node: Node) -> Face {
    let surface = surfaces[node.surface];
    let world = surface.corner.xyz + surface.along.xyz * node.share.x + surface.up.xyz * node.share.y;
    return Face(
        clip_of(in_camera(world)),
        world,
        node.share * surface.size.xy,
        surface.nodes.xy + surface.nodes.zw * node.share,
        vec4(surface.corner.w, surface.along.w, surface.up.w, surface.size.z),
        normalize(cross(surface.along.xyz, surface.up.xyz)),
        surface.size.xy,
        vec4(surface.nodes.xy, surface.nodes.xy + surface.nodes.zw),
    );
}

// What is on the face at this place, as a factor on its albedo.
fn texture_at(face: Face) -> f32 {
    let seed = u32(face.material.w);
    // Floors go on from face to face.
    let on_floor = TEXTURE == 2u || TEXTURE == 3u || TEXTURE == 4u || TEXTURE == 7u;
    let place = select(face.place, face.world.xy, on_floor);
    let extent = fwidth(place);
    let pixel_m = 0.5 * (extent.x + extent.y);
    if (TEXTURE == 1u) {
        return plaster(place, pixel_m, seed);
    }
    if (TEXTURE == 2u) {
        return tiles(place, extent, pixel_m);
    }
    if (TEXTURE == 3u) {
        return concrete(place, pixel_m, seed);
    }
    if (TEXTURE == 4u) {
        return wood(place, extent, pixel_m);
    }
    if (TEXTURE == 5u) {
        return carpet(face.world.xy, place, face.size, pixel_m);
    }
    if (TEXTURE == 6u) {
        return picture(place, face.size, pixel_m, seed);
    }
    if (TEXTURE == 7u) {
        // Of what is below the water, tiles and concrete have a texture.
        return select(concrete(place, pixel_m, 0u), tiles(place, extent, pixel_m), seed == 2u);
    }
    if (TEXTURE == 8u) {
        return chessboard(place, extent, face.size, seed);
    }
    return 1.0;
}

@fragment
fn surface_luminance(face: Face) -> @location(0) vec4<f32> {
    var albedo = face.material.x;
    if (TEXTURE != 0u) {
        albedo *= texture_at(face);
    }
    let lux = mapped_lux(clamp(face.node, face.nodes.xy, face.nodes.zw));
    let matt = lux * view.luminance_per_lux;
    var lit = matt;
    if (!RING && !GLOSS) {
        return vec4(albedo * lit, 0.0, 0.0, 1.0);
    }
    let way = normalize(face.world - view.eye.xyz);
    let cosine = clamp(-dot(way, face.normal), 0.0, 1.0);
    if (RING) {
        lit += ring_lux(face.world) * cosine / PI;
    }
    if (!GLOSS) {
        return vec4(albedo * lit, 0.0, 0.0, 1.0);
    }
    // Schlick 1994: what a smooth face mirrors grows to all of it at grazing incidence, as the fifth power.
    let grazing = 1.0 - cosine;
    let square = grazing * grazing;
    let mirrored = face.material.y + (1.0 - face.material.y) * square * square * grazing;
    let out = way + 2.0 * cosine * face.normal;
    // Of the room besides lamps a rough face mirrors some mean; half of what a white wall here would show.
    var seen = lamps_along(face.world, out, face.material.z) + 0.5 * matt;
    if (TEXTURE == 7u) {
        // Water mirrors what stands there and darkens what it soaks, within the edge of a puddle.
        let deep = puddle(face.place, face.size);
        seen = mix(seen, nearest_along(face.world + face.normal * 0.002, out), deep);
        albedo *= 1.0 - 0.35 * deep;
    }
    return vec4((1.0 - mirrored) * albedo * lit + mirrored * seen, 0.0, 0.0, 1.0);
}
