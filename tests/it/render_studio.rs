//! Helpers that the renderer's tests share: a scene with an ideally mounted camera, one renderer for the process, and whole runs with all their
//! images.

use std::{
    ops::{Deref, DerefMut},
    sync::Mutex,
    thread,
};

use image::GrayImage;
use localizer::Pose;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};
use sim::{
    devices::camera::{DrawnCamera, world_from_camera},
    judge::Verdict,
    optics::{Exposure, Lens},
    render::{NoiseKey, Renderer, Shows, View},
    run::{FramesPolicy, RunOptions, RunRecord, run},
    scene::{CameraKeys, Scene},
    subject::IntervalLocalizer,
    truth::Truth,
    world::Drawn,
};

use crate::judging::verdict_of;

/// A room with even light, the errors drawn for its scene, and a floor camera that is mounted as the test wants it.
pub(crate) struct Studio {
    pub(crate) scene: Scene,
    pub(crate) drawn: Drawn,
    pub(crate) mount: FloorMount,
}

/// A floor camera as the test mounts it.
#[derive(Clone, Copy)]
pub(crate) struct FloorMount {
    /// Position of the optical centre forward and left of the robot's origin.
    pub(crate) position_m: [f64; 2],
    /// Height of the optical centre above the floor at rest.
    pub(crate) height_m: f64,
    pub(crate) focal_px: f64,
    /// Rotation of the image about the body's vertical, counter-clockwise seen from above.
    pub(crate) yaw_rad: f64,
    /// Rotation vector, about robot x and robot y, by which the optical axis deviates from the body's vertical.
    pub(crate) tilt_rad: [f64; 2],
    pub(crate) distortion: [f64; 5],
}

impl FloorMount {
    /// The same camera as the simulator describes cameras: image right is robot right (−y), image down is robot backward (−x), ahead is down (−z).
    pub(crate) fn camera(&self) -> DrawnCamera {
        let [forward_m, left_m] = self.position_m;
        let [about_x_rad, about_y_rad] = self.tilt_rad;
        let down = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0));
        let attitude = Rotation3::from_scaled_axis(vector![about_x_rad, about_y_rad, 0.0])
            * Rotation3::from_axis_angle(&Vector3::z_axis(), self.yaw_rad)
            * down;
        DrawnCamera {
            body_from_camera: Isometry3::from_parts(
                Translation3::new(forward_m, left_m, self.height_m),
                UnitQuaternion::from_rotation_matrix(&attitude),
            ),
            focal_px: [self.focal_px; 2],
            principal_point_px: [319.5, 239.5],
            distortion: self.distortion,
        }
    }
}

impl Studio {
    /// A square room of this width, lit evenly by 300 lx unless `more` says otherwise; `more` is appended to the scene's text.
    pub(crate) fn new(width_m: f64, more: &str) -> Studio {
        let light = if more.contains("[light]") { "" } else { "[light]\nunevenness_ratio = 1.0" };
        let middle_m = width_m / 2.0;
        let text = format!(
            "duration_s = 1.0
            [room]\nwidth_m = {width_m:?}\ndepth_m = {width_m:?}
            [start]\nx_m = {middle_m:?}\ny_m = {middle_m:?}\nheading_deg = 0
            [[route.waypoint]]\nx_m = {middle_m:?}\ny_m = {middle_m:?}\nspeed_m_per_s = 0.1
            {light}\n{more}"
        );
        let scene = Scene::parse(&text, "studio.toml").unwrap();
        let drawn = Drawn::draw(&scene, 1);
        let camera = scene.robot.floor_camera.as_ref().unwrap();
        // The floor camera's 640 px cover 0.48 m of the floor, seen from 0.25 m above: one pixel is 0.75 mm.
        let focal_px = 0.25 * 640.0 / 0.48;
        assert_eq!((camera.height_m, camera.footprint_width_m), (0.25, 0.48));
        let mount = FloorMount {
            position_m: [-0.15, 0.0],
            height_m: 0.25,
            focal_px,
            yaw_rad: 0.0,
            tilt_rad: [0.0, 0.0],
            distortion: camera.lens.distortion,
        };
        Studio { scene, drawn, mount }
    }

    /// A view from the poses that the robot takes during an exposure of 10 ms, in light that gives a tile of albedo 0.55 some 110 levels.
    pub(crate) fn view(&self, truths: &[Truth], image: u32) -> View {
        let camera = self.scene.robot.floor_camera.as_ref().unwrap();
        View {
            shows: Shows::Floor,
            sensor: camera.sensor_model(),
            world_from_camera: self.poses(truths),
            exposure_s: 0.01,
            gain_levels_per_electron: 0.025,
            illuminance_at_floor_lux: self.scene.light.illuminance_at_floor_lux,
            noise: NoiseKey { seed: 5, image },
            lens: Lens::of(camera, &self.mount.camera()),
        }
    }

    /// A view whose noise is a fifth of a grey level: the full well holds a million electrons, and there is no read noise.
    pub(crate) fn quiet_view(&self, truths: &[Truth]) -> View {
        let mut view = self.view(truths, 0);
        view.sensor.full_well_electrons = 1e6;
        view.sensor.read_noise_electrons = 0.0;
        view.exposure_s = 1.0;
        view.gain_levels_per_electron = 0.025 / 100.0;
        view
    }

    pub(crate) fn draw(&self, view: View) -> GrayImage {
        let mut renderer = renderer();
        let world = renderer.upload(&self.scene, &self.drawn).unwrap();
        renderer.draw(&world, &[view]).unwrap().remove(0)
    }

    fn poses(&self, truths: &[Truth]) -> Vec<Isometry3<f64>> {
        truths.iter().map(|truth| world_from_camera(truth, &self.mount.camera())).collect()
    }

    /// Image of a floor point by trigonometry alone, written from the frames' definitions and not from the simulator's code.
    ///
    /// From world to body the transform undoes heading, then pitch, then roll; from body to mount it undoes tilt, then yaw. For a camera that
    /// looks down, image right is robot right (−y) and image down is robot backward (−x).
    pub(crate) fn project(&self, truth: &Truth, [x, y]: [f64; 2]) -> [f64; 2] {
        let [roll, pitch] = truth.tilt_rad;
        let (dx, dy, dz) = (x - truth.pose.x_m, y - truth.pose.y_m, -truth.heave_m);
        let (sin, cos) = truth.pose.heading_rad.sin_cos();
        let (dx, dy) = (cos * dx + sin * dy, -sin * dx + cos * dy);
        let (dx, dz) = (pitch.cos() * dx - pitch.sin() * dz, pitch.sin() * dx + pitch.cos() * dz);
        let (dy, dz) = (roll.cos() * dy + roll.sin() * dz, -roll.sin() * dy + roll.cos() * dz);
        let [forward, left] = self.mount.position_m;
        let p = [dx - forward, dy - left, dz - self.mount.height_m];
        let p = rotated(p, [-self.mount.tilt_rad[0], -self.mount.tilt_rad[1], 0.0]);
        let (sin, cos) = self.mount.yaw_rad.sin_cos();
        let (px, py) = (cos * p[0] + sin * p[1], -sin * p[0] + cos * p[1]);
        let depth = -p[2];
        // The principal point is the middle of the image of 640 × 480 pixels, (319.5, 239.5).
        [319.5 + self.mount.focal_px * -py / depth, 239.5 + self.mount.focal_px * -px / depth]
    }
}

/// Renderers that no test uses at the moment.
static IDLE: Mutex<Vec<Renderer>> = Mutex::new(Vec::new());

/// A renderer that one test uses. Afterwards it serves another test, unless the test failed.
pub(crate) struct Lent(Option<Renderer>);

/// A renderer for one test: an idle one, or a new one where tests in other threads use all that there are.
pub(crate) fn renderer() -> Lent {
    let idle = IDLE.lock().unwrap().pop();
    Lent(Some(idle.unwrap_or_else(|| Renderer::new().unwrap())))
}

impl Deref for Lent {
    type Target = Renderer;

    fn deref(&self) -> &Renderer {
        self.0.as_ref().unwrap()
    }
}

impl DerefMut for Lent {
    fn deref_mut(&mut self) -> &mut Renderer {
        self.0.as_mut().unwrap()
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if !thread::panicking() {
            IDLE.lock().unwrap().extend(self.0.take());
        }
    }
}

/// True state of a robot at rest.
pub(crate) fn standing(x_m: f64, y_m: f64, heading_rad: f64) -> Truth {
    Truth { pose: Pose { x_m, y_m, heading_rad }, ..Truth::default() }
}

/// The same view with the exposure time and gain that auto-exposure chose.
pub(crate) fn exposed(mut view: View, exposure: Exposure) -> View {
    view.exposure_s = exposure.exposure_s;
    view.gain_levels_per_electron = exposure.gain_levels_per_electron;
    view
}

/// Rodrigues' formula: p·cos a + (n × p)·sin a + n·(n·p)·(1 − cos a) for the rotation vector a·n.
fn rotated(p: [f64; 3], vector: [f64; 3]) -> [f64; 3] {
    let angle = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    if angle == 0.0 {
        return p;
    }
    let n = vector.map(|v| v / angle);
    let cross = [n[1] * p[2] - n[2] * p[1], n[2] * p[0] - n[0] * p[2], n[0] * p[1] - n[1] * p[0]];
    let dot = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
    [0, 1, 2].map(|k| p[k] * angle.cos() + cross[k] * angle.sin() + n[k] * dot * (1.0 - angle.cos()))
}

/// Simulates a run with all its images, and judges it.
pub(crate) fn judged(scene: &Scene, seed: u64) -> (RunRecord, Verdict) {
    let options = RunOptions { keep_images: FramesPolicy::All, baselines: true };
    let record =
        run(scene, seed, &mut IntervalLocalizer::of(scene), Some(&mut renderer()), &options, &mut |_| {}).unwrap();
    let verdict = verdict_of(scene, &record);
    (record, verdict)
}
