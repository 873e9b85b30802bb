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

from . import _native  # noqa: E402
from ._native import (  # noqa: E402
    AnswerError,
    Ctc,
    CtcBox,
    CtcDist,
    CtcInter,
    CtcPolar,
    CtcQInter,
    CtcUnion,
    Cue,
    Cues,
    Drive,
    DriveResult,
    FlowReading,
    GyroReading,
    ImageReading,
    Interval,
    IntervalVector,
    Localizer,
    OtherReading,
    PoseUnion,
    RangeReading,
    Reading,
    RunError,
    SceneError,
    Sep,
    SepDist,
    Step,
    WheelsReading,
    WhereinError,
    __version__,
    sivia,
)
from .experiments import Comparison, compare, picture, report, run, sweep  # noqa: E402

_native.be_library(_native.__file__)

__all__ = [
    "AnswerError",
    "Comparison",
    "Ctc",
    "CtcBox",
    "CtcDist",
    "CtcInter",
    "CtcPolar",
    "CtcQInter",
    "CtcUnion",
    "Cue",
    "Cues",
    "Drive",
    "DriveResult",
    "FlowReading",
    "GyroReading",
    "ImageReading",
    "Interval",
    "IntervalVector",
    "Localizer",
    "OtherReading",
    "PoseUnion",
    "RangeReading",
    "Reading",
    "RunError",
    "SceneError",
    "Sep",
    "SepDist",
    "Step",
    "WheelsReading",
    "WhereinError",
    "compare",
    "picture",
    "report",
    "run",
    "sivia",
    "sweep",
]
