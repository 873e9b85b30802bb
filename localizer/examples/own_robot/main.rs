//! Where was a robot of one's own? Boxes from its log of odometry and of ranges to beacons: `cargo run --example own_robot log.csv`.
use interval::{Interval, contractor::ForwardBackward};
use localizer::robot::{ErrorLaw, Reach, WheelModel};
use localizer::{Constraint, Localizer, Map, Method, PoseBox, Reading, RobotModel, method::Context};

#[cfg(test)]
mod tests;

/// Reads ranges to beacons, which are numbers x, y and range, each range with an error of up to 5 cm.
struct Beacons;

impl Method for Beacons {
    fn name(&self) -> &'static str {
        "beacons"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Other { device, .. } if device == "beacon")
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let &[a_m, b_m, range_m] = &numbers[..] else { return None };
        let on_pose = ForwardBackward::new(|[x, y, _]| (x - a_m).hypot(y - b_m), Interval::centred(range_m, 0.05));
        Some(Constraint { relies_on: vec!["beacon.range"], ..Constraint::new(self.name(), *measured_s, on_pose) })
    }
}

/// A robot in a room of 8 m × 6 m, which starts within 20 cm of (1, 1) and within 0.2 rad of the heading 0.3 rad.
fn own_robot() -> Localizer {
    let along = ErrorLaw { floor_m: 0.002, share: 0.02, m_per_s: 0.0005 };
    let aside = ErrorLaw { floor_m: 0.002, share: 0.01, m_per_s: 0.0 };
    let wheels = WheelModel::of_odometry(Interval::centred(0.4, 0.001), along, aside);
    let reach = Reach { speed_m_per_s: 0.5, turn_rate_rad_per_s: 1.0, acceleration_m_per_s2: 1.0 };
    let room = [Interval::new(0.0, 8.0), Interval::new(0.0, 6.0)];
    let start = [(1.0, 0.2), (1.0, 0.2), (0.3, 0.2)].map(|(middle, within)| Interval::centred(middle, within));
    let (map, robot) = (Map::of_room(room), RobotModel::new(wheels, reach));
    Localizer::new(map, robot, vec![Box::new(Beacons)], PoseBox::from(start))
}

/// A line of the log: time, device, numbers.
fn reading(line: &str) -> Option<Reading> {
    let (time, (device, rest)) = line.split_once(',').and_then(|(time, rest)| Some((time, rest.split_once(',')?)))?;
    let (at_s, numbers) = (time.parse().ok()?, rest.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>().ok()?);
    match (device, &numbers[..]) {
        ("odometry", &[left_m, right_m]) => Reading::odometry(at_s, at_s, [left_m, right_m]),
        _ => Some(Reading::Other { measured_s: at_s, arrived_s: at_s, device: device.to_owned(), numbers }),
    }
}

fn main() -> std::io::Result<()> {
    let log = std::fs::read_to_string(std::env::args().nth(1).unwrap_or_default())?;
    let mut localizer = own_robot();
    for line in log.lines() {
        let dropped = reading(line).map(|reading| localizer.observe(&reading).dropped);
        let [x_m, y_m, heading_rad] = localizer.estimate().pose.hull().components();
        println!("{line}: x {x_m:.2}, y {y_m:.2}, heading {heading_rad:.2} {dropped:?}");
    }
    Ok(())
}
