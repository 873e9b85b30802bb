// What every pass over a room knows of its view, and how a place becomes a pixel of the plate.
//
// The plate is the image before the lens bends it: a pinhole's, with a margin. Frame `camera`: x right, y down, z forward.

struct View {
    // Rows of camera_from_world while the middle row is exposed.
    camera_from_world: array<vec4<f32>, 3>,
    // How the camera turns (rad/s) and moves (m/s) while rows are read out, in its own frame.
    turn: vec4<f32>,
    drift: vec4<f32>,
    // Focal lengths and principal point of the plate, (0, 0) the centre of its first pixel.
    plate_focal_px: vec2<f32>,
    plate_centre_px: vec2<f32>,
    plate_size_px: vec2<f32>,
    // Along v, of the sensor.
    sensor_focal_px: f32,
    sensor_centre_px: f32,
    // k1, k2, p1, p2 and k3 of Brown and Conrady.
    distortion: vec4<f32>,
    distortion_k3: f32,
    row_time_s: f32,
    middle_row: f32,
    last_row: f32,
    // Of the camera, world.
    eye: vec4<f32>,
    // Equivalent candela of the ring, along the axis.
    ring_candela: vec4<f32>,
    // Luminance of an albedo of 1 for each equivalent lux of the map; luminance of lamps for that of their buffer.
    luminance_per_lux: f32,
    lamp_factor: f32,
    // Rectangles come first.
    first_bulb: u32,
    // Surfaces that are looked for in a puddle.
    mirrored_count: u32,
    // From when people were placed to when the middle row is exposed.
    bodies_s: f32,
    // Luminance of the sky.
    sky: f32,
    padding_b: u32,
    padding_c: u32,
}

override ROLLING: bool = false;
override RING: bool = false;
// 0 visible, 1 infrared.
override BAND: u32 = 0u;

const NEAR_M: f32 = 0.02;

// In uniform memory, and in storage what loops depend on, as in the floor's view.wgsl; for faces both travel with the corners.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> counted: View;

// Row of a point of the plane at depth 1.
fn sensor_row(at: vec2<f32>) -> f32 {
    return view.sensor_focal_px * slope_on_sensor(at, view.distortion, view.distortion_k3) + view.sensor_centre_px;
}

// A place in the camera's frame `time` seconds after the middle row: R(turn·time)ᵀ·(p − drift·time), by Rodrigues' formula.
fn at_time(place: vec3<f32>, time: f32) -> vec3<f32> {
    let p = place - view.drift.xyz * time;
    let vector = -view.turn.xyz * time;
    let angle = max(length(vector), 1e-9);
    let axis = vector / angle;
    return p * cos(angle) + cross(axis, p) * sin(angle) + axis * dot(axis, p) * (1.0 - cos(angle));
}

// The row that a place is seen on. Corners beyond the picture have times beyond its own, up to its height: what lies between them and a corner
// within is seen at times between.
fn exposed_row(seen: vec3<f32>) -> f32 {
    return clamp(sensor_row(seen.xy / max(seen.z, NEAR_M)), -view.last_row, 2.0 * view.last_row);
}

// The place as the row sees it on which it is seen: the time decides the row and the row the time, a contraction as long as
// the image moves slower than its rows are read.
fn in_camera(world: vec3<f32>) -> vec3<f32> {
    let h = vec4(world, 1.0);
    let middle = vec3(
        dot(view.camera_from_world[0], h),
        dot(view.camera_from_world[1], h),
        dot(view.camera_from_world[2], h),
    );
    if (!ROLLING) {
        return middle;
    }
    var seen = middle;
    for (var round = 0; round < 4; round++) {
        let row = exposed_row(seen);
        seen = at_time(middle, (row - view.middle_row) * view.row_time_s);
    }
    return seen;
}

// The same of a place that moves: where it is when the row sees it on which it is seen.
fn moving_in_camera(world: vec3<f32>, velocity: vec3<f32>) -> vec3<f32> {
    let seen = in_camera(world + velocity * view.bodies_s);
    if (!ROLLING) {
        return seen;
    }
    let row = exposed_row(seen);
    return in_camera(world + velocity * (view.bodies_s + (row - view.middle_row) * view.row_time_s));
}

// Depth is near/z, so that it is 1 at the near plane and single precision serves far places too.
fn clip_of(seen: vec3<f32>) -> vec4<f32> {
    let centre = (view.plate_centre_px + 0.5) * 2.0 / view.plate_size_px - 1.0;
    let xy = seen.xy * view.plate_focal_px * 2.0 / view.plate_size_px + centre * seen.z;
    return vec4(xy.x, -xy.y, NEAR_M, seen.z);
}

// Equivalent lux that the ring gives on a plane across the ray, this `way` from the eye; its light falls with the cosine off the axis, along
// which `candela` points.
fn ring_lux(way: vec3<f32>, candela: vec3<f32>) -> f32 {
    let square = max(dot(way, way), 1e-4);
    return max(dot(way, candela), 0.0) / (square * sqrt(square));
}

const PI: f32 = 3.14159265;
