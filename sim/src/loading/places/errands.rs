//! Contradictions about errands that the robot cannot drive.

use crate::{
    base::TurningCircle,
    loading::contradiction::Contradiction,
    place::navigation::{CurvePlanner, Planner},
    scene::Scene,
};

/// Errands with the same name, and goals to which no path leads.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let navigation = scene.navigation();
    if scene.start.anywhere && !scene.has_errands() {
        let expected = "true without errands, expected some `[[errand]]` or `navigation.random_goals`, to which the robot plans its way from \
                        wherever it finds itself"
            .to_owned();
        found.push(Contradiction { key: "start.anywhere".to_owned(), expected });
    }
    let is_map_missing = navigation.map.is_some() && navigation.surveyed.is_none();
    // A goal outside the room or in furniture has been reported already, and no path can be planned on a map that could not be read.
    if !scene.has_errands() || !found.is_empty() || is_map_missing {
        return;
    }
    for (index, errand) in scene.errands.iter().enumerate().filter(|(_, errand)| !errand.name.is_empty()) {
        if let Some(first) = scene.errands[..index].iter().position(|other| other.name == errand.name) {
            let expected = format!("{:?} is errand[{first}] too, expected a name of its own, or none", errand.name);
            found.push(Contradiction { key: format!("errand[{index}].name"), expected });
        }
    }
    let planner = Planner::of(scene);
    let start_m = [scene.start.x_m, scene.start.y_m];
    let Some(reach) = planner.reach(start_m) else {
        let expected = format!("the map leaves no free floor here, expected some {}", room_needed(scene));
        found.push(Contradiction { key: "start.x_m".to_owned(), expected });
        return;
    };
    for (index, errand) in scene.errands.iter().enumerate() {
        if !reach.contains([errand.x_m, errand.y_m]) {
            let expected =
                format!("no way leads from the start to this goal, expected one with {}", room_needed(scene));
            found.push(Contradiction { key: format!("errand[{index}].x_m"), expected });
        }
    }
    if found.is_empty()
        && let Some(circle) = scene.robot.base.drivetrain().turning_circle()
    {
        ways_in_curves(scene, &planner, circle, found);
    }
    if navigation.random_goals > 0 && reach.n_cells() < 2 {
        let expected = "there is nowhere to go, expected free floor about the start".to_owned();
        found.push(Contradiction { key: "navigation.random_goals".to_owned(), expected });
    }
}

/// Goals to which no path leads that a base with a turning circle could drive, from the pose at the goal before.
fn ways_in_curves(scene: &Scene, planner: &Planner, circle: TurningCircle, found: &mut Vec<Contradiction>) {
    let planner = CurvePlanner::new(planner, circle.planned_radius_m());
    let mut pose = scene.nominal_start();
    for (index, errand) in scene.errands.iter().enumerate() {
        let Some(arcs) = planner.plan(pose, [errand.x_m, errand.y_m]) else {
            let expected = format!(
                "no way leads to this goal for a turning circle of radius {:.2} m, expected one in curves with {}",
                circle.radius_m,
                room_needed(scene)
            );
            found.push(Contradiction { key: format!("errand[{index}].x_m"), expected });
            return;
        };
        pose = arcs.iter().fold(pose, |pose, arc| arc.end(pose));
    }
}

fn room_needed(scene: &Scene) -> String {
    let margin_m = scene.navigation().margin_m;
    format!("{} m to either side, the robot's body and a margin of {margin_m} m", scene.robot.body_radius_m + margin_m)
}
