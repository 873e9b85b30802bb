// From the plate to the sensor: each pixel looks up where the lens takes its light from. Follows photons.wgsl.

struct Sheet {
    // Focal lengths and principal point of the plate.
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    // One over the plate's size.
    per_size: vec2<f32>,
    // Where the sensor's first pixel lies on the plate unless it is bent.
    shift_px: vec2<f32>,
    // Sub-frames, and the share of one in the exposure.
    n_plates: u32,
    share: f32,
    defocus_radius_px: f32,
    // One step of the map of places.
    step_px: f32,
}

override BENT: bool = false;
override DEFOCUSED: bool = false;
override VIGNETTING: bool = false;

@group(1) @binding(0) var<uniform> sheet: Sheet;
// Mean over the sub-frames.
@group(1) @binding(1) var plate: texture_2d<f32>;
// How far the lens bends every pixel of the sensor away, in steps.
@group(1) @binding(2) var bends: texture_2d<i32>;
@group(1) @binding(3) var between: sampler;

// The four pixels around a corner between pixels, which a software driver reads in half the time of a filtered look: lower left, lower right,
// upper right, upper left in the order of the plate's rows, which run down.
fn around(corner: vec2<f32>, per_size: vec2<f32>) -> vec4<f32> {
    return textureGather(0, plate, between, corner * per_size);
}

// Linear between pixels.
fn linear_at(place: vec2<f32>, per_size: vec2<f32>) -> f32 {
    let low = floor(place);
    let off = place - low;
    let four = around(low + 1.0, per_size);
    return mix(mix(four.w, four.z, off.x), mix(four.x, four.y, off.x), off.y);
}

// The quadratic B-spline through 3 × 3 pixels: the mean place of its weights is the place itself, so that nothing moves. Where a lens
// stretches the plate by a tenth, linear weights count some pixels of a dot a tenth more often than others, which moved dots by 0.02 px at a
// time; these count them alike to a hundredth.
fn smooth_at(place: vec2<f32>, per_size: vec2<f32>) -> f32 {
    let middle = round(place);
    let off = place - middle;
    let before = 0.5 * (0.5 - off) * (0.5 - off);
    let after = 0.5 * (0.5 + off) * (0.5 + off);
    let here = 1.0 - before - after;
    let first = around(middle, per_size);
    let second = around(middle + vec2(1.0, 0.0), per_size);
    let third = around(middle + vec2(0.0, 1.0), per_size);
    let last = around(middle + 1.0, per_size);
    return before.y * (before.x * first.w + here.x * first.z + after.x * second.z)
        + here.y * (before.x * first.x + here.x * first.y + after.x * second.y)
        + after.y * (before.x * third.x + here.x * third.y + after.x * last.y);
}

fn optics() -> Optics {
    return Optics(vec4(sheet.shift_px, sheet.step_px, sheet.defocus_radius_px), vec4(sheet.centre_px, 1.0 / sheet.focal_px), sheet.per_size);
}

fn luminance_at(pixel: vec2<u32>, lens: Optics) -> f32 {
    var place = vec2<f32>(pixel) + lens.placing.xy;
    if (BENT || DEFOCUSED) {
        place += vec2<f32>(textureLoad(bends, pixel, 0).xy) * lens.placing.z;
    }
    var luminance = 0.0;
    if (DEFOCUSED) {
        // Places spread evenly over the disc by the golden angle.
        for (var spot = 0; spot < 24; spot++) {
            let radius = lens.placing.w * sqrt((f32(spot) + 0.5) / 24.0);
            let angle = f32(spot) * 2.3999632;
            luminance += linear_at(place + radius * vec2(cos(angle), sin(angle)), lens.per_size) / 24.0;
        }
    } else if (BENT) {
        luminance = smooth_at(place, lens.per_size);
    } else {
        // The plate is the picture.
        luminance = textureLoad(plate, pixel, 0).x;
    }
    if (VIGNETTING) {
        // cos⁴ of the angle off the axis; its tangent is the distance on the plate over the focal length.
        let tangent = (place - lens.axis.xy) * lens.axis.zw;
        let square = 1.0 + dot(tangent, tangent);
        luminance /= square * square;
    }
    return luminance;
}
