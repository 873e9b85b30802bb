// What every pass over the floor knows of its view.
//
// Frame `local`: the grid frame of the tiles, moved to the nominal corner nearest to the camera, so that single
// precision keeps 1e-4 px in a hall of any size. A software driver executes both sides of every `if`: what is needed only
// in places is therefore drawn only there, as geometry of its own.

// Homography from pixels about the principal point to the local frame: rows of a 3 × 3 matrix. The third component is
// positive where the floor is in front of the camera.
struct Homography {
    x: vec4<f32>,
    y: vec4<f32>,
    depth: vec4<f32>,
}

struct View {
    // At the first instant of the exposure, in its middle, and at the last.
    start: Homography,
    middle: Homography,
    end: Homography,
    // From the local frame to clip space in the middle of the exposure: columns x, y, 1; components x, y, w.
    clip_from_local: array<vec4<f32>, 3>,
    principal_point_px: vec2<f32>,
    sub_frames: u32,
    pattern_samples: u32,
    // Gradient of ln E (1/m), and E/π at the local origin (cd/m² for albedo 1).
    light_gradient: vec2<f32>,
    light_at_origin: f32,
    pattern_contrast: f32,
    // Distance between printed stripes (m).
    stripe_spacing_m: f32,
    // Share of the time that a row is exposed for.
    exposed_share: f32,
    plate_size_px: vec2<f32>,
    // k1, k2, p1, p2 and k3 of Brown and Conrady, and one over the focal length.
    distortion: vec4<f32>,
    distortion_k3: f32,
    per_focal_px: f32,
    // When a row's exposure starts, as a share of the time: on the optical axis, and for each focal length below it.
    first_share: f32,
    share_per_slope: f32,
    // At the ends of the sub-frames.
    sub_frame_ends: array<Homography, 33>, // MAX_SUB_FRAMES of exposure.rs, and one
}

// Whether rows are exposed one after the other. The start is then that of the first row's exposure and the end that of the last row's.
override ROLLING: bool = false;

// In uniform memory. What a fragment shader reads of it often travels with the corners instead: a software driver loads even a uniform number
// anew for each pixel, but holds one number for all pixels of a triangle.
@group(0) @binding(0) var<uniform> view: View;
// The same in storage, for what a branch or a loop depends on: lavapipe compiles a shader anew for every new value of such
// a uniform, which takes 90 ms and is never freed.
@group(0) @binding(1) var<storage, read> counted: View;

// The pixel whose centre the rasteriser calls (0.5, 0.5), about the principal point.
fn pixel_at(position: vec4<f32>) -> vec3<f32> {
    return vec3(position.xy - 0.5 - view.principal_point_px, 1.0);
}

fn place_at(homography: Homography, pixel: vec3<f32>) -> vec2<f32> {
    let place = vec2(dot(homography.x.xyz, pixel), dot(homography.y.xyz, pixel));
    return place / dot(homography.depth.xyz, pixel);
}

// The way of a pixel over the floor while rows are exposed: the parabola through its places at the start, in the middle and at the end.
struct Way {
    start: vec2<f32>,
    speed: vec2<f32>,
    bend: vec2<f32>,
}

fn way_through(start: vec2<f32>, middle: vec2<f32>, end: vec2<f32>) -> Way {
    let bend = 2.0 * (start - 2.0 * middle + end);
    return Way(start, end - start - bend, bend);
}

fn way_of(pixel: vec3<f32>) -> Way {
    return way_through(place_at(view.start, pixel), place_at(view.middle, pixel), place_at(view.end, pixel));
}

// At a share of the time.
fn on_way(way: Way, time: f32) -> vec2<f32> {
    return way.start + time * (way.speed + time * way.bend);
}

// When the exposure of a pixel's row starts, as a share of the time. Corners beyond the picture have times beyond its own, up to its height.
fn exposed_from(pixel: vec3<f32>) -> f32 {
    let slope = slope_on_sensor(pixel.xy * view.per_focal_px, view.distortion, view.distortion_k3);
    let read = 1.0 - view.exposed_share;
    return clamp(view.first_share + view.share_per_slope * slope, -read, 2.0 * read);
}

// How the place moves with the pixel: ∂(n/d) = (∂n − (n/d)·∂d)/d; columns for u and v.
fn sides_at(homography: Homography, pixel: vec3<f32>, place: vec2<f32>) -> mat2x2<f32> {
    let depth = dot(homography.depth.xyz, pixel);
    return mat2x2(
        (vec2(homography.x.x, homography.y.x) - place * homography.depth.x) / depth,
        (vec2(homography.x.y, homography.y.y) - place * homography.depth.y) / depth,
    );
}

// Luminance of a matt surface of albedo 1.
fn light_at(place: vec2<f32>) -> f32 {
    return view.light_at_origin * exp(dot(view.light_gradient, place));
}

fn clip_at(place: vec2<f32>) -> vec4<f32> {
    let clip = view.clip_from_local[0].xyz * place.x + view.clip_from_local[1].xyz * place.y + view.clip_from_local[2].xyz;
    // The floor needs no depth; half of w is inside the depth range.
    return vec4(clip.xy, 0.5 * clip.z, clip.z);
}

// Where the middle pose shows what each row sees at this place: time decides the row and the row the time, a contraction as long as the
// image moves slower than its rows are read.
fn on_its_row(place: vec2<f32>) -> vec2<f32> {
    if (!ROLLING) {
        return place;
    }
    var shown = place;
    for (var round = 0; round < 8; round++) {
        let clip = clip_at(shown);
        if (clip.w <= 0.0) {
            return place;
        }
        let corner_px = (vec2(clip.x, -clip.y) / clip.w + 1.0) * 0.5 * view.plate_size_px;
        let pixel = vec3(corner_px - 0.5 - view.principal_point_px, 1.0);
        shown += place - on_way(way_of(pixel), exposed_from(pixel) + 0.5 * view.exposed_share);
    }
    return shown;
}
