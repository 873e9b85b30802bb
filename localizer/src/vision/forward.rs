//! A camera that looks ahead in the dark: straight edges of walls, ceilings, doors and shelves.
//!
//! ```text
//! ours:   stabilise noise ──> bin ──> rolling guidance ──> segments ──> refit on the unfiltered image ──> EdgeLine with bounds
//! paper:  equalise ─────────────────> rolling guidance ──> segments ──> sets A and B ──> RANSAC ──> LM ──> azimuth
//! ```

mod draws;
pub mod equalise;
pub mod features;
pub mod guidance_filter;
pub mod picture;
pub mod refit;
pub mod segments;
pub mod stabilise;
pub mod vanishing;

pub use picture::Picture;
pub use segments::Segment;

use nalgebra::Vector3;
use vanishing::Equalisation;

/// Rounds of the rolling guidance filter; the paper's reference 41 finds that four suffice.
pub const ROUNDS: usize = 4;
/// Spatial standard deviation of the filter in pixels of the picture it is given.
const GUIDANCE_PX: f32 = 2.5;
/// Distance to the image's border within which nothing is looked for: filters and lenses are worst there.
const BORDER_PX: f64 = 14.0;
/// Edges fray where they meet others: as much is cut off at each end.
const TRIM_PX: f64 = 4.0;
/// Bound of an end of the paper's segments, which states none: its filter moves edges by as much.
const PRINTED_PX: f64 = 1.5;
/// Shorter edges say nothing of a direction.
const SHORTEST_PX: f64 = 45.0;

/// A straight edge whose two ends lie within their bound, across the edge, of the true image of one straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeLine {
    /// First and last point, `[u, v]`.
    pub ends_px: [[f64; 2]; 2],
    /// Bound of either end's distance across the edge.
    pub bound_px: f64,
}

/// Straight edges by the paper's chain: those that its vanishing points stand on. `ray` gives the direction, in the camera's frame, in
/// which a pixel looks.
pub fn detect_as_printed(
    picture: &Picture,
    equalisation: Equalisation,
    ray: impl Fn([f64; 2]) -> Vector3<f64>,
) -> Vec<EdgeLine> {
    let segments = vanishing::segments_in(picture, equalisation);
    let agreeing =
        vanishing::vanishing_points(&segments, &ray).map(|points| vanishing::agreeing(&segments, &points, &ray));
    let line = |segment: &Segment| EdgeLine { ends_px: segment.ends_px, bound_px: PRINTED_PX };
    agreeing.iter().flatten().map(line).collect()
}

/// Straight edges by our chain.
///
/// Noise is made even first, so that one threshold serves shadows and lamps; what is found in the filtered picture is measured again
/// in the unfiltered one, because the filter moves edges.
pub fn detect(picture: &Picture) -> Vec<EdgeLine> {
    if picture.width.min(picture.height) as f64 <= 2.0 * BORDER_PX {
        // All of it is border.
        return Vec::new();
    }
    let even = stabilise::stabilised(picture);
    let filtered = guided(&even.binned());
    refitted(&even, &long_segments(&filtered, picture))
}

/// A binned picture without what is smaller than an edge.
pub fn guided(binned: &Picture) -> Picture {
    // Binning four pixels halves the noise.
    guidance_filter::rolling_guidance_at_speed(binned, GUIDANCE_PX, 0.5, ROUNDS)
}

/// Segments of the binned picture that are long enough in `whole`, without their ends, in pixels of that.
pub fn long_segments(filtered: &Picture, whole: &Picture) -> Vec<Segment> {
    segments::segments(filtered, segments::NOISE_FLOOR)
        .iter()
        .filter_map(|segment| segment.unbinned().within(whole.width, whole.height, BORDER_PX)?.trimmed(TRIM_PX))
        .filter(|segment| segment.length_px() >= SHORTEST_PX)
        .collect()
}

/// Segments measured again in the unfiltered picture, each edge once.
pub fn refitted(even: &Picture, segments: &[Segment]) -> Vec<EdgeLine> {
    let mut lines: Vec<EdgeLine> = segments.iter().filter_map(|segment| refit::refit(even, segment)).collect();
    refit::drop_repeats(&mut lines);
    lines
}
