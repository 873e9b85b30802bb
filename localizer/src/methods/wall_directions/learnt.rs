//! Learnt directions of the building: what `wall_directions` keeps from one image to the next, learns, and takes back.

use interval::Interval;

use crate::{
    PoseUnion,
    method::{Memory, MotionBetween},
};

use super::{FEWEST_TO_LEARN, NEW_DIRECTION_RAD, WallDirections, headings, held::Certificates};

/// One direction of the building modulo quarter turns, from world x counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Direction {
    pub(super) direction_rad: Interval,
    /// Stamp of the image from which the direction was learnt; directions of the map are known from the beginning.
    pub(super) since_s: f64,
}

impl Memory for WallDirections {
    fn learn(&mut self, posterior: &PoseUnion, _motion: MotionBetween) {
        let heading = posterior.hull()[2];
        if !self.learns || self.strange_rad.len() < FEWEST_TO_LEARN || heading.is_empty() {
            return;
        }
        // A direction α of the building is the heading θ plus the edge's angle φ from robot forward, up to quarter turns. Its interval is as wide as
        // those of heading and edges together, never narrower.
        let quarter = Interval::PI * 0.5;
        let any = Interval::new(-0.1, quarter.hi() + 0.1);
        let turned: Vec<Vec<Interval>> =
            self.strange_rad.iter().map(|&azimuth| headings::of_line(azimuth * -1.0, &[Interval::ZERO], any)).collect();
        let agreed = headings::agreed(&turned, turned.len() - self.quotas.wrong_of_image(turned.len()));
        let Some(azimuth) = one_direction(&agreed) else { return };
        let direction_rad = azimuth + heading;
        let near = |known: Interval| {
            let quarters = ((known.mid() - direction_rad.mid()) / quarter.mid()).round();
            !(direction_rad + quarter * quarters).inflate(NEW_DIRECTION_RAD).is_disjoint_from(known)
        };
        if direction_rad.width() <= NEW_DIRECTION_RAD && !self.directions_rad().into_iter().any(near) {
            self.directions.push(Direction { direction_rad, since_s: self.latest_s });
        }
    }

    fn forget_since(&mut self, since_s: f64) {
        self.directions.retain(|direction| direction.since_s <= since_s);
        self.certificates = Certificates::default();
    }

    fn take_contradiction(&mut self) -> bool {
        let are_too_many = self.certificates.are_too_many;
        if are_too_many {
            self.certificates = Certificates::default();
        }
        are_too_many
    }

    fn clock_set_back(&mut self) {
        self.directions.iter_mut().for_each(|direction| direction.since_s = f64::NEG_INFINITY);
    }
}

/// The one direction on which all given intervals of directions agree up to quarter turns; `None` where they give several directions and it is not
/// known which is right.
fn one_direction(sets: &[Interval]) -> Option<Interval> {
    let quarter = Interval::PI * 0.5;
    let (&first, others) = sets.split_first()?;
    others.iter().try_fold(first, |direction, &set| {
        let again = set - quarter;
        (!again.is_disjoint_from(first)).then(|| direction.hull(again))
    })
}
