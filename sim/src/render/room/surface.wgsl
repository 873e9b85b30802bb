// Faces of the building: mapped light on a texture, the ring's light, and what mirrors.

override GLOSS: bool = false;

struct Node {
    @location(0) surface: u32,
    // From 0 to 1 along both sides.
    @location(1) share: vec2<f32>,
}

struct Face {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) share: vec2<f32>,
    @location(2) @interpolate(flat) surface: u32,
}

@vertex
fn surface_node(node: Node) -> Face {
    let surface = surfaces[node.surface];
    let world = surface.corner.xyz + surface.along.xyz * node.share.x + surface.up.xyz * node.share.y;
    return Face(clip_of(in_camera(world)), world, node.share, node.surface);
}

@fragment
fn surface_luminance(face: Face) -> @location(0) vec4<f32> {
    let surface = surfaces[face.surface];
    let place = face.share * surface.size.xy;
    let extent = fwidth(place);
    let pixel_m = 0.5 * (extent.x + extent.y);
    var albedo = surface.corner.w;
    let seed = u32(surface.size.z);
    if (TEXTURE == 1u) {
        albedo *= plaster(place, pixel_m, seed);
    } else if (TEXTURE == 2u || TEXTURE == 7u) {
        let wide = fwidth(face.world.xy);
        if (grid.edge_m.x > 0.0) {
            // In infrared as much brighter as the surface's own mean is.
            albedo *= tiles(face.world.xy, wide, pixel_m) * grid.albedo_ratio;
        }
    } else if (TEXTURE == 3u) {
        albedo *= concrete(face.world.xy, pixel_m, seed);
    } else if (TEXTURE == 4u) {
        albedo *= wood(face.world.xy, fwidth(face.world.xy), pixel_m);
    } else if (TEXTURE == 5u) {
        albedo *= carpet(face.world.xy, place, surface.size.xy, pixel_m);
    } else if (TEXTURE == 6u) {
        albedo *= picture(place, surface.size.xy, pixel_m, seed);
    }
    let matt = mapped_lux(surface.nodes.xy + surface.nodes.zw * face.share) * view.luminance_per_lux;
    var lit = matt;
    let way = normalize(face.world - view.eye.xyz);
    if (RING || GLOSS) {
        let normal = normalize(cross(surface.along.xyz, surface.up.xyz));
        let cosine = clamp(-dot(way, normal), 0.0, 1.0);
        if (RING) {
            lit += ring_lux(face.world) * cosine / PI;
        }
        if (GLOSS) {
            // Schlick 1994: what a smooth face mirrors grows to all of it at grazing incidence.
            let mirrored = surface.along.w + (1.0 - surface.along.w) * pow(1.0 - cosine, 5.0);
            let out = way + 2.0 * cosine * normal;
            var seen = lamps_along(face.world, out, surface.up.w);
            if (TEXTURE == 7u) {
                seen = nearest_along(face.world + normal * 0.002, out);
            } else {
                // Of the room besides lamps a rough face mirrors some mean; half of what a white wall here would show.
                seen += 0.5 * matt;
            }
            return vec4((1.0 - mirrored) * albedo * lit + mirrored * seen, 0.0, 0.0, 1.0);
        }
    }
    return vec4(albedo * lit, 0.0, 0.0, 1.0);
}
