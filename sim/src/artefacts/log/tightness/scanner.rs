//! How far beyond mapped walls a scanner's beams ended, as seen from the true poses.

use std::f64::consts::FRAC_PI_3;

use localizer::{Reading, bounds, map::Wall, methods::wall_ranges::Scan};
use nalgebra::Vector2;

use super::{Comparison, Tightness};
use crate::scene::Scanner;

/// Greatest angle between a beam and a wall's normal for the beam to be compared: at a slant the wall's place tells little of the distance.
const MOST_SLANT_RAD: f64 = FRAC_PI_3;

/// A wall that a beam meets.
struct Met {
    distance_m: f64,
    /// Distance from the place where the beam meets the wall to the nearer end of the wall.
    from_end_m: f64,
    length_m: f64,
    /// Angle between the beam and the wall's normal.
    slant_rad: f64,
}

impl Comparison<'_> {
    /// Errors of the distances that the scanner measured. Things that stand before a wall end a beam sooner, so that a distance that is too short says
    /// nothing; but no beam passes through a wall.
    pub(super) fn scans(&self, scans: &[Reading]) -> Option<Tightness> {
        let (scanner, map) = (self.told.robot.scanner.as_ref()?, self.told.map());
        let walls = map.walls?;
        let mut range = Tightness::new(bounds::SCANNER_RANGE);
        for reading in scans {
            let Reading::Other { measured_s, numbers, .. } = reading else { continue };
            let (Some(scan), Some(pose)) = (Scan::of(numbers), self.truth.at(*measured_s)) else { continue };
            let toward = |rad: f64| Vector2::new(rad.cos(), rad.sin());
            let ahead = toward(pose.heading_rad);
            let left = Vector2::new(-ahead.y, ahead.x);
            let eye = Vector2::new(pose.x_m, pose.y_m) + ahead * scanner.forward_m + left * scanner.left_m;
            for (bearing_rad, read_m) in scan.echoes() {
                let beam = toward(pose.heading_rad + scanner.yaw_deg.to_radians() + bearing_rad);
                let met = walls.walls.iter().filter_map(|wall| met(wall, eye, beam));
                let Some(met) = met.min_by(|one, other| one.distance_m.total_cmp(&other.distance_m)) else { continue };
                let Some(farthest_m) = self.farthest_m(&met, scanner, walls.placement_m) else { continue };
                let off_m = [read_m - met.distance_m, farthest_m - met.distance_m];
                range.compare([*measured_s; 2], scanner.tolerance_m, [scanner.tolerance_m, 1.0], off_m);
            }
        }
        Some(range)
    }

    /// Greatest distance at which the beam may meet the wall, given the errors of the true pose, of the scanner's mount and stamp, of the body's lean
    /// and of the wall's place; `None` where the beam may pass beside the wall, or meets it at too great a slant.
    fn farthest_m(&self, met: &Met, scanner: &Scanner, placement_m: f64) -> Option<f64> {
        let (bounds, arm_m) = (&self.told.bounds, scanner.forward_m.hypot(scanner.left_m));
        let [speed_m_per_s, turn_rad_per_s] = [bounds.reach_speed_m_per_s, bounds.reach_turn_rate_rad_per_s];
        let turned_rad = self.within_rad + turn_rad_per_s * scanner.stamp_tolerance_s;
        let moved_m = 2.0_f64.sqrt() * (self.within_m + scanner.position_tolerance_m)
            + speed_m_per_s * scanner.stamp_tolerance_s
            + arm_m * turned_rad;
        let angle_rad = scanner.angle_tolerance_deg.to_radians();
        // Both ends of the wall may be off, to opposite sides.
        let by_ends_rad = 2.0 * placement_m / met.length_m;
        let slant_rad = met.slant_rad + turned_rad + angle_rad + by_ends_rad;
        let lean_rad = angle_rad + bounds.body_tilt_deg.to_radians();
        if slant_rad > MOST_SLANT_RAD || lean_rad > MOST_SLANT_RAD {
            return None;
        }
        let away_m = met.distance_m * met.slant_rad.cos() + moved_m + placement_m;
        let farthest_m = away_m / (slant_rad.cos() * lean_rad.cos());
        let aside_m = away_m * (slant_rad.tan() - met.slant_rad.tan()) + moved_m + placement_m;
        (aside_m < met.from_end_m).then_some(farthest_m)
    }
}

/// Where a beam meets the front of a wall; `None` if it passes beside it or comes from behind.
fn met(wall: &Wall, eye: Vector2<f64>, beam: Vector2<f64>) -> Option<Met> {
    let [from, to] = wall.ends_m.map(Vector2::from);
    let length_m = (to - from).norm();
    let along = (to - from) / length_m;
    let normal = Vector2::new(-along.y, along.x);
    let toward = -beam.dot(&normal);
    let distance_m = (eye - from).dot(&normal) / toward;
    let share_m = (eye + beam * distance_m - from).dot(&along);
    let is_met = length_m > 0.0 && toward > 0.0 && distance_m > 0.0 && (0.0..=length_m).contains(&share_m);
    is_met.then(|| Met {
        distance_m,
        from_end_m: share_m.min(length_m - share_m),
        length_m,
        slant_rad: toward.clamp(0.0, 1.0).acos(),
    })
}
