//! The devices of a robot. All that is known of a kind of device beyond its keys stands in its file or folder here: what a seed draws of it,
//! what the localizer is told of it, how it senses, which declared bounds there are to it and how much of each was used.
//!
//! A further kind is one such file, and one line of `scene::with_every_kind`; a further method that reads a device is one line of
//! `scene::with_every_method`, and the device makes it. Pictures are drawn by [`sensors`](crate::sensors), for which a camera's
//! file says where the camera is and what its lens does.

pub mod camera;
mod ceiling_camera;
pub mod delivery;
pub mod encoders;
pub mod flow;
mod floor_camera;
mod forward_camera;
pub mod gnss;
pub mod gyro;
pub mod proximity;
pub mod range_camera;
mod told_key;

use std::fmt::Debug;

use interval::Interval;
use localizer::{Map, Method, Reading, RobotModel, bounds::Assumption, reading::LandmarkId};

use crate::{
    place::Bystander,
    scene::{
        CeilingCamera, Distribution, FloorCamera, Flow, ForwardCamera, Gnss, Gyro, MethodName, RangeCamera, Robot,
        Scene, with_every_kind, with_every_method,
    },
    truth::Truth,
};

pub(crate) use told_key::{ToldKey, Widens};

/// A kind of device, by its keys in a scene.
pub trait Device {
    /// What a seed draws of it once, before the run.
    type Drawn: Clone + Debug;

    /// Draws it, each quantity from a stream of its own.
    fn draw(&self, errors: Distribution, seed: u64) -> Self::Drawn;

    /// What looks at the world in a drive of the scene; none of a camera, which looks at pictures of it.
    fn sensor(&self, _drawn: &Self::Drawn, _scene: &Scene, _seed: u64) -> Option<Box<dyn Sensor>> {
        None
    }

    /// Whether its readings are read by the board of the base, and go by its bus.
    fn is_on_base(&self) -> bool {
        false
    }

    /// Whether the scene's localizer makes anything of its readings, and so relies on its bounds.
    fn is_relied_on(&self, scene: &Scene) -> bool;

    /// The method of this name, which is listed as one that reads it, as the scene asks for it; none where there is nothing that it could see.
    fn method(&self, _name: MethodName, _scene: &Scene, _map: &Map, _robot: &RobotModel) -> Option<Box<dyn Method>> {
        None
    }

    /// Its declared bounds on what stays the same over a run: name, declared, and true value.
    fn constants(&self, drawn: &Self::Drawn, scene: &Scene) -> Vec<(Assumption, f64, f64)>;

    /// Its keys that tell the localizer a bound.
    fn told_keys(&mut self) -> Vec<ToldKey<'_>>;

    /// The bounds beyond which its truth may be drawn or placed, so that a run can have it moved back. The others hold by construction, or are of
    /// what emerges from the physics.
    const CLIPPED: &'static [Assumption] = &[];

    /// Moves back to its bound what was drawn, or is to be drawn, beyond the bound of this name.
    fn clip(&self, _drawn: &mut Self::Drawn, _bound: &str) {}

    /// Keys of its table that contradict each other, and what was expected of each.
    fn contradictions(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}

/// What looks at the world at every physics step and now and then has a reading.
pub trait Sensor {
    /// Looks at one physics step.
    fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation>;
}

/// A reading, with the truth behind it for those who may know.
#[derive(Clone, Debug)]
pub struct Observation {
    /// What the localizer gets.
    pub reading: Reading,
    /// Truth at the true time of the measurement.
    pub truth: Truth,
    /// The declared bounds that this reading has a part in, each with the true value.
    pub checks: Vec<BoundCheck>,
    /// Codes given in a reading of the range camera, in its order, and whether each is its landmark's own; none in others.
    pub codes: Vec<(LandmarkId, bool)>,
}

impl Observation {
    /// A reading without anything else behind it than the truth.
    pub fn new(reading: Reading, truth: Truth) -> Self {
        Observation { reading, truth, checks: Vec::new(), codes: Vec::new() }
    }

    /// The true value behind a bound that this reading has a part in.
    pub fn true_value(&self, bound: Assumption) -> Option<f64> {
        self.checks.iter().find(|check| check.bound == bound).map(|check| check.true_value)
    }
}

/// A declared bound beside the true value behind it, over a span of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundCheck {
    /// The bound's name.
    pub bound: Assumption,
    /// From when to when the value was so.
    pub span_s: [f64; 2],
    /// What the scene declares.
    pub declared: f64,
    /// What was true.
    pub true_value: f64,
}

impl BoundCheck {
    /// Whether the true value is beyond the bound. A drawn value at its very corner is inside, whatever the rounding of the comparison.
    pub fn is_exceeded(&self) -> bool {
        self.true_value > self.declared * (1.0 + 1e-9) + 1e-15
    }
}

macro_rules! define {
    ($($(#[$doc:meta])+ $name:ident: $keys:ident as $fitted:literal ;)+) => {
        /// Of each kind of device, the bounds beyond which its truth may be drawn or placed.
        pub(crate) const CLIPPED: &[&[Assumption]] = &[$(<$keys as Device>::CLIPPED),+];

        /// What a seed draws of each device that the robot has.
        #[derive(Clone, Debug)]
        pub struct DrawnDevices {
            $(
                #[doc = concat!("Of `[robot.", stringify!($name), "]`.")]
                pub $name: Option<<$keys as Device>::Drawn>,
            )+
        }

        impl DrawnDevices {
            /// Draws every device of the robot.
            pub(crate) fn draw(robot: &Robot, seed: u64) -> Self {
                DrawnDevices { $($name: robot.$name.as_ref().map(|device| device.draw(robot.errors, seed)),)+ }
            }

            /// Moves back to its bound what of any device was drawn beyond the bound of this name.
            pub(crate) fn clip(&mut self, bound: &str, robot: &Robot) {
                $(if let (Some(device), Some(drawn)) = (&robot.$name, &mut self.$name) {
                    device.clip(drawn, bound);
                })+
            }

            /// Every declared bound on what stays the same over a run, of devices that the scene's localizer relies on.
            pub(crate) fn constants(&self, scene: &Scene) -> Vec<(Assumption, f64, f64)> {
                let mut all = Vec::new();
                $(if let (Some(device), Some(drawn)) = (&scene.robot.$name, &self.$name)
                    && device.is_relied_on(scene)
                {
                    all.extend(device.constants(drawn, scene));
                })+
                all
            }

            /// What looks at the world in a drive of the scene.
            pub(crate) fn sensors(&self, scene: &Scene, seed: u64) -> Vec<FittedSensor> {
                let mut all = Vec::new();
                $(if let (Some(device), Some(drawn)) = (&scene.robot.$name, &self.$name)
                    && let Some(sensor) = device.sensor(drawn, scene, seed)
                {
                    let (is_on_base, is_relied_on) = (device.is_on_base(), device.is_relied_on(scene));
                    all.push(FittedSensor { sensor, is_on_base, is_relied_on });
                })+
                all
            }
        }

        /// Hands over every key of a device of the robot that tells the localizer a bound.
        pub(crate) fn each_told_key(robot: &mut Robot, change: &mut dyn FnMut(ToldKey<'_>)) {
            $(robot.$name.iter_mut().flat_map(Device::told_keys).for_each(&mut *change);)+
        }

        /// Keys of devices that contradict each other, from the scene's root, and what was expected of each.
        pub(crate) fn contradictions(robot: &Robot) -> Vec<(String, String)> {
            let mut all = Vec::new();
            $(for (key, expected) in robot.$name.iter().flat_map(Device::contradictions) {
                all.push((format!("robot.{}.{key}", stringify!($name)), expected));
            })+
            all
        }
    };
}

with_every_kind!(define);

macro_rules! define_methods {
    ($($(#[$doc:meta])+ $method:ident reads $device:ident,)+) => {
        /// A method as the scene asks for it; none where the robot lacks what it reads, or there is nothing that it could see.
        pub(crate) fn method(name: MethodName, scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
            match name {
                $(MethodName::$method => scene.robot.$device.as_ref()?.method(name, scene, map, robot),)+
            }
        }
    };
}

with_every_method!(define_methods);

/// A sensor on the robot.
pub(crate) struct FittedSensor {
    sensor: Box<dyn Sensor>,
    /// Whether its readings go by the base's bus.
    pub(crate) is_on_base: bool,
    is_relied_on: bool,
}

impl FittedSensor {
    /// Looks at one physics step. Bounds of a sensor that nobody relies on are not checked.
    pub(crate) fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation> {
        let mut observation = self.sensor.observe(truth, people)?;
        if !self.is_relied_on {
            observation.checks.clear();
        }
        Some(observation)
    }
}

/// What a period that the physics cannot sample is told, if it cannot.
pub(crate) fn unsampled(period_s: f64) -> Option<String> {
    let steps = period_s / 0.001;
    let is_sampled = (steps - steps.round()).abs() <= 1e-6;
    (!is_sampled).then(|| "expected a multiple of 0.001, the step of the physics".to_owned())
}

/// `nominal·(1 ± share)`.
pub(crate) fn relative(nominal: f64, share: f64) -> Interval {
    Interval::centred(nominal, nominal.abs() * share)
}

/// The greater distance along either axis.
fn farthest(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}
