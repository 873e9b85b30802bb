//! The receiver of satellite navigation.

mod sensor;

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::gnss_positions::{GnssPositions, ReceiverModel},
};

use crate::{
    scene::{Distribution, Gnss, MethodName, Scene},
    truth::randomness::{draw_within, stream},
};

use super::{Device, Sensor, ToldKey, farthest};

pub use sensor::GnssSensor;

/// True position of the satellite navigation antenna on the robot.
#[derive(Clone, Copy, Debug)]
pub struct DrawnGnss {
    /// Position of the satellite navigation antenna in the robot frame: forward and left.
    pub position_m: [f64; 2],
}

impl Device for Gnss {
    type Drawn = DrawnGnss;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnGnss {
        let mut rng = stream(seed, "gnss.mount");
        let around = |nominal_m: f64| nominal_m + draw_within(self.position_tolerance_m, errors, &mut rng);
        DrawnGnss { position_m: [self.forward_m, self.left_m].map(around) }
    }

    fn sensor(&self, drawn: &DrawnGnss, scene: &Scene, seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(GnssSensor::new(self, drawn, scene, seed)))
    }

    fn method(&self, _name: MethodName, scene: &Scene, _map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        Some(Box::new(GnssPositions::new(self.model(scene), robot)))
    }

    fn first_arrival_s(&self) -> f64 {
        self.period_s + self.latency_s + self.latency_tolerance_s
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::GnssPositions)
    }

    fn constants(&self, drawn: &DrawnGnss, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let off_m = farthest(drawn.position_m, [self.forward_m, self.left_m]);
        vec![(bounds::GNSS_ANTENNA, self.position_tolerance_m, off_m)]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        vec![
            ToldKey::is(&[bounds::GNSS_ANTENNA], &mut self.position_tolerance_m),
            ToldKey::is(&[bounds::GNSS_FIXED], &mut self.fixed_tolerance_m),
            ToldKey::is(&[bounds::GNSS_FLOATING], &mut self.floating_tolerance_m),
            ToldKey::is(&[bounds::GNSS_STAMP], &mut self.stamp_tolerance_s),
        ]
    }
}

impl Gnss {
    /// The model of the receiver that the localizer is given. Stamps are those of the receiver's own clock; where the base has another
    /// clock, the bound on their error grows by the bound on that clock.
    pub(crate) fn model(&self, scene: &Scene) -> ReceiverModel {
        let place = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        ReceiverModel {
            position_m: [place(self.forward_m), place(self.left_m)],
            height_m: self.height_m,
            fixed_m: self.fixed_tolerance_m,
            floating_m: self.floating_tolerance_m,
            stamp_error_s: self.stamp_tolerance_s + scene.robot.delivery.stamp_tolerance_s,
        }
    }
}
