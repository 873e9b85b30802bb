//! The devices of a robot. Everything about a kind of device beyond its keys is in one file or folder here: what a seed draws at random for
//! it, what the localizer is given about it, how it senses, its declared bounds, and how much of each bound was used.
//!
//! A new kind needs such a file and one line of `scene::with_every_kind`. A new method that reads a device needs one line of
//! `scene::with_every_method`, and the device creates it. Pictures are taken by [`sensors`](crate::run::sensors); a camera's file says where the
//! camera is and what its lens does.

pub mod camera;
mod ceiling_camera;
pub mod delivery;
pub mod encoders;
pub mod flow;
mod floor_camera;
mod forward_camera;
pub mod gnss;
pub mod gyro;
pub mod point_camera;
pub mod range_camera;
pub mod scanner;
mod steering_encoder;
mod surroundings;
mod told_key;

use std::fmt::Debug;

use interval::Interval;
use localizer::{Map, Method, Reading, RobotModel, bounds::Assumption, reading::LandmarkId};

use crate::{
    place::Bystander,
    scene::{
        CeilingCamera, Distribution, FloorCamera, Flow, ForwardCamera, Gnss, Gyro, MethodName, PointCamera,
        RangeCamera, Robot, Scanner, Scene, SteeringEncoder, with_every_kind, with_every_method,
    },
    truth::Truth,
};

pub use surroundings::{Look, Surroundings, WatchedBound};
pub(crate) use told_key::{ToldKey, Widens};

/// A kind of device of the robot, such as a sensor, implemented for the keys by which a scene describes it.
pub trait Device {
    /// The values that a seed draws at random for the device once, before the run.
    type Drawn: Clone + Debug;

    /// Draws the device's true values at random, each quantity from a random stream of its own.
    fn draw(&self, errors: Distribution, seed: u64) -> Self::Drawn;

    /// The sensor that observes the world in a drive of the scene; `None` for a camera, whose pictures are rendered.
    fn sensor(&self, _drawn: &Self::Drawn, _scene: &Scene, _seed: u64) -> Option<Box<dyn Sensor>> {
        None
    }

    /// Whether the board of the base reads the device and sends its readings over the base's bus.
    fn is_on_base(&self) -> bool {
        false
    }

    /// Whether the scene's localizer uses the device's readings, and so relies on its bounds.
    fn is_relied_on(&self, scene: &Scene) -> bool;

    /// Latest time after the start at which the device's first reading of the robot's surroundings arrives; 0 for a device that measures only the
    /// robot's motion.
    fn first_arrival_s(&self) -> f64 {
        0.0
    }

    /// The localizer's method of this name, which reads this device, with the settings of the scene; `None` where there is nothing that the method
    /// could see.
    fn method(&self, _name: MethodName, _scene: &Scene, _map: &Map, _robot: &RobotModel) -> Option<Box<dyn Method>> {
        None
    }

    /// The device's declared bounds on values that stay the same over a run, each with its name, the declared value and the true value.
    fn constants(&self, drawn: &Self::Drawn, scene: &Scene) -> Vec<(Assumption, f64, f64)>;

    /// The declared bounds on the robot's surroundings that the localizer relies on when it uses the device's readings, compared with what truly
    /// stands there.
    fn surroundings(
        &self,
        _drawn: &Self::Drawn,
        _scene: &Scene,
        _surroundings: &Surroundings<'_>,
    ) -> Vec<WatchedBound> {
        Vec::new()
    }

    /// The keys of the device in a scene that state a bound for the localizer.
    fn told_keys(&mut self) -> Vec<ToldKey<'_>>;

    /// Bounds that true values of the device may exceed when they are drawn or placed, so that a counterfactual run (a run simulated again to find
    /// what was to blame) can move these values back to the bound. All other bounds hold by construction, or limit quantities that emerge from the
    /// physics.
    const CLIPPED: &'static [Assumption] = &[];

    /// Moves values of the device that a seed has drawn, or is still to draw, back to the named bound where they exceed it.
    fn clip(&self, _drawn: &mut Self::Drawn, _bound: &str) {}

    /// Keys of the device's table in a scene that contradict each other, each with what was expected.
    fn contradictions(&self) -> Vec<(String, String)> {
        Vec::new()
    }
}

/// A sensor that observes the world at every physics step and gives a reading now and then.
pub trait Sensor {
    /// Observes the world at one physics step; returns a reading when one is due.
    fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation>;
}

/// A reading together with the truth behind it. The localizer is given the reading alone.
#[derive(Clone, Debug)]
pub struct Observation {
    /// The reading that the localizer is given.
    pub reading: Reading,
    /// Truth at the time at which the measurement was truly made.
    pub truth: Truth,
    /// The declared bounds that the errors of this reading are subject to, each with the true value of the quantity that it limits.
    pub checks: Vec<BoundCheck>,
    /// The landmark codes of a range camera's reading, in the reading's order, each with whether it is the landmark's own code; empty for readings of
    /// other sensors.
    pub codes: Vec<(LandmarkId, bool)>,
    /// True travel of the flow sensor along its own axes in the period that a reading of it ends, forward and left; 0 for readings of other sensors.
    pub travel_m: [f64; 2],
    /// What the flow sensor has counted since the start, forward and left, together with where each axis stood within a count then: real numbers, of
    /// which the reading has the whole parts. 0 for readings of other sensors.
    pub counted: [f64; 2],
}

impl Observation {
    /// Makes an observation of a reading and the truth behind it, without checks of bounds and without landmark codes.
    pub fn new(reading: Reading, truth: Truth) -> Self {
        Observation { reading, truth, checks: Vec::new(), codes: Vec::new(), travel_m: [0.0; 2], counted: [0.0; 2] }
    }

    /// The true value of the quantity that the bound limits, if the errors of this reading are subject to the bound; `None` for any other bound.
    pub fn true_value(&self, bound: Assumption) -> Option<f64> {
        self.checks.iter().find(|check| check.bound == bound).map(|check| check.true_value)
    }
}

/// A declared bound and the true value of the quantity that it limits, over a time span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundCheck {
    /// Name of the declared bound.
    pub bound: Assumption,
    /// Start and end of the time span over which the quantity had its true value.
    pub span_s: [f64; 2],
    /// The bound that the scene declares.
    pub declared: f64,
    /// The true value that the bound limits.
    pub true_value: f64,
}

impl BoundCheck {
    /// Whether the true value exceeds the bound. A value drawn at the very bound does not, whatever the rounding of the comparison.
    pub fn is_exceeded(&self) -> bool {
        self.true_value > self.declared * (1.0 + 1e-9) + 1e-15
    }
}

macro_rules! define {
    ($($(#[$doc:meta])+ $name:ident: $keys:ident as $fitted:literal ;)+) => {
        /// For each kind of device, the bounds that its true values may exceed when they are drawn or placed.
        pub(crate) const CLIPPED: &[&[Assumption]] = &[$(<$keys as Device>::CLIPPED),+];

        /// The values that a seed draws at random before the run for each device of the robot.
        #[derive(Clone, Debug)]
        pub struct DrawnDevices {
            $(
                #[doc = concat!("Of `[robot.", stringify!($name), "]`.")]
                pub $name: Option<<$keys as Device>::Drawn>,
            )+
        }

        impl DrawnDevices {
            /// Draws the true values of every device of the robot at random.
            pub(crate) fn draw(robot: &Robot, seed: u64) -> Self {
                DrawnDevices { $($name: robot.$name.as_ref().map(|device| device.draw(robot.errors, seed)),)+ }
            }

            /// Moves the drawn values of all devices back to the named bound where they exceed it.
            pub(crate) fn clip(&mut self, bound: &str, robot: &Robot) {
                $(if let (Some(device), Some(drawn)) = (&robot.$name, &mut self.$name) {
                    device.clip(drawn, bound);
                })+
            }

            /// Every declared bound on values that stay the same over a run, of the devices that the scene's localizer relies on.
            pub(crate) fn constants(&self, scene: &Scene) -> Vec<(Assumption, f64, f64)> {
                let mut all = Vec::new();
                $(if let (Some(device), Some(drawn)) = (&scene.robot.$name, &self.$name)
                    && device.is_relied_on(scene)
                {
                    all.extend(device.constants(drawn, scene));
                })+
                all
            }

            /// Every declared bound on the robot's surroundings, for the devices that the scene's localizer relies on.
            pub(crate) fn surroundings(&self, scene: &Scene, surroundings: &Surroundings<'_>) -> Vec<WatchedBound> {
                let mut all = Vec::new();
                $(if let (Some(device), Some(drawn)) = (&scene.robot.$name, &self.$name)
                    && device.is_relied_on(scene)
                {
                    all.extend(device.surroundings(drawn, scene, surroundings));
                })+
                all
            }

            /// The sensors that observe the world in a drive of the scene.
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

        /// Calls `change` for every key of the robot's devices that states a bound for the localizer.
        pub(crate) fn each_told_key(robot: &mut Robot, change: &mut dyn FnMut(ToldKey<'_>)) {
            $(robot.$name.iter_mut().flat_map(Device::told_keys).for_each(&mut *change);)+
        }

        /// Latest time after the start at which each device of the robot has sent a reading of the surroundings, if it has anything to read.
        pub(crate) fn first_arrivals_s(robot: &Robot) -> f64 {
            let mut latest_s: f64 = 0.0;
            $(latest_s = latest_s.max(robot.$name.as_ref().map_or(0.0, Device::first_arrival_s));)+
            latest_s
        }

        /// Keys of devices that contradict each other, named from the scene's root, each with what was expected.
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
        /// The localizer's method of the given name with the settings of the scene; `None` where the robot lacks the device that the method reads, or
        /// there is nothing that the method could see.
        pub(crate) fn method(name: MethodName, scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
            if scene.robot.shows_landmarks(name) {
                return scene.robot.forward_camera.as_ref()?.method(name, scene, map, robot);
            }
            match name {
                $(MethodName::$method => scene.robot.$device.as_ref()?.method(name, scene, map, robot),)+
            }
        }
    };
}

with_every_method!(define_methods);

/// A sensor that is fitted to the robot.
pub(crate) struct FittedSensor {
    sensor: Box<dyn Sensor>,
    /// Whether the sensor's readings reach the localizer over the bus of the robot's base.
    pub(crate) is_on_base: bool,
    is_relied_on: bool,
}

impl FittedSensor {
    /// Observes the world at one physics step. The bounds of a sensor that the localizer does not rely on are not checked.
    pub(crate) fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation> {
        let mut observation = self.sensor.observe(truth, people)?;
        if !self.is_relied_on {
            observation.checks.clear();
        }
        Some(observation)
    }
}

/// The message for a period that is not a multiple of the physics step; `None` for a valid period.
pub(crate) fn unsampled(period_s: f64) -> Option<String> {
    let steps = period_s / 0.001;
    let is_sampled = (steps - steps.round()).abs() <= 1e-6;
    (!is_sampled).then(|| "expected a multiple of 0.001, the step of the physics".to_owned())
}

/// The interval `nominal·(1 ± share)`.
pub(crate) fn relative(nominal: f64, share: f64) -> Interval {
    Interval::centred(nominal, nominal.abs() * share)
}

/// The distance between two points along the axis on which it is greater.
fn farthest(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}
