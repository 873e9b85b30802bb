//! The interval localizer of this project as a subject, with the methods that a scene asks for.

use localizer::{
    Localizer, Method, PoseBox, Reading,
    localizer::Account,
    methods::{
        ceiling_markers::CeilingMarkers,
        floor_tiles::{Chain, FloorTiles},
        range_landmarks::{Freedom, RangeLandmarks, Solver},
        wall_directions::{self, WallDirections},
    },
    motion::SlipExcess,
};

use super::{Answer, Subject};
use crate::scene::{
    FloorTilesChain, MethodName, RangeLandmarksFreedom, RangeLandmarksSolver, Scene, WallDirectionsChain,
};

/// The interval localizer as a subject.
pub struct IntervalLocalizer {
    localizer: Localizer,
    /// Of the latest reading.
    accounts: Vec<Account>,
}

impl IntervalLocalizer {
    /// With the methods that the scene asks for, told what the scene tells it.
    pub fn of(scene: &Scene) -> IntervalLocalizer {
        IntervalLocalizer::from(localizer(scene))
    }

    /// The same, as [`SubjectOf`](super::SubjectOf) wants it.
    pub fn boxed(scene: &Scene) -> Box<dyn Subject> {
        Box::new(IntervalLocalizer::of(scene))
    }
}

impl From<Localizer> for IntervalLocalizer {
    /// A localizer that was made otherwise; where it was made to start does not matter.
    fn from(localizer: Localizer) -> IntervalLocalizer {
        IntervalLocalizer { localizer, accounts: Vec::new() }
    }
}

impl Subject for IntervalLocalizer {
    fn start(&mut self, start: &PoseBox) {
        self.localizer.restart(*start);
    }

    fn observe(&mut self, reading: &Reading) {
        self.accounts = self.localizer.observe(reading);
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        Answer::Boxes(self.localizer.estimate_at(time_s))
    }

    fn accounts(&mut self) -> Vec<Account> {
        std::mem::take(&mut self.accounts)
    }

    fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.localizer.expect_slip(excesses);
    }
}

/// The localizer that the scene asks for, told what the scene tells it.
fn localizer(scene: &Scene) -> Localizer {
    let localizer = Localizer::new(scene.map(), scene.robot_model(), methods(scene), scene.start_box())
        .with_base_clock(scene.robot.delivery.stamp_tolerance_s);
    if scene.localizer.learns_gyro {
        localizer.learning_gyro(scene.bounds.rest_turn_deg.map(f64::to_radians))
    } else {
        localizer
    }
}

/// The methods that the scene asks for; a new method is one line here.
fn methods(scene: &Scene) -> Vec<Box<dyn Method>> {
    let (map, robot) = (scene.map(), scene.robot_model());
    let chain = match scene.localizer.floor_tiles_chain {
        FloorTilesChain::Direct => Chain::Direct,
        FloorTilesChain::Paper => Chain::Paper,
    };
    let freedom = match scene.localizer.range_landmarks_freedom {
        RangeLandmarksFreedom::Line => Freedom::Line,
        RangeLandmarksFreedom::Translation => Freedom::Translation,
        RangeLandmarksFreedom::Full => Freedom::Full,
    };
    let solver = match scene.localizer.range_landmarks_solver {
        RangeLandmarksSolver::OneShot => Solver::OneShot,
        RangeLandmarksSolver::Polar => Solver::Polar,
        RangeLandmarksSolver::TableIv => Solver::TableIv,
        RangeLandmarksSolver::Sivia => Solver::Sivia { resolution: 0.05 },
    };
    let setup = scene.localizer.wall_directions();
    let walls = wall_directions::Setup {
        chain: match setup.chain {
            WallDirectionsChain::Direct => wall_directions::Chain::Direct,
            WallDirectionsChain::Paper => wall_directions::Chain::Paper,
            WallDirectionsChain::PaperByTiles => wall_directions::Chain::PaperByTiles,
        },
        solves_lean: setup.solves_lean,
        floor_edges: setup.floor_edges,
        learns: setup.learns,
        decides: scene.localizer.methods == [MethodName::WallDirections],
        quotas: setup.quotas(),
    };
    let build = |name: &MethodName| -> Option<Box<dyn Method>> {
        match name {
            MethodName::FloorTiles => {
                FloorTiles::new(&map, &robot, chain).map(|method| Box::new(method) as Box<dyn Method>)
            }
            MethodName::RangeLandmarks => {
                RangeLandmarks::new(&robot, freedom, solver).map(|method| Box::new(method) as Box<dyn Method>)
            }
            MethodName::CeilingMarkers => {
                CeilingMarkers::new(&map, &robot).map(|method| Box::new(method) as Box<dyn Method>)
            }
            MethodName::WallDirections => {
                WallDirections::new(&map, &robot, walls).map(|method| Box::new(method) as Box<dyn Method>)
            }
        }
    };
    scene.localizer.methods.iter().filter_map(build).collect()
}
