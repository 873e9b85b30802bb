"""The examples: two filters that drive errands, three ranges, the notebook, and what the package's page shows."""

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import wherein

EXAMPLES = Path(__file__).parents[1] / "examples"
HOME = Path(__file__).parents[2] / "scenes" / "home.toml"


@pytest.mark.parametrize("name, most", [("ekf", 60), ("particle_filter", 80), ("three_ranges", 15)])
def test_examples_are_short(name, most):
    lines = (EXAMPLES / f"{name}.py").read_text().splitlines()
    assert len([line for line in lines if line.strip()]) <= most


def test_the_kalman_filter_runs_all_errands_and_its_report_opens(tmp_path):
    subprocess.run([sys.executable, EXAMPLES / "ekf.py", HOME], cwd=tmp_path, check=True)
    report = (tmp_path / "renders" / "report.html").read_text()
    assert report.startswith("<!DOCTYPE html>") and "ekf.py" in report
    figures = wherein.report(tmp_path / "renders").iloc[0]
    assert figures["metrics.goals_reached"] == figures["metrics.errands"] == 5 and figures["metrics.collisions"] == 0
    # The built-in filters of the same readings are within 1 cm on average; a filter that used no image would be off by decimetres.
    assert figures["error.position_m.mean"] < 0.03


def test_the_particle_filter_knows_where_it_is(tmp_path):
    subject = runpy.run_path(str(EXAMPLES / "particle_filter.py"))["ParticleFilter"]
    figures = wherein.run(HOME, seeds=3, subject=subject, set={"duration_s": 30}, out=tmp_path).iloc[0]
    assert figures["subject"] == "ParticleFilter" and figures["error.position_m.mean"] < 0.03


@pytest.mark.parametrize("name, of_class", [("ekf", "Ekf"), ("particle_filter", "ParticleFilter")])
def test_without_a_gyroscope_the_wheels_tell_the_turn(name, of_class, tmp_path):
    subject = runpy.run_path(str(EXAMPLES / f"{name}.py"))[of_class]
    # Without the camera nothing else does, and after half a lap a filter that did not turn would be off by metres.
    options = {"duration_s": 10, "robot.floor_camera": False}
    figures = wherein.run(HOME.with_name("tiles.toml"), seeds=3, subject=subject, set=options, out=tmp_path).iloc[0]
    assert figures["error.position_m.max"] < 0.1 and figures["distribution.nees.mean"] < 6


def test_three_ranges_print_a_place():
    printed = subprocess.run([sys.executable, EXAMPLES / "three_ranges.py"], check=True, capture_output=True, text=True)
    # The true place, (4, 3), is 5 m, 5 m and 3 m from the beacons.
    assert "one may be wrong" in printed.stdout and "[3.8" in printed.stdout


def test_what_the_page_of_the_package_shows_runs_anywhere(tmp_path):
    page = (EXAMPLES.parent / "README.md").read_text()
    example = page.split("```python\n")[1].split("```")[0]
    printed = subprocess.run([sys.executable, "-c", example], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert printed.stdout.startswith("<DriveResult of room seed 3: passed")


def test_the_notebook_runs(monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    from nbclient import NotebookClient

    monkeypatch.setenv("DURATION_S", "6")
    notebook = nbformat.read(EXAMPLES / "compare.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    drawn = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs if "data" in output]
    assert "image/png" in drawn[-1]["data"] and "image/png" in drawn[-2]["data"]
