// From the plate to the sensor: each pixel looks up where the lens takes its light from. Follows photons.wgsl.

struct Sheet {
    // Focal lengths, principal point and size of the plate.
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    size_px: vec2<f32>,
    defocus_radius_px: f32,
    padding: f32,
}

override BENT: bool = false;
override DEFOCUSED: bool = false;
override VIGNETTING: bool = false;
// Whether what lamps give is laid over the plate.
override LAMPLIT: bool = false;

// Places along each side of the lamplight, as in cut.rs.
const LAMPLIGHT_PX: f32 = 65.0;

@group(1) @binding(0) var<uniform> sheet: Sheet;
// Mean over the sub-frames.
@group(1) @binding(1) var plate: texture_2d<f32>;
@group(1) @binding(2) var between: sampler;
// A factor, from the plate's first pixel to its last.
@group(1) @binding(3) var lamplight: texture_2d<f32>;

// A rectangle of the sensor whose places on the plate are a pixel's own number and a polynomial, as in map.rs.
struct Cell {
    // First pixel, and the one after the last.
    @location(0) bounds: vec4<f32>,
    @location(1) one_u: vec4<f32>,
    @location(2) v_uu: vec4<f32>,
    @location(3) uv_vv: vec4<f32>,
    @location(4) uuu_uuv: vec4<f32>,
    @location(5) uvv_vvv: vec4<f32>,
}

struct Picture {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) key: vec4<u32>,
    @location(1) @interpolate(flat) electrons: vec4<f32>,
    @location(2) @interpolate(flat) levels: vec4<f32>,
    @location(3) @interpolate(flat) own: vec4<f32>,
    // The cell's terms, and the pixel from which they count.
    @location(4) @interpolate(flat) one_u: vec4<f32>,
    @location(5) @interpolate(flat) v_uu: vec4<f32>,
    @location(6) @interpolate(flat) uv_vv: vec4<f32>,
    @location(7) @interpolate(flat) uuu_uuv: vec4<f32>,
    @location(8) @interpolate(flat) uvv_vvv: vec4<f32>,
    @location(9) @interpolate(flat) middle: vec2<f32>,
    // The optical axis on the plate, and one over the focal lengths.
    @location(10) @interpolate(flat) axis: vec4<f32>,
    // One over the plate's size, and the radius of defocus.
    @location(11) @interpolate(flat) plate: vec3<f32>,
    // From the plate's first pixel to its last.
    @location(12) @interpolate(flat) last: vec2<f32>,
}

@vertex
fn picture_corner(@builtin(vertex_index) index: u32, cell: Cell) -> Picture {
    let corner = vec2(select(cell.bounds.x, cell.bounds.z, (index & 1u) == 1u), select(cell.bounds.y, cell.bounds.w, index >= 2u));
    let at = corner * 2.0 / vec2<f32>(readout.size_px) - 1.0;
    let sensor = sensor();
    return Picture(
        vec4(at.x, -at.y, 0.0, 1.0),
        sensor.key,
        sensor.electrons,
        sensor.levels,
        sensor.own,
        cell.one_u,
        cell.v_uu,
        cell.uv_vv,
        cell.uuu_uuv,
        cell.uvv_vvv,
        0.5 * (cell.bounds.xy + cell.bounds.zw - 1.0),
        vec4(sheet.centre_px, 1.0 / sheet.focal_px),
        vec3(1.0 / sheet.size_px, sheet.defocus_radius_px),
        max(sheet.size_px - 1.0, vec2(1.0)),
    );
}

// Place on the plate of a pixel.
fn place_of(pixel: vec2<f32>, cell: Picture) -> vec2<f32> {
    let off = pixel - cell.middle;
    let along_u = cell.one_u.zw + off.x * (cell.v_uu.zw + off.x * cell.uuu_uuv.xy + off.y * cell.uuu_uuv.zw) + off.y * cell.uv_vv.xy;
    let along_v = cell.v_uu.xy + off.y * (cell.uv_vv.zw + off.x * cell.uvv_vvv.xy + off.y * cell.uvv_vvv.zw);
    return pixel + (cell.one_u.xy + off.x * along_u + off.y * along_v);
}

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

@fragment
fn read_out(picture: Picture) -> @location(0) u32 {
    let pixel = vec2<u32>(picture.position.xy);
    var place = vec2<f32>(pixel);
    if (BENT || DEFOCUSED) {
        place = place_of(place, picture);
    }
    var luminance = 0.0;
    if (DEFOCUSED) {
        // Places spread evenly over the disc by the golden angle.
        for (var spot = 0; spot < 24; spot++) {
            let radius = picture.plate.z * sqrt((f32(spot) + 0.5) / 24.0);
            let angle = f32(spot) * 2.3999632;
            luminance += linear_at(place + radius * vec2(cos(angle), sin(angle)), picture.plate.xy) / 24.0;
        }
    } else if (BENT) {
        luminance = smooth_at(place, picture.plate.xy);
    } else {
        // The plate is the picture.
        luminance = textureLoad(plate, pixel, 0).x;
    }
    if (LAMPLIT) {
        let at = (place / picture.last * (LAMPLIGHT_PX - 1.0) + 0.5) / LAMPLIGHT_PX;
        luminance *= textureSampleLevel(lamplight, between, at, 0.0).x;
    }
    if (VIGNETTING) {
        // cos⁴ of the angle off the axis; its tangent is the distance on the plate over the focal length.
        let tangent = (place - picture.axis.xy) * picture.axis.zw;
        let square = 1.0 + dot(tangent, tangent);
        luminance /= square * square;
    }
    return level_at(pixel, luminance, Sensor(picture.key, picture.electrons, picture.levels, picture.own));
}
