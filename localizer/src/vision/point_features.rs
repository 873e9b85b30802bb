//! The visual front end of paper 4: points that are seen in one image and found again in others, each with a claim of where it is.
//!
//! ```text
//! image ──> fine, coarse ──> Keypoints ──> Descriptors ──> Landmark { patch, descriptor }
//!                                │                              │
//! Search (from the prior) ──> candidates by descriptor <────────┤
//!                                v                              v
//!                            coarse alignment ──> fine alignment of the patch ──> ZNCC, claim ──> Sighting, or a Refusal
//! ```
//!
//! Paper 4 (section 2.3 and reference 28) searches SURF features in the area that the interval prediction gives, by their descriptors first and by
//! their orientations second, and assumes an error of one pixel for each. Here the second stage aligns the landmark's own patch with the image, so
//! that the position is known to about a twentieth of a pixel and its bound is computed instead of assumed. The method
//! [`mapped_landmarks`](crate::methods::mapped_landmarks::pictures) uses it.
//!
//! All steps are deterministic, and images of any size and content are allowed.

mod smoothing;
mod keypoint;
mod descriptor;
mod patch;
mod alignment;
pub mod claim;
mod search;
mod correlation;
mod landmark;
mod posture;
mod templates;
mod frame;
mod matching;

#[cfg(test)]
mod synthetic;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
#[cfg(test)]
mod trial;

pub use claim::ImageBounds;
pub use descriptor::Descriptor;
pub use frame::Frame;
pub use keypoint::Keypoint;
pub use landmark::{Landmark, Record};
pub use matching::PointMatch;
pub use search::{Refusal, Search, Sighting};
pub use templates::Templates;
