// From luminance to grey levels: electrons, shot noise, full well, read noise, gain, 8 bits. Four pixels an invocation.

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
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> readout: Readout;
@group(0) @binding(1) var luminance: texture_2d<f32>;
// Row-major grey levels without padding, four to a word, the first in the lowest byte.
@group(0) @binding(2) var<storage, read_write> grey: array<u32>;

// Above this mean the shot noise is taken as a normal variable with the Poisson law's skewness: the distribution
// functions then differ by less than 0.001 everywhere. Below, the Poisson law is sampled exactly.
const EXACT_BELOW: f32 = 60.0;

@compute @workgroup_size(64)
fn read_out(@builtin(global_invocation_id) id: vec3<u32>) {
    let word = id.y * readout.row + id.x;
    let pixels = readout.size_px.x * readout.size_px.y;
    if (4u * word >= pixels) {
        return;
    }
    var packed = 0u;
    for (var byte = 0u; byte < 4u; byte++) {
        let index = min(4u * word + byte, pixels - 1u);
        packed |= grey_level(index) << (8u * byte);
    }
    grey[word] = packed;
}

fn grey_level(index: u32) -> u32 {
    let place = vec2(index % readout.size_px.x, index / readout.size_px.x);
    let mean = textureLoad(luminance, place, 0).x * readout.electrons_per_luminance;
    let random = pcg4d(vec4(index, readout.image, readout.seed));
    // Box and Muller: two uniform variables give two independent normal ones.
    let radius = sqrt(-2.0 * log(unit(random.x)));
    let angle = 6.2831853 * unit(random.y);
    var electrons = normal_shot(mean, radius * cos(angle));
    if (mean < EXACT_BELOW) {
        electrons = poisson(mean, unit(random.z));
    }
    let collected = min(electrons, readout.full_well_electrons);
    let read = collected + readout.read_noise_electrons * radius * sin(angle);
    return u32(clamp(floor(read * readout.gain_levels_per_electron + 0.5), 0.0, 255.0));
}

// Poisson by inversion: counts while the distribution function is below the uniform variable.
fn poisson(mean: f32, uniform_value: f32) -> f32 {
    var term = exp(-mean);
    var remaining = uniform_value - term;
    var count = 0.0;
    // A mean of 60 exceeds 140 once in 10^17.
    while (remaining > 0.0 && count < 140.0) {
        count += 1.0;
        term *= mean / count;
        remaining -= term;
    }
    return count;
}

// Cornish and Fisher's expansion of the Poisson law to first order: mean + √mean·z + (z² − 1)/6.
fn normal_shot(mean: f32, z: f32) -> f32 {
    return max(floor(mean + sqrt(mean) * z + (z * z - 1.0) / 6.0 + 0.5), 0.0);
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
