//! Setup of the method `mapped_landmarks`, which locates the robot by landmarks in space.

use localizer::methods::mapped_landmarks::{Learning, pictures::Declared};
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
    /// Whether images of the whole drive are kept, and the map that a run leaves is made of all of them at its end; `wherein teach` sets it.
    /// Otherwise the map is what was learnt on the way. In pictures of the forward camera, landmarks are then bounded by windows of twelve pictures
    /// together. Without effect where `learns` is false.
    pub teaches: bool,
    /// For landmarks that are seen in pictures of the forward camera: greatest share of a picture's sightings that may be false, as where something
    /// else looks like the landmark, or where the landmark is not where the map has it. Unless given, it is 0.05. The number is
    /// rounded down: with the eighteen sightings at most that are used, a share below 0.056 adds none to `wrong_items`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_share: Option<f64>,
    /// Number of a picture's sightings that may be false in addition to `wrong_share`. Unless given, it is 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1000))]
    pub wrong_items: Option<usize>,
    /// For landmarks that are seen in pictures of the forward camera: number of things, such as paintings or shelves, all of whose landmarks may be
    /// elsewhere than the map has them, so that all of their sightings in a picture are false. Landmarks within 0.4 m of each other are on one thing. A
    /// pose is then what the rest of a picture tells without any one of the things (or any two, and so on), and boxes are wider. Unless given, it is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 3))]
    pub wrong_things: Option<usize>,
    /// For landmarks that are seen in pictures of the forward camera: least distance, along the direction of view, of a landmark that is seen for the
    /// first time. Nearer ones count as false sightings. The farther all is, the better landmarks are found again: 3 m suit a street. Unless given, it
    /// is 0.4 m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.05, max = 1000.0))]
    pub least_depth_m: Option<f64>,
    /// A fault of the map, for landmarks that are seen in pictures of the forward camera: share of the map's landmarks that are confused with a
    /// neighbour, as a system does that matches what looks alike. The seed draws pairs of landmarks that a camera sees side by side, 10 to 30 px apart,
    /// and exchanges their looks: each is then found where the other is, and its sightings are false. Unless given, it is 0. Where fewer landmarks have
    /// such a neighbour, fewer are confused.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub confused_share: Option<f64>,
    /// Contents of the file that the key `map` names.
    #[serde(skip)]
    pub known: Option<LandmarkMap>,
    /// Time that it took to read and check that file, for `timing.json` alone.
    #[serde(skip)]
    pub reading_s: Option<f64>,
}

impl Default for MappedLandmarksSetup {
    fn default() -> Self {
        MappedLandmarksSetup {
            map: None,
            learns: true,
            teaches: false,
            wrong_share: None,
            wrong_items: None,
            wrong_things: None,
            least_depth_m: None,
            confused_share: None,
            known: None,
            reading_s: None,
        }
    }
}

impl MappedLandmarksSetup {
    /// Whether the method learns, as the localizer is given it.
    pub(crate) fn learning(&self) -> Learning {
        match (self.learns, self.teaches) {
            (false, _) => Learning::Never,
            (true, false) => Learning::Drives,
            (true, true) => Learning::Teaches,
        }
    }

    /// Whether landmarks of the map are confused with each other.
    pub(crate) fn confuses(&self) -> bool {
        self.confused_share.is_some_and(|share| share > 0.0)
    }

    /// What is declared of sightings in pictures, as the localizer is given it.
    pub(crate) fn declared(&self) -> Declared {
        let usual = Declared::default();
        Declared {
            wrong_share: self.wrong_share.unwrap_or(usual.wrong_share),
            wrong_items: self.wrong_items.unwrap_or(usual.wrong_items),
            wrong_things: self.wrong_things.unwrap_or(usual.wrong_things),
            least_depth_m: self.least_depth_m.unwrap_or(usual.least_depth_m),
        }
    }
}
