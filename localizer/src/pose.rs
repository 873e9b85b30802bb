//! Planar poses, boxes of poses and unions of boxes. Heading lives on the real line and is never wrapped.

use interval::{Interval, IntervalBox};

/// A pose in the plane: `world_from_robot`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// World x of the robot origin.
    pub x_m: f64,
    /// World y of the robot origin.
    pub y_m: f64,
    /// Angle from world x to robot x, counter-clockwise, unwrapped.
    pub heading_rad: f64,
}

/// A box of poses, in the order x, y, heading (metres, metres, radians).
pub type PoseBox = IntervalBox<3>;

/// Disjunction of pose boxes: the pose is in at least one of them. No branch means that an assumption failed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseUnion {
    /// Non-empty boxes, in a fixed order.
    pub branches: Vec<PoseBox>,
}

impl Pose {
    /// `[x_m, y_m, heading_rad]`.
    pub fn to_array(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.heading_rad]
    }
}

impl PoseUnion {
    /// A union of one box, or of none if the box is empty.
    pub fn single(pose: PoseBox) -> Self {
        PoseUnion { branches: if pose.is_empty() { Vec::new() } else { vec![pose] } }
    }

    /// Whether no pose is left.
    pub fn is_empty(&self) -> bool {
        self.branches.is_empty()
    }

    /// Smallest box around all branches; the empty box if there is none.
    pub fn hull(&self) -> PoseBox {
        self.branches.iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch))
    }

    /// The union without branches that lie inside another one.
    pub fn without_repeats(self) -> Self {
        let mut kept: Vec<PoseBox> = Vec::with_capacity(self.branches.len());
        for branch in self.branches {
            if kept.iter().any(|other| branch.is_subset_of(other)) {
                continue;
            }
            kept.retain(|other| !other.is_subset_of(&branch));
            kept.push(branch);
        }
        PoseUnion { branches: kept }
    }

    /// The poses that are in both unions: every branch of one with every branch of the other.
    pub fn common(&self, other: &PoseUnion) -> Self {
        let branches =
            self.branches.iter().flat_map(|one| other.branches.iter().map(move |other| one.intersect(other)));
        PoseUnion { branches: branches.filter(|branch| !branch.is_empty()).collect() }.without_repeats()
    }

    /// Whether some branch contains the pose.
    pub fn contains(&self, pose: Pose) -> bool {
        self.branches.iter().any(|branch| branch.contains(&pose.to_array()))
    }
}

/// `[x, y, heading]` of a box, by name.
pub fn components(pose: &PoseBox) -> (Interval, Interval, Interval) {
    (pose[0], pose[1], pose[2])
}
