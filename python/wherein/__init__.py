"""A physics-simulated testbed for indoor robot localization.

    drive = wherein.Drive("scenes/home.toml", seed=3)
    for step in drive:
        for reading in step.readings:
            ...
        step.answer(mean, covariance)
    drive.result.summary

Lengths are in metres, angles in radians, times in seconds. The frame `world` has x and y along two walls of the room and z up; the frame `robot` has
x forward, y left and z up. Headings are counter-clockwise from world x.
"""

import os as _os

# Keeps Mesa's device selection layer from asking for a display, which a headless machine does not have.
_os.environ.setdefault("NODEVICE_SELECT", "1")

from ._native import (  # noqa: E402
    AnswerError,
    Cue,
    Cues,
    Drive,
    DriveResult,
    FlowReading,
    GyroReading,
    ImageReading,
    OtherReading,
    RangeReading,
    Reading,
    RunError,
    SceneError,
    Step,
    WheelsReading,
    WhereinError,
)

__all__ = [
    "AnswerError",
    "Cue",
    "Cues",
    "Drive",
    "DriveResult",
    "FlowReading",
    "GyroReading",
    "ImageReading",
    "OtherReading",
    "RangeReading",
    "Reading",
    "RunError",
    "SceneError",
    "Step",
    "WheelsReading",
    "WhereinError",
]
