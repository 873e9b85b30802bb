// Box-filter coverage: how much of a pixel, smeared over a sub-frame, lies on one side of a straight edge.

// The pixel's two sides and the way it moves during the sub-frame, as vectors on the floor (m).
struct Footprint {
    side_u: vec2<f32>,
    side_v: vec2<f32>,
    motion: vec2<f32>,
}

// The footprint's three widths along a unit vector.
//
// A width of nothing would divide by zero; a floor of 5 % of the greatest keeps the cubes below exact to 1e-4, and
// widens symmetrically, so that no edge moves.
fn widths_along(normal: vec2<f32>, footprint: Footprint) -> vec3<f32> {
    let widths = abs(vec3(
        dot(normal, footprint.side_u),
        dot(normal, footprint.side_v),
        dot(normal, footprint.motion),
    ));
    let least = 0.05 * max(widths.x, max(widths.y, widths.z));
    return max(widths, vec3(least));
}

fn cube_of_abs(x: f32) -> f32 {
    let a = abs(x);
    return a * a * a;
}

// Share of the footprint with signed distance > 0, when its centre has signed distance `x` to the edge.
//
// The footprint's distance is the sum of three independent uniform variables of the given widths; their distribution
// function is 1/2 + (1/(12·a·b·c)) Σ ±|x ± a/2 ± b/2 ± c/2|³, the sign being the product of the three.
fn half_plane_coverage(x: f32, widths: vec3<f32>) -> f32 {
    let half = 0.5 * widths;
    let reach = half.x + half.y + half.z;
    if (abs(x) >= reach) {
        return select(0.0, 1.0, x > 0.0);
    }
    let sum = cube_of_abs(x + half.x + half.y + half.z) - cube_of_abs(x - half.x - half.y - half.z)
        - cube_of_abs(x + half.x + half.y - half.z) + cube_of_abs(x - half.x - half.y + half.z)
        - cube_of_abs(x + half.x - half.y + half.z) + cube_of_abs(x - half.x + half.y - half.z)
        - cube_of_abs(x - half.x + half.y + half.z) + cube_of_abs(x + half.x - half.y - half.z);
    return clamp(0.5 + sum / (12.0 * widths.x * widths.y * widths.z), 0.0, 1.0);
}

// Share of the footprint within `half_width` of a line, when its centre has signed distance `x` to the line.
fn band_coverage(x: f32, half_width: f32, widths: vec3<f32>) -> f32 {
    return half_plane_coverage(x + half_width, widths) - half_plane_coverage(x - half_width, widths);
}
