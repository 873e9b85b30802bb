//! Colours of debug frames, chosen so that people with any kind of colour vision can tell them apart (the set of Okabe and Ito).

use image::Rgb;

pub(super) const PAPER: Rgb<u8> = Rgb([250, 250, 248]);
pub(super) const INK: Rgb<u8> = Rgb([20, 20, 24]);
pub(super) const FAINT_INK: Rgb<u8> = Rgb([110, 110, 116]);
pub(super) const WALL: Rgb<u8> = Rgb([60, 60, 66]);
pub(super) const ROOM: Rgb<u8> = Rgb([255, 255, 255]);
pub(super) const JOINT: Rgb<u8> = Rgb([176, 172, 164]);
pub(super) const REGION: Rgb<u8> = Rgb([222, 214, 190]);
pub(super) const FURNITURE: Rgb<u8> = Rgb([206, 206, 202]);
/// Colour of the paths that people walk; it differs from the colour of the robot's own outline.
pub(super) const PEOPLE: Rgb<u8> = Rgb([160, 110, 40]);
/// Colour of ceiling markers that are on the localizer's map.
pub(super) const MARKER: Rgb<u8> = Rgb([108, 72, 168]);
pub(super) const ROUTE: Rgb<u8> = Rgb([150, 190, 225]);
pub(super) const TRAIL: Rgb<u8> = Rgb([130, 130, 136]);

/// Colour of what the localizer claims to have seen, where the claim is true.
pub(super) const SEEN: Rgb<u8> = Rgb([86, 200, 245]);
/// Colour of what the localizer claims to have seen, where the claim is false.
pub(super) const FALSE: Rgb<u8> = Rgb([235, 80, 200]);
/// Colour of line segments in an image that the localizer examined and rejected.
pub(super) const REJECTED: Rgb<u8> = Rgb([240, 130, 20]);
/// Colour of boxes that hold the truth.
pub(super) const BOX: Rgb<u8> = Rgb([0, 114, 178]);
/// Colour of boxes that do not hold the truth.
pub(super) const MISS: Rgb<u8> = Rgb([213, 60, 0]);
/// Colour of the true pose.
pub(super) const TRUTH: Rgb<u8> = Rgb([0, 128, 92]);
