// From the plate to the sensor: each pixel looks up where the lens takes its light from.

struct Sheet {
    // Focal lengths and principal point of the plate.
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    width_px: u32,
    // Share of this sub-frame in the exposure.
    share: f32,
    defocus_radius_px: f32,
    padding: f32,
}

override BENT: bool = false;
override DEFOCUSED: bool = false;
override VIGNETTING: bool = false;

@group(0) @binding(0) var<storage, read> sheet: Sheet;
@group(0) @binding(1) var plate: texture_multisampled_2d<f32>;
// Place on the plate of every pixel of the sensor, row by row.
@group(0) @binding(2) var<storage, read> places_px: array<vec2<f32>>;

@vertex
fn sheet_corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle over everything.
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Mean of a pixel's samples.
fn pixel_of(at: vec2<i32>) -> f32 {
    return 0.25 * (textureLoad(plate, at, 0).x + textureLoad(plate, at, 1).x
        + textureLoad(plate, at, 2).x + textureLoad(plate, at, 3).x);
}

// Between pixels linear in both directions: weights whose mean place is the place itself, so that nothing moves.
fn between(place: vec2<f32>) -> f32 {
    let cell = floor(place);
    let f = place - cell;
    let at = vec2<i32>(cell);
    let low = mix(pixel_of(at), pixel_of(at + vec2(1, 0)), f.x);
    let high = mix(pixel_of(at + vec2(0, 1)), pixel_of(at + vec2(1, 1)), f.x);
    return mix(low, high, f.y);
}

@fragment
fn sheet_luminance(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    var place = position.xy - 0.5;
    if (BENT || DEFOCUSED) {
        place = places_px[pixel.y * sheet.width_px + pixel.x];
    }
    var luminance = 0.0;
    if (DEFOCUSED) {
        // Places spread evenly over the disc by the golden angle.
        for (var index = 0; index < 24; index++) {
            let radius = sheet.defocus_radius_px * sqrt((f32(index) + 0.5) / 24.0);
            let angle = f32(index) * 2.3999632;
            luminance += between(place + radius * vec2(cos(angle), sin(angle))) / 24.0;
        }
    } else if (BENT) {
        luminance = between(place);
    } else {
        luminance = pixel_of(vec2<i32>(pixel));
    }
    if (VIGNETTING) {
        // cos⁴ of the angle off the axis; its tangent is the distance on the plate over the focal length.
        let tangent = (place - sheet.centre_px) / sheet.focal_px;
        let square = 1.0 + dot(tangent, tangent);
        luminance /= square * square;
    }
    return vec4(luminance * sheet.share, 0.0, 0.0, 1.0);
}
