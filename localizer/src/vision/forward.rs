//! Vision of the camera that looks ahead in the dark: it finds straight edges of walls, ceilings, doors and shelves.
//!
//! ```text
//! ours:   stabilise noise ──> bin ──> rolling guidance ──> segments ──> refit on the unfiltered image ──> EdgeLine with bounds
//! paper:  equalise ─────────────────> rolling guidance ──> segments ──> sets A and B ──> RANSAC ──> LM ──> azimuth
//! ```

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

/// Number of rounds of the rolling guidance filter; reference 41 of paper 2 finds that four suffice.
pub const ROUNDS: usize = 4;
/// Spatial standard deviation of the rolling guidance filter, in pixels of the image that it is given.
const GUIDANCE_PX: f32 = 2.5;
/// Width of the image's border in which no edges are searched: filters and lenses are least accurate there.
const BORDER_PX: f64 = 14.0;
/// Length that is cut off at each end of an edge, because edges are distorted where they meet other edges.
const TRIM_PX: f64 = 4.0;
/// Distance from the image's border within which an edge that was found may go on beyond its end: the border in which none is searched, what is cut
/// off, and the block of pixels in which a segment ends.
pub const GOES_ON_PX: f64 = BORDER_PX + TRIM_PX + 6.0;
/// Bound assumed for the ends of segments from the chain of paper 2, which states none: the chain's filter moves edges by about as much.
const PRINTED_PX: f64 = 1.5;
/// Least length of an edge; shorter edges do not determine a direction.
const SHORTEST_PX: f64 = 45.0;

/// A straight edge in an image. Both of its ends lie within their bound, measured across the edge, of the line that a straight edge of the room has
/// in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeLine {
    /// First and last point of the edge, each `[u, v]`.
    pub ends_px: [[f64; 2]; 2],
    /// Bound of the distance of either end of the edge from the true line, across the edge.
    pub bound_px: f64,
}

/// Straight edges found by the chain of paper 2: those segments that point to one of the vanishing points found. `ray` gives the direction in the
/// camera frame in which a pixel looks.
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

/// Straight edges found by this project's own chain.
///
/// The noise is first made equal everywhere, so that one threshold serves for dark and bright areas. What is found in the filtered image is
/// measured again in the unfiltered one, because the filter moves edges.
pub fn detect(picture: &Picture) -> Vec<EdgeLine> {
    let even = stabilise::stabilised(picture);
    let filtered = guided(&even.binned());
    refitted(&even, &long_segments(&filtered, picture))
}

/// The binned image after the rolling guidance filter, which removes what is smaller than an edge.
pub fn guided(binned: &Picture) -> Picture {
    // Averaging blocks of four pixels halves the noise, so that the filter's range is 0.5.
    guidance_filter::rolling_guidance_at_speed(binned, GUIDANCE_PX, 0.5, ROUNDS)
}

/// Segments found in the filtered image of half resolution, converted to pixels of the full image `whole`. Parts in the image's border and the ends
/// are cut off, and only segments that are still long enough are kept.
pub fn long_segments(filtered: &Picture, whole: &Picture) -> Vec<Segment> {
    segments::segments(filtered, segments::NOISE_FLOOR)
        .iter()
        .filter_map(|segment| segment.unbinned().within(whole.width, whole.height, BORDER_PX)?.trimmed(TRIM_PX))
        .filter(|segment| segment.length_px() >= SHORTEST_PX)
        .collect()
}

/// Edges from segments, measured again in the unfiltered image `even` with its even noise; of edges beside each other only the longest is kept.
pub fn refitted(even: &Picture, segments: &[Segment]) -> Vec<EdgeLine> {
    let mut lines: Vec<EdgeLine> = segments.iter().filter_map(|segment| refit::refit(even, segment)).collect();
    refit::drop_repeats(&mut lines);
    lines
}
