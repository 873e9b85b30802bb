// Faces of the building: mapped light on a texture, the ring's light, and what mirrors.

override GLOSS: bool = false;
// Whether lamps may be seen in it.
override GLINTS: bool = false;

// Numbers of lamps there can be, none included; as in room.rs.
const LAMP_ENDS: u32 = 1025u;

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
    // In the light map, from 0 to 1.
    @location(2) node: vec2<f32>,
    // Albedo, mirrored share, roughness, seed.
    @location(3) @interpolate(flat) material: vec4<f32>,
    @location(4) @interpolate(flat) normal: vec3<f32>,
    // Lengths of both sides, and where its words of `sunlight` begin.
    @location(5) @interpolate(flat) size: vec3<f32>,
    // First and last node: beyond are another face's, and some drivers interpolate a little too far.
    @location(6) @interpolate(flat) nodes: vec4<f32>,
    // Of the view: eye and luminance per lux; the ring's candela along the axis and the factor on lamps; the first lamp that may show, the first
    // bulb, where lamps that may show end, and how many faces a puddle mirrors.
    @location(7) @interpolate(flat) eye: vec4<f32>,
    @location(8) @interpolate(flat) lamplight: vec4<f32>,
    @location(9) @interpolate(flat) counts: vec4<u32>,
    // Of the tiles: turn and edges, phase and joints, the first tile and how many, contrast and mean albedo.
    @location(10) @interpolate(flat) turn_and_edge: vec4<f32>,
    @location(11) @interpolate(flat) phase_and_joint: vec4<f32>,
    @location(12) @interpolate(flat) tiles: vec4<i32>,
    @location(13) @interpolate(flat) tone: vec2<f32>,
}

fn grid_of(face: Face) -> Grid {
    return Grid(
        face.turn_and_edge.xy,
        face.turn_and_edge.zw,
        face.phase_and_joint.xy,
        face.phase_and_joint.z,
        face.phase_and_joint.w,
        face.tiles.xy,
        face.tiles.zw,
        face.tone.x,
        face.tone.y,
        0u,
        0u,
    );
}

@vertex
fn surface_node(node: Node, @builtin(instance_index) shown: u32) -> Face {
    let surface = surfaces[node.surface];
    let world = surface.corner.xyz + surface.along.xyz * node.share.x + surface.up.xyz * node.share.y;
    let per_size = 1.0 / vec2<f32>(textureDimensions(light_map));
    return Face(
        clip_of(in_camera(world)),
        world,
        node.share * surface.size.xy,
        (surface.nodes.xy + surface.nodes.zw * node.share + 0.5) * per_size,
        vec4(surface.corner.w, surface.along.w, surface.up.w, surface.size.z),
        normalize(cross(surface.along.xyz, surface.up.xyz)),
        surface.size.xyw,
        vec4((surface.nodes.xy + 0.5) * per_size, (surface.nodes.xy + surface.nodes.zw + 0.5) * per_size),
        vec4(view.eye.xyz, view.luminance_per_lux),
        vec4(view.ring_candela.xyz, view.lamp_factor),
        vec4(shown % LAMP_ENDS, counted.first_bulb, shown / LAMP_ENDS, counted.mirrored_count),
        vec4(grid.turn, grid.edge_m),
        vec4(grid.phase_m, grid.joint_width_m, grid.joint_albedo),
        vec4(grid.first, grid.count),
        vec2(grid.pattern_contrast, grid.mean_albedo),
    );
}

// What is on the face at this place, as a factor on its albedo.
fn texture_at(face: Face) -> f32 {
    let seed = u32(face.material.w);
    // Floors go on from face to face.
    let on_floor = TEXTURE == 2u || TEXTURE == 3u || TEXTURE == 4u || TEXTURE == 7u || TEXTURE == 10u;
    let place = select(face.place, face.world.xy, on_floor);
    let extent = fwidth(place);
    let pixel_m = 0.5 * (extent.x + extent.y);
    if (TEXTURE == 1u) {
        return plaster(place, pixel_m, seed);
    }
    if (TEXTURE == 2u) {
        return tiles(place, extent, pixel_m, grid_of(face));
    }
    if (TEXTURE == 3u) {
        return concrete(place, pixel_m, seed);
    }
    if (TEXTURE == 4u) {
        return wood(place, extent, pixel_m);
    }
    if (TEXTURE == 5u) {
        return carpet(face.world.xy, place, face.size.xy, pixel_m);
    }
    if (TEXTURE == 6u) {
        return picture(place, face.size.xy, pixel_m, seed);
    }
    if (TEXTURE == 7u) {
        // What is below the water, by its number.
        if (seed == 2u) {
            return tiles(place, extent, pixel_m, grid_of(face));
        }
        if (seed == 3u) {
            return concrete(place, pixel_m, 0u);
        }
        if (seed == 4u) {
            return wood(place, extent, pixel_m);
        }
        if (seed == 5u) {
            // Its border runs along walls, of which those beyond the puddle are not known here.
            return carpet(place, place, 2.0 * place, pixel_m);
        }
        return 1.0;
    }
    if (TEXTURE == 8u) {
        return chessboard(place, extent, face.size.xy, seed);
    }
    if (TEXTURE == 9u) {
        return facade(place, extent, pixel_m, face.size.xy, seed);
    }
    if (TEXTURE == 10u) {
        return asphalt(place, pixel_m, seed);
    }
    if (TEXTURE == 11u) {
        return books(place, extent, pixel_m, face.size.xy, seed);
    }
    return 1.0;
}

@fragment
fn surface_luminance(face: Face) -> @location(0) vec4<f32> {
    var albedo = face.material.x;
    if (TEXTURE != 0u) {
        albedo *= texture_at(face);
    }
    var lux = textureSampleLevel(light_map, between_nodes, clamp(face.node, face.nodes.xy, face.nodes.zw), 0.0).x;
    if (SKY) {
        let across_x = dpdx(face.place);
        let across_y = dpdy(face.place);
        let share = sunlit(face.place, across_x, across_y, u32(face.size.z));
        if (share > 0.0) {
            let pixel_m = 0.5 * (length(across_x) + length(across_y));
            let cosine = max(dot(face.normal, sun.towards.xyz), 0.0);
            lux += share * left_by_people(face.world, pixel_m) * sun.towards.w * cosine;
        }
    }
    let matt = lux * face.eye.w;
    var lit = matt;
    if (!RING && !GLOSS) {
        return vec4(albedo * lit, 0.0, 0.0, 1.0);
    }
    let from_eye = face.world - face.eye.xyz;
    let way = normalize(from_eye);
    let cosine = clamp(-dot(way, face.normal), 0.0, 1.0);
    if (RING) {
        lit += ring_lux(from_eye, face.lamplight.xyz) * cosine / PI;
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
    var seen = 0.5 * matt;
    if (GLINTS) {
        seen += face.lamplight.w * lamps_along(face.world, out, face.material.z, face.counts.xyz, FAR_M);
    }
    if (TEXTURE == 7u) {
        // Water mirrors what stands there and darkens what it soaks, within the edge of a puddle.
        let deep = puddle(face.place, fwidth(face.place), face.size.xy);
        seen = mix(seen, nearest_along(face, out), deep);
        albedo *= 1.0 - 0.35 * deep;
    }
    return vec4((1.0 - mirrored) * albedo * lit + mirrored * seen, 0.0, 0.0, 1.0);
}
