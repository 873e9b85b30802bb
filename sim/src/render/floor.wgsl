// Luminance of the floor, averaged over the exposure: one fragment walks all sub-frames.
//
// Frame `local`: the grid frame of the tiles, moved to the nominal corner nearest to the camera, so that
// single precision keeps 1e-4 px in a hall of any size.

struct View {
    // Homographies from pixels about the principal point to the local frame, at the ends of the sub-frames; the floor is
    // in front of the camera where the third component is positive. Rows of a 3 × 3 matrix.
    local_from_pixel: array<array<vec4<f32>, 3>, 33>, // MAX_SUB_FRAMES of exposure.rs, and one
    principal_point_px: vec2<f32>,
    sub_frames: u32,
    stray_count: u32,
    // Gradient of ln E (1/m), and E/π at the local origin (cd/m² for albedo 1).
    light_gradient: vec2<f32>,
    light_at_origin: f32,
    // Albedo of everything beyond the walls.
    wall_albedo: f32,
    // Inside of the room: normal · p + offset > 0, for the four walls.
    walls: array<vec4<f32>, 4>,
    // Index of the local origin among the laid corners, and the number of corners of each axis.
    origin: vec2<i32>,
    corners: vec2<i32>,
    strays: array<Stray, 64>, // MAX_STRAYS of floor.rs
}

struct Material {
    edge_m: vec2<f32>,
    half_joint_m: f32,
    // Greatest displacement of a corner, and half a joint.
    joint_reach_m: f32,
    joint_albedo: f32,
    pattern_contrast: f32,
    // Albedo of a floor without tiles.
    plain_albedo: f32,
    tiled: u32,
    pattern_seed: u32,
}

struct Stray {
    middle_m: vec2<f32>,
    direction: vec2<f32>,
    half_length_m: f32,
    half_width_m: f32,
    albedo: f32,
    // Share of the light that its shade takes away beside it.
    shade: f32,
}

@group(0) @binding(0) var<uniform> material: Material;
// Displacement of the corner (m), contrast of the joint towards greater j, contrast of the joint towards greater i.
@group(0) @binding(1) var<storage, read> laid: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> tile_albedo: array<f32>;
@group(1) @binding(0) var<uniform> view: View;

@vertex
fn cover_view(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle that covers the whole view.
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn floor_luminance(@builtin(position) position: vec4<f32>) -> @location(0) f32 {
    // The rasteriser puts the centre of the first pixel at (0.5, 0.5).
    let pixel = vec3(position.xy - 0.5 - view.principal_point_px, 1.0);
    var sum = 0.0;
    var start = local_point(0u, pixel);
    for (var frame = 0u; frame < view.sub_frames; frame++) {
        let end = local_point(frame + 1u, pixel);
        sum += sub_frame_luminance(frame, pixel, start, end);
        start = end;
    }
    return sum / f32(view.sub_frames);
}

// Where a pixel meets the floor plane at the beginning of a sub-frame; z is positive in front of the camera.
fn local_point(frame: u32, pixel: vec3<f32>) -> vec3<f32> {
    let depth = dot(view.local_from_pixel[frame][2].xyz, pixel);
    let place = vec2(
        dot(view.local_from_pixel[frame][0].xyz, pixel),
        dot(view.local_from_pixel[frame][1].xyz, pixel),
    );
    return vec3(place / depth, depth);
}

fn sub_frame_luminance(frame: u32, pixel: vec3<f32>, start: vec3<f32>, end: vec3<f32>) -> f32 {
    if (start.z <= 0.0) {
        return view.light_at_origin * view.wall_albedo;
    }
    let place = 0.5 * (start.xy + end.xy);
    // Derivative of the homography: ∂(n/d) = (∂n − (n/d)·∂d)/d.
    let row_x = view.local_from_pixel[frame][0];
    let row_y = view.local_from_pixel[frame][1];
    let row_d = view.local_from_pixel[frame][2];
    let footprint = Footprint(
        (vec2(row_x.x, row_y.x) - start.xy * row_d.x) / start.z,
        (vec2(row_x.y, row_y.y) - start.xy * row_d.y) / start.z,
        end.xy - start.xy,
    );
    var albedo = material.plain_albedo;
    if (material.tiled != 0u) {
        albedo = tiled_albedo(place, footprint);
    }
    albedo = with_strays(albedo, place, footprint);
    albedo = within_walls(albedo, place, footprint);
    return albedo * view.light_at_origin * exp(dot(view.light_gradient, place));
}

fn corner(index: vec2<i32>) -> vec4<f32> {
    let clamped = clamp(view.origin + index, vec2(0), view.corners - 1);
    return laid[clamped.x * view.corners.y + clamped.y];
}

fn albedo_of_tile(tile: vec2<i32>) -> f32 {
    let clamped = clamp(view.origin + tile, vec2(0), view.corners - 1);
    return tile_albedo[clamped.x * view.corners.y + clamped.y];
}

// One joint near a place: the share of the footprint that it hides, and the share on its greater side.
struct Joint {
    mask: f32,
    greater_side: f32,
    on_greater_side: bool,
}

// The joint of family `axis` through the corner nearest to the place.
fn joint_at(axis: u32, place: vec2<f32>, nearest: vec2<i32>, footprint: Footprint) -> Joint {
    let along = select(vec2(1, 0), vec2(0, 1), axis == 0u);
    let here = corner(nearest);
    let before = corner(nearest - along);
    let from_m = vec2<f32>(nearest) * material.edge_m + here.xy;
    let onward = select(place.x >= from_m.x, place.y >= from_m.y, axis == 0u);
    let other = select(nearest - along, nearest + along, onward);
    let to_m = vec2<f32>(other) * material.edge_m + corner(other).xy;
    let reach = to_m - from_m;
    let length = length(reach);
    let direction = reach / length * select(-1.0, 1.0, onward);
    // Left of +y is −x, so the normal towards greater x is the direction turned clockwise; for family 1 the other way.
    let normal = select(vec2(-direction.y, direction.x), vec2(direction.y, -direction.x), axis == 0u);
    let distance = dot(place - from_m, normal);
    let widths = widths_along(normal, footprint);

    let here_contrast = select(here.w, here.z, axis == 0u);
    let before_contrast = select(before.w, before.z, axis == 0u);
    let own = select(before_contrast, here_contrast, onward);
    let neighbour = select(here_contrast, before_contrast, onward);
    // Wear fades over the first quarter of a tile's edge; a joint that is missing ends at once.
    let at_corner = select(own, 0.5 * (own + neighbour), own > 0.0 && neighbour > 0.0);
    let share = abs(dot(place - from_m, direction)) / length;
    let contrast = mix(at_corner, own, smoothstep(0.0, 0.25, share));

    let mask = contrast * band_coverage(distance, material.half_joint_m, widths);
    return Joint(mask, half_plane_coverage(distance, widths), distance >= 0.0);
}

fn tiled_albedo(place: vec2<f32>, footprint: Footprint) -> f32 {
    let scaled = place / material.edge_m;
    let nearest = vec2<i32>(round(scaled));
    var tile = vec2<i32>(floor(scaled));
    var joints = 0.0;
    // Tiles on both sides of a joint, and the share of the footprint on the greater one.
    var low = tile;
    var high = tile;
    var greater = vec2(1.0);
    let extent = abs(footprint.side_u) + abs(footprint.side_v) + abs(footprint.motion);
    let near = abs(place - vec2<f32>(nearest) * material.edge_m) < material.joint_reach_m + extent;
    if (near.x) {
        let joint = joint_at(0u, place, nearest, footprint);
        low.x = nearest.x - 1;
        high.x = nearest.x;
        greater.x = joint.greater_side;
        tile.x = select(low.x, high.x, joint.on_greater_side);
        joints = joint.mask;
    }
    if (near.y) {
        let joint = joint_at(1u, place, nearest, footprint);
        low.y = nearest.y - 1;
        high.y = nearest.y;
        greater.y = joint.greater_side;
        tile.y = select(low.y, high.y, joint.on_greater_side);
        joints = 1.0 - (1.0 - joints) * (1.0 - joint.mask);
    }
    var albedo = albedo_of_tile(high);
    if (near.x || near.y) {
        let low_row = mix(albedo_of_tile(low), albedo_of_tile(vec2(high.x, low.y)), greater.x);
        let high_row = mix(albedo_of_tile(vec2(low.x, high.y)), albedo, greater.x);
        albedo = mix(low_row, high_row, greater.y);
    }
    if (PATTERN != 0u) {
        let in_tile = place - vec2<f32>(tile) * material.edge_m;
        let size_m = 0.5 * (extent.x + extent.y);
        let pattern = pattern_at(in_tile, view.origin + tile, material.pattern_seed, size_m, extent.x, material.edge_m.x / 5.0);
        albedo *= 1.0 + material.pattern_contrast * pattern;
    }
    return mix(albedo, material.joint_albedo, joints);
}

fn with_strays(floor_albedo: f32, place: vec2<f32>, footprint: Footprint) -> f32 {
    var albedo = floor_albedo;
    let extent = length(footprint.side_u) + length(footprint.side_v) + length(footprint.motion);
    for (var index = 0u; index < view.stray_count; index++) {
        let stray = view.strays[index];
        let from_middle = place - stray.middle_m;
        let normal = vec2(-stray.direction.y, stray.direction.x);
        let across = dot(from_middle, normal);
        let along = dot(from_middle, stray.direction);
        // The shade is gone three widths away.
        let reach = 6.0 * stray.half_width_m + extent;
        if (abs(across) < reach && abs(along) < stray.half_length_m + reach) {
            let end = band_coverage(along, stray.half_length_m, widths_along(stray.direction, footprint));
            let cover = end * band_coverage(across, stray.half_width_m, widths_along(normal, footprint));
            let from_edge = across / (2.0 * stray.half_width_m);
            albedo *= 1.0 - stray.shade * end * exp(-from_edge * from_edge);
            albedo = mix(albedo, stray.albedo, cover);
        }
    }
    return albedo;
}

fn within_walls(floor_albedo: f32, place: vec2<f32>, footprint: Footprint) -> f32 {
    var inside = 1.0;
    let extent = length(footprint.side_u) + length(footprint.side_v) + length(footprint.motion);
    for (var index = 0u; index < 4u; index++) {
        let wall = view.walls[index];
        let distance = dot(wall.xy, place) + wall.z;
        if (distance < extent) {
            inside *= half_plane_coverage(distance, widths_along(wall.xy, footprint));
        }
    }
    return mix(view.wall_albedo, floor_albedo, inside);
}
