//! Brown and Conrady's lens: what it adds to the picture of a pinhole.
//!
//! Coefficients k1, k2, p1, p2, k3 and points in focal lengths from the principal point, x right and y down. The lens puts what a
//! pinhole shows at x to D(x) = x + b(x) (Brown, *Decentering distortion of lenses*, 1966, in OpenCV's order).

/// b(x): x·(k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·x·y + p2·(r² + 2x²), and likewise for y with p1 and p2 exchanged.
pub(crate) fn bend([k1, k2, p1, p2, k3]: [f64; 5], [x, y]: [f64; 2]) -> [f64; 2] {
    let square = x * x + y * y;
    let radial = square * (k1 + square * (k2 + square * k3));
    [
        x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    ]
}
