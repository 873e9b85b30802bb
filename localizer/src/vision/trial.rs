//! Trials of tile joint detection on synthetic images of floors: the lines found and the bounds claimed for them are compared with the truth.

use std::f64::consts::FRAC_PI_2;
use std::time::Instant;

use super::synthetic::{Floor, Pattern, Random, Strip};
use super::{FloorLines, FloorView, line_fit};

/// Function under trial that detects tile joints. Its arguments are the image, the declared values of the camera's view, and the image motion and the
/// robot's rotation over the exposure; it returns the lines found.
pub(super) type Chain = fn(&image::GrayImage, &FloorView, [f64; 2], f64) -> FloorLines;

/// Number of images per kind of floor; the environment variable `WHEREIN_VISION_FRAMES` sets another number for a long trial.
pub(super) fn frames(usual: usize) -> usize {
    std::env::var("WHEREIN_VISION_FRAMES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Results of detecting tile joints in a number of synthetic images of tiled floors.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    pub(super) frames: usize,
    /// Number of families of parallel tile joints in view, and number of those of which a joint was found; each is summed over all images. A family
    /// is in view if one of its joints is visible over more than 200 px.
    pub(super) families_in_view: usize,
    pub(super) families_found: usize,
    pub(super) lines: usize,
    /// Number of lines that are no tile joint: most of their points are more than 2 px beyond their bound.
    pub(super) wrong_lines: usize,
    /// Number of lines with more points beyond their bound from the tile joint than the share of wrong points that the line declares.
    pub(super) false_claims: usize,
    /// Number of lines for which the set of lines fitted to the points does not contain the true line.
    pub(super) missed_sets: usize,
    pub(super) points: usize,
    /// Greatest distance of a point of a correct line from its tile joint, in units of the point's bound.
    pub(super) worst: f64,
    pub(super) false_points: usize,
    pub(super) psi_squares: f64,
    pub(super) rho_squares: f64,
    pub(super) milliseconds: f64,
}

impl Tally {
    pub(super) fn print(&self, name: &str) {
        let right = (self.lines - self.wrong_lines).max(1) as f64;
        println!(
            "{name:28} frames {:5}  found {:5.1} %  lines {:6}  wrong {:3}  false claims {:3}  missed sets {:3}  false points {:6.3} %  worst {:.2}  psi {:.3} mrad  rho {:.3} px  {:.2} ms",
            self.frames,
            100.0 * self.families_found as f64 / self.families_in_view.max(1) as f64,
            self.lines,
            self.wrong_lines,
            self.false_claims,
            self.missed_sets,
            100.0 * self.false_points as f64 / self.points.max(1) as f64,
            self.worst,
            1e3 * (self.psi_squares / right).sqrt(),
            (self.rho_squares / right).sqrt(),
            self.milliseconds / self.frames.max(1) as f64,
        );
    }

    /// Detects tile joints in an image of a floor and compares the result with the truth. Returns the image, the lines found, and whether everything
    /// that was reported is true.
    pub(super) fn add(
        &mut self,
        chain: Chain,
        floor: &Floor,
        random: &mut Random,
    ) -> (image::GrayImage, FloorLines, bool) {
        let picture = floor.picture(random);
        let view = floor.view();
        let start = Instant::now();
        let found = chain(&picture, &view, floor.blur_px, floor.turn_rad);
        self.milliseconds += start.elapsed().as_secs_f64() * 1e3;
        self.frames += 1;
        let before = self.wrong_lines + self.false_claims + self.missed_sets;
        let mut seen = [false; 2];
        for line in &found.lines {
            self.judge(line, floor, &mut seen);
        }
        for (family, seen) in seen.into_iter().enumerate() {
            if floor.longest_chord_px(family) > 200.0 {
                self.families_in_view += 1;
                self.families_found += usize::from(seen);
            }
        }
        let good = before == self.wrong_lines + self.false_claims + self.missed_sets;
        (picture, found, good)
    }

    fn judge(&mut self, line: &super::FloorLine, floor: &Floor, seen: &mut [bool; 2]) {
        let far = |family: usize, index: i64| {
            line.points_px
                .iter()
                .filter(|point| floor.distance_to_joint_px(family, index, [point[0], point[1]]).abs() > point[2])
                .count()
        };
        let middle = line.points_px[line.points_px.len() / 2];
        // A reported line is compared with one tile joint: the joint for which the fewest of the line's points are farther away than their bound.
        let joints: Vec<(usize, i64)> = [0, 1]
            .into_iter()
            .flat_map(|family| {
                let number = floor.joint_number(family, [middle[0], middle[1]]);
                (-1..=1).map(move |near| (family, number + near))
            })
            .collect();
        let Some((wrong, &(family, number))) =
            joints.iter().map(|joint| (far(joint.0, joint.1), joint)).min_by_key(|pair| pair.0)
        else {
            return;
        };
        let beyond = |distance: f64, point: &[f64; 3]| distance.abs() > 2.0 + point[2];
        let distances: Vec<f64> = line
            .points_px
            .iter()
            .map(|point| floor.distance_to_joint_px(family, number, [point[0], point[1]]))
            .collect();
        let off = distances.iter().zip(&line.points_px).filter(|(distance, point)| beyond(**distance, point)).count();
        self.lines += 1;
        self.points += line.points_px.len();
        self.false_points += wrong;
        self.false_claims += usize::from(wrong as f64 > line.share_wrong * line.points_px.len() as f64);
        if 2 * off > line.points_px.len() {
            self.wrong_lines += 1;
            return;
        }
        seen[family] = true;
        for (distance, point) in distances.iter().zip(&line.points_px) {
            self.worst = self.worst.max(distance.abs() / point[2]);
        }
        let Some(set) = line_fit::enclose(&line.points_px, line.share_wrong) else { return };
        // The true line is expressed relative to the centroid of the fitted set of lines, and its angle is chosen, modulo half a turn, nearest to the
        // set's.
        let mut true_rad = floor.angle_rad + family as f64 * FRAC_PI_2;
        let half_turns = ((set.direction_rad - true_rad) / std::f64::consts::PI).round();
        true_rad += half_turns * std::f64::consts::PI;
        let sign = if half_turns.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        let true_offset_px = -sign * floor.distance_to_joint_px(family, number, set.centroid_px);
        self.psi_squares += (set.direction_rad - true_rad).powi(2);
        self.rho_squares += true_offset_px.powi(2);
        let inside = set
            .offset_at(true_rad, true_rad)
            .is_some_and(|[low, high]| low <= true_offset_px && true_offset_px <= high);
        self.missed_sets += usize::from(!inside);
    }
}

/// A plain floor at a random position and angle: the test scenes' usual floor of 0.30 m tiles under a camera of 1333 px/m.
pub(super) fn plain_floor(random: &mut Random) -> Floor {
    let edge_px = [400.0, 400.0];
    Floor {
        size_px: [640, 480],
        edge_px,
        joint_width_px: random.between(4.0, 6.7),
        angle_rad: random.between(-4.0, 4.0),
        phase_px: [random.between(0.0, 400.0), random.between(0.0, 400.0)],
        tile_albedo: 0.6,
        joint_albedo: 0.25,
        tile_spread: 0.03,
        texture: 0.0,
        pattern: Pattern::Plain,
        wear: 0.0,
        strips: Vec::new(),
        shadow: None,
        gradient: [random.between(-0.3, 0.3), random.between(-0.3, 0.3)],
        electrons: 10_000.0,
        exposure_grey: 128.0,
        blur_px: [0.0, 0.0],
        turn_rad: 0.0,
    }
}

/// A random floor with everything that the test scenes' floors may contain: wear, patterns, wires, tapes, shadows, texture, uneven light and motion.
pub(super) fn realistic_floor(random: &mut Random) -> Floor {
    let mut floor = plain_floor(random);
    if random.chance(0.25) {
        floor.edge_px = [400.0, 600.0];
        floor.phase_px[1] = random.between(0.0, 600.0);
    }
    floor.tile_albedo = random.between(0.35, 0.8);
    // Tile joints are mostly darker than the tiles, sometimes lighter; their albedo always differs from that of the tiles by at least 18 %.
    floor.joint_albedo = if random.chance(0.8) {
        floor.tile_albedo * random.between(0.3, 0.75)
    } else {
        (floor.tile_albedo * random.between(1.3, 1.8)).min(0.95)
    };
    floor.tile_spread = random.between(0.0, 0.12);
    floor.texture = random.between(0.01, 0.04);
    floor.pattern = match (random.unit() * 8.0) as usize {
        0 => Pattern::Speckle,
        1 => Pattern::Marble,
        2 => Pattern::Stripes { pitch_px: random.between(35.0, 120.0), contrast: random.between(0.05, 0.25) },
        _ => Pattern::Plain,
    };
    floor.wear = if random.chance(0.3) { random.between(0.0, 0.9) } else { 0.0 };
    floor.gradient = [random.between(-0.8, 0.8), random.between(-0.8, 0.8)];
    floor.shadow = random.chance(0.25).then(|| (random.between(0.1, 0.6), random.between(-2.0, 2.0)));
    for _ in 0..(random.unit() * 2.2) as usize {
        floor.strips.push(stray_strip(&floor, random));
    }
    floor.electrons = [50.0, 170.0, 1700.0, 10_000.0][(random.unit() * 4.0) as usize];
    floor.exposure_grey = random.between(80.0, 150.0);
    let (speed_px, course) = (random.between(0.0, 7.0), random.between(-3.2, 3.2));
    floor.blur_px = [speed_px * course.cos(), speed_px * course.sin()];
    floor.turn_rad = random.between(-0.012, 0.012);
    floor
}

/// A wire or a tape on the floor; one in four is nearly parallel to the joints.
fn stray_strip(floor: &Floor, random: &mut Random) -> Strip {
    let wire = random.chance(0.5);
    let normal_rad =
        if random.chance(0.25) { floor.angle_rad + random.between(-0.08, 0.08) } else { random.between(-1.6, 1.6) };
    Strip {
        sin_cos: [normal_rad.sin(), normal_rad.cos()],
        offset_px: random.between(-250.0, 250.0),
        width_px: if wire { random.between(3.0, 9.0) } else { random.between(12.0, 60.0) },
        albedo: if random.chance(0.5) { random.between(0.03, 0.15) } else { random.between(0.2, 0.9) },
        bend_px: if wire { random.between(0.0, 25.0) } else { 0.0 },
    }
}

/// Writes an image, with the lines found marked in it, to the folder that the environment variable `WHEREIN_VISION_SAVE` names; without the variable
/// nothing is written. A line's points have a colour for its family, rejected segments are red.
pub(super) fn save(name: &str, picture: &image::GrayImage, found: &FloorLines, floor: &Floor) {
    let Ok(folder) = std::env::var("WHEREIN_VISION_SAVE") else { return };
    let mut canvas =
        image::RgbImage::from_fn(picture.width(), picture.height(), |u, v| image::Rgb([picture.get_pixel(u, v)[0]; 3]));
    for line in &found.lines {
        for point in &line.points_px {
            canvas.put_pixel(
                point[0].round() as u32,
                point[1].round() as u32,
                image::Rgb([if line.family == 0 { 255 } else { 0 }, 255, 0]),
            );
        }
    }
    for &[u0, v0, u1, v1] in &found.rejected_px {
        for step in 0..120 {
            let share = f64::from(step) / 120.0;
            let (u, v) = (u0 + share * (u1 - u0), v0 + share * (v1 - v0));
            if (0.0..f64::from(picture.width())).contains(&u) && (0.0..f64::from(picture.height())).contains(&v) {
                canvas.put_pixel(u as u32, v as u32, image::Rgb([255, 0, 0]));
            }
        }
    }
    println!("{name}: {floor:?}");
    let _ = canvas.save(format!("{folder}/{name}.png"));
}
