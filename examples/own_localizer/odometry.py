#!/usr/bin/env python3
"""Dead reckoning with a covariance, from wheels and gyroscope: a localizer in a process of its own.

    wherein run scenes/home.toml --subject 'python3 examples/own_localizer/odometry.py'
"""

import json
import math
import struct
import sys


def messages(stream):
    """Yields topic and data of each message of an MCAP stream (https://mcap.dev/spec), until it ends."""
    stream.read(8)  # the magic bytes
    topics = {}
    while len(head := stream.read(9)) == 9:
        kind, length = struct.unpack("<BQ", head)
        record = stream.read(length)
        if kind == 4:  # a channel: its number, that of its schema, its topic
            channel, _, size = struct.unpack_from("<HHI", record)
            topics[channel] = record[8 : 8 + size].decode()
        elif kind == 5:  # a message: its channel, 20 bytes of numbers and times, its data
            yield topics[struct.unpack_from("<H", record)[0]], record[22:]


def middle(interval):
    return (interval[0] + interval[1]) / 2


def deviation(interval):
    """Standard deviation for a value of which bounds are known: they are taken for 3σ."""
    return (interval[1] - interval[0]) / 6


class Odometry:
    def __init__(self, robot):
        wheels, self.gyro = robot["wheels"], robot["gyro"]
        self.radius_m = [middle(radius) for radius in wheels["radius_m"]]
        self.radius_share = deviation(wheels["radius_m"][0]) / self.radius_m[0]
        self.track_m = middle(wheels["track_m"])
        self.track_share = deviation(wheels["track_m"]) / self.track_m
        self.turn_rad = 2 * math.pi / wheels["ticks_per_turn"]
        self.slip_ratio, self.side_slip_ratio = wheels["slip_ratio"] / 3, wheels["side_slip_ratio"] / 3

    def start(self, box):
        self.mean = [middle(side) for side in box]
        self.covariance = [[0.0, 0.0, 0.0] for _ in range(3)]
        for axis in range(3):
            self.covariance[axis][axis] = deviation(box[axis]) ** 2
        self.ticks, self.stamp_s, self.gyro_turn_rad, self.gyro_span_s = None, 0.0, 0.0, 0.0

    def turn(self, reading):
        """Adds the turn since the gyroscope's reading before."""
        span_s, self.stamp_s = reading["measured_s"] - self.stamp_s, reading["measured_s"]
        rate_rad_per_s = (reading["rate_rad_per_s"] - middle(self.gyro["bias_rad_per_s"])) / middle(self.gyro["scale"])
        self.gyro_turn_rad += span_s * rate_rad_per_s
        self.gyro_span_s += span_s

    def roll(self, ticks):
        """Moves on by the ticks since the wheels' reading before."""
        before, self.ticks = self.ticks or ticks, ticks
        left_m, right_m = (
            radius_m * self.turn_rad * (now - then) for radius_m, now, then in zip(self.radius_m, ticks, before)
        )
        ahead_m, turn_rad = (left_m + right_m) / 2, (right_m - left_m) / self.track_m
        turn_sd_rad = abs(turn_rad) * self.track_share + (abs(left_m) + abs(right_m)) * self.radius_share / self.track_m
        turn_sd_rad += abs(ahead_m) * self.slip_ratio / self.track_m
        if self.gyro_span_s > 0.0:
            turn_rad, turn_sd_rad = self.gyro_turn_rad, self.gyro_span_s * deviation(self.gyro["bias_rad_per_s"])
            turn_sd_rad += abs(turn_rad) * deviation(self.gyro["scale"])
            self.gyro_turn_rad, self.gyro_span_s = 0.0, 0.0
        direction_rad = self.mean[2] + turn_rad / 2
        cos, sin = math.cos(direction_rad), math.sin(direction_rad)
        step = [ahead_m * cos, ahead_m * sin, turn_rad]
        self.mean = [value + change for value, change in zip(self.mean, step)]
        # P ← J·P·Jᵀ + Q, with J = ∂(pose after)/∂(pose before). The errors last, so that deviations are added.
        self.covariance = carried(self.covariance, [[1, 0, -step[1]], [0, 1, step[0]], [0, 0, 1]])
        ahead_sd_m = abs(ahead_m) * (self.radius_share + self.slip_ratio)
        side_sd_m = abs(ahead_m) * self.side_slip_ratio
        sd = [abs(cos) * ahead_sd_m + abs(sin) * side_sd_m, abs(sin) * ahead_sd_m + abs(cos) * side_sd_m, turn_sd_rad]
        for axis in range(3):
            self.covariance[axis][axis] += sd[axis] * (2 * math.sqrt(self.covariance[axis][axis]) + sd[axis])


def carried(covariance, jacobian):
    """The product J·P·Jᵀ."""
    product = [[sum(row[k] * covariance[k][c] for k in range(3)) for c in range(3)] for row in jacobian]
    return [[sum(row[k] * other[k] for k in range(3)) for other in jacobian] for row in product]


def main():
    odometry = None
    for topic, data in messages(sys.stdin.buffer):
        if topic == "/wherein/pixels":  # raw bytes; everything else is JSON
            continue
        message = json.loads(data)
        if topic == "/wherein/setup":
            odometry = Odometry(message["robot"])
        elif topic == "/wherein/start":
            odometry.start(message["box"])
        elif topic == "/wherein/gyro":
            odometry.turn(message)
        elif topic == "/wherein/wheels":
            odometry.roll(message["ticks"])
        elif topic == "/wherein/ask":
            answer = {"time_s": message["time_s"], "mean": odometry.mean, "covariance": odometry.covariance}
            print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
