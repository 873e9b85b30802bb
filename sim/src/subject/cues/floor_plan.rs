//! The walls of the map as the classical estimators compare lines of a scan with them, and how far the true walls may be from there.
//!
//! Any point of a wall is within the bound `walls.placement` of its place on the map, for the whole run. Two things can be to blame, and either may
//! use up the bound: the whole plan lies askew, or each wall has errors of its own. Both last, so that neither averages out over scans: not over the
//! beams that meet one wall, and the first not over walls either. The first is three numbers, a shift along x and y and a turn about the middle of
//! all walls; the second is two numbers for each wall, namely how far either of its ends is in front of its place.

use localizer::{
    Map,
    map::{Wall, WallMap},
};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

use crate::subject::half_turn;

use super::{Mount, SIGMAS_OF_BOUND, scan::Line, turned};

/// Fronts of walls.
#[derive(Clone, Debug)]
pub(crate) struct FloorPlan {
    fronts: Vec<Front>,
    /// Middle of all walls, about which the plan may be turned.
    middle_m: [f64; 2],
    /// Standard deviation of the place of any point of a wall, by either cause.
    pub(crate) placement_sigma_m: f64,
    /// Standard deviation of the plan's turn that moves the farthest point by as much.
    turn_sigma_rad: f64,
}

/// The front of a wall: the side to the left of the way along it.
#[derive(Clone, Copy, Debug)]
struct Front {
    from: Vector2<f64>,
    along: Vector2<f64>,
    length_m: f64,
    /// Direction out of the front.
    normal_rad: f64,
}

/// What a line of a scan says about a pose by the wall that it is nearest to from there: residuals (measured less predicted).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    /// Index of the wall.
    pub(crate) wall: usize,
    /// Residual of the heading.
    pub(crate) turn_rad: f64,
    /// Unit vector out of the wall, along which the line tells the position, and the residual along it.
    pub(crate) normal: [f64; 2],
    pub(crate) off_m: f64,
    /// Shares of the errors of the wall's two ends that the wall is off by where it is met.
    pub(crate) shares: [f64; 2],
    /// Length of the wall.
    pub(crate) length_m: f64,
    /// Place in the world where the line's middle is seen from the pose, and the derivative of its place along the normal by the heading.
    place: Vector2<f64>,
    by_turn_m: f64,
}

/// Angle between a line and a wall beyond which the line is something else whatever the pose: a robot that has lost its heading by so much is lost.
const MOST_TURN_RAD: f64 = 0.3;

impl FloorPlan {
    /// The plan of a map; `None` for a map without walls.
    pub(crate) fn new(map: &Map) -> Option<FloorPlan> {
        let WallMap { walls, placement_m } = map.walls.as_ref()?;
        let ends_m = || walls.iter().flat_map(|wall| wall.ends_m).map(Vector2::from);
        let (low, high) = (ends_m().reduce(|a, b| a.inf(&b))?, ends_m().reduce(|a, b| a.sup(&b))?);
        let middle = (low + high) * 0.5;
        let farthest_m = ends_m().map(|end| (end - middle).norm()).fold(0.0, f64::max);
        let placement_sigma_m = SIGMAS_OF_BOUND * placement_m;
        Some(FloorPlan {
            fronts: walls.iter().filter_map(Front::of).collect(),
            middle_m: middle.into(),
            placement_sigma_m,
            turn_sigma_rad: placement_sigma_m / farthest_m.max(f64::MIN_POSITIVE),
        })
    }

    /// Standard deviations of the plan's shift along x and y, and of its turn.
    pub(crate) fn sigma(&self) -> [f64; 3] {
        [self.placement_sigma_m, self.placement_sigma_m, self.turn_sigma_rad]
    }

    /// The pose from which a robot would see the walls where the map has them as a robot at `pose` sees them on a plan that is shifted and turned.
    pub(crate) fn seen_from(
        &self,
        [x_m, y_m, heading_rad]: [f64; 3],
        [east_m, north_m, turn_rad]: [f64; 3],
    ) -> [f64; 3] {
        let [dx, dy] = self.about_middle([x_m, y_m]);
        [x_m - east_m + turn_rad * dy, y_m - north_m - turn_rad * dx, heading_rad - turn_rad]
    }

    /// A place as seen from the middle of the plan.
    pub(crate) fn about_middle(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        [x_m - self.middle_m[0], y_m - self.middle_m[1]]
    }

    /// The wall that a line is nearest to from a pose, among those that show their front and that the line's middle is beside; `None` without one.
    pub(crate) fn met(&self, line: &Line, pose: [f64; 3]) -> Option<Met> {
        self.beside(line, pose).min_by(|one, other| one.off_m.abs().total_cmp(&other.off_m.abs()))
    }

    /// Half the distance from the wall that a line meets from a pose to the next one that it may as well be: what the residual may be without being
    /// that of another wall.
    pub(crate) fn half_way_m(&self, line: &Line, pose: [f64; 3], met: &Met) -> f64 {
        let others = self.beside(line, pose).filter(|other| other.wall != met.wall);
        0.5 * others.map(|other| (other.off_m - met.off_m).abs()).fold(f64::INFINITY, f64::min)
    }

    fn beside(&self, line: &Line, [x_m, y_m, heading_rad]: [f64; 3]) -> impl Iterator<Item = Met> {
        let (line_rad, [dx, dy]) = (heading_rad + line.normal_rad, turned(line.middle_m, heading_rad));
        let place = Vector2::new(x_m + dx, y_m + dy);
        self.fronts.iter().enumerate().filter_map(move |(wall, front)| {
            let turn_rad = half_turn(front.normal_rad - line_rad);
            let share = (place - front.from).dot(&front.along) / front.length_m;
            let is_beside = turn_rad.abs() <= MOST_TURN_RAD && (0.0..=1.0).contains(&share);
            let normal = Vector2::new(-front.along.y, front.along.x);
            is_beside.then(|| Met {
                wall,
                turn_rad,
                normal: normal.into(),
                off_m: (front.from - place).dot(&normal),
                shares: [1.0 - share, share],
                length_m: front.length_m,
                place,
                by_turn_m: normal.dot(&Vector2::new(-dy, dx)),
            })
        })
    }

    /// Covariance of the turn and of the place along the normal by the displacements of the wall and of the plan.
    pub(crate) fn displaced(&self, met: &Met) -> Matrix2<f64> {
        let by_ends = Matrix2::new(-1.0 / met.length_m, 1.0 / met.length_m, met.shares[0], met.shares[1]);
        let [east, north] = met.normal;
        let [dx, dy] = self.about_middle(met.place.into());
        let by_plan = Matrix2x3::new(0.0, 0.0, -1.0, -east, -north, east * dy - north * dx);
        by_ends * by_ends.transpose() * self.placement_sigma_m.powi(2) + covariance(by_plan, self.sigma())
    }

    /// Derivatives of the turn and of the place along the normal by a pose, and the covariance of all errors of the comparison from there.
    pub(crate) fn noise(
        &self,
        line: &Line,
        met: &Met,
        heading_rad: f64,
        mount: &Mount,
    ) -> ([[f64; 3]; 2], Matrix2<f64>) {
        let [east, north] = met.normal;
        let rows = [[0.0, 0.0, 1.0], [east, north, met.by_turn_m]];
        let [ahead, left] = turned(met.normal, -heading_rad);
        let by_mount = Matrix2x3::new(0.0, 0.0, 1.0, ahead, left, met.by_turn_m);
        let own = Matrix2::from_diagonal(&Vector2::from(line.sigma.map(|sigma| sigma * sigma)));
        (rows, own + covariance(by_mount, mount.sigma) + self.displaced(met))
    }
}

/// Covariance of two quantities that depend on three errors by `by`.
fn covariance(by: Matrix2x3<f64>, sigma: [f64; 3]) -> Matrix2<f64> {
    by * Matrix3::from_diagonal(&Vector3::from(sigma.map(|sigma| sigma * sigma))) * by.transpose()
}

impl Front {
    /// The front of a wall; `None` for one without length.
    fn of(wall: &Wall) -> Option<Front> {
        let [from, to] = wall.ends_m.map(Vector2::from);
        let length_m = (to - from).norm();
        let along = (to - from) / length_m;
        (length_m > 0.0).then(|| Front { from, along, length_m, normal_rad: along.x.atan2(-along.y) })
    }
}
