// From luminance, which `luminance_at` of ideal.wgsl or lens.wgsl tells, to grey levels by EMVA 1288's linear model: photons and dark current to electrons, shot noise, full well, offsets and
// read noise, gain, black level, 8 to 12 bits. Four pixels an invocation.

// Whether pixels differ in sensitivity, offset and dark current, and whether levels take two bytes.
override UNEVEN: bool = false;
override DEEP: bool = false;

struct Readout {
    size_px: vec2<u32>,
    // First half of the noise key's seed, second half, number of the image.
    seed: vec2<u32>,
    image: u32,
    electrons_per_luminance: f32,
    full_well_electrons: f32,
    read_noise_electrons: f32,
    gain_levels_per_electron: f32,
    // Invocations in a row of workgroups.
    row: u32,
    // One over the width.
    row_per_pixel: f32,
    // Mean over the exposure.
    dark_electrons: f32,
    // Standard deviations of the pixels' offsets, and of their sensitivities as a share.
    offset_electrons: f32,
    sensitivity: f32,
    // Black level and half a level, for rounding.
    lifted_levels: f32,
    greatest_level: f32,
}

// In uniform memory, as the floor's view: no branch depends on it alone.
@group(0) @binding(0) var<uniform> readout: Readout;
// Row-major grey levels without padding, four to a word or two when deep, the first in the lowest bytes.
@group(0) @binding(1) var<storage, read_write> grey: array<u32>;
// Of every pixel its sensitivity as a factor and its offset in electrons: the same in every image of a seed.
@group(0) @binding(2) var<storage, read_write> pattern: array<vec2<f32>>;

// From this mean on, shot noise is taken from a normal variable by Cornish and Fisher's expansion: its distribution function
// then departs from the Poisson law's by 5e-4 at most. Below, the Poisson law is sampled exactly.
const EXACT_BELOW: f32 = 20.0;
// Takes the place of an image's number in what all images share.
const PATTERN_KEY: u32 = 0xFFFFFFFFu;

@compute @workgroup_size(64)
fn read_out(@builtin(global_invocation_id) id: vec3<u32>) {
    let word = id.y * readout.row + id.x;
    let pixels = readout.size_px.x * readout.size_px.y;
    if (4u * word >= pixels) {
        return;
    }
    // Written out: a loop costs a software driver a third more.
    let index = 4u * word;
    if (DEEP) {
        grey[2u * word] = grey_level(index) | (grey_level(index + 1u) << 16u);
        grey[2u * word + 1u] = grey_level(index + 2u) | (grey_level(index + 3u) << 16u);
        return;
    }
    grey[word] = grey_level(index)
        | (grey_level(index + 1u) << 8u)
        | (grey_level(index + 2u) << 16u)
        | (grey_level(index + 3u) << 24u);
}

// Column and row of a pixel. A software driver divides integers one by one, so the row is found in floating point, where
// the half keeps it exact up to 2^22 pixels and the correction beyond.
fn place_of(index: u32) -> vec2<u32> {
    let width = readout.size_px.x;
    var row = u32((f32(index) + 0.5) * readout.row_per_pixel);
    row -= select(0u, 1u, row * width > index);
    row += select(0u, 1u, (row + 1u) * width <= index);
    return vec2(index - row * width, row);
}

// A pixel past the end, in the last word, reads black.
fn grey_level(index: u32) -> u32 {
    let light = luminance_at(index) * readout.electrons_per_luminance;
    if (!UNEVEN) {
        return level_of(light, 0.0, index);
    }
    let own = pattern[index];
    return level_of(light * own.x + readout.dark_electrons, own.y, index);
}

// Draws the pattern, for all images to come.
@compute @workgroup_size(64)
fn lay_pattern(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.y * readout.row + id.x;
    if (index >= arrayLength(&pattern)) {
        return;
    }
    let own = pcg4d(vec4(index, PATTERN_KEY, readout.seed));
    let size = sqrt(-2.0 * log(unit(own.x)));
    let turn = 6.2831853 * unit(own.y);
    let sensitivity = max(1.0 + readout.sensitivity * size * cos(turn), 0.0);
    pattern[index] = vec2(sensitivity, readout.offset_electrons * size * sin(turn));
}

// Grey level of a pixel that gets `mean` electrons on average and reads `offset` more.
fn level_of(mean: f32, offset: f32, index: u32) -> u32 {
    let random = pcg4d(vec4(index, readout.image, readout.seed));
    // Box and Muller: two uniform variables give two independent normal ones.
    let radius = sqrt(-2.0 * log(unit(random.x)));
    let angle = 6.2831853 * unit(random.y);
    var electrons = normal_shot(mean, radius * cos(angle));
    if (mean < EXACT_BELOW) {
        electrons = poisson(mean, unit(random.z));
    }
    let collected = min(electrons, readout.full_well_electrons) + offset;
    let read = collected + readout.read_noise_electrons * radius * sin(angle);
    let level = floor(read * readout.gain_levels_per_electron + readout.lifted_levels);
    return u32(clamp(level, 0.0, readout.greatest_level));
}

// Poisson by inversion: counts while the distribution function is below the uniform variable.
fn poisson(mean: f32, uniform_value: f32) -> f32 {
    var term = exp(-mean);
    var remaining = uniform_value - term;
    var count = 0.0;
    // A mean of 20 exceeds 80 once in 10^24.
    while (remaining > 0.0 && count < 80.0) {
        count += 1.0;
        term *= mean / count;
        remaining -= term;
    }
    return count;
}

// Poisson by Cornish and Fisher's expansion: mean + √mean·z + (z² − 1)/6 + (z − z³)/(72·√mean), rounded. Rounding adds
// a variance of 1/12, which is taken off first.
fn normal_shot(mean: f32, z: f32) -> f32 {
    let deviation = sqrt(max(mean - 1.0 / 12.0, 1.0));
    let skewed = mean + deviation * z + (z * z - 1.0) / 6.0 + (z - z * z * z) / (72.0 * deviation);
    return max(floor(skewed + 0.5), 0.0);
}

// In (0, 1), never an end: 23 bits and half a step fill single precision.
fn unit(bits: u32) -> f32 {
    return (f32(bits >> 9u) + 0.5) / 8388608.0;
}

// Counter-based generator of Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020.
fn pcg4d(counter: vec4<u32>) -> vec4<u32> {
    var v = counter * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> vec4(16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}
