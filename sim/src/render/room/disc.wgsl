// Discs with smooth edges: retro-reflective dots and bulbs.

struct Disc {
    @location(0) centre: vec3<f32>,
    @location(1) radius_m: f32,
    // Of a dot its coefficient of retroreflection and albedo; of a bulb 0, and its luminance.
    @location(2) retroreflection: f32,
    @location(3) matt: f32,
}

struct Spot {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) from_centre_m: vec2<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) disc: vec3<f32>,
}

@vertex
fn disc_corner(@builtin(vertex_index) index: u32, disc: Disc) -> Spot {
    let side = vec2(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    // A pixel and a half more, in which the edge fades.
    let depth = max(in_camera(disc.centre).z, NEAR_M);
    let reach = disc.radius_m + 1.5 * depth / min(view.plate_focal_px.x, view.plate_focal_px.y);
    let from_centre = side * reach;
    var world = disc.centre + vec3(from_centre.x, -from_centre.y, 0.0);
    if (disc.retroreflection == 0.0) {
        // A bulb is round from everywhere.
        let way = normalize(disc.centre - view.eye.xyz);
        let aside = normalize(cross(way, select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(way.z) > 0.9)));
        world = disc.centre + aside * from_centre.x + cross(way, aside) * from_centre.y;
    }
    return Spot(clip_of(in_camera(world)), from_centre, world, vec3(disc.radius_m, disc.retroreflection, disc.matt));
}

// Share of a square pixel on one side of a straight edge that its middle is `inside` of; `slope` is what `inside` gains per pixel along u and v.
// A ramp one pixel wide, whatever the edge's direction, would shift the centroid of a disc of six pixels by up to 0.03 pixels.
fn covered(inside: f32, slope: vec2<f32>) -> f32 {
    let steep = max(max(slope.x, slope.y), 1e-7);
    let gentle = max(min(slope.x, slope.y), 1e-4 * steep);
    let reach = 0.5 * (steep + gentle);
    if (abs(inside) <= 0.5 * (steep - gentle)) {
        return 0.5 + inside / steep;
    }
    let left = max(reach - abs(inside), 0.0);
    let corner = left * left / (2.0 * steep * gentle);
    return select(corner, 1.0 - corner, inside > 0.0);
}

// Blended as luminance + (1 − share)·what was there.
@fragment
fn disc_luminance(spot: Spot) -> @location(0) vec4<f32> {
    let distance = length(spot.from_centre_m);
    let from_edge = spot.disc.x - distance;
    // The place changes evenly from pixel to pixel, the distance does not: its own differences would be wrong for a disc of few pixels.
    let outward = spot.from_centre_m / max(distance, 1e-9);
    let slope = vec2(dot(outward, dpdx(spot.from_centre_m)), dot(outward, dpdy(spot.from_centre_m)));
    let share = covered(from_edge, abs(slope));
    var luminance = spot.disc.z * view.lamp_factor;
    if (spot.disc.y > 0.0) {
        // Luminance of a retro-reflector: R_A·E⊥ (CIE 54), for light and eye in one place.
        luminance = spot.disc.z * view.luminance_per_lux;
        if (RING) {
            luminance += spot.disc.y * ring_lux(spot.world - view.eye.xyz, view.ring_candela.xyz);
        }
    }
    return vec4(luminance * share, 0.0, 0.0, share);
}
