//! The scene's events as they came about in a run: when, what, and where the robot truly was.

use serde::Serialize;

use crate::{
    run::RunRecord,
    scene::{Event, Scene, Side, Stuck},
};

/// One of the scene's events in a run.
#[derive(Clone, Debug, Serialize)]
pub struct Occurrence {
    /// Time at which the event began.
    pub from_s: f64,
    /// Time at which it ended; for a switch of lamps and a change of friction the time at which it began.
    pub to_s: f64,
    /// What happened, in words.
    pub what: String,
    /// True position of the robot as the event began, along world x.
    pub x_m: f64,
    /// True position of the robot as the event began, along world y.
    pub y_m: f64,
}

/// The events that began before the end of a run, in the order of time. Where the robot is put at stations, every event happens at each of them.
pub(super) fn occurrences(scene: &Scene, record: &RunRecord) -> Vec<Occurrence> {
    let mut found = Vec::new();
    for drive in record.drives() {
        let began_s = drive.first().map_or(0.0, |truth| truth.time_s);
        for event in &scene.events {
            let from_s = began_s + event.at_s();
            // The last step before the event; the first one for an event at the very start.
            let step = drive.partition_point(|truth| truth.time_s <= from_s).saturating_sub(1);
            let Some(truth) = drive.get(step).filter(|_| drive.last().is_some_and(|last| from_s <= last.time_s)) else {
                continue;
            };
            let (x_m, y_m) = (truth.pose.x_m, truth.pose.y_m);
            found.push(Occurrence { from_s, to_s: from_s + event.lasts_s(), what: what(event), x_m, y_m });
        }
    }
    found.sort_by(|one, other| one.from_s.total_cmp(&other.from_s));
    found
}

fn what(event: &Event) -> String {
    match event {
        Event::Push { displacement_m, .. } => format!("pushed {}", displaced(*displacement_m)),
        Event::Light { illuminance_at_floor_lux, .. } => {
            format!("lamps switched to {illuminance_at_floor_lux} lx at the floor")
        }
        Event::Lamp { lamp, share, .. } => switched(lamp, *share),
        Event::Friction { region, friction, .. } => match region {
            Some(region) => format!("friction on {region} changes to {friction}"),
            None => format!("friction outside all regions changes to {friction}"),
        },
        Event::Lift { displacement_m, turn_deg, .. } => {
            format!("lifted, put down {} and turned by {turn_deg}°", displaced(*displacement_m))
        }
        Event::StuckWheel { wheel, how, .. } => {
            let wheel = if *wheel == Side::Left { "left" } else { "right" };
            let how = if *how == Stuck::Blocked { "is held fast" } else { "spins without grip" };
            format!("{wheel} wheel {how}")
        }
        Event::FlowBlind { .. } => "flow sensor loses the floor".to_owned(),
    }
}

/// A switch of the lamps of one name.
fn switched(lamp: &str, share: f64) -> String {
    match share {
        0.0 => format!("lamp {lamp} switched off"),
        1.0 => format!("lamp {lamp} switched on"),
        share => format!("lamp {lamp} dimmed to {} %", (share * 1e4).round() / 1e2),
    }
}

/// A displacement, forward and left in the robot frame.
fn displaced([forward_m, left_m]: [f64; 2]) -> String {
    let along = if forward_m < 0.0 { "back" } else { "forward" };
    let across = if left_m < 0.0 { "right" } else { "left" };
    match (forward_m.abs(), left_m.abs()) {
        (0.0, 0.0) => "in place".to_owned(),
        (forward_m, 0.0) => format!("{forward_m} m {along}"),
        (0.0, left_m) => format!("{left_m} m to the {across}"),
        (forward_m, left_m) => format!("{forward_m} m {along} and {left_m} m to the {across}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_told_with_their_units_and_sides() {
        let push = Event::Push { at_s: 0.0, displacement_m: [-0.2, 0.1], lasts_s: 1.0 };
        assert_eq!(what(&push), "pushed 0.2 m back and 0.1 m to the left");
        let lift = Event::Lift { at_s: 0.0, displacement_m: [0.0, 0.0], turn_deg: -90.0, lasts_s: 1.0 };
        assert_eq!(what(&lift), "lifted, put down in place and turned by -90°");
        let stuck = Event::StuckWheel { at_s: 0.0, wheel: Side::Right, how: Stuck::Spinning, lasts_s: 1.0 };
        assert_eq!(what(&stuck), "right wheel spins without grip");
        let lamp = |share| Event::Lamp { at_s: 0.0, lamp: "desk".to_owned(), share };
        assert_eq!(
            [0.0, 1.0, 0.335].map(|share| what(&lamp(share))),
            ["lamp desk switched off", "lamp desk switched on", "lamp desk dimmed to 33.5 %"]
        );
        assert_eq!(what(&Event::FlowBlind { at_s: 0.0, lasts_s: 1.0 }), "flow sensor loses the floor");
    }
}
