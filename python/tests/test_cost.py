"""What Python costs: dead reckoning by a loop in Python, against the same dead reckoning in Rust (examples/own_subject)."""

import json
import os
import resource
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
HOME = REPOSITORY / "scenes" / "home.toml"
SEED, DURATION_S = 3, 20
# Greatest share by which Python may be dearer.
MOST = 0.15

RECKONING = """
import math, sys
import wherein

scene, seed, duration_s, out = sys.argv[1:]
drive = wherein.Drive(scene, int(seed), set={"duration_s": float(duration_s)}, out=out, name="reckoning")
wheels = drive.told["robot"]["wheels"]
tick_m = [sum(radius_m) / 2 * 2 * math.pi / wheels["ticks_per_turn"] for radius_m in wheels["radius_m"]]
track_m = sum(wheels["track_m"]) / 2
for step in drive:
    if step.start is not None:
        (x_m, y_m, heading_rad), before = [(low + high) / 2 for low, high in step.start], None
    for reading in step.readings:
        if reading.device == "wheels":
            ticks = reading.ticks
            left_m, right_m = [(now - then) * one for now, then, one in zip(ticks, before or ticks, tick_m)]
            before = ticks
            heading_rad += (right_m - left_m) / track_m
            x_m += (left_m + right_m) / 2 * math.cos(heading_rad)
            y_m += (left_m + right_m) / 2 * math.sin(heading_rad)
    step.answer((x_m, y_m, heading_rad))
"""


def measured(command, out):
    """Runs a command; returns its processor time in user mode in seconds, its real-time factor, and its mean error in metres."""
    before_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    ended = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    user_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before_s
    folder = out / "home" / str(SEED)
    # Dead reckoning misses the expectations of the scene, which is exit code 1 of the command.
    assert ended.returncode in (0, 1) and folder.exists(), ended.stderr
    timing, summary = (json.loads((folder / name).read_text()) for name in ("timing.json", "summary.json"))
    return user_s, timing["real_time_factor"], summary["error"]["position_m"]["mean"]


def test_python_costs_little_against_the_same_estimator_in_rust(tmp_path, capsys):
    rust = os.environ.get("OWN_SUBJECT")
    if rust is None:
        pytest.skip("OWN_SUBJECT names no program; make test-python builds examples/own_subject and names it")
    commands = {
        "Rust": [rust, "run", HOME, "--subject", "reckoning", "--seed", SEED, "--set", f"duration_s={DURATION_S}", "--out"],
        "Python": [sys.executable, "-c", RECKONING, HOME, SEED, DURATION_S],
    }
    runs = {language: [] for language in commands}
    # The runs alternate, so that other work of the machine meets both alike.
    for number in range(3):
        for language, command in commands.items():
            out = tmp_path / f"{language}{number}"
            runs[language].append(measured([*command, out], out))
    (rust_s, rust_factor, rust_m), (python_s, python_factor, python_m) = (
        [statistics.median(column) for column in zip(*of)] for of in runs.values()
    )
    with capsys.disabled():
        print(
            f"\nDead reckoning on {DURATION_S} s of home.toml, median of 3: Rust {rust_factor:.2f} times real time with {rust_s:.2f} s of "
            f"user time, Python {python_factor:.2f} times with {python_s:.2f} s: {python_s / rust_s - 1:+.1%} user time, "
            f"{rust_factor / python_factor - 1:+.1%} wall time"
        )
    # It is the same estimator: both are lost by the same way.
    assert python_m == pytest.approx(rust_m, rel=1e-3)
    # User time hardly depends on what else the machine does.
    assert python_s < (1 + MOST) * rust_s
