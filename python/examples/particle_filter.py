"""A particle filter of x, y and heading drives a robot on its errands: python python/examples/particle_filter.py scenes/home.toml"""

import sys
from collections import deque

import numpy as np

import wherein


class ParticleFilter:
    N = 1000  # particles

    def __init__(self, told):
        # `cues` tells what images say, by the vision of the built-in filters
        wheels, self.gyro, self.cues = told["robot"]["wheels"], told["robot"]["gyro"], told["cues"]
        self.tick_m = np.mean(wheels["radius_m"], axis=1) * 2 * np.pi / wheels["ticks_per_turn"]
        self.slip = np.array([wheels["slip_ratio"], wheels["side_slip_ratio"]]) / 3 + 0.002
        self.track_m, self.bias_sd = np.mean(wheels["track_m"]), np.ptp(self.gyro["bias_rad_per_s"]) / 6 if self.gyro else 0.0
        self.random = np.random.default_rng(1)  # equal runs give equal answers

    def start(self, box):
        self.poses = self.random.uniform(box[:, 0], box[:, 1], (self.N, 3))
        self.weights = np.full(self.N, 1 / self.N)
        self.ticks, self.stamp_s, self.turn_rad = None, 0.0, 0.0
        self.past = deque([(0.0, np.zeros(3))], maxlen=200)  # odometry of the last two seconds, for images that arrive late
        self.gone = np.zeros(3)

    def observe(self, reading):
        if reading.device == "gyro":
            rate = (reading.rate_rad_per_s - np.mean(self.gyro["bias_rad_per_s"])) / np.mean(self.gyro["scale"])
            self.turn_rad, self.stamp_s = self.turn_rad + rate * (reading.measured_s - self.stamp_s), reading.measured_s
        if reading.device == "wheels":
            self.roll(np.array(reading.ticks), reading.measured_s)
        for cue in self.cues.read(reading):
            self.weigh(cue)

    def roll(self, ticks, time_s):
        left_m, right_m = self.tick_m * (ticks - (ticks if self.ticks is None else self.ticks))
        ahead_m, span_s, turn_rad = (left_m + right_m) / 2, time_s - self.past[-1][0], self.turn_rad
        self.ticks, self.turn_rad, turn_rad2 = ticks, 0.0, 10 * self.bias_sd**2 * span_s
        if not self.gyro:  # the wheels tell the turn, each with its slip
            turn_rad, turn_rad2 = (right_m - left_m) / self.track_m, (self.slip[0] / self.track_m) ** 2 * (abs(left_m) + abs(right_m))
        slipped = self.random.normal(size=(self.N, 2)) * self.slip * np.sqrt(abs(ahead_m))  # as declared after 1 m
        drifted = self.random.normal(size=self.N) * np.sqrt(turn_rad2 + 1e-9)
        self.poses = moved(self.poses, ahead_m + slipped[:, 0], slipped[:, 1], turn_rad + drifted)
        self.gone = moved(self.gone[None], ahead_m, 0.0, turn_rad)[0]
        self.past.append((time_s, self.gone))

    def weigh(self, cue):
        mean, covariance = self.moments()
        then = min(self.past, key=lambda entry: abs(entry[0] - cue.measured_s))[1]
        turned = mean[2] - self.gone[2]  # from the frame of odometry to the world
        c, s = np.cos(turned), np.sin(turned)
        back = np.append(np.array([[c, -s], [s, c]]) @ (then - self.gone)[:2], then[2] - self.gone[2])
        compared = cue.compare(mean + back, covariance)
        if compared is None:
            return
        residual, H, R = compared
        noise = R + 0.25 * H @ covariance @ H.T  # a cue that is far sharper than the cloud would leave a single particle
        if residual @ np.linalg.solve(R + H @ covariance @ H.T, residual) > 25:  # an outlier of five standard deviations
            return
        off = residual - (self.poses - mean) @ H.T
        self.weights *= np.exp(-0.5 * np.sum(off * np.linalg.solve(noise, off.T).T, axis=1)) + 1e-12
        self.weights /= self.weights.sum()
        if 1 / np.sum(self.weights**2) < self.N / 2:
            at = (np.arange(self.N) + self.random.uniform()) / self.N
            self.poses = self.poses[np.searchsorted(np.cumsum(self.weights), at).clip(max=self.N - 1)]
            self.weights = np.full(self.N, 1 / self.N)
            self.poses += self.random.multivariate_normal(np.zeros(3), 0.01 * self.moments()[1], self.N)

    def moments(self):
        mean = self.weights @ self.poses
        off = self.poses - mean
        return mean, (off.T * self.weights) @ off + 1e-12 * np.eye(3)

    def answer(self, time_s):
        return {"samples": np.column_stack([self.poses, self.weights])}


def moved(poses, ahead_m, left_m, turn_rad):
    direction = poses[:, 2] + turn_rad / 2
    c, s = np.cos(direction), np.sin(direction)
    return poses + np.stack([ahead_m * c - left_m * s, ahead_m * s + left_m * c, turn_rad + 0 * c], axis=1)


if __name__ == "__main__":
    drive = wherein.Drive(sys.argv[1], seed=3, name="particle_filter.py", out="renders")
    particles = ParticleFilter(drive.told)
    for step in drive:
        if step.start is not None:
            particles.start(step.start)
        for reading in step.readings:
            particles.observe(reading)
        step.answer_samples(particles.poses, particles.weights)
    print(drive.result, drive.result.summary["error"]["position_m"])
