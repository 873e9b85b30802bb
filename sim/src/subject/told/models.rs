//! The models that a scene gives the localizer: nominal values with their declared bounds, never a value drawn at random.

use interval::Interval;
use localizer::{
    Map, Pose, PoseBox, RobotModel,
    map::{TileGrid, WallMap},
    robot::{BodyModel, Reach},
};

use crate::{
    base::wheel_model,
    devices::first_arrivals_s,
    place::building::{Enclosure, enclosures},
    scene::{CeilingCamera, FloorCamera, Flow, ForwardCamera, Gyro, RangeCamera, Scene, Start, Station, Tiles},
};

/// Upper bound on how far the contact with a wall gives way in the physics: less than a millimetre.
const GIVES_WAY_M: f64 = 0.001;

impl Scene {
    /// The map of the building, as surveyed.
    pub fn map(&self) -> Map {
        let room_m = self.room_hull_m();
        Map {
            room_m,
            tiles: self.floor.tiles.as_ref().map(|tiles| tile_grid(tiles, self)),
            markers: self.markers.as_ref().map(|markers| markers.map(self)),
            wall_directions_rad: self.wall_directions_rad(),
            walls: Some(WallMap {
                walls: self.mapped_walls(),
                placement_m: self.localizer.wall_ranges().placement_tolerance_m,
            }),
        }
    }

    /// The robot model that the localizer is given: nominal dimensions and declared bounds.
    pub fn robot_model(&self) -> RobotModel {
        let (robot, bounds) = (&self.robot, &self.bounds);
        let mut model = RobotModel {
            wheels: wheel_model(robot, bounds),
            reach: Reach {
                speed_m_per_s: bounds.reach_speed_m_per_s,
                turn_rate_rad_per_s: bounds.reach_turn_rate_rad_per_s,
                acceleration_m_per_s2: bounds.reach_acceleration_m_per_s2,
            },
            body: BodyModel {
                tilt_rad: bounds.body_tilt_deg.to_radians(),
                heave_m: bounds.body_heave_m,
                clearance_m: robot.body_radius_m - GIVES_WAY_M,
            },
            floor_camera: robot.floor_camera.as_ref().map(FloorCamera::model),
            forward_camera: robot.forward_camera.as_ref().map(ForwardCamera::model),
            gyro: robot.gyro.as_ref().map(Gyro::model),
            flow: robot.flow.as_ref().map(Flow::model),
            ceiling_camera: robot.ceiling_camera.as_ref().map(CeilingCamera::model),
            range_camera: robot.range_camera.as_ref().map(RangeCamera::model),
            steering: robot.steering_encoder.as_ref().map(|encoder| encoder.model(&robot.base)),
        };
        // The localizer uses the clock of the base. Stamps of cameras may differ from it by the base clock's own error in addition to theirs.
        let base_s = robot.delivery.stamp_tolerance_s;
        model.floor_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model.forward_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model.ceiling_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model.range_camera.iter_mut().for_each(|camera| camera.stamp_error_s += base_s);
        model
    }

    /// Intervals of x and y that hold all rooms, however their walls stand within their tolerance.
    pub(crate) fn room_hull_m(&self) -> [Interval; 2] {
        let most_deg = self.most_walls_turn_deg();
        let rooms = enclosures(self);
        if rooms.len() > 1 {
            return hull_of_turned(&rooms, self.plan().size_m.map(|extent_m| 0.5 * extent_m), most_deg.to_radians());
        }
        let (plan, beyond_m) = (self.plan(), self.plan().beyond_m(most_deg.to_radians()));
        [0, 1].map(|axis| Interval::new(-beyond_m[axis], plan.size_m[axis] + beyond_m[axis]))
    }

    /// Greatest distance along x and along y between two possible positions of the robot's origin: the room's size less the strips along the walls
    /// that the robot's body keeps the origin out of.
    pub(crate) fn left_to_origin_m(&self) -> [f64; 2] {
        let keep_m = self.robot.body_radius_m - GIVES_WAY_M;
        self.room_hull_m().map(|range| range.width() - 2.0 * keep_m)
    }

    fn wall_directions_rad(&self) -> Vec<Interval> {
        let setup = self.localizer.wall_directions();
        let tolerance_rad = setup.tolerance_deg.to_radians() + setup.askew_deg.to_radians();
        let directions_deg = self.mapped_wall_directions_deg();
        directions_deg.iter().map(|deg| Interval::centred(deg.to_radians(), tolerance_rad)).collect()
    }

    /// The start pose as the scene states it, without the error that is drawn at random.
    pub fn nominal_start(&self) -> Pose {
        Pose { x_m: self.start.x_m, y_m: self.start.y_m, heading_rad: self.start.heading_deg.to_radians() }
    }

    /// The scene with the robot placed at a station. It lasts until the first image of every camera, the first range reading and the first position
    /// of satellite navigation have arrived.
    pub fn at_station(&self, station: &Station) -> Scene {
        let arrival_s = first_arrivals_s(&self.robot);
        let start = Start {
            x_m: station.x_m,
            y_m: station.y_m,
            heading_deg: station.heading_deg,
            tolerance_m: station.tolerance_m.unwrap_or(self.start.tolerance_m),
            tolerance_deg: station.tolerance_deg.unwrap_or(self.start.tolerance_deg),
            anywhere: false,
        };
        // The run lasts one step longer than the first readings take to arrive, so that the estimate after their arrival counts as well.
        let duration_s = ((arrival_s / 0.01).ceil() + 1.0) * 0.01;
        Scene { start, duration_s, stations: Vec::new(), ..self.clone() }
    }

    /// Simulated duration of a run: that of its drive, or of all stations together at which the robot is put.
    pub fn simulated_s(&self) -> f64 {
        if self.stations.is_empty() {
            return self.duration_s;
        }
        self.stations.iter().map(|station| self.at_station(station).duration_s + 0.01).sum()
    }

    /// The box that the localizer is given for the start of the robot.
    pub fn start_box(&self) -> PoseBox {
        let start = self.nominal_start();
        // The base's clock may show 0 up to a time ε after the start. A robot that accelerates from rest meanwhile, at most by a, gets a·ε²/2 far.
        let late_s = self.robot.delivery.stamp_tolerance_s;
        let left_m = 0.5 * self.bounds.reach_acceleration_m_per_s2 * late_s * late_s;
        let turned_rad = 2.0 * left_m / (self.robot.base.track_m * (1.0 - self.robot.base.track_tolerance));
        if self.start.anywhere {
            let [x_m, y_m] = self.room_hull_m().map(|range_m| range_m.inflate(left_m));
            return PoseBox::from([x_m, y_m, Interval::centred(start.heading_rad, std::f64::consts::PI)]);
        }
        PoseBox::from([
            Interval::centred(start.x_m, self.start.tolerance_m + left_m),
            Interval::centred(start.y_m, self.start.tolerance_m + left_m),
            Interval::centred(start.heading_rad, self.start.tolerance_deg.to_radians() + turned_rad),
        ])
    }
}

/// Intervals of x and y that hold all corners of rooms, however they are turned together about a point by up to `most_rad` either way.
fn hull_of_turned(rooms: &[Enclosure], about_m: [f64; 2], most_rad: f64) -> [Interval; 2] {
    let turn = Interval::new(-most_rad, most_rad);
    let (sin, cos) = (turn.sin(), turn.cos());
    let [mut x, mut y] = [Interval::EMPTY; 2];
    for side in rooms.iter().flat_map(Enclosure::sides) {
        let [along_x, along_y] = [side.from.x - about_m[0], side.from.y - about_m[1]].map(Interval::point);
        x = x.hull(cos * along_x - sin * along_y + Interval::point(about_m[0]));
        y = y.hull(sin * along_x + cos * along_y + Interval::point(about_m[1]));
    }
    [x, y]
}

fn tile_grid(tiles: &Tiles, scene: &Scene) -> TileGrid {
    let shortest_m = scene.room.width_m.min(scene.room.depth_m);
    TileGrid {
        edge_m: [tiles.edge_x_m, tiles.edge_y_m],
        rotation_rad: tiles.rotation_deg.to_radians(),
        phase_m: [tiles.phase_x_m, tiles.phase_y_m],
        joint_width_m: tiles.joint_width_m,
        laying_m: tiles.laying_tolerance_m,
        // A joint whose two ends are both within the tolerance is turned by at most their difference over the room's shorter side.
        laying_angle_rad: 2.0 * tiles.laying_tolerance_m / shortest_m,
        straightness_m: tiles.corner_tolerance_m,
    }
}
