// From the plates of the sub-frames to the sensor: each pixel looks up where the lens takes its light from. Follows photons.wgsl.

struct Sheet {
    // Focal lengths and principal point of the plate.
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    // One over the plate's size.
    per_size: vec2<f32>,
    n_plates: u32,
    // Share of a sub-frame in the exposure.
    share: f32,
    defocus_radius_px: f32,
    padding: f32,
}

override BENT: bool = false;
override DEFOCUSED: bool = false;
override VIGNETTING: bool = false;

@group(1) @binding(0) var<storage, read> sheet: Sheet;
// One layer for each sub-frame.
@group(1) @binding(1) var plates: texture_2d_array<f32>;
// Place on the plate of every pixel of the sensor, row by row.
@group(1) @binding(2) var<storage, read> places_px: array<vec2<f32>>;
@group(1) @binding(3) var between: sampler;

// Mean over the sub-frames. Between pixels linear in both directions: weights whose mean place is the place itself, so that nothing moves.
fn mean_at(place: vec2<f32>) -> f32 {
    let at = (place + 0.5) * sheet.per_size;
    var sum = textureSampleLevel(plates, between, at, 0, 0.0).x;
    for (var plate = 1u; plate < sheet.n_plates; plate++) {
        sum += textureSampleLevel(plates, between, at, i32(plate), 0.0).x;
    }
    return sum * sheet.share;
}

fn luminance_at(index: u32) -> f32 {
    var place = vec2<f32>(place_of(index));
    if (BENT || DEFOCUSED) {
        place = places_px[index];
    }
    var luminance = 0.0;
    if (DEFOCUSED) {
        // Places spread evenly over the disc by the golden angle.
        for (var spot = 0; spot < 24; spot++) {
            let radius = sheet.defocus_radius_px * sqrt((f32(spot) + 0.5) / 24.0);
            let angle = f32(spot) * 2.3999632;
            luminance += mean_at(place + radius * vec2(cos(angle), sin(angle))) / 24.0;
        }
    } else {
        luminance = mean_at(place);
    }
    if (VIGNETTING) {
        // cos⁴ of the angle off the axis; its tangent is the distance on the plate over the focal length.
        let tangent = (place - sheet.centre_px) / sheet.focal_px;
        let square = 1.0 + dot(tangent, tangent);
        luminance /= square * square;
    }
    return luminance;
}
