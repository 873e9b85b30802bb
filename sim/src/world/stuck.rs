//! Wheels that are blocked, or spin without hold on the floor, for a while.

use crate::scene::{Event, Scene, Side, Stuck};

/// The scene's events that say when which wheel is stuck.
#[derive(Clone, Debug)]
pub(super) struct StuckWheels(Vec<Event>);

impl StuckWheels {
    /// Takes the events for stuck wheels from the scene.
    pub(super) fn new(scene: &Scene) -> Self {
        let is_stuck = |event: &&Event| matches!(event, Event::StuckWheel { .. });
        StuckWheels(scene.events.iter().filter(is_stuck).cloned().collect())
    }

    /// How the left (0) or right (1) wheel is stuck at a time; `None` if it is free.
    pub(super) fn at(&self, wheel_idx: usize, time_s: f64) -> Option<Stuck> {
        self.0.iter().filter(|event| event.is_on(time_s)).find_map(|event| match event {
            Event::StuckWheel { wheel, how, .. } if (*wheel == Side::Left) == (wheel_idx == 0) => Some(*how),
            _ => None,
        })
    }
}
