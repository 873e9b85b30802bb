//! Geographic positions in the world frame: a plane that touches the earth's ellipsoid at the world's origin.

use crate::scene::Datum;

/// Greater half axis of the ellipsoid of WGS 84 (NIMA TR8350.2, table 3.1).
const HALF_AXIS_M: f64 = 6_378_137.0;
/// Flattening of the ellipsoid of WGS 84 (NIMA TR8350.2, table 3.1).
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// World x and y of a geographic position: its offset east and north from the datum, in the plane that touches the ellipsoid there, turned so that x
/// is the datum's axis.
pub(super) fn world_m(datum: &Datum, latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> [f64; 2] {
    let origin = geocentric_m(datum.latitude_deg, datum.longitude_deg, datum.altitude_m);
    let place = geocentric_m(latitude_deg, longitude_deg, altitude_m);
    let [dx, dy, dz] = [0, 1, 2].map(|axis| place[axis] - origin[axis]);
    let (sin_lat, cos_lat) = datum.latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = datum.longitude_deg.to_radians().sin_cos();
    let east_m = -sin_lon * dx + cos_lon * dy;
    let north_m = -sin_lat * cos_lon * dx - sin_lat * sin_lon * dy + cos_lat * dz;
    let (sin, cos) = datum.x_axis_deg.to_radians().sin_cos();
    [cos * east_m + sin * north_m, -sin * east_m + cos * north_m]
}

/// Earth-centred coordinates of a geographic position: N = a/√(1 − e² sin² φ), x = (N + h) cos φ cos λ, y = (N + h) cos φ sin λ,
/// z = (N(1 − e²) + h) sin φ.
fn geocentric_m(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> [f64; 3] {
    let squared_eccentricity = FLATTENING * (2.0 - FLATTENING);
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    let normal_m = HALF_AXIS_M / (1.0 - squared_eccentricity * sin_lat * sin_lat).sqrt();
    [
        (normal_m + altitude_m) * cos_lat * cos_lon,
        (normal_m + altitude_m) * cos_lat * sin_lon,
        (normal_m * (1.0 - squared_eccentricity) + altitude_m) * sin_lat,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn datum(x_axis_deg: f64) -> Datum {
        Datum { latitude_deg: 45.0, longitude_deg: 9.0, altitude_m: 0.0, x_axis_deg, sigmas: 0.0 }
    }

    #[test]
    fn a_second_of_arc_at_45_degrees_has_the_length_of_the_tables() {
        // Lengths of a degree at latitude 45° in tables for WGS 84, rounded to metres: 111 132 m along the meridian, 78 847 m along the parallel.
        let [east_m, _] = world_m(&datum(0.0), 45.0, 9.0 + 1.0 / 3600.0, 0.0);
        let [_, north_m] = world_m(&datum(0.0), 45.0 + 1.0 / 3600.0, 9.0, 0.0);
        assert!((east_m - 78_847.0 / 3600.0).abs() < 2e-4, "{east_m}");
        assert!((north_m - 111_132.0 / 3600.0).abs() < 2e-4, "{north_m}");
    }

    #[test]
    fn an_axis_to_the_north_turns_north_into_x() {
        let [x_m, y_m] = world_m(&datum(90.0), 45.0001, 9.0, 0.0);
        assert!(x_m > 11.1 && y_m.abs() < 1e-6, "{x_m} {y_m}");
        let [x_m, y_m] = world_m(&datum(90.0), 45.0, 9.0001, 0.0);
        assert!(y_m < -7.8 && x_m.abs() < 1e-3, "{x_m} {y_m}");
    }

    #[test]
    fn a_height_far_from_the_datum_leans_outwards() {
        // The vertical leans by 0.1° a tenth of a degree to the north, and by cos 45° of that a tenth of a degree to the east, in which direction it
        // also leans to the north by sin 45° · cos 45° · (1 − cos 0.1°).
        let raised_m = |latitude_deg: f64, longitude_deg: f64| {
            let [ground, high] =
                [0.0, 100.0].map(|altitude_m| world_m(&datum(0.0), latitude_deg, longitude_deg, altitude_m));
            [high[0] - ground[0], high[1] - ground[1]]
        };
        let (sin, cos) = 0.1_f64.to_radians().sin_cos();
        for (raised_m, by_hand_m) in [
            (raised_m(45.1, 9.0), [0.0, 100.0 * sin]),
            (raised_m(45.0, 9.1), [100.0 * 0.5_f64.sqrt() * sin, 100.0 * 0.5 * (1.0 - cos)]),
        ] {
            let is_near = (0..2).all(|axis| (raised_m[axis] - by_hand_m[axis]).abs() < 1e-7);
            assert!(is_near, "{raised_m:?} instead of {by_hand_m:?}");
        }
    }
}
