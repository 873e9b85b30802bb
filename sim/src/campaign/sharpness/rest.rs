//! Times of rest: how far the body may turn while the encoders count nothing.

use interval::Interval;
use localizer::bounds;

use super::{
    SAME_S,
    history::History,
    kind::{Broken, Declared, Kind, Linearised, demand, within},
};

/// Time for which wheels may roll on after the encoders' last count; only then are they at rest, as the bound `wheels.rest` says.
const SETTLED_S: f64 = 0.5;

/// The times of rest up to an instant.
pub(super) struct Rest {
    /// For each time of rest the stamps of the wheel readings from when the wheels had settled.
    pub(super) rests: Vec<Vec<usize>>,
    /// Greatest turn of the body since the wheels had settled.
    pub(super) turn_rad: f64,
}

impl Rest {
    /// The times of rest of wheel readings, each given by its stamp and the ticks of both wheels.
    pub(super) fn of(readings: &[(usize, [i64; 2])], history: &History, turn_rad: f64) -> Rest {
        let still = readings.chunk_by(|one, other| one.1 == other.1);
        let settled = still.map(|still| {
            let since_s = history.stamps_s[still[0].0] + SETTLED_S - SAME_S;
            still.iter().map(|(stamp, _)| *stamp).filter(|stamp| history.stamps_s[*stamp] >= since_s).collect()
        });
        Rest { rests: settled.filter(|stamps: &Vec<usize>| stamps.len() > 1).collect(), turn_rad }
    }
}

impl Kind for Rest {
    fn declared(&self, _history: &History) -> Vec<Declared> {
        Vec::new()
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let heading = |stamp: usize| Interval::point(history.poses[stamp].heading_rad);
        let most = within(Interval::point(self.turn_rad));
        for rest in &self.rests {
            for stamp in &rest[1..] {
                let turned_rad = heading(*stamp) - heading(rest[0]);
                demand(slack, bounds::WHEELS_REST, history.stamps_s[*stamp], turned_rad, most)?;
            }
        }
        Ok(())
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let most = Interval::new(-self.turn_rad, self.turn_rad);
        for rest in &self.rests {
            let (first, last) = (rest[0], rest[rest.len() - 1]);
            let knots = near.knots.iter().copied().filter(|knot| first < *knot && *knot < last);
            for stamp in knots.chain([last]).collect::<Vec<_>>() {
                let turned_rad = near.history.poses[stamp].heading_rad - near.history.poses[first].heading_rad;
                let mut terms = near.pose(stamp, 2, 1.0).to_vec();
                terms.extend(near.pose(first, 2, -1.0));
                near.add(terms, turned_rad, most);
            }
        }
    }
}
