//! A single binary with all integration tests. The comment at each `mod` line says what the tests of that module check.
#![allow(clippy::unwrap_used, clippy::expect_used)]

/// Helpers that run the `wherein` command in temporary folders, each test in its own.
mod command;
/// Tests of `wherein check`, which looks at a scene before it is run.
mod scene_check;
/// Tests of `wherein judge`, which compares estimates of any program with a recording.
mod judged_estimates;
/// Helper that runs the judge on a run that a test has made.
mod judging;
/// Helpers that read source files as text.
mod source_text;
/// Helpers that find which modules of a crate use which others.
mod modules;

/// Tests of interval contractors and pavings on problems worked out by hand.
mod contractor_by_hand;
/// Tests that try to make the contractors for rigid motions lose the truth.
mod contractor_falsification;
/// Tests of the laws that every interval contractor obeys.
mod contractor_laws;
/// Tests of every contractor on boxes that are unbounded, huge, far away or empty.
mod contractor_extremes;
/// Tests of the interval arithmetic against ITF1788, an independent collection of test cases.
mod interval_itf1788;
/// Tests of the interval arithmetic against arithmetic with many more bits.
mod interval_precision;
/// Tests of printing intervals as text and reading them.
mod interval_text;
/// Tests of the motion that wheel odometry encloses, against motion integrated in much finer steps.
mod motion_enclosure;
/// Helpers: a range camera and landmarks in three dimensions, written for these tests alone.
mod range_landmarks_setup;
/// Tests of every solver for the pose from landmarks, with some landmarks matched wrongly.
mod range_landmarks_solvers;
/// Tests of drives past landmarks that are on no map.
mod range_landmarks_drive;
/// Tests of gaps between sightings of a landmark's code, and of constraints that must not outlive the sightings that they were derived from.
mod range_landmarks_gaps;
/// Tests of point methods for landmarks without a map, and of paper 3's contractor as printed, compared with the sound interval contractors.
mod landmark_baselines;
/// Tests of the point method that computes the pose from ceiling markers for a camera whose vertical is known.
mod marker_baselines;
/// Tests of when the methods to compare with run, and of where their time is counted.
mod baselines_asked;
/// Tests of the rotation that the gyroscope encloses, against rotation integrated in much finer steps.
mod gyro_enclosure;
/// Tests of learning the gyroscope's bias and scale from turns that are known from another source.
mod gyro_errors;
/// Tests of the simulated range camera, gyroscope and people against geometry worked out by hand.
mod range_sensing;
/// Tests of whole runs that localize by landmarks that are on no map.
mod range_runs;
/// Tests of the point camera, and of maps of landmarks that one drive teaches and others use.
mod mapped_landmarks;
/// Tests of computing poses from tile joints, against a camera and a floor written for these tests alone.
mod floor_tiles_geometry;
/// Tests of computing headings from level edges of walls, against a camera written for these tests alone.
mod wall_directions_geometry;
mod wall_bearings;
mod wall_ranges;
/// Tests of the detection of straight edges and features in images of known brightness.
mod dark_vision;
/// Tests of whole runs at 0.1 lx that take the heading from level edges of walls.
mod dark_runs;
/// Tests of the motion that the flow sensor encloses, against motion integrated in much finer steps, and of wheels that provably slip.
mod flow_enclosure;
/// Tests of the point methods of paper 2: the slip decision between wheels and flow sensor, the database of wall directions, and the pose graph.
mod dark_baselines;
/// Tests of computing poses from ceiling markers, against a camera and a ceiling written for these tests alone.
mod ceiling_markers_geometry;
/// Tests of reading markers, whole and damaged, on rendered images of ceilings.
mod ceiling_pasted;
/// Tests of the calibration of a camera's lens and of its mounting position, on rendered images.
mod calibrated_drives;
mod calibration_rendered;
/// Tests of whole runs that localize by markers on the ceiling.
mod ceiling_runs;
/// Tests of histories other than the truth that keep every declared bound on the readings of a run.
mod witnessed_faults;
mod witnesses;
/// Tests of the proof that markers cover a room, against cameras and poses drawn at random.
mod marker_coverage;
/// Tests of the command `wherein markers`: the sheet that it prints and the map that it writes.
mod marker_sheet;
/// Tests of scenes whose markers must be refused, and of the error messages.
mod marker_refusals;
/// Helpers: scenes and drives that the tests of the simulated world share.
mod world_setup;
/// Tests of the tyre law against the numerical integral and the closed form of the brush model.
mod world_tyre;
/// Tests of the robot's motion at rest, straight on and in a circle against closed forms; of walls; and of distance travelled against poses.
mod world_motion;
/// Tests of wheel slip in regions of the floor, of events that change friction, and of pushes.
mod world_floor;
/// Tests of carpets, ramps, stuck wheels, lifts, snapshots and Borenstein's square path against closed forms.
mod carpet_physics;
/// Tests of whole runs that localize by wheels, gyroscope and flow sensor, and of faults in such runs.
mod carpet_runs;
/// Tests of gyroscope, flow sensor and delivery of readings against closed forms and geometry worked out by hand.
mod motion_sensors;
/// Tests of the bounds on sensors and surroundings that a careful user can know: where they apply, and that they hold the truth in six scenes.
mod careful_bounds;
/// Tests of a gyroscope whose noise is not redrawn when it exceeds its bound: how long its accumulated error stays within the declared band.
mod gyro_band;
/// Tests of a mobile base whose clock has an unknown offset: its time stamps, the estimates for true instants, and whole runs.
mod base_clock;
/// Tests of errors that are drawn anew for every reading, and of those that always push to one side (drift), against their bounds.
mod world_drifts;
/// Tests of the car as a base against closed forms: steering, slip, its rear wheels as the localizer reads them, its driver, and refused drives.
mod cars;
/// Tests of a car's errands: planned curves against geometry worked out by hand, the law that follows them, jumps of the estimate, things in the way.
mod car_errands;
/// Tests of a car with a steering encoder: what it reads, how much better the heading is known by it, blame, and refused robots.
mod steering;
/// Tests of the turn that a car can have made by its steering angle: each part by hand, and against the integral of random drives.
mod steering_enclosure;
/// Tests of routes that the robot drives by estimated poses, and of the default bounds on such a drive.
mod world_driver;
/// Tests of occupancy grids, paths through them and their files, against maps drawn by hand and the rules of ROS's map_server.
mod navigation_map;
/// Tests of errands (drives to goals): control laws worked out by hand, wrong estimates, blocked paths, and what a run reports about its errands.
mod navigation_drive;
/// Tests of the wheel encoders against the definition of a tick.
mod world_encoder;
/// Tests of errors drawn at random against their tolerances.
mod world_drawn;
/// Tests of scenes that must be refused, and of the error messages.
mod scene_refusals;
/// Tests of scenes that extend other scenes: the keys that result, what is refused, and recordings that can be replayed without the extended scene.
mod scene_extends;
/// Tests of keys that have moved: refused with their new names, and rewritten by `wherein upgrade`.
mod upgrade;
/// Tests of the key `[expect]`, which states what a run must achieve.
mod scene_expectations;
/// Tests of the command line other than refusals: exit codes, output, replay, and resuming after an interruption.
mod cli_runs;
/// Tests of the film of a run: its frames as another program's decoder shows them, and the film in the book's gallery.
mod film;
/// Tests of the files that a run writes, read back by independent code.
mod record_files;
/// Tests of rules that every scene file, the schema and the documents must obey.
mod repository;
/// Tests of the documents for people: links, tables, the length of README, and targets of make.
mod documents;
/// Tests that the commands in documents and scripts are commands of the program, with options that it has.
mod shown_commands;
/// Test that runs every command of the book's page *First hour*.
mod first_hour;
/// Tests of what a release consists of: licences, the crates' metadata, versions, citation and changelog.
mod release;
/// Tests of the floor camera's lens and rolling shutter against formulas that are written out in the tests.
mod render_floor_lens;
/// Tests of floor tiles as laid at random, against the bounds that the localizer is given.
mod render_laid_tiles;
/// Tests of the image sensor against the linear model of EMVA 1288: dark current, non-uniformities, bit depth, presets,
/// and the photon budget at 0.1 lx.
mod render_sensor;
/// Tests of grey levels and noise of rendered images against photon counts worked out by hand.
mod render_photons;
/// Tests of rendered floor points, joints and blur against a projection derived by hand.
mod render_projection;
/// Tests of the light of lamps against closed forms, of shadows against similar triangles, and of spectra against published figures.
mod light_of_lamps;
/// Tests of the light that surfaces reflect: between rooms, behind furniture, far from lamps.
mod light_reflected;
/// Tests of lamps that events switch one by one: light at the floor, reflected light, pictures and images of runs.
mod light_switched;
/// Tests of the live view of a run in a viewer that speaks Foxglove's WebSocket protocol.
mod live_view;
/// Tests of rooms rendered through lenses, against projections written for these tests alone.
mod render_room;
/// Tests of puddles: mirrored objects and lamps against the law of reflection, and the wet floor against Ångström's model.
mod render_puddles;
/// Tests of the glints of long lamps on the floor, against the lamps' mirror images below the floor.
mod render_glints;
/// Tests that further rooms and open doors are there for the robot's body, beams, landmarks and paths, not only for cameras.
mod rooms_felt;
/// Tests of rooms of any polygon: walls, beams, light and pictures, against rays and against the same rooms as rectangles.
mod polygon_rooms;
/// Tests of rooms and doors that cannot be, which are refused by the key that is wrong.
mod rooms_refused;
/// Drives whose camera that looks ahead has a rolling shutter, by what methods claim of edges in its images.
mod rolling_shutters;
/// Tests of walking people in images, row by row of a rolling shutter and at the image's border.
mod render_walkers;
/// Tests of cracks between rendered faces, and of light that defocus brings in from beyond the image's border.
mod render_gaps;
/// Tests of a ring light's illuminance on walls, people and lamps against the cosines at both ends of the ray.
mod render_ring_light;
/// Tests of scenes under the open sky: sunlight, shadows and skylight, and what is refused there.
mod outdoors;
/// Tests of satellite navigation: the receiver's positions, and drives that are localized by them.
mod gnss;
/// Tests of rendered images of rooms against images that a person has inspected.
mod golden_images;
/// Tests of the command `wherein render`.
mod cli_render;
/// Helpers that the renderer's tests share.
mod render_studio;
/// Tests of the blame when the truth is outside of a box: on records made by hand, and on runs with a planted fault.
mod blame;
/// Tests of runs in which every error is as great as its bound allows: the boxes contain the truth, and are so tight
/// that a fault that shrinks them would be noticed.
mod corner_runs;
/// Tests of doubt: what the localizer doubts, how soon, and when its box contains the truth again.
mod contradictions;
mod doubts;
/// Tests of what a new user meets first: default cameras, a hobby robot's encoders, large tiles, and scenes that leave the localizer nothing to read.
mod newcomer;
/// Tests of readings that come long after the slot (stored pose) before them, or after silent wheels, and of headings when nothing else is known.
mod slots;
/// Tests that every bound that an estimate relies on is checked against the truth, and that every checked bound is relied on.
mod bounds_watched;
/// Tests of the dependencies that are allowed between the folders of each crate.
mod structure;
/// Tests of the Kalman filter and the particle filter as subjects: what they answer, how they are judged and named.
mod estimators;
/// Tests of a user's own localizers in the simulation loop: what they are given and how they are judged.
mod subjects;
/// Tests of a localization method that is written outside of the localizer's crate.
mod own_method;
/// Tests of localizers in processes of their own: the stream that they are sent, their answers, and those that misbehave.
mod own_process;
/// Tests of the measures of a run: how much of the boxes' width the errors use, what counts as available, and what was not measured.
mod power;
/// Tests of runs whose localizer is given narrower bounds than the true ones.
mod weakened;
/// Tests of whole runs on rendered images: soundness, recovery, and identical bytes for identical seeds.
mod whole_runs;
/// Tests of recordings: read by the `mcap` crate, and replayed through the localizer.
mod recordings;
/// Tests of sweeps: every case runs once, and the result has the same bytes for any number of jobs, after an
/// interruption, and when merged from parts.
mod sweep_cases;
/// Tests of sweeps that must be refused, and of the error messages.
mod sweep_refusals;
/// Tests of a sweep's report, JUnit file and annotations against the sweep's own table.
mod sweep_report;
/// Tests of reports that are made of tables row by row, against the report of all cases.
mod sweep_sketch;
/// Tests of what reports show of a run's events and broken bounds.
mod report_incidents;
/// Tests of the ceiling markers and landmarks that figures and maps show.
mod map_beacons;
/// Tests of the result table's rows and pooled figures, of the report's measures, and of the CSV reader.
mod result_figures;
/// Tests of the command `wherein compare`: it finds planted differences and does not report chance as a difference.
mod sweep_compare;
/// Tests of the generator of random scenes: it uses every key of the schema, and most of its scenes are accepted.
mod falsify_grammar;
/// Tests of the command `wherein falsify`: it finds failures, shrinks them and can be resumed; and a minute of its search with fixed seeds.
mod falsify_search;
/// Tests of which records of runs fulfil which search goal (wish) of `wherein falsify`, on records made by hand.
mod falsify_wishes;
/// Tests of scenes that once showed a fault, each with its seeds.
mod found_scenes;
/// Tests of replaying logs that another program wrote: bags of rosbag2 by the Python package rosbags.
mod foreign_logs;
