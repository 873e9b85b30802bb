//! Setup of the method `mapped_landmarks`, which locates the robot by landmarks in space.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::LandmarkMap;

/// Setup of the method `mapped_landmarks`: what it knows of landmarks beforehand, and whether it learns more.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MappedLandmarksSetup {
    /// File with the map of landmarks that an earlier drive has learnt, as a path from the folder of the scene's file. Unless given, no landmark is
    /// known at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// Whether the localizer learns where landmarks are, those of the map and others.
    pub learns: bool,
    /// Whether images of the whole drive are kept, and the map that a run leaves is made of all of them at its end; `wherein teach` sets it. Otherwise
    /// the map is what was learnt on the way. Without effect where `learns` is false.
    pub teaches: bool,
    /// Contents of the file that the key `map` names.
    #[serde(skip)]
    pub known: Option<LandmarkMap>,
}

impl Default for MappedLandmarksSetup {
    fn default() -> Self {
        MappedLandmarksSetup { map: None, learns: true, teaches: false, known: None }
    }
}
