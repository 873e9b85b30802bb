//! One binary for all integration tests; each module states what belongs in it.
#![allow(clippy::unwrap_used, clippy::expect_used)]

/// Runs the `wherein` command in folders of its own.
mod command;
/// Judges a run that a test has made.
mod judging;

/// Contractors and pavings on problems worked out by hand.
mod contractor_by_hand;
/// Attempts to make the rigid contractors lose the truth.
mod contractor_falsification;
/// Laws that every contractor keeps.
mod contractor_laws;
/// Every contractor on boxes that are unbounded, huge, far away or empty.
mod contractor_extremes;
/// Interval arithmetic against the ITF1788 collection of cases from outside.
mod interval_itf1788;
/// Interval arithmetic against arithmetic with many more bits.
mod interval_precision;
/// Printing and reading intervals.
mod interval_text;
/// The wheels' enclosure against motion integrated much finer.
mod motion_enclosure;
/// A range camera and landmarks of the tests' own, seen in three dimensions.
mod range_landmarks_setup;
/// Every way to solve for the pose from landmarks, some of them matched wrongly.
mod range_landmarks_solvers;
/// Drives past landmarks that nobody has mapped.
mod range_landmarks_drive;
/// Gaps between uses of a code, and constraints that outlive what they stood on.
mod range_landmarks_gaps;
/// Point methods and the printed contractor beside the sound ones.
mod landmark_baselines;
/// Where markers put a robot whose camera's vertical is known.
mod marker_baselines;
/// The gyroscope's turn against turns integrated much finer.
mod gyro_enclosure;
mod gyro_errors;
/// Range camera, gyroscope and people against geometry by hand.
mod range_sensing;
/// Whole runs by landmarks that no map names.
mod range_runs;
/// Tile joints to poses, against a camera and a floor of the tests' own.
mod floor_tiles_geometry;
/// Level edges to headings, against a camera of the tests' own.
mod wall_directions_geometry;
/// Straight edges and features in pictures of known light.
mod dark_vision;
mod dark_runs;
mod gyro_bias_learning;
/// The flow sensor's enclosure against motion integrated much finer; the gyroscope's bias.
mod flow_enclosure;
/// Paper 2's slip decision, direction database and pose graph.
mod dark_baselines;
/// Ceiling markers to poses, against a camera and a ceiling of the tests' own.
mod ceiling_markers_geometry;
/// Markers on rendered ceilings, whole and damaged, read by the localizer.
mod ceiling_pasted;
/// A camera's lens and the place of its mount, measured on rendered pictures.
mod calibration_rendered;
mod ceiling_runs;
/// Whether markers cover a room, against cameras and poses drawn at random.
mod marker_coverage;
/// `wherein markers`: sheet and map.
mod marker_sheet;
/// Markers that must be refused, and what the refusal says.
mod marker_refusals;
/// Scenes and drives that the tests of the world share.
mod world_setup;
/// The tyre law against the brush's own integral and closed form.
mod world_tyre;
/// Motion at rest, straight on and in a circle against closed forms; walls; travel against pose.
mod world_motion;
/// Slip by region, friction events and pushes.
mod world_floor;
/// Carpets, ramps, stuck wheels, lifts, snapshots and Borenstein's square against closed forms.
mod carpet_physics;
/// Whole runs by wheels, gyroscope and flow sensor, and what goes wrong on them.
mod carpet_runs;
/// Scenes that once broke motion, its sensors and landmarks.
mod found_motion;
/// Gyroscope, flow sensor and delivery against closed forms and geometry by hand.
mod motion_sensors;
/// Routes driven by estimates, and the default bounds on such a drive.
mod careful_bounds;
mod gyro_band;
mod base_clock;
mod world_drifts;
mod world_driver;
/// Occupancy grids, ways through them and their files, against maps drawn by hand and map_server's rules.
mod navigation_map;
/// Errands: control laws by hand, estimates that lie, blocked ways, what a run tells of it.
mod navigation_drive;
/// Encoders against the definition of a tick.
mod world_encoder;
/// Drawn errors against their tolerances.
mod world_drawn;
/// Scenes that must be refused, and what the refusal says.
mod scene_refusals;
/// Scenes that build on others: what they come to state, what is refused, and what is left of them.
mod scene_extends;
/// What `[expect]` holds a run against.
mod scene_expectations;
/// What a user meets on the command line besides refusals: exit codes, output, replay, resumption.
mod cli_runs;
/// What a run leaves behind, read back by other means than ours.
mod record_files;
/// What every scene file, the schema and the documents keep true.
mod repository;
/// The floor camera's lens and rolling shutter against formulas written out there.
mod render_floor_lens;
/// Tiles as laid, against the bounds that the localizer is told.
mod render_laid_tiles;
/// The sensor against the linear model of EMVA 1288: dark current, non-uniformities, depth, presets, the photon budget at 0.1 lx.
mod render_sensor;
/// Grey levels and noise against photon counts by hand.
mod render_photons;
/// Rendered floor points, joints and blur against a projection derived by hand.
mod render_projection;
/// Light of lamps against closed forms; shadows against similar triangles; spectra against published figures.
mod light_of_lamps;
mod live_view;
/// Rooms seen through lenses against projections of the tests' own.
mod render_room;
/// Puddles: mirrored things and lamps against the law of reflection, the wet floor against Ångström's.
mod render_puddles;
/// Glints of long lamps against their images below the floor.
mod render_glints;
/// People who walk, row by row and at the picture's border.
mod render_walkers;
/// Cracks between faces, and what defocus draws in from beyond the border.
mod render_gaps;
/// The ring's light on walls, people and lamps against both cosines.
mod render_ring_light;
/// Pictures of rooms against pictures that somebody has looked at.
mod gnss;
mod golden_images;
/// `wherein render`.
mod cli_render;
/// What the renderer's tests share.
mod render_studio;
/// Who is at fault when the truth is outside: on records made by hand, and on runs with a fault planted in them.
mod blame;
/// Runs with every error as far as its bound lets it: contained, in boxes of which a fault that makes them smaller would be seen.
mod corner_runs;
/// What is doubted, how soon, and when the truth is in the box again.
mod doubts;
/// Readings that come long after the slot before them, or after wheels that were silent, and headings when nothing else is known.
mod slots;
/// Every bound that an estimate stands on is watched, and the other way round.
mod bounds_watched;
/// What the folders of each crate may know of each other.
mod structure;
/// Localizers of somebody's own in the loop: what they are told and how they are judged.
mod subjects;
/// How much of the boxes is used, what counts as available, and what was not measured.
mod power;
/// Runs whose localizer is told narrower bounds than hold.
mod weakened;
/// Whole runs on rendered images: soundness, recovery, the same bytes for the same seed.
mod whole_runs;
/// Recordings as the `mcap` crate reads them, and the localizer on them.
mod recordings;
/// Sweeps: every case once, the same bytes for any number of jobs, after kills, and merged from parts.
mod sweep_cases;
/// Sweeps that must be refused, and what the refusal says.
mod sweep_refusals;
/// Reports, JUnit and annotations of a sweep, against its own table.
mod sweep_report;
/// The result table's rows and pooled figures, the report's measures, the CSV's reader.
mod result_figures;
/// `wherein compare`: planted differences found, chance not taken for one.
mod sweep_compare;
/// What random scenes are made of: every key of the schema, most of them accepted.
mod falsify_grammar;
/// `wherein falsify`: found, shrunk, resumed; and a minute of it with fixed seeds.
mod falsify_search;
/// Which records come true as which wish, on records made by hand.
mod falsify_wishes;
/// Scenes that broke something once, each with its seeds.
mod found_scenes;
