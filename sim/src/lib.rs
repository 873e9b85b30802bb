//! A physics-simulated testbed for indoor localization.
//!
//! ```text
//! scenes/x.toml ─> Scene ─> World ─> Truth ─> Sensors (+ Renderer) ─> Readings ─> Subject ───> Answer
//!                             ^                                                                   │
//!                             └──────────── DriveCommand <── Driver <─────────────────────────────┤
//!                  run(): RunRecord { Truth, Answer } ─> judge() ─> Verdict ─> artefacts
//! ```
//!
//! The modules are listed in reading order, from the scene file to the verdict.

pub mod scene;
pub mod loading;
pub mod truth;
pub mod optics;
pub mod place;
pub mod devices;
pub mod base;
pub mod world;
pub mod render;
pub mod driver;
pub mod subject;
pub mod run;
pub mod judge;
pub mod artefacts;
pub mod campaign;
pub mod cli;
