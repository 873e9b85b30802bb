//! Dead reckoning by wheels as a localizer of one's own: `cargo run -p own-subject -- run scenes/gnss.toml --subject reckoning`.
use localizer::{Pose, PoseBox, Reading, robot::WheelModel};
use sim::{cli, subject};

struct Reckoning {
    wheels: WheelModel,
    pose: Pose,
    ticks: Option<[i64; 2]>,
}

impl subject::Subject for Reckoning {
    fn name(&self) -> &str {
        "reckoning"
    }

    fn start(&mut self, start: &PoseBox) {
        (self.pose, self.ticks) =
            (Pose { x_m: start[0].mid(), y_m: start[1].mid(), heading_rad: start[2].mid() }, None);
    }

    fn observe(&mut self, reading: &Reading) {
        let Reading::Wheels { ticks, .. } = reading else { return };
        let before = self.ticks.replace(*ticks).unwrap_or(*ticks);
        let rolled_m = |wheel| (ticks[wheel] - before[wheel]) as f64 * self.wheels.metres_per_tick(wheel).mid();
        self.pose.heading_rad += (rolled_m(1) - rolled_m(0)) / self.wheels.track_m.mid();
        self.pose.x_m += (rolled_m(0) + rolled_m(1)) / 2.0 * self.pose.heading_rad.cos();
        self.pose.y_m += (rolled_m(0) + rolled_m(1)) / 2.0 * self.pose.heading_rad.sin();
    }

    fn estimate_at(&self, _time_s: f64) -> subject::Answer {
        subject::Answer::Point(self.pose)
    }
}

fn main() -> std::process::ExitCode {
    subject::add_subject("reckoning", |scene| {
        Box::new(Reckoning { wheels: scene.robot_model().wheels, pose: Pose::default(), ticks: None })
    });
    cli::main()
}
