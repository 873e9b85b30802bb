//! People who walk to and fro and stand still while the robot is in their way.

use crate::{
    place::{
        Bystander,
        building::{STRIDE_M, UprightBody},
    },
    scene::{Person, Scene},
};

/// Gap below which a person stands still: the distance to the robot's edge from the path that the person would walk in the next second.
const KEEPS_AWAY_M: f64 = 0.4;

impl From<Bystander> for UprightBody {
    fn from(person: Bystander) -> UprightBody {
        UprightBody {
            middle_m: person.place_m,
            heading_rad: person.heading_rad,
            height_m: person.height_m,
            radius_m: person.radius_m,
            stride: (person.walked_m / STRIDE_M).fract(),
            velocity_m_per_s: person.velocity_m_per_s,
        }
    }
}

/// A person who walks to and fro.
#[derive(Clone, Debug)]
pub(super) struct Walker {
    waypoints_m: Vec<[f64; 2]>,
    speed_m_per_s: f64,
    robot_radius_m: f64,
    /// Index of the waypoint that the person walks to, and whether the person goes through the list of waypoints forwards.
    towards: (usize, bool),
    body: Bystander,
}

impl Walker {
    /// All people of a scene, each at the first waypoint.
    pub(super) fn all(scene: &Scene) -> Vec<Walker> {
        scene.people.iter().filter_map(|person| Walker::new(person, scene.robot.body_radius_m)).collect()
    }

    fn new(person: &Person, robot_radius_m: f64) -> Option<Walker> {
        let start = UprightBody::at_start(person)?;
        let body = Bystander {
            place_m: start.middle_m,
            radius_m: start.radius_m,
            height_m: start.height_m,
            heading_rad: start.heading_rad,
            walked_m: 0.0,
            velocity_m_per_s: [0.0; 2],
        };
        Some(Walker {
            waypoints_m: person.waypoints_m.clone(),
            speed_m_per_s: person.speed_m_per_s,
            robot_radius_m,
            towards: (0, true),
            body,
        })
    }

    /// The person's body at the present time.
    pub(super) fn body(&self) -> Bystander {
        self.body
    }

    /// Moves the person by one step, unless the robot is in the way.
    pub(super) fn advance(&mut self, robot_m: [f64; 2], step_s: f64) {
        self.body.velocity_m_per_s = [0.0; 2];
        let Some(&goal_m) = self.waypoints_m.get(self.towards.0) else { return };
        let [x_m, y_m] = self.body.place_m;
        let way = [goal_m[0] - x_m, goal_m[1] - y_m];
        let left_m = way[0].hypot(way[1]);
        let step_m = self.speed_m_per_s * step_s;
        if left_m <= step_m {
            self.turn_to_next();
            return;
        }
        let along = [way[0] / left_m, way[1] / left_m];
        let ahead_m = [x_m + along[0] * self.speed_m_per_s, y_m + along[1] * self.speed_m_per_s];
        let gap_m = distance_to_segment(robot_m, [x_m, y_m], ahead_m) - self.robot_radius_m - self.body.radius_m;
        let leaves = (robot_m[0] - x_m) * along[0] + (robot_m[1] - y_m) * along[1] < 0.0;
        if gap_m > KEEPS_AWAY_M || leaves {
            self.body.place_m = [x_m + along[0] * step_m, y_m + along[1] * step_m];
            self.body.heading_rad = along[1].atan2(along[0]);
            self.body.walked_m += step_m;
            self.body.velocity_m_per_s = along.map(|share| share * self.speed_m_per_s);
        }
    }

    fn turn_to_next(&mut self) {
        let (index, forth) = self.towards;
        let last = self.waypoints_m.len() - 1;
        self.towards = match (forth, index) {
            (true, index) if index < last => (index + 1, true),
            (true, index) => (index.saturating_sub(1), false),
            (false, 0) => (last.min(1), true),
            (false, index) => (index - 1, false),
        };
    }
}

fn distance_to_segment(place: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let (along, way) = ([to[0] - from[0], to[1] - from[1]], [place[0] - from[0], place[1] - from[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((way[0] * along[0] + way[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (way[0] - share * along[0]).hypot(way[1] - share * along[1])
}
