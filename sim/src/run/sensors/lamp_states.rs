//! How the lamps are switched in the course of a run.

use std::sync::Arc;

use crate::{
    render::RenderedWorld,
    scene::{Event, Scene},
};

/// State of the lamps from a time on.
#[derive(Clone, Debug, PartialEq)]
pub struct LampState {
    at_s: f64,
    /// Mean illuminance over the floor of the robot's room.
    pub illuminance_at_floor_lux: f64,
    /// Share of their light that the lamps of each name give that events switch, in the order of [`Scene::switched_lamps`].
    pub shares: Vec<f64>,
}

/// The states of the lamps over time: at first all are on, then as the scene's events switch them.
#[derive(Clone, Debug)]
pub struct LampStates(Arc<[LampState]>);

impl LampStates {
    /// The states of the lamps of a scene whose world has all of them on.
    pub fn new(scene: &Scene, world: &RenderedWorld) -> LampStates {
        let all_on_lux = world.illuminance_at_floor_lux().unwrap_or(scene.light.illuminance_at_floor_lux);
        LampStates(states(scene, all_on_lux, |shares| world.floor_share(shares)).into())
    }

    /// The state of the lamps at a time.
    pub fn at(&self, time_s: f64) -> &LampState {
        let latest = self.0.iter().rposition(|state| state.at_s <= time_s);
        &self.0[latest.unwrap_or(0)]
    }
}

/// The states of the lamps in the order of time; the first one holds from the start. With all lamps on they give `all_on_lux`, until an event says
/// otherwise, and with some of them `floor_share` of it.
fn states(scene: &Scene, mut all_on_lux: f64, floor_share: impl Fn(&[f64]) -> f64) -> Vec<LampState> {
    let names = scene.switched_lamps();
    let mut shares = vec![1.0; names.len()];
    let mut states =
        vec![LampState { at_s: f64::NEG_INFINITY, illuminance_at_floor_lux: all_on_lux, shares: shares.clone() }];
    let mut events: Vec<&Event> = scene.events.iter().collect();
    events.sort_by(|one, other| one.at_s().total_cmp(&other.at_s()));
    for event in events {
        match event {
            Event::Light { illuminance_at_floor_lux, .. } => all_on_lux = *illuminance_at_floor_lux,
            Event::Lamp { lamp, share, .. } => {
                let switched = names.iter().zip(&mut shares).filter(|(name, _)| *name == lamp);
                switched.for_each(|(_, now)| *now = *share);
            }
            _ => continue,
        }
        let illuminance_at_floor_lux = all_on_lux * floor_share(&shares);
        states.push(LampState { at_s: event.at_s(), illuminance_at_floor_lux, shares: shares.clone() });
    }
    states
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn switched_lamps_keep_their_shares_when_all_are_dimmed_and_the_other_way_round() {
        let lamp = |name: &str| format!("[[lamp]]\nkind = \"panel\"\nname = \"{name}\"\nx_m = 1\ny_m = 1\n");
        let off = |at_s: f64, share: f64| {
            format!("[[event]]\nkind = \"lamp\"\nat_s = {at_s}\nlamp = \"desk\"\nshare = {share}\n")
        };
        let dim = "[[event]]\nkind = \"light\"\nat_s = 4.0\nilluminance_at_floor_lux = 20\n";
        let text = format!(
            "duration_s = 10\n[room]\nwidth_m = 3\ndepth_m = 3\n[start]\nx_m = 1\ny_m = 1\n[[route.waypoint]]\nx_m = 1.1\n\
             y_m = 1\n{}{}{}{dim}{}",
            lamp("desk"),
            lamp("wall"),
            off(6.0, 1.0),
            off(2.0, 0.5)
        );
        let scene = Scene::parse(&text, "lamps.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        assert_eq!(scene.switched_lamps(), ["desk"]);
        // The lamp on the desk gives two fifths of the light at the floor.
        let states = LampStates(states(&scene, 100.0, |shares| 0.6 + 0.4 * shares[0]).into());
        let lux = |time_s: f64| states.at(time_s).illuminance_at_floor_lux;
        assert_eq!([0.0, 2.0, 4.5, 6.0, 9.0].map(lux), [100.0, 80.0, 16.0, 20.0, 20.0]);
        assert_eq!([1.9, 2.0, 5.9, 6.0].map(|time_s| states.at(time_s).shares[0]), [1.0, 0.5, 0.5, 1.0]);
    }
}
