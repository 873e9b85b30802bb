//! Keys that stood elsewhere in scenes of older versions.

/// For each key that has moved, its dotted path in older scenes and its dotted path now.
pub(crate) const MOVED: [(&str, &str); 7] = [
    ("robot.wheel_radius_m", "robot.base.wheel_radius_m"),
    ("robot.wheel_radius_tolerance", "robot.base.wheel_radius_tolerance"),
    ("robot.wheel_wear", "robot.base.wheel_wear"),
    ("robot.track_m", "robot.base.track_m"),
    ("robot.track_tolerance", "robot.base.track_tolerance"),
    ("robot.proximity", "robot.scanner"),
    ("robot.caster_stiffness", "robot.base.differential.caster_stiffness"),
];

/// Where a key of an older scene stands now; `None` for a key that has not moved.
pub(crate) fn place_now(key: &str) -> Option<&'static str> {
    MOVED.iter().find(|(before, _)| *before == key).map(|(_, now)| *now)
}
