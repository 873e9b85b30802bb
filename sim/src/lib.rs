//! A physics-simulated testbed for indoor localization.
//!
//! ```text
//! scenes/x.toml ─> Scene ─> World ─> Truth ─> Sensors (+ Renderer) ─> Readings ─> Localizer ─> Estimate
//!                             ^                                                                   │
//!                             └──────────── WheelCommand <── Driver <─────────────────────────────┤
//!                  run(): RunRecord { Truth, Estimate } ─> check() ─> Verdict ─> record
//! ```
//!
//! Modules in reading order, from the file to the verdict.

pub mod scene;
pub mod randomness;
pub mod drawn;
pub mod coverage;
pub mod marker_sheet;
pub mod truth;
pub mod world;
pub mod building;
pub mod light;
pub mod render;
pub mod sensors;
pub mod still;
pub mod navigation;
pub mod driver;
pub mod run;
pub mod check;
pub mod weaken;
pub mod figures;
pub mod frames;
pub mod record;
pub mod recording;
pub mod replay;
pub mod machine;
pub mod table;
pub mod sweep;
pub mod results;
pub mod report;
pub mod junit;
pub mod compare;
pub mod falsify;
pub mod cli;
