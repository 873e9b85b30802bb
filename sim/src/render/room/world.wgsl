// What every pass over a room knows of the world.

struct Surface {
    // First corner, and albedo.
    corner: vec4<f32>,
    // Side to the second corner, and mirrored share.
    along: vec4<f32>,
    // Side to the last corner, and roughness (rad).
    up: vec4<f32>,
    // In the light map: column and row of the first node, and how many further to the last.
    nodes: vec4<f32>,
    // Lengths of both sides, the seed of the texture, and where the face's words of `sunlight` begin.
    size: vec4<f32>,
}

struct Lamp {
    // Middle, and luminance.
    centre: vec4<f32>,
    // Unit vectors along both sides, each with half of its side's length; of a bulb 0.
    side_u: vec4<f32>,
    side_v: vec4<f32>,
    // Where a rectangle shines to, and 0; or the radius of a bulb.
    normal: vec4<f32>,
}

struct Grid {
    // From world to grid: cosine and sine; then edges.
    turn: vec2<f32>,
    edge_m: vec2<f32>,
    phase_m: vec2<f32>,
    joint_width_m: f32,
    joint_albedo: f32,
    // Of the array of albedos.
    first: vec2<i32>,
    count: vec2<i32>,
    pattern_contrast: f32,
    mean_albedo: f32,
    padding_a: u32,
    padding_b: u32,
}

struct Sun {
    // Unit vector to the sun, and equivalent lux across it.
    towards: vec4<f32>,
    n_people: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
    // Of each person place, half width and height; then velocity.
    people: array<vec4<f32>, 128>, // 2 * MOST_SHADES of sun.rs
}

@group(1) @binding(0) var<storage, read> surfaces: array<Surface>;
// In uniform memory, as the view: from storage a software driver loads each value for each pixel.
@group(1) @binding(1) var<uniform> lamps: array<Lamp, 1024>; // MAX_LAMPS of scene/lamps.rs
@group(1) @binding(2) var<uniform> grid: Grid;
@group(1) @binding(3) var<storage, read> tile_albedo: array<f32>;
// Equivalent lux at the nodes, linear between them in both directions.
@group(1) @binding(4) var light_map: texture_2d<f32>;
@group(1) @binding(5) var between_nodes: sampler;
// Shadows in sunlight, as place/light/shadows.rs writes them.
@group(1) @binding(6) var<storage, read> sunlight: array<u32>;
@group(1) @binding(7) var<uniform> sun: Sun;
