//! Maps of landmarks in space as files: JSON with a format name, a version, and a digest of the text that shows damage.

mod views;

use std::{fmt::Write, fs, path::Path};

use base64::{Engine, prelude::BASE64_STANDARD as BASE64};
use interval::Interval;
use localizer::{
    map::{Anchor, SpacePoint, Views},
    reading::LandmarkId,
    vision::point_features::Landmark,
};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::scene::LandmarkMap;

use super::navigation::map_server::MapError;

/// Name of the format, which every file states.
const FORMAT: &str = "wherein landmark map";
/// Latest version of the format: pictures of the drives that taught the map tell where they show landmarks. A map is written in the first version that
/// has all that it tells; otherwise the versions are the same.
const VERSION: u64 = 4;
/// Version of the format without views: landmarks have looks, with the focal lengths of the cameras that took them.
const VERSION_WITHOUT_VIEWS: u64 = 3;
/// Version of the format whose looks have no focal lengths. They are taken to be of a camera like the one that reads the map.
const VERSION_WITHOUT_FOCAL_LENGTHS: u64 = 2;
/// Version of the format without looks.
const VERSION_WITHOUT_LOOKS: u64 = 1;
/// What stands for the digest in the text that the digest is of.
const NO_DIGEST: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Share of its size, and absolute part, by which every interval is made wider when it is written: numbers may be read back with a rounding error.
const ROUNDING: f64 = 1e-12;

/// Greatest coordinate of an anchor: far beyond any building, so that a unit that was mistaken shows.
const FARTHEST_M: f64 = 1e6;
/// Greatest slope of a ray. Depths are counted along the axis that is nearest to the ray, so that a slope is 1 or a little more at most when the landmark
/// is first seen.
const STEEPEST: f64 = 1e3;
/// Greatest inverse depth, of a landmark 1 mm away from its anchor.
const NEAREST_PER_M: f64 = 1e3;

/// The file as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u64,
    digest: String,
    room_m: [f64; 2],
    relies_on: Vec<String>,
    /// The cameras of the drives that taught the map, and their pictures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    cameras: Vec<views::CameraEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pictures: Vec<views::PictureEntry>,
    landmarks: Vec<Entry>,
}

/// A landmark as it is written: its place is `anchor_m + (depth, slope·depth, slope·depth)` along the axis and the two axes that follow it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    number: u32,
    anchor_m: [f64; 3],
    axis: String,
    slopes: [[f64; 2]; 2],
    inverse_depth_per_m: [f64; 2],
    /// How the landmark looks: position, direction, descriptors, grey levels and focal length as bytes in Base64.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    look: Option<String>,
    /// Where pictures show it, each as five numbers: the picture's place among those of the file, column and row, and the greatest errors of both.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    seen_in: Vec<views::SightEntry>,
}

/// Names of the axes along which depths are counted.
const AXES: [(&str, usize, bool); 6] =
    [("+x", 0, true), ("-x", 0, false), ("+y", 1, true), ("-y", 1, false), ("+z", 2, true), ("-z", 2, false)];

/// An interval as it is written.
fn written(value: Interval) -> [f64; 2] {
    let wider = value.inflate(ROUNDING * (1.0 + value.magnitude()));
    [wider.lo(), wider.hi()]
}

/// The text of a map's file.
pub fn text(map: &LandmarkMap) -> String {
    let entry = |&(landmark, point): &(LandmarkId, SpacePoint)| {
        let axis = AXES
            .iter()
            .find(|(_, axis, is_positive)| (*axis, *is_positive) == (point.anchor.axis, point.anchor.is_positive));
        let [alpha, beta, rho] = point.value.map(written);
        Entry {
            number: landmark.0,
            anchor_m: point.anchor.from_m,
            axis: axis.map_or("", |(name, ..)| name).to_owned(),
            slopes: [alpha, beta],
            inverse_depth_per_m: [rho[0].max(0.0), rho[1]],
            look: map.looks.iter().find(|(of, _)| *of == landmark).map(|(_, look)| BASE64.encode(look.to_bytes())),
            seen_in: views::sights(&map.views, landmark),
        }
    };
    let file = File {
        format: FORMAT.to_owned(),
        version: version_of(map),
        digest: NO_DIGEST.to_owned(),
        room_m: map.room_m,
        relies_on: map.relies_on.clone(),
        cameras: views::cameras(&map.views),
        pictures: views::pictures(&map.views, &map.true_eyes),
        landmarks: map.landmarks.iter().map(entry).collect(),
    };
    // The keys are texts and all numbers are finite, so that serialising cannot fail.
    let text = serde_json::to_string_pretty(&file).unwrap_or_default() + "\n";
    let digest = digest_of(&text);
    text.replacen(NO_DIGEST, &digest, 1)
}

/// The first version of the format that has all that a map tells.
fn version_of(map: &LandmarkMap) -> u64 {
    if map.looks.is_empty() {
        VERSION_WITHOUT_LOOKS
    } else if map.looks.iter().all(|(_, look)| look.focal_px().is_none()) {
        VERSION_WITHOUT_FOCAL_LENGTHS
    } else if map.views == Views::default() {
        VERSION_WITHOUT_VIEWS
    } else {
        VERSION
    }
}

/// Whether a file is a map, though it may be damaged.
pub(crate) fn is_one(path: &Path) -> bool {
    fs::read(path).is_ok_and(|bytes| bytes.is_empty() || String::from_utf8_lossy(&bytes).contains(FORMAT))
}

/// Reads a map's file.
pub fn read(path: &Path) -> Result<LandmarkMap, MapError> {
    let invalid = |expected| MapError::Invalid { path: path.to_owned(), expected };
    let expected = "expected a file that `wherein teach` has written";
    let bytes = fs::read(path).map_err(|error| invalid(format!("{error}, {expected}")))?;
    let text = String::from_utf8(bytes).map_err(|_| invalid(format!("it is no text in UTF-8, {expected}")))?;
    parse(&text).map_err(invalid)
}

/// The map that a text states, or what was expected instead.
fn parse(text: &str) -> Result<LandmarkMap, String> {
    let value: serde_json::Value = serde_json::from_str(text).map_err(|error| format!("{error}, expected JSON"))?;
    if value["format"] != FORMAT {
        return Err(format!("`format` is {}, expected \"{FORMAT}\"", value["format"]));
    }
    match value["version"].as_u64() {
        Some(version) if version > VERSION => {
            return Err(format!("`version` is {version}, of a later Wherein, expected at most {VERSION}"));
        }
        Some(VERSION_WITHOUT_LOOKS..=VERSION) => {}
        _ => return Err(format!("`version` is {}, expected a number from 1 to {VERSION}", value["version"])),
    }
    let file: File =
        serde_path_to_error::deserialize(value).map_err(|error| format!("`{}`: {}", error.path(), error.inner()))?;
    if file.digest.len() != NO_DIGEST.len() || digest_of(&text.replacen(&file.digest, NO_DIGEST, 1)) != file.digest {
        return Err("`digest` is not that of the text, expected a file as `wherein teach` wrote it".to_owned());
    }
    let landmarks = file.landmarks.iter().enumerate().map(|(index, entry)| {
        point_of(entry)
            .map(|point| (LandmarkId(entry.number), point))
            .map_err(|(key, expected)| format!("`landmarks[{index}].{key}` is not possible, expected {expected}"))
    });
    let landmarks: Vec<(LandmarkId, SpacePoint)> = landmarks.collect::<Result<_, _>>()?;
    if let Some(at) = (1..landmarks.len()).find(|&at| landmarks[at - 1].0 >= landmarks[at].0) {
        return Err(format!("`landmarks[{at}].number` is out of order, expected each number once, the least first"));
    }
    let looks = looks_of(&file)?;
    let (views, true_eyes) = views::read(&file)?;
    Ok(LandmarkMap { room_m: file.room_m, relies_on: file.relies_on, landmarks, looks, views, true_eyes })
}

/// An interval as it stands in a file.
fn interval([lo, hi]: [f64; 2]) -> Option<Interval> {
    (lo <= hi && lo.is_finite() && hi.is_finite()).then(|| Interval::new(lo, hi))
}

/// The landmark of an entry, or the key that is at fault with what was expected of it.
fn point_of(entry: &Entry) -> Result<SpacePoint, (&'static str, &'static str)> {
    let &(_, axis, is_positive) =
        AXES.iter().find(|(name, ..)| *name == entry.axis).ok_or(("axis", "one of +x, -x, +y, -y, +z and -z"))?;
    if !entry.anchor_m.iter().all(|at_m| at_m.abs() <= FARTHEST_M) {
        return Err(("anchor_m", "three numbers from -1e6 to 1e6"));
    }
    let slope = |ends| interval(ends).filter(|slope| slope.magnitude() <= STEEPEST);
    let [alpha, beta] = entry.slopes.map(slope);
    let (Some(alpha), Some(beta)) = (alpha, beta) else {
        return Err(("slopes", "two pairs of numbers from -1000 to 1000, the lesser first"));
    };
    let rho = interval(entry.inverse_depth_per_m).filter(|rho| rho.lo() >= 0.0 && rho.hi() <= NEAREST_PER_M);
    let rho = rho.ok_or(("inverse_depth_per_m", "a pair of numbers from 0 to 1000, the lesser first"))?;
    Ok(SpacePoint { anchor: Anchor { from_m: entry.anchor_m, axis, is_positive }, value: [alpha, beta, rho] })
}

/// How the landmarks of a file look: all of them, or none.
fn looks_of(file: &File) -> Result<Vec<(LandmarkId, Landmark)>, String> {
    let has_looks = file.version > VERSION_WITHOUT_LOOKS;
    let mut looks = Vec::new();
    for (index, entry) in file.landmarks.iter().enumerate() {
        if entry.look.is_some() != has_looks {
            let expected = if has_looks { "one for each landmark" } else { "none in version 1" };
            return Err(format!("`landmarks[{index}].look` is not possible, expected {expected}"));
        }
        let Some(text) = &entry.look else { continue };
        let look = BASE64.decode(text).ok().and_then(|bytes| Landmark::from_bytes(&bytes));
        let look = look.filter(|look| look.focal_px().is_none() || file.version > VERSION_WITHOUT_FOCAL_LENGTHS);
        let expected = || {
            format!("`landmarks[{index}].look` is not possible, expected bytes in Base64 as `wherein teach` wrote them")
        };
        looks.push((LandmarkId(entry.number), look.ok_or_else(expected)?));
    }
    Ok(looks)
}

fn digest_of(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().fold(String::new(), |mut digest, byte| {
        // Writing to a `String` cannot fail.
        let _ = write!(digest, "{byte:02x}");
        digest
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use image::{GrayImage, Luma};
    use localizer::{
        PoseBox,
        map::{ViewCamera, ViewPicture, ViewSight},
        vision::point_features::{Frame, ImageBounds},
    };
    use nalgebra::{Isometry3, Vector3};

    use super::*;
    use crate::scene::TrueEye;

    fn map() -> LandmarkMap {
        let anchor = Anchor { from_m: [1.0, -0.3, 0.4], axis: 1, is_positive: false };
        let value = [Interval::new(-0.1, 1.0 / 3.0), Interval::new(0.2, 0.2), Interval::new(0.0, 0.7)];
        let far = Anchor { axis: 2, is_positive: true, ..anchor };
        LandmarkMap {
            room_m: [5.0, 4.0],
            relies_on: vec!["gnss.fixed".to_owned()],
            landmarks: vec![
                (LandmarkId(3), SpacePoint { anchor, value }),
                (LandmarkId(9), SpacePoint { anchor: far, value }),
            ],
            looks: Vec::new(),
            views: Views::default(),
            true_eyes: Vec::new(),
        }
    }

    #[test]
    fn a_map_comes_back_from_its_text_hardly_wider() {
        let (map, back) = (map(), parse(&text(&map())).unwrap());
        assert_eq!((back.room_m, &back.relies_on), (map.room_m, &map.relies_on));
        for ((id, point), (id_back, point_back)) in map.landmarks.iter().zip(&back.landmarks) {
            assert_eq!((id, point.anchor), (id_back, point_back.anchor));
            for (value, back) in point.value.iter().zip(&point_back.value) {
                assert!(value.is_subset_of(*back) && back.width() < value.width() + 1e-11, "{value} {back}");
            }
        }
    }

    #[test]
    fn looks_come_back_from_a_file_and_a_map_is_of_the_first_version_that_has_all_that_it_tells() {
        let picture =
            GrayImage::from_fn(200, 160, |u, v| Luma([(u * 7 % 90 + (u / 9 * 37 + v / 11 * 53) % 120) as u8]));
        let bounds = ImageBounds { focal_px: 400.0, slant: 1.0, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };
        let looks: Vec<Landmark> = Frame::new(&picture, &bounds).landmarks(2);
        assert_eq!(looks.len(), 2);
        let map = LandmarkMap { looks: [LandmarkId(3), LandmarkId(9)].into_iter().zip(looks).collect(), ..map() };
        let told = text(&map);
        assert!(told.contains("\"version\": 3") && text(&self::map()).contains("\"version\": 1"));
        assert_eq!(parse(&told).unwrap().looks, map.looks);
        assert!(map.looks.iter().all(|(_, look)| look.focal_px() == Some(400.0)));
        // Looks of an earlier Wherein end where the focal length begins.
        let earlier = |look: &Landmark| Landmark::from_bytes(&look.to_bytes()[..look.to_bytes().len() - 8]).unwrap();
        let looks: Vec<_> = map.looks.iter().map(|(landmark, look)| (*landmark, earlier(look))).collect();
        let of_earlier = text(&LandmarkMap { looks: looks.clone(), ..map.clone() });
        assert!(of_earlier.contains("\"version\": 2"));
        assert_eq!(parse(&of_earlier).unwrap().looks, looks);
        assert!(looks.iter().all(|(_, look)| look.focal_px().is_none()));
        let unsigned = told.replacen(&serde_json::from_str::<File>(&told).unwrap().digest, NO_DIGEST, 1);
        let resigned = |text: String| text.replacen(NO_DIGEST, &digest_of(&text), 1);
        for (from, to) in [
            ("\"look\": \"", "\"look\": \"AAAA"),
            ("\"version\": 3", "\"version\": 2"),
            ("\"version\": 3", "\"version\": 1"),
        ] {
            let refused = parse(&resigned(unsigned.replacen(from, to, 1))).unwrap_err();
            assert!(refused.contains("`landmarks[0].look` is not possible"), "{refused}");
        }
    }

    /// A map with one picture that shows both landmarks, and a second that shows the second one.
    fn with_views() -> LandmarkMap {
        let pair = |middle: f64| Interval::centred(middle, 0.01);
        let camera = ViewCamera {
            focal_px: pair(417.0),
            centre_px: [320.0, 240.0].map(pair),
            tilt_up_rad: 0.1,
            yaw_rad: pair(0.0),
            tilt_rad: 0.001,
            position_m: [0.1, 0.0].map(pair),
            height_m: pair(0.6),
            body_tilt_rad: 0.002,
            heave_m: 1e-4,
        };
        let picture = |stamp_s: f64, turned_since: Vec<(usize, Interval)>| ViewPicture {
            stamp_s,
            camera: 0,
            pose: PoseBox::from([1.0, 2.0, 0.3].map(pair)),
            turned_since,
        };
        let sight = |picture| ViewSight { picture, at_px: [100.25, 1.0 / 3.0], error_px: [0.5, 0.25] };
        let eye = |x_m: f64| TrueEye {
            world_from_camera: Isometry3::new(Vector3::new(x_m, 0.2, 0.6), Vector3::new(0.1, -0.2, 0.3)),
            focal_px: 417.0,
            centre_px: [320.0, 240.0],
        };
        let views = Views {
            cameras: vec![camera],
            pictures: vec![picture(1.5, Vec::new()), picture(2.0, vec![(0, pair(0.1))])],
            sights: vec![(LandmarkId(3), sight(0)), (LandmarkId(9), sight(0)), (LandmarkId(9), sight(1))],
        };
        LandmarkMap { views, true_eyes: vec![eye(0.1), eye(0.2)], ..map() }
    }

    #[test]
    fn views_come_back_from_a_file_with_the_cameras_that_took_them() {
        // A map with views has looks, whose version is refused without them; here the places alone are told.
        let map = with_views();
        let told = text(&LandmarkMap { views: map.views.clone(), ..map.clone() });
        let file: File = serde_json::from_str(&told).unwrap();
        let (views, eyes) = views::read(&File { version: VERSION, ..file }).unwrap();
        assert_eq!((views.cameras.len(), views.pictures.len(), views.sights.len()), (1, 2, 3));
        for (eye, back) in map.true_eyes.iter().zip(&eyes) {
            let off = eye.world_from_camera.inverse() * back.world_from_camera;
            assert!(off.translation.vector.norm() + off.rotation.angle() < 1e-9 && eye.focal_px == back.focal_px);
        }
        for ((landmark, sight), (landmark_back, back)) in map.views.sights.iter().zip(&views.sights) {
            assert_eq!((landmark, sight.picture), (landmark_back, back.picture));
            for axis in 0..2 {
                // An interval of places that holds the former, and is hardly wider.
                let interval = |sight: &ViewSight| Interval::centred(sight.at_px[axis], sight.error_px[axis]);
                assert!(
                    interval(sight).is_subset_of(interval(back)) && back.error_px[axis] < sight.error_px[axis] + 3e-6
                );
            }
        }
        for (picture, back) in map.views.pictures.iter().zip(&views.pictures) {
            assert!((0..3).all(|axis| picture.pose[axis].is_subset_of(back.pose[axis])));
            assert_eq!(picture.turned_since.len(), back.turned_since.len());
            assert!(
                picture.turned_since.iter().zip(&back.turned_since).all(|(a, b)| a.0 == b.0 && a.1.is_subset_of(b.1))
            );
        }
    }

    #[test]
    fn views_that_cannot_be_are_refused_with_their_key() {
        let told = text(&with_views());
        let refused = |from: &str, to: &str| {
            let changed = told.replacen(from, to, 1);
            assert_ne!(changed, told, "{from}");
            let file: File = serde_json::from_str(&changed).unwrap();
            views::read(&File { version: VERSION, ..file }).unwrap_err()
        };
        assert!(refused("\"camera\": 0", "\"camera\": 1").contains("`pictures[0].camera`"));
        assert!(refused("\"tilt_rad\": 0.001", "\"tilt_rad\": -0.001").contains("`cameras[0].tilt_rad`"));
        assert!(refused("\"tilt_up_rad\": 0.1", "\"tilt_up_rad\": 5.7").contains("`cameras[0].tilt_up_rad`"));
        assert!(refused("100.25", "-1e9").contains("`landmarks[0].seen_in[0]`"));
        assert!(refused("1.5,", "1.5, \"turned_since\": [[0, 0.0, 0.1]],").contains("`pictures[0].turned_since`"));
        // Maps of earlier versions have none.
        let file: File = serde_json::from_str(&told).unwrap();
        let refused = views::read(&File { version: VERSION_WITHOUT_VIEWS, ..file }).unwrap_err();
        assert!(refused.contains("not possible in version 3"), "{refused}");
    }

    #[test]
    fn what_is_no_map_is_refused_with_its_key() {
        let good = text(&map());
        let of_later = good.replacen("\"version\": 1", "\"version\": 5", 1);
        let changed = good.replacen("-0.3", "-0.4", 1);
        for (bad, told) in [
            ("", "expected JSON"),
            (&good[..good.len() / 2], "expected JSON"),
            ("{}", "`format` is null"),
            (&of_later, "`version` is 5, of a later Wherein, expected at most 4"),
            (&changed, "`digest` is not that of the text"),
        ] {
            let refused = parse(bad).unwrap_err();
            assert!(refused.contains(told), "{refused}");
        }
        let resigned = |from: &str, to: &str| {
            let unsigned = good.replacen(&serde_json::from_str::<File>(&good).unwrap().digest, NO_DIGEST, 1);
            let changed = unsigned.replacen(from, to, 1);
            assert_ne!(unsigned, changed);
            changed.replacen(NO_DIGEST, &digest_of(&changed), 1)
        };
        for (from, to, told) in [
            ("\"-y\"", "\"y\"", "`landmarks[0].axis`"),
            ("\"number\": 9", "\"number\": 3", "`landmarks[1].number` is out of order"),
            ("0.7", "-0.7", "`landmarks[0].inverse_depth_per_m`"),
            ("0.7", "9000.7", "`landmarks[0].inverse_depth_per_m`"),
            ("-0.3", "-30000000.0", "`landmarks[0].anchor_m`"),
            ("-0.3", "\"-0.3\"", "`landmarks[0].anchor_m[1]`: invalid type: string \"-0.3\", expected f64"),
            ("\"number\": 9", "\"number\": 9.5", "`landmarks[1].number`: invalid type: floating point"),
        ] {
            let refused = parse(&resigned(from, to)).unwrap_err();
            assert!(refused.contains(told), "{refused}");
        }
    }
}
