// From luminance, which `luminance_at` of ideal.wgsl or lens.wgsl tells, to grey levels by EMVA 1288's linear model: photons and dark current to electrons, shot noise, full well, offsets and
// read noise, gain, black level, 8 to 12 bits. Follows readout.wgsl.

// Whether pixels differ in sensitivity, offset and dark current.
override UNEVEN: bool = false;

// As pattern.wgsl laid it. A software driver reads a texture for eight pixels at once, where from storage it loads pixel by pixel.
@group(0) @binding(1) var pattern: texture_2d<f32>;

// From this mean on, shot noise is taken from a normal variable by Cornish and Fisher's expansion: its distribution function
// then departs from the Poisson law's by 5e-4 at most. Below, the Poisson law is sampled exactly.
const EXACT_BELOW: f32 = 20.0;
// A triangle over the whole picture: a software driver runs a fragment shader on sixteen pixels at once, where a compute shader costs it 2 ms a
// picture of 640 × 480 before it does anything.
@vertex
fn whole_picture(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn read_out(@builtin(position) position: vec4<f32>) -> @location(0) u32 {
    let place = vec2<u32>(position.xy);
    let index = place.y * readout.size_px.x + place.x;
    let light = luminance_at(place) * readout.electrons_per_luminance;
    if (!UNEVEN) {
        return level_of(light, 0.0, index);
    }
    let own = textureLoad(pattern, place, 0).xy;
    return level_of(light * own.x + readout.dark_electrons, own.y, index);
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
