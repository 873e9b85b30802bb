//! Light that the surfaces of a building reflect, computed by radiosity (Goral and others 1984): each reflector gives off the light that falls on it
//! times its albedo, and light falls on it from lamps and from all reflectors that it sees.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::{
    Illuminance,
    occlusion::{Between, Occluders},
    parallel::in_parallel,
    reflector::{Reflector, reflectors},
};
use crate::place::building::Building;

/// Change of the exitances, relative to the greatest of them, at which they count as found.
const SETTLED: f64 = 1e-5;
/// Greatest number of sweeps over all reflectors; each takes off at least the light that is absorbed at one reflection.
const MAX_SWEEPS: usize = 200;

/// All surfaces of a building that reflect light, and what stands between them.
pub(super) struct Reflecting<'a> {
    /// The reflectors, face by face.
    pub(super) all: Vec<Reflector>,
    faces: Vec<Face>,
    occluders: &'a Occluders,
}

/// The reflectors of one flat face.
struct Face {
    corners: [Point3<f64>; 4],
    normal: Vector3<f64>,
    reflectors: Range<usize>,
}

impl Reflecting<'_> {
    /// Cuts the surfaces of a building into reflectors.
    pub(super) fn new<'a>(building: &Building, occluders: &'a Occluders) -> Reflecting<'a> {
        let all = reflectors(building, occluders);
        let mut faces: Vec<Face> = Vec::new();
        let mut first = 0;
        for of_face in all.chunk_by(|one, next| one.panel == next.panel) {
            let panel = &building.panels[of_face[0].panel];
            let end = first + of_face.len();
            faces.push(Face { corners: panel.corners(), normal: panel.normal(), reflectors: first..end });
            first = end;
        }
        Reflecting { all, faces, occluders }
    }

    /// Calls `visit` for each reflector of which something may be seen from a point, with what may stand in between and the reflector's number. Only
    /// reflectors are visited that lie before at least one of the surfaces with the given normals.
    pub(super) fn each_before<const N: usize>(
        &self,
        at: Point3<f64>,
        normals: &[Vector3<f64>; N],
        mut visit: impl FnMut(usize, &Between),
    ) {
        let mut between = Between::default();
        for face in &self.faces {
            let lies_before =
                |normal: &Vector3<f64>| face.corners.iter().any(|corner| normal.dot(&(corner - at)) > 0.0);
            if face.normal.dot(&(at - face.corners[0])) <= 0.0 || !normals.iter().any(lies_before) {
                continue;
            }
            self.occluders.towards(at, &face.corners, &mut between);
            face.reflectors.clone().for_each(|index| visit(index, &between));
        }
    }

    /// The exitance of each reflector, given the view factors and the light that falls on it from lamps: B = ρ·(E + F·B), solved by the method of
    /// Gauss and Seidel.
    pub(super) fn exitances(&self, factors: &[Vec<(u32, f32)>], direct: &[Illuminance]) -> Vec<Illuminance> {
        let mut exitances = vec![[0.0_f64; 3]; self.all.len()];
        for _ in 0..MAX_SWEEPS {
            let (mut change, mut greatest) = (0.0_f64, 0.0_f64);
            for (index, (reflector, direct)) in self.all.iter().zip(direct).enumerate() {
                let mut sum = [direct.lux, direct.by_band[0], direct.by_band[1]];
                for (other, factor) in &factors[index] {
                    let (factor, exitance) = (f64::from(*factor), exitances[*other as usize]);
                    sum = [0, 1, 2].map(|band| sum[band] + factor * exitance[band]);
                }
                let [visible, infrared] = reflector.albedo;
                let new = [sum[0] * visible, sum[1] * visible, sum[2] * infrared];
                for (new, old) in new.iter().zip(&exitances[index]) {
                    change = change.max((new - old).abs());
                    greatest = greatest.max(*new);
                }
                exitances[index] = new;
            }
            if change <= SETTLED * greatest {
                break;
            }
        }
        exitances
            .into_iter()
            .map(|[lux, visible, infrared]| Illuminance { lux, by_band: [visible, infrared] })
            .collect()
    }

    /// View factors from each reflector to those that it sees, with their numbers.
    ///
    /// What two reflectors give each other is the same from either side (reciprocity): A·F from one to the other. It is found from both and averaged,
    /// so that reflections neither make light nor lose it.
    pub(super) fn view_factors(&self) -> Vec<Vec<(u32, f32)>> {
        let numbers: Vec<usize> = (0..self.all.len()).collect();
        let one_sided = in_parallel(&numbers, |own| self.view_factors_of(*own));
        in_parallel(&numbers, |&own| {
            let own_m2 = self.all[own].open_m2;
            let averaged = |&(other, factor): &(u32, f32)| {
                let (there, area) = (&one_sided[other as usize], self.all[other as usize].open_m2 / own_m2);
                let back = there.binary_search_by_key(&(own as u32), |(number, _)| *number).map(|place| there[place].1);
                let factor = back.map_or(factor, |back| 0.5 * (factor + back * area as f32));
                (factor > 0.0).then_some((other, factor))
            };
            one_sided[own].iter().filter_map(averaged).collect()
        })
    }

    /// View factors from one reflector to all that lie before it, hidden ones included: as seen from its middle, or the mean over several of its
    /// points if the other one is near.
    fn view_factors_of(&self, number: usize) -> Vec<(u32, f32)> {
        let (own, mut row) = (&self.all[number], Vec::new());
        self.each_before(own.eye, &[own.normal], |index, between| {
            let other = &self.all[index];
            let from = |(salt, at): (usize, Point3<f64>)| {
                other.factors(at, &[own.normal], between, salt).map(|[factor]| factor)
            };
            let factor = if other.is_near(own) {
                let factors = own.spread().into_iter().enumerate().filter_map(|(salt, at)| from((salt + number, at)));
                factors.reduce(|sum, factor| sum + factor).map(|sum| 0.25 * sum)
            } else {
                // Neighbours ask for different points of the reflector that they look at, and so does one of its neighbours.
                from((5 * number + index, own.eye))
            };
            row.extend(factor.map(|factor| (index as u32, factor as f32)));
        });
        row
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crate::{
        place::{building::Part, drawn::DrawnPlace},
        scene::Scene,
    };

    use super::*;

    fn room(size_m: [f64; 3]) -> Building {
        let [width_m, depth_m, height_m] = size_m;
        let text = format!(
            "[room]\nwidth_m = {width_m:?}\ndepth_m = {depth_m:?}\n[building]\nceiling_height_m = {height_m:?}\n\
             [start]\nx_m = 0.5\ny_m = 0.5\n[[route.waypoint]]\nx_m = 0.6\ny_m = 0.5\n"
        );
        let scene = Scene::parse(&text, "room.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        Building::new(&scene, &DrawnPlace::draw(&scene, 0))
    }

    /// Mean view factors between floor, walls and ceiling of a building; row i holds those from surface i.
    fn between_parts(building: &Building) -> [[f64; 3]; 3] {
        let occluders = Occluders::new(building);
        let reflecting = Reflecting::new(building, &occluders);
        // There are no things in the room.
        let part = |reflector: &Reflector| match building.panels[reflector.panel].part {
            Part::Floor => 0,
            Part::Wall => 1,
            Part::Ceiling | Part::Thing => 2,
        };
        let (mut sums, mut areas_m2) = ([[0.0; 3]; 3], [0.0; 3]);
        for (own, row) in reflecting.all.iter().zip(reflecting.view_factors()) {
            areas_m2[part(own)] += own.open_m2;
            for (other, factor) in row {
                sums[part(own)][part(&reflecting.all[other as usize])] += f64::from(factor) * own.open_m2;
            }
        }
        [0, 1, 2].map(|from| sums[from].map(|sum| sum / areas_m2[from]))
    }

    /// View factor between two equal rectangles straight above each other; `x` and `y` are their sides over their distance (Howell, A Catalog of
    /// Radiation Heat Transfer Configuration Factors, C-11).
    fn of_opposite_rectangles(x: f64, y: f64) -> f64 {
        let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
        let logarithm = 0.5 * (x2 * y2 / (1.0 + x * x + y * y)).ln();
        let sides = x * y2.sqrt() * (x / y2.sqrt()).atan() + y * x2.sqrt() * (y / x2.sqrt()).atan();
        2.0 / (PI * x * y) * (logarithm + sides - x * x.atan() - y * y.atan())
    }

    #[test]
    fn what_two_reflectors_give_each_other_is_the_same_from_either_side() {
        let text = "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[start]\nx_m = 0.5\ny_m = 0.5\n[[route.waypoint]]\nx_m = 0.6\n\
                    y_m = 0.5\n[[building.room]]\nx_m = 4.1\ny_m = 0.0\nwidth_m = 3.0\ndepth_m = 3.0\n\
                    [[building.door]]\nfrom_m = [4.0, 1.0]\nto_m = [4.0, 2.0]\nopen = true\n[[furniture]]\n\
                    name = \"table\"\nx_m = 1.2\ny_m = 1.9\nsize_m = [0.8, 1.2]\nheight_m = 0.7\nrotation_deg = 20\n";
        let scene = Scene::parse(text, "rooms.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        let building = Building::new(&scene, &DrawnPlace::draw(&scene, 0));
        let occluders = Occluders::new(&building);
        let reflecting = Reflecting::new(&building, &occluders);
        let rows = reflecting.view_factors();
        let (mut n_pairs, mut n_one_sided) = (0, 0);
        for (own, row) in rows.iter().enumerate() {
            for (other, factor) in row {
                let (one, two) = (&reflecting.all[own], &reflecting.all[*other as usize]);
                let back = rows[*other as usize].iter().find(|(number, _)| *number as usize == own);
                let Some((_, back)) = back else {
                    n_one_sided += 1;
                    continue;
                };
                let exchange_m2 = [f64::from(*factor) * one.open_m2, f64::from(*back) * two.open_m2];
                assert!((exchange_m2[0] / exchange_m2[1] - 1.0).abs() < 1e-4, "{exchange_m2:?}");
                n_pairs += 1;
            }
        }
        // The planes of faces that stand askew cut through reflectors, of which the one may then lie before the other's middle and not the other way.
        assert!(n_pairs > 50_000 && 100 * n_one_sided < n_pairs, "{n_pairs} pairs, {n_one_sided} from one side");
    }

    #[test]
    fn floor_and_ceiling_of_every_one_of_six_rooms_reflect() {
        let mut text =
            "[room]\nwidth_m = 2.0\ndepth_m = 2.0\n[start]\nx_m = 0.5\ny_m = 0.5\n[[route.waypoint]]\nx_m = 0.6\n\
                        y_m = 0.5\n"
                .to_owned();
        for room in 1..6 {
            text += &format!(
                "[[building.room]]\nx_m = {:?}\ny_m = 0.0\nwidth_m = 2.0\ndepth_m = 2.0\n",
                2.1 * f64::from(room)
            );
        }
        let scene = Scene::parse(&text, "rooms.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        let building = Building::new(&scene, &DrawnPlace::draw(&scene, 0));
        let occluders = Occluders::new(&building);
        let reflecting = Reflecting::new(&building, &occluders);
        for room in 0..6 {
            for part in [Part::Floor, Part::Ceiling] {
                let is_of_it = |one: &&Reflector| {
                    let panel = &building.panels[one.panel];
                    panel.room == room && panel.part == part
                };
                let open_m2: f64 = reflecting.all.iter().filter(is_of_it).map(|one| one.open_m2).sum();
                assert!((open_m2 - 4.0).abs() < 1e-9, "{part:?} of room {room}: {open_m2} m²");
            }
        }
    }

    #[test]
    fn view_factors_are_the_published_ones_within_one_percent() {
        // Howell's catalog, C-11, gives 0.1998 for the view factor between opposite faces of a unit cube.
        assert!((of_opposite_rectangles(1.0, 1.0) - 0.19982).abs() < 1e-4);
        for size_m in [[2.5, 2.5, 2.5], [4.0, 3.0, 2.5], [12.0, 3.0, 2.5], [30.0, 20.0, 4.0]] {
            let building = room(size_m);
            let factors = between_parts(&building);
            let [width_m, depth_m, height_m] = size_m;
            let opposite = of_opposite_rectangles(width_m / height_m, depth_m / height_m);
            let walls_m2 = 2.0 * (width_m + depth_m) * height_m;
            let from_walls = (1.0 - opposite) * width_m * depth_m / walls_m2;
            let expected = [
                [0.0, 1.0 - opposite, opposite],
                [from_walls, 1.0 - 2.0 * from_walls, from_walls],
                [opposite, 1.0 - opposite, 0.0],
            ];
            for (factor, expected) in factors.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((factor - expected).abs() < 0.01 * expected.max(0.2), "{size_m:?}: {factors:?}");
            }
        }
    }
}
