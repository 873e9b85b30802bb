//! How likely a measurement is from a pose: a Gaussian by the declared bounds, mixed with a uniform density for measurements that are wrong.

use std::f64::consts::{FRAC_PI_2, PI};

use localizer::map::TileGrid;
use nalgebra::{Matrix2, Vector2, Vector3};

use crate::subject::{
    cues::{Edge, FloorPlan, Joint, Line, READINGS_WHILE_LASTING, Seen, heading_of, turned, within_quarter},
    half_turn,
};

/// Share of the uniform density, for measurements that are wrong: that of AMCL's model of range readings (`z_rand`).
const WRONG_SHARE: f64 = 0.05;
/// Share of the lines of a scan that are no mapped walls but furniture: that of Nav2's AMCL (`z_rand`), since half of what stands along the walls of
/// a furnished room is furniture.
const FURNITURE_SHARE: f64 = 0.5;
/// Range in metres within which a piece of furniture may be anywhere before a wall: that of a room.
const BEFORE_WALL_M: f64 = 5.0;

/// What measurements are compared with.
pub(crate) struct Known<'a> {
    pub(crate) tiles: Option<&'a TileGrid>,
    pub(crate) wall_directions_rad: &'a [f64],
    pub(crate) floor_plan: Option<&'a FloorPlan>,
    /// Area of the building, over which a wrong position may be anywhere.
    pub(crate) area_m2: f64,
    /// Factor on the standard deviations of measurements.
    pub(crate) scale: f64,
}

/// A function that gives the logarithm of a measurement's likelihood from a pose; `None` for a measurement that tells nothing. `mean_rad` is the mean
/// heading of the poses that it is asked for.
///
/// The poses are those at which the device would be seen to be if it were mounted as stated: a pose with the errors of the mount added.
pub(crate) fn likelihood<'a>(
    seen: &'a Seen,
    known: &'a Known<'a>,
    mean_rad: f64,
) -> Option<Box<dyn Fn([f64; 3]) -> f64 + 'a>> {
    match seen {
        Seen::Pose { pose, covariance } => {
            let covariance = covariance * known.scale.powi(2);
            let (inverse, determinant) = (covariance.try_inverse()?, covariance.determinant());
            let peak = ((2.0 * PI).powi(3) * determinant).sqrt().recip();
            let anywhere = (known.area_m2 * 2.0 * PI).recip();
            Some(Box::new(move |at| {
                let off = Vector3::new(pose[0] - at[0], pose[1] - at[1], half_turn(pose[2] - at[2]));
                mixed(peak * (-0.5 * off.dot(&(inverse * off))).exp(), anywhere)
            }))
        }
        Seen::Joints(joints) => {
            let grid = known.tiles.filter(|_| !joints.is_empty())?;
            // The joints of one image share most of their errors. Together they count as one joint of each of the two families.
            let weight = 2.0_f64.min(joints.len() as f64) / joints.len() as f64;
            Some(Box::new(move |at| {
                weight * joints.iter().map(|joint| of_joint(joint, at, grid, known.scale)).sum::<f64>()
            }))
        }
        Seen::Edges(edges) => of_edges(edges, known, mean_rad),
        Seen::Lines(lines) => {
            let plan = known.floor_plan.filter(|_| !lines.is_empty())?;
            Some(Box::new(move |at| lines.iter().map(|line| of_line(line, at, plan, known.scale)).sum()))
        }
        // Landmarks are on no map, and a filter over poses alone keeps none.
        Seen::Landmarks(_) => None,
        Seen::Position { in_robot_m, in_world_m, sigma_m } => {
            let variance = (sigma_m * known.scale).powi(2);
            let covariance = Matrix2::from_diagonal_element(variance);
            let (inverse, peak) = (covariance.try_inverse()?, (2.0 * PI * variance).recip());
            Some(Box::new(move |at| {
                let [dx, dy] = turned(*in_robot_m, at[2]);
                let off = Vector2::new(in_world_m[0] - at[0] - dx, in_world_m[1] - at[1] - dy);
                mixed(peak * (-0.5 * off.dot(&(inverse * off))).exp(), known.area_m2.recip())
            }))
        }
    }
}

fn of_joint(joint: &Joint, at: [f64; 3], grid: &TileGrid, scale: f64) -> f64 {
    let agreement = joint.agreement(at, grid);
    let sigma = joint.sigma.map(|sigma| sigma * scale);
    let off = [agreement.turn_rad, agreement.off_m];
    let anywhere = [FRAC_PI_2, 2.0 * agreement.half_edge_m];
    // A joint that is far from where a pose has one still tells that pose's heading.
    let of_side = |side: usize| {
        let peak = ((2.0 * PI).sqrt() * sigma[side]).recip();
        mixed(peak * (-0.5 * (off[side] / sigma[side]).powi(2)).exp(), anywhere[side].recip())
    };
    of_side(0) + of_side(1)
}

/// The line is the wall that it is nearest to, or furniture.
///
/// The displacements of the wall and of the whole plan are not sampled: they are too many. They last, so that the scans of a metre's way say together
/// what one of them would say: each is given as many times their variance as there are such scans.
fn of_line(line: &Line, at: [f64; 3], plan: &FloorPlan, scale: f64) -> f64 {
    let anywhere = (BEFORE_WALL_M * PI).recip();
    let by_wall = plan.met(line, at).and_then(|met| {
        let own = Matrix2::from_diagonal(&Vector2::from(line.sigma.map(|sigma| (scale * sigma).powi(2))));
        let covariance = own + plan.displaced(&met) * READINGS_WHILE_LASTING;
        let (off, inverse) = (Vector2::new(met.turn_rad, met.off_m), covariance.try_inverse()?);
        Some((-0.5 * off.dot(&(inverse * off))).exp() / (2.0 * PI * covariance.determinant().sqrt()))
    });
    ((1.0 - FURNITURE_SHARE) * by_wall.unwrap_or(0.0) + FURNITURE_SHARE * anywhere).ln()
}

fn of_edges<'a>(edges: &[Edge], known: &Known<'a>, mean_rad: f64) -> Option<Box<dyn Fn([f64; 3]) -> f64 + 'a>> {
    // Wherever the samples are, all edges count that are not clutter at sight, so that samples that are all wrong do not keep themselves.
    let (off_rad, variance) = heading_of(edges, known.wall_directions_rad, mean_rad, f64::INFINITY)?;
    let (told_rad, sigma_rad) = (mean_rad + off_rad, known.scale * variance.sqrt());
    let peak = ((2.0 * PI).sqrt() * sigma_rad).recip();
    Some(Box::new(move |at| {
        let off = within_quarter(told_rad - at[2]) / sigma_rad;
        mixed(peak * (-0.5 * off * off).exp(), FRAC_PI_2.recip())
    }))
}

/// Logarithm of the mixture of a right and of a wrong measurement's density.
fn mixed(right: f64, anywhere: f64) -> f64 {
    ((1.0 - WRONG_SHARE) * right + WRONG_SHARE * anywhere).ln()
}
