//! The optical flow sensor.

mod sensor;

use interval::Interval;
use localizer::{
    bounds::{self, Assumption},
    robot::FlowModel,
};

use crate::{
    scene::{Distribution, Flow, Scene},
    truth::randomness::{draw_within, stream},
};

use super::{Device, Sensor, ToldKey, Widens, farthest, relative, unsampled};

pub use sensor::FlowSensor;

/// True mount and scale of the optical flow sensor.
#[derive(Clone, Copy, Debug)]
pub struct DrawnFlow {
    /// Position in the robot frame of the spot that the flow sensor looks at: forward and left.
    pub position_m: [f64; 2],
    /// Angle of the sensor's forward axis from the robot's, counter-clockwise.
    pub yaw_rad: f64,
    /// True counts per metre over the nominal ones, at the mounted height.
    pub scale: f64,
}

impl Device for Flow {
    type Drawn = DrawnFlow;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnFlow {
        let mut rng = stream(seed, "flow.mount");
        let mut around = |nominal: f64, tolerance: f64| nominal + draw_within(tolerance, errors, &mut rng);
        DrawnFlow {
            position_m: [self.forward_m, self.left_m].map(|nominal_m| around(nominal_m, self.position_tolerance_m)),
            yaw_rad: around(0.0, self.yaw_tolerance_deg.to_radians()),
            scale: around(1.0, self.calibration_tolerance),
        }
    }

    fn sensor(&self, drawn: &DrawnFlow, scene: &Scene, seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(FlowSensor::new(self, drawn, scene, seed)))
    }

    fn is_on_base(&self) -> bool {
        true
    }

    /// The localizer uses the flow sensor only together with a gyroscope.
    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.robot.gyro.is_some()
    }

    fn constants(&self, drawn: &DrawnFlow, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let off_m = farthest(drawn.position_m, [self.forward_m, self.left_m]);
        vec![
            (bounds::FLOW_POSITION, self.position_tolerance_m, off_m),
            (bounds::FLOW_YAW, self.yaw_tolerance_deg.to_radians(), drawn.yaw_rad.abs()),
            (bounds::FLOW_CALIBRATION, self.calibration_share(), (drawn.scale - 1.0).abs()),
        ]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        vec![
            ToldKey::is(&[bounds::FLOW_POSITION], &mut self.position_tolerance_m),
            ToldKey::is_in_deg(&[bounds::FLOW_YAW], &mut self.yaw_tolerance_deg),
            ToldKey::is(&[bounds::FLOW_CALIBRATION], &mut self.calibration_tolerance),
            // The scale's whole tolerance less the calibration's tolerance is the bound on how far the counts per metre may vary.
            ToldKey::is_part(&[bounds::FLOW_SCALE, bounds::FLOW_CALIBRATION], &mut self.scale_tolerance, Widens::By),
            ToldKey::is(&[bounds::FLOW_BACK_AND_FORTH], &mut self.back_and_forth_m),
        ]
    }

    /// The errors of the flow sensor's scale (counts per metre) that are drawn at random are parts of its declared tolerance: the calibration's
    /// tolerance is part of the whole, and those of surfaces and noise together are part of what the calibration leaves.
    fn contradictions(&self) -> Vec<(String, String)> {
        let mut found = Vec::from_iter(unsampled(self.period_s).map(|expected| ("period_s".to_owned(), expected)));
        if self.calibration_tolerance > self.scale_tolerance {
            let expected = format!(
                "expected at most `scale_tolerance`, of which it is part and which is {}",
                self.scale_tolerance
            );
            found.push(("calibration_tolerance".to_owned(), expected));
            return found;
        }
        // Sums such as 0.01 + 0.02 are not exact.
        const ROUNDING: f64 = 1e-12;
        if self.surface_tolerance + self.noise_tolerance > self.varying_share() + ROUNDING {
            let key =
                if self.surface_tolerance > self.noise_tolerance { "surface_tolerance" } else { "noise_tolerance" };
            let expected = format!(
                "expected `surface_tolerance` and `noise_tolerance` to come to at most {}, which is what `calibration_tolerance` leaves of \
                 `scale_tolerance`",
                (self.varying_share() * 1e6).round() / 1e6
            );
            found.push((key.to_owned(), expected));
        }
        found
    }
}

impl Flow {
    /// The model of the optical flow sensor that the localizer is given.
    pub(crate) fn model(&self) -> FlowModel {
        let place = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        FlowModel {
            position_m: [place(self.forward_m), place(self.left_m)],
            metres_per_count: Interval::point(1.0) / relative(self.counts_per_m, self.calibration_share()),
            // With s the scale (counts per metre over nominal), s₀ its value at the mounted height and v the bound on its variation: from |s − s₀| ≤
            // v follows |s/s₀ − 1| ≤ v/s₀, which is greatest where s₀ is least.
            scale_change: self.varying_share() / (1.0 - self.calibration_share()),
            yaw_rad: Interval::centred(0.0, self.yaw_tolerance_deg.to_radians()),
            quantisation_counts: 1.0,
            back_and_forth_m: self.back_and_forth_m,
            period_s: self.period_s,
        }
    }
}
