// What pixels of a sensor differ by: the same in every image of a seed. Follows readout.wgsl.

// Takes the place of an image's number in what all images share.
const PATTERN_KEY: u32 = 0xFFFFFFFFu;

// Of every pixel its sensitivity as a factor and its offset in electrons.
@group(0) @binding(1) var pattern: texture_storage_2d<rg32float, write>;

// Draws the pattern, for all images to come.
@compute @workgroup_size(64)
fn lay_pattern(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>) {
    let index = id.y * 64u * count.x + id.x;
    if (index >= readout.size_px.x * readout.size_px.y) {
        return;
    }
    let own = pcg4d(vec4(index, PATTERN_KEY, readout.seed));
    let size = sqrt(-2.0 * log(unit(own.x)));
    let turn = 6.2831853 * unit(own.y);
    let sensitivity = max(1.0 + readout.sensitivity * size * cos(turn), 0.0);
    let place = vec2(index % readout.size_px.x, index / readout.size_px.x);
    textureStore(pattern, place, vec4(sensitivity, readout.offset_electrons * size * sin(turn), 0.0, 0.0));
}
