// The row of the sensor on which a lens shows a point of the plane at depth 1, in focal lengths from the principal point: v of Brown and
// Conrady's model, with k1, k2, p1 and p2 in `distortion`.
fn slope_on_sensor(at: vec2<f32>, distortion: vec4<f32>, k3: f32) -> f32 {
    let square = dot(at, at);
    let radial = 1.0 + square * (distortion.x + square * (distortion.y + square * k3));
    return at.y * radial + distortion.z * (square + 2.0 * at.y * at.y) + 2.0 * distortion.w * at.x * at.y;
}
