// From luminance, which `luminance_at` of ideal.wgsl or lens.wgsl tells, to grey levels by EMVA 1288's linear model: photons and dark current to electrons, shot noise, full well, offsets and
// read noise, gain, black level, 8 to 12 bits. Follows readout.wgsl.

// Whether pixels differ in sensitivity, offset and dark current.
override UNEVEN: bool = false;

// As pattern.wgsl laid it.
@group(0) @binding(1) var pattern: texture_2d<f32>;

// From this mean on, shot noise is taken from a normal variable by Cornish and Fisher's expansion: its distribution function
// then departs from the Poisson law's by 5e-4 at most. Below, the Poisson law is sampled exactly.
const EXACT_BELOW: f32 = 20.0;

// A lens as a picture's corners carry it.
struct Optics {
    // A pixel's place on the plate where nothing bends it, less the pixel; a step of the map of places; radius of defocus.
    placing: vec4<f32>,
    // The optical axis on the plate, and one over the focal lengths.
    axis: vec4<f32>,
    // One over the plate's size.
    per_size: vec2<f32>,
}

struct Picture {
    @builtin(position) position: vec4<f32>,
    // Width of the picture, both halves of the seed, number of the image.
    @location(0) @interpolate(flat) key: vec4<u32>,
    // Electrons per luminance and in the dark, the full well, and the noise of reading.
    @location(1) @interpolate(flat) electrons: vec4<f32>,
    // Levels per electron, the black level lifted by half a level, and the greatest.
    @location(2) @interpolate(flat) levels: vec3<f32>,
    // What a byte of the pattern makes of sensitivity and offset: what none makes, and then each step of 1/255.
    @location(3) @interpolate(flat) own: vec4<f32>,
    // Of the lens.
    @location(4) @interpolate(flat) placing: vec4<f32>,
    @location(5) @interpolate(flat) axis: vec4<f32>,
    @location(6) @interpolate(flat) per_size: vec2<f32>,
}

@vertex
fn picture_corner(@builtin(vertex_index) index: u32) -> Picture {
    let lens = optics();
    let spread = vec2(readout.sensitivity, readout.offset_electrons) / DEVIATION;
    return Picture(
        whole_picture(index),
        vec4(readout.size_px.x, readout.seed, readout.image),
        vec4(readout.electrons_per_luminance, readout.dark_electrons, readout.full_well_electrons, readout.read_noise_electrons),
        vec3(readout.gain_levels_per_electron, readout.lifted_levels, readout.greatest_level),
        vec4(vec2(1.0, 0.0) - MIDDLE * spread, 255.0 * spread),
        lens.placing,
        lens.axis,
        lens.per_size,
    );
}

@fragment
fn read_out(picture: Picture) -> @location(0) u32 {
    let place = vec2<u32>(picture.position.xy);
    let light = luminance_at(place, Optics(picture.placing, picture.axis, picture.per_size)) * picture.electrons.x;
    if (!UNEVEN) {
        return level_of(light, 0.0, place, picture);
    }
    let own = picture.own.xy + picture.own.zw * textureLoad(pattern, place, 0).xy;
    return level_of(light * max(own.x, 0.0) + picture.electrons.y, own.y, place, picture);
}

// Grey level of a pixel that gets `mean` electrons on average and reads `offset` more.
fn level_of(mean: f32, offset: f32, place: vec2<u32>, picture: Picture) -> u32 {
    let random = pcg4d(vec4(place.y * picture.key.x + place.x, picture.key.w, picture.key.yz));
    // Box and Muller: two uniform variables give two independent normal ones.
    let radius = sqrt(-2.0 * log(unit(random.x)));
    let angle = 6.2831853 * unit(random.y);
    var electrons = normal_shot(mean, radius * cos(angle));
    if (mean < EXACT_BELOW) {
        electrons = poisson(mean, unit(random.z));
    }
    let collected = min(electrons, picture.electrons.z) + offset;
    let read = collected + picture.electrons.w * radius * sin(angle);
    let level = floor(read * picture.levels.x + picture.levels.y);
    return u32(clamp(level, 0.0, picture.levels.z));
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
