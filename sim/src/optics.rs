//! Light through a lens onto a sensor: what rendering, sensors and the judge have in common. It draws nothing and senses nothing.
//!
//! | module | what it has |
//! |---|---|
//! | [`pinhole`] | projection through a point |
//! | [`lens`] | projection with distortion, and the ray of a pixel |
//! | `mounts` | nominal poses of cameras on the body |
//! | [`exposure`] | electrons of a luminance, and automatic exposure |
//! | `spectrum` | photons of a lumen, by lamp and band |

pub mod pinhole;
pub mod lens;
pub(crate) mod mounts;
pub mod exposure;
pub(crate) mod spectrum;

pub use exposure::{AutoExposure, Exposure};
pub use lens::Lens;
pub use pinhole::Intrinsics;
pub use spectrum::{EQUIVALENT_LUMENS_PER_WATT_850_NM, Photons};
