"""Runs, sweeps, reports and comparisons, with tables as data frames."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Callable, Union

from . import _native

PathLike = Union[str, "os.PathLike[str]"]
Subject = Union[str, Callable[[dict], Any]]


def frame(columns: Mapping[str, list]) -> Any:
    """The columns as a pandas data frame, else as a polars data frame, else, where neither is installed, as a list of dicts."""
    try:
        import pandas

        return pandas.DataFrame(dict(columns))
    except ImportError:
        pass
    try:
        import polars

        return polars.DataFrame(dict(columns), strict=False)
    except ImportError:
        return [dict(zip(columns, row)) for row in zip(*columns.values())]


def run(
    scenes: PathLike | Sequence[PathLike],
    *,
    seeds: int | range | str = 0,
    subject: Subject | None = None,
    set: Mapping[str, Any] | None = None,
    out: PathLike = "renders",
    frames: str = "none",
    adapter: str | None = None,
    baselines: bool = False,
) -> Any:
    """Runs scenes, or every scene below a folder, as `wherein run` does. Returns a frame with one row for each run.

    seeds: a seed, a range of seeds, or a text such as "0..10".
    subject: the localizer under test: a name such as "ekf", a command, or a class. A class is called with what the localizer is told (a dict of `map`,
        `robot` and `cues`) and has the methods start(box), observe(reading) and answer(time_s), which returns a pair of mean and covariance, a pose,
        or a dict with `samples`, `boxes`, `pose`, or `mean` and `covariance`; a dict may also have `newest_s`, the stamp of the newest reading that
        the answer takes into account. Without a subject, the interval localizer runs.
    set: keys of the scenes to set, such as {"duration_s": 30}.
    out: folder for the results; each run leaves OUT/<scene>/<seed>/ as the command does.
    frames: images for which debug frames are written: "none", "failures", "every=N" or "all".
    adapter: graphics adapter, by a part of its name.
    baselines: whether other methods are run on the same readings, too, to compare with; otherwise odometry alone is.
    """
    paths = [scenes] if isinstance(scenes, (str, os.PathLike)) else list(scenes)
    return frame(_native.run_scenes([os.fspath(path) for path in paths], seeds, subject, set, os.fspath(out), frames, adapter, baselines))


def sweep(
    scene: PathLike,
    vary: Mapping[str, Sequence[Any] | str],
    *,
    seeds: int | range | str = 0,
    subject: Subject | None = None,
    out: PathLike | None = None,
    jobs: int | None = None,
    frames: str = "none",
    adapter: str | None = None,
    baselines: bool = False,
) -> Any:
    """Runs a scene with every combination of the values of some keys, as `wherein sweep` does. Returns a frame with one row for each case.

    vary: values by key, such as {"light.illuminance_at_floor_lux": [1, 10, 100]}, or a text as the command has it, such as "0.1..0.8/8".
    seeds, subject, frames, adapter, baselines: as for `run`.
    out: folder for the results and their report, by default sweeps/<scene>. Cases that are recorded there already do not run again, unless the
        localizer under test is a command or a class, which may have changed.
    jobs: number of runs at the same time, by default as many as there are processor cores.
    """
    folder = None if out is None else os.fspath(out)
    return frame(_native.run_sweep(os.fspath(scene), dict(vary), seeds, subject, folder, jobs, frames, adapter, baselines))


def report(folder: PathLike, *, junit: PathLike | None = None) -> Any:
    """Writes report.html, summary.md and results.csv of a folder of results, as `wherein report` does. Returns a frame with one row for each run.

    junit: file for the results as JUnit XML, which CI systems show: one test for each run.
    """
    return frame(_native.report_folder(os.fspath(folder), None if junit is None else os.fspath(junit)))


class Comparison:
    """Whether a second set of results is better or worse than a first one.

    table: a frame with one row for each compared quantity: its means, the confidence interval of the difference, and the finding.
    is_worse: whether the second set is worse in anything.
    """

    def __init__(self, table: Any, text: str, is_worse: bool) -> None:
        self.table = table
        self.is_worse = is_worse
        self._text = text

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<Comparison: {'worse' if self.is_worse else 'not worse'}>"

    def _repr_html_(self) -> str | None:
        to_html = getattr(self.table, "_repr_html_", None)
        return to_html() if to_html else None


def compare(first: PathLike, second: PathLike, *, confidence: float = 0.99, tolerance: float = 0.1) -> Comparison:
    """Compares two folders of results, or files results.csv, case by case, as `wherein compare` does.

    confidence: that with which all intervals hold together.
    tolerance: greatest worsening that may stay unseen, as a share of the first set's mean.
    """
    columns, text, is_worse = _native.compare_results(os.fspath(first), os.fspath(second), confidence, tolerance)
    return Comparison(frame(columns), text, is_worse)


def picture(result: _native.DriveResult) -> Any:
    """The map of a drive as a PIL image, or where Pillow is not installed, as the bytes of a PNG file."""
    png = result.map_png()
    try:
        import io

        from PIL import Image

        return Image.open(io.BytesIO(png))
    except ImportError:
        return png
