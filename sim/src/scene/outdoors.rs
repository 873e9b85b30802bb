//! A scene under the open sky: place and time, from which the sun's position follows, and the state of the sky.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Open sky over the robot's room and all further rooms in place of ceilings and lamps. Walls and furniture cast shadows in direct sunlight, and the
/// sky lights whatever sees it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Outdoors {
    /// Geographic latitude of the place, positive north of the equator.
    #[schemars(range(min = -90.0, max = 90.0))]
    pub latitude_deg: f64,
    /// Day of the year, 1 on the first of January.
    #[schemars(range(min = 1, max = 366))]
    pub day_of_year: u32,
    /// Solar time of the day, which is 12 when the sun is highest. The sun does not move during a run.
    #[schemars(range(min = 0.0, max = 24.0))]
    pub solar_hour: f64,
    /// Direction of north, counter-clockwise from world x.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub north_deg: f64,
    /// State of the sky.
    pub sky: Sky,
}

/// States of the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sky {
    /// No clouds: direct sunlight with shadows, and a sky of even luminance.
    Clear,
    /// Clouds all over: a sky of even luminance, and no direct sunlight.
    Overcast,
}

impl Default for Outdoors {
    fn default() -> Self {
        Outdoors { latitude_deg: 48.0, day_of_year: 172, solar_hour: 10.0, north_deg: 90.0, sky: Sky::Clear }
    }
}

impl Outdoors {
    /// Unit vector towards the sun, world frame; z is negative while the sun is below the horizon.
    ///
    /// The declination is that of Cooper (The absorption of radiation in solar stills, Solar Energy 12, 1969), 23.45°·sin(360°·(284 + n)/365) on day
    /// n of the year. The hour angle grows by 15° an hour and is 0 at solar noon. With the latitude they give the sun's components towards up, north
    /// and east (Duffie and Beckman, Solar Engineering of Thermal Processes, section 1.6).
    pub fn towards_sun(&self) -> [f64; 3] {
        let declination_rad = 23.45_f64.to_radians() * (TAU * f64::from(284 + self.day_of_year) / 365.0).sin();
        let hour_angle_rad = (15.0 * (self.solar_hour - 12.0)).to_radians();
        let (sin_latitude, cos_latitude) = self.latitude_deg.to_radians().sin_cos();
        let (sin_declination, cos_declination) = declination_rad.sin_cos();
        let (sin_hour, cos_hour) = hour_angle_rad.sin_cos();
        let up = sin_latitude * sin_declination + cos_latitude * cos_declination * cos_hour;
        let north = cos_latitude * sin_declination - sin_latitude * cos_declination * cos_hour;
        let east = -cos_declination * sin_hour;
        let (sin_north, cos_north) = self.north_deg.to_radians().sin_cos();
        // East is a quarter turn to the right of north.
        [north * cos_north + east * sin_north, north * sin_north - east * cos_north, up]
    }

    /// Angle of the sun above the horizon.
    pub fn sun_elevation_deg(&self) -> f64 {
        self.towards_sun()[2].clamp(-1.0, 1.0).asin().to_degrees()
    }

    /// Compass bearing of the sun, clockwise from north, from 0 to 360.
    pub fn sun_azimuth_deg(&self) -> f64 {
        let [x, y, _] = self.towards_sun();
        (self.north_deg - y.atan2(x).to_degrees()).rem_euclid(360.0)
    }

    /// Illuminance by direct sunlight on a plane across it; 0 under clouds.
    ///
    /// The daylight availability model of the Illuminating Engineering Society of North America (IESNA Lighting Handbook, 9th edition, chapter 8):
    /// the solar illumination constant of 128 klx varies with the distance of the sun, and is weakened by exp(−c·m) with c = 0.21 and the optical
    /// air mass m = 1/sin(elevation).
    pub fn direct_normal_lux(&self) -> f64 {
        let sin_elevation = self.towards_sun()[2];
        if self.sky == Sky::Overcast || sin_elevation <= 0.0 {
            return 0.0;
        }
        let day = f64::from(self.day_of_year);
        128_000.0 * (1.0 + 0.034 * (TAU * (day - 2.0) / 365.0).cos()) * (-0.21 / sin_elevation).exp()
    }

    /// Illuminance by the whole sky, without the sun itself, on a level plane in the open.
    ///
    /// By the same model as [`direct_normal_lux`](Self::direct_normal_lux): A + B·sin(elevation)^C, in klx, with A = 0.8, B = 15.5 and C = 0.5 for a
    /// clear sky, and A = 0.3, B = 21 and C = 1 for an overcast one.
    pub fn diffuse_horizontal_lux(&self) -> f64 {
        let sin_elevation = self.towards_sun()[2].max(0.0);
        1000.0
            * match self.sky {
                Sky::Clear => 0.8 + 15.5 * sin_elevation.sqrt(),
                Sky::Overcast => 0.3 + 21.0 * sin_elevation,
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_deg: f64, day_of_year: u32, solar_hour: f64) -> Outdoors {
        Outdoors { latitude_deg, day_of_year, solar_hour, ..Outdoors::default() }
    }

    #[test]
    fn the_sun_is_as_high_at_noon_as_latitude_and_season_say() {
        // Day 81 is Cooper's equinox; on days 172 and 355 the sun is over a tropic, at 23.45°.
        for (latitude_deg, day, elevation_deg, azimuth_deg) in [
            (48.0, 81, 42.0, 180.0),
            (48.0, 172, 65.45, 180.0),
            (48.0, 355, 18.55, 180.0),
            (-35.0, 355, 78.45, 0.0),
            (10.0, 172, 76.55, 0.0),
        ] {
            let noon = at(latitude_deg, day, 12.0);
            assert!((noon.sun_elevation_deg() - elevation_deg).abs() < 0.01, "{latitude_deg} {day}");
            let beside_deg = (noon.sun_azimuth_deg() - azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
            assert!(beside_deg.abs() < 1e-6, "{latitude_deg} {day}");
        }
    }

    #[test]
    fn the_sun_rises_where_the_seasons_have_it() {
        // At the equinox due east, at six. At the summer solstice sunrise is at cos ω = −tan φ·tan δ, towards cos A = sin δ/cos φ.
        let equinox = at(48.0, 81, 6.0);
        assert!(equinox.sun_elevation_deg().abs() < 1e-6 && (equinox.sun_azimuth_deg() - 90.0).abs() < 1e-6);
        let [latitude_rad, tropic_rad] = [48.0_f64, 23.45].map(f64::to_radians);
        let hours = (-latitude_rad.tan() * tropic_rad.tan()).acos().to_degrees() / 15.0;
        let solstice = at(48.0, 172, 12.0 - hours);
        let azimuth_deg = (tropic_rad.sin() / latitude_rad.cos()).acos().to_degrees();
        assert!(solstice.sun_elevation_deg().abs() < 0.01, "{}", solstice.sun_elevation_deg());
        assert!((solstice.sun_azimuth_deg() - azimuth_deg).abs() < 0.01, "{}", solstice.sun_azimuth_deg());
    }

    #[test]
    fn the_worked_example_of_duffie_and_beckman_comes_out() {
        // Example 1.6.2: in Madison, at 43° N, at 9:30 on 13 February the zenith angle is 66.5° and the sun 40° east of south, with a
        // declination rounded to −14°.
        let example = at(43.0, 44, 9.5);
        assert!((90.0 - example.sun_elevation_deg() - 66.5).abs() < 0.1, "{}", example.sun_elevation_deg());
        assert!((example.sun_azimuth_deg() - 140.0).abs() < 0.15, "{}", example.sun_azimuth_deg());
    }

    #[test]
    fn north_may_point_anywhere_on_the_plan() {
        let noon = Outdoors { north_deg: 0.0, ..at(48.0, 81, 12.0) };
        let [x, y, z] = noon.towards_sun();
        // The sun stands in the south, which is against world x.
        assert!((x + 48.0_f64.to_radians().sin()).abs() < 1e-9 && y.abs() < 1e-9 && z > 0.0);
    }

    #[test]
    fn illuminances_are_those_of_the_handbook() {
        // 42° high at the equinox: 128·(1 + 0.034·cos(360°·79/365))·exp(−0.21/0.6691) klx, and 0.8 + 15.5·√0.6691 klx.
        let noon = at(48.0, 81, 12.0);
        assert!((noon.direct_normal_lux() - 94_187.0).abs() < 1.0, "{}", noon.direct_normal_lux());
        assert!((noon.diffuse_horizontal_lux() - 13_479.0).abs() < 5.0, "{}", noon.diffuse_horizontal_lux());
        let clouds = Outdoors { sky: Sky::Overcast, ..noon };
        assert_eq!(clouds.direct_normal_lux(), 0.0);
        assert!((clouds.diffuse_horizontal_lux() - 14_352.0).abs() < 5.0, "{}", clouds.diffuse_horizontal_lux());
    }
}
