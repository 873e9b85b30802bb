//! The claimed points of a line that matter.

/// Indices of the points of a line that limit how far the line can move and turn, of as many points as have to be within their bounds. Each point is
/// its place along the line, its distance from the line, and the bound of that distance.
///
/// A line that moves by α and turns by β moves by α + β·t at the place t. It stays within the bounds of all points exactly if it stays within those
/// at the corners of the lower hull of the room that is left above the points, and of the room that is left below them. Points that are the farthest
/// out, measured by their bounds, are left out first, as many as may be wrong.
pub(super) fn outline(points: &[[f64; 3]], n_needed: usize) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..points.len()).collect();
    let used = |at: usize| points[at][1].abs() / points[at][2];
    kept.sort_by(|&a, &b| used(a).total_cmp(&used(b)));
    kept.truncate(n_needed);
    kept.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    let mut corners = lower_hull(&kept, |at| [points[at][0], points[at][2] - points[at][1]]);
    corners.extend(lower_hull(&kept, |at| [points[at][0], points[at][2] + points[at][1]]));
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// Corners of the lower convex hull of points in ascending order of their first coordinate (Andrew's monotone chain).
fn lower_hull(indices: &[usize], place: impl Fn(usize) -> [f64; 2]) -> Vec<usize> {
    let mut hull: Vec<usize> = Vec::new();
    for &index in indices {
        let [x, y] = place(index);
        while let [.., a, b] = hull[..] {
            let ([ax, ay], [bx, by]) = (place(a), place(b));
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(index);
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Room above the points: 1, 0.5, 1, 1; below: 1, 1.5, 1, 0.6. By hand, the corners above are the ends and the second; below the ends.
    #[test]
    fn the_points_that_limit_a_line_are_its_corners() {
        let points = [[0.0, 0.0, 1.0], [1.0, 0.5, 1.0], [2.0, 0.0, 1.0], [3.0, -0.2, 0.8]];
        assert_eq!(outline(&points, 4), [0, 1, 3]);
        // The second uses most of its bound, and is the first to be left out.
        assert_eq!(outline(&points, 3), [0, 3]);
    }
}
