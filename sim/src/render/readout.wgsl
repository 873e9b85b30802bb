// What every pass over a sensor knows of its view, and where its random numbers come from.

struct Readout {
    size_px: vec2<u32>,
    // First half of the noise key's seed, second half, number of the image.
    seed: vec2<u32>,
    image: u32,
    electrons_per_luminance: f32,
    full_well_electrons: f32,
    read_noise_electrons: f32,
    gain_levels_per_electron: f32,
    // Mean over the exposure.
    dark_electrons: f32,
    // Standard deviations of the pixels' offsets, and of their sensitivities as a share.
    offset_electrons: f32,
    sensitivity: f32,
    // Black level and half a level, for rounding.
    lifted_levels: f32,
    greatest_level: f32,
}

// Only vertex shaders read it: what is the same for a whole picture travels with its corners, one number for all pixels, where a software driver
// loads even from uniform memory pixel by pixel.
@group(0) @binding(0) var<uniform> readout: Readout;

// What pixels differ by is kept in bytes: a normal variable in steps of 1/DEVIATION, up to four.
const DEVIATION: f32 = 31.75;
const MIDDLE: f32 = 128.0;

// A triangle over the whole picture: a software driver runs a fragment shader on sixteen pixels at once, where a compute shader costs it 2 ms a
// picture of 640 × 480 before it does anything.
fn whole_picture(index: u32) -> vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
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
