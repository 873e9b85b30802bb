//! A tiled floor as it was laid: corners off their nominal place, joints worn or missing.

/// Displaced corners and joint contrasts of a tiled floor, covering the room with a margin.
///
/// Corner `(i, j)` is the crossing of joint `i` of grid x and joint `j` of grid y, `first[a] ≤ index < first[a] + count[a]`.
/// A joint runs straight from corner to corner.
#[derive(Clone, Debug)]
pub struct LaidTiles {
    /// Index of the first joint of each axis.
    pub first: [i32; 2],
    /// Number of joints of each axis.
    pub count: [usize; 2],
    /// Displacement of each corner from its nominal place, grid frame; `count[0] × count[1]`, row-major in `(i, j)`.
    pub corner_offset_m: Vec<[f64; 2]>,
    /// Contrast of each joint segment, 1 as new and 0 not to be seen; `[0]`: from corner `(i, j)` to `(i, j + 1)`,
    /// `[1]`: to `(i + 1, j)`; indexed as the corners.
    pub contrast: [Vec<f32>; 2],
    /// Albedo of the tile at corner `(i, j)` (towards `(i + 1, j + 1)`), indexed as the corners.
    pub tile_albedo: Vec<f32>,
}
