// From luminance, which lens.wgsl looks up, to grey levels by EMVA 1288's linear model: photons and dark current to electrons, shot noise, full well, offsets and
// read noise, gain, black level, 8 to 12 bits. Follows readout.wgsl.

// Whether pixels differ in sensitivity, offset and dark current.
override UNEVEN: bool = false;

// As pattern.wgsl laid it.
@group(0) @binding(1) var pattern: texture_2d<f32>;

// From this mean on, shot noise is taken from a normal variable by Cornish and Fisher's expansion: its distribution function
// then departs from the Poisson law's by 5e-4 at most. Below, the Poisson law is sampled exactly.
const EXACT_BELOW: f32 = 20.0;

// The sensor as a picture's corners carry it.
struct Sensor {
    // Width of the picture, both halves of the seed, number of the image.
    key: vec4<u32>,
    // Electrons per luminance and in the dark, the full well, and the noise of reading.
    electrons: vec4<f32>,
    // Levels per electron, the black level lifted by half a level, and the greatest.
    levels: vec4<f32>,
    // What the pattern makes of sensitivity and offset: where it is 0, and for each of its unit.
    own: vec4<f32>,
}

fn sensor() -> Sensor {
    let spread = vec2(readout.sensitivity, readout.offset_electrons) / DEVIATION;
    return Sensor(
        vec4(readout.size_px.x, readout.seed, readout.image),
        vec4(readout.electrons_per_luminance, readout.dark_electrons, readout.full_well_electrons, readout.read_noise_electrons),
        vec4(readout.gain_levels_per_electron, readout.lifted_levels, readout.greatest_level, 0.0),
        vec4(vec2(1.0, 0.0) - MIDDLE * spread, 255.0 * spread),
    );
}

// Grey level of a pixel on which light of this luminance falls.
fn level_at(pixel: vec2<u32>, luminance: f32, sensor: Sensor) -> u32 {
    let light = luminance * sensor.electrons.x;
    if (!UNEVEN) {
        return level_of(light, 0.0, pixel, sensor);
    }
    let own = sensor.own.xy + sensor.own.zw * textureLoad(pattern, pixel, 0).xy;
    return level_of(light * max(own.x, 0.0) + sensor.electrons.y, own.y, pixel, sensor);
}

// Grey level of a pixel that gets `mean` electrons on average and reads `offset` more.
fn level_of(mean: f32, offset: f32, pixel: vec2<u32>, sensor: Sensor) -> u32 {
    let random = pcg4d(vec4(pixel.y * sensor.key.x + pixel.x, sensor.key.w, sensor.key.yz));
    // Box and Muller: two uniform variables give two independent normal ones.
    let radius = sqrt(-2.0 * log(unit(random.x)));
    let angle = 6.2831853 * unit(random.y);
    var electrons = normal_shot(mean, radius * cos(angle));
    if (mean < EXACT_BELOW) {
        electrons = poisson(mean, unit(random.z));
    }
    let collected = min(electrons, sensor.electrons.z) + offset;
    let read = collected + sensor.electrons.w * radius * sin(angle);
    let level = floor(read * sensor.levels.x + sensor.levels.y);
    return u32(clamp(level, 0.0, sensor.levels.z));
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
