// Edges of faces: what one sample a pixel has made into steps is mixed anew from the colours on both sides, by the share of the pixel on each.

struct Edge {
    @location(0) start: vec3<f32>,
    @location(1) end: vec3<f32>,
    // Of the faces on both sides; 0 where only the first counts.
    @location(2) normal: vec3<f32>,
    @location(3) other_normal: vec3<f32>,
    @location(4) start_velocity: vec3<f32>,
    @location(5) end_velocity: vec3<f32>,
}

struct Seam {
    @builtin(position) @invariant position: vec4<f32>,
    // Unit normal in pixels, and what makes the distance from the line 0 on it.
    @location(0) @interpolate(flat) line: vec3<f32>,
}

// An edge is drawn this much nearer than it is, so that the face beside it, which comes nearer from pixel to pixel, does not hide it.
const NEARER: f32 = 1.03;
// Half of the strip's width in pixels: as far as a pixel's corner reaches.
const REACH_PX: f32 = 0.75;

@group(2) @binding(0) var stepped: texture_2d<f32>;

fn on_plate(seen: vec3<f32>) -> vec2<f32> {
    return seen.xy / seen.z * view.plate_focal_px + view.plate_centre_px;
}

@vertex
fn edge_corner(@builtin(vertex_index) index: u32, edge: Edge) -> Seam {
    let way = view.eye.xyz - edge.start;
    // Two faces that are both seen, or both not, have no outline between them.
    let outline = (dot(way, edge.normal) > 0.0) != (dot(way, edge.other_normal) > 0.0);
    var start = moving_in_camera(edge.start, edge.start_velocity);
    var end = moving_in_camera(edge.end, edge.end_velocity);
    let near = NEARER * NEAR_M;
    if (!outline || max(start.z, end.z) <= near) {
        return Seam(vec4(2.0, 2.0, 2.0, 1.0), vec3(0.0));
    }
    let steep = end.z - start.z;
    if (start.z < near) {
        start += (end - start) * ((near - start.z) / steep);
    }
    if (end.z < near) {
        end = start + (end - start) * ((near - start.z) / steep);
    }
    let from_px = on_plate(start);
    let along = on_plate(end) - from_px;
    let normal = vec2(-along.y, along.x) / max(length(along), 1e-6);
    let here = select(start, end, (index & 1u) == 1u);
    let side = f32(index >> 1u) * 2.0 - 1.0;
    let at = (on_plate(here) + normal * side * REACH_PX + 0.5) * 2.0 / view.plate_size_px - 1.0;
    let position = vec4(at.x * here.z, -at.y * here.z, near, here.z);
    return Seam(position, vec3(normal, -dot(normal, from_px)));
}

@fragment
fn edge_luminance(seam: Seam) -> @location(0) vec4<f32> {
    let from_line = dot(seam.line.xy, seam.position.xy - 0.5) + seam.line.z;
    // To the pixel that lies wholly on the other side.
    let across = abs(seam.line.xy);
    let towards = -sign(seam.line.xy) * select(-1.0, 1.0, from_line >= 0.0);
    let steep = across.x >= across.y;
    let step = vec2<i32>(select(vec2(0.0, towards.y), vec2(towards.x, 0.0), steep));
    let at = vec2<i32>(seam.position.xy);
    let limit = vec2<i32>(view.plate_size_px) - 1;
    let here = textureLoad(stepped, at, 0).x;
    let beside = textureLoad(stepped, clamp(at + step, vec2(0), limit), 0).x;
    // Below 0 is nothing: a crack between two faces that meet.
    let own = select(here, beside, here < 0.0);
    let other = select(beside, here, beside < 0.0);
    return vec4(mix(own, other, covered(-abs(from_line), across)), 0.0, 0.0, 1.0);
}
