//! Light through a lens onto a sensor, as rendering, sensors and the judge use it. These modules neither render nor simulate a sensor.
//!
//! | module | contents |
//! |---|---|
//! | [`pinhole`] | projection of a pinhole camera |
//! | [`lens`] | projection of a lens with distortion, and the ray of a pixel |
//! | `mounts` | nominal poses of cameras on the robot's body |
//! | [`exposure`] | electrons per luminance, and automatic exposure |
//! | `spectrum` | photons per lumen, by lamp and band |

pub mod pinhole;
pub mod lens;
pub(crate) mod mounts;
pub mod exposure;
pub(crate) mod spectrum;

pub use exposure::{AutoExposure, Exposure};
pub use lens::Lens;
pub use pinhole::Intrinsics;
pub use spectrum::{EQUIVALENT_LUMENS_PER_WATT_850_NM, Photons};
