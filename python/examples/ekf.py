"""An extended Kalman filter of x, y and heading drives a robot on its errands: python python/examples/ekf.py scenes/home.toml"""

import sys
from collections import deque

import numpy as np

import wherein


class Ekf:
    def __init__(self, told):
        wheels, self.gyro, self.cues = told["robot"]["wheels"], told["robot"]["gyro"], told["cues"]
        self.tick_m = np.mean(wheels["radius_m"], axis=1) * 2 * np.pi / wheels["ticks_per_turn"]
        self.slip = np.array([wheels["slip_ratio"], wheels["side_slip_ratio"]]) / 3 + 0.002
        self.track_m, self.bias_sd = np.mean(wheels["track_m"]), np.ptp(self.gyro["bias_rad_per_s"]) / 6 if self.gyro else 0.0

    def start(self, box):
        self.mean, self.covariance = box.mean(axis=1), np.diag((np.ptp(box, axis=1) / 6) ** 2)
        self.ticks, self.stamp_s, self.turn_rad = None, 0.0, 0.0
        self.past = deque([(0.0, self.mean.copy())], maxlen=200)  # the last two seconds, for images that arrive late

    def observe(self, reading):
        if reading.device == "gyro":
            rate = (reading.rate_rad_per_s - np.mean(self.gyro["bias_rad_per_s"])) / np.mean(self.gyro["scale"])
            self.turn_rad, self.stamp_s = self.turn_rad + rate * (reading.measured_s - self.stamp_s), reading.measured_s
        if reading.device == "wheels":
            self.roll(np.array(reading.ticks), reading.measured_s)
        for cue in self.cues.read(reading):
            self.correct(cue)

    def roll(self, ticks, time_s):
        left_m, right_m = self.tick_m * (ticks - (ticks if self.ticks is None else self.ticks))
        self.ticks, ahead_m, span_s = ticks, (left_m + right_m) / 2, time_s - self.past[-1][0]
        turn_rad, turn_rad2, self.turn_rad = self.turn_rad, 10 * self.bias_sd**2 * span_s, 0.0
        if not self.gyro:  # the wheels tell the turn, each with its slip
            turn_rad, turn_rad2 = (right_m - left_m) / self.track_m, (self.slip[0] / self.track_m) ** 2 * (abs(left_m) + abs(right_m))
        c, s = np.cos(self.mean[2] + turn_rad / 2), np.sin(self.mean[2] + turn_rad / 2)
        self.mean = self.mean + [ahead_m * c, ahead_m * s, turn_rad]
        F = np.array([[1, 0, -ahead_m * s], [0, 1, ahead_m * c], [0, 0, 1]])
        G = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])  # slip after 1 m and bias for 10 s are as declared
        Q = np.diag([*(self.slip**2 * abs(ahead_m)), turn_rad2 + 1e-9])
        self.covariance = F @ self.covariance @ F.T + G @ Q @ G.T
        self.past.append((time_s, self.mean.copy()))

    def correct(self, cue):
        then = min(self.past, key=lambda entry: abs(entry[0] - cue.measured_s))[1]
        if (compared := cue.compare(then, self.covariance)) is None:
            return
        residual, H, R = compared
        S = H @ self.covariance @ H.T + R
        if residual @ np.linalg.solve(S, residual) > 25:  # an outlier of five standard deviations
            return
        gain = np.linalg.solve(S, H @ self.covariance).T
        self.mean, self.covariance = self.mean + gain @ residual, (np.eye(3) - gain @ H) @ self.covariance
        self.past = deque(((at, pose + gain @ residual) for at, pose in self.past), maxlen=200)

    def answer(self, time_s):
        return self.mean, (self.covariance + self.covariance.T) / 2


if __name__ == "__main__":
    drive = wherein.Drive(sys.argv[1], seed=3, name="ekf.py", out="renders")
    ekf = Ekf(drive.told)
    for step in drive:
        if step.start is not None:
            ekf.start(step.start)
        for reading in step.readings:
            ekf.observe(reading)
        step.answer(*ekf.answer(step.time_s))
    wherein.report("renders")  # renders/report.html
    print(drive.result, drive.result.summary["error"]["position_m"])
