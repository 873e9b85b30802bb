"""Sweeps on a Ray cluster of nodes on this machine: wherein.ray, called by scripts/ray_sweep without the package.

The environment variable WHEREIN names the program, by default that of the last build.
"""

import importlib.machinery
import importlib.util
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import time

import pytest

pytest.importorskip("ray.cluster_utils", reason="the Python package ray is not installed")

ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = os.path.abspath(os.environ.get("WHEREIN", ROOT / "target/debug/wherein"))
SCRIPT = ROOT / "scripts/ray_sweep"
# Blind, so that a run of 1 s takes a tenth of a second; the longer ones take a second, which leaves time to stop or kill something.
SCENE, LONG = "scenes/gnss.toml", ["--vary", "duration_s=80", "--seeds", "0..6"]

if not os.path.exists(PROGRAM):
    pytest.skip(f"found no program {PROGRAM}", allow_module_level=True)


def load(name, path):
    """Returns a file of the repository as a module of this name."""
    loader = importlib.machinery.SourceFileLoader(name, str(ROOT / path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    sys.modules[name] = module
    loader.exec_module(module)
    return module


trial = load("ray_trial", "scripts/ray_trial")


@pytest.fixture(scope="module")
def cluster():
    """Three nodes of one core; tests that kill one start another."""
    with trial.LocalCluster(3) as cluster:
        yield cluster


def alone(out, *options):
    """Runs a sweep by the program itself, and returns its folder."""
    subprocess.run([PROGRAM, "sweep", SCENE, *options, "--out", out], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return out


def start(cluster, out, *options, scene=SCENE):
    """Starts a sweep on the cluster, and returns its process."""
    command = [sys.executable, SCRIPT, scene, *options, "--out", out, "--address", cluster.address]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen([*command, "--program", PROGRAM], cwd=ROOT, text=True, **pipes)


def finish(running):
    """Waits for a sweep, and returns its exit code and what it said."""
    out, said = running.communicate(timeout=240)
    return running.returncode, out + said


def wait_for(what, limit_s=60):
    """Waits until `what` returns something true."""
    end = time.monotonic() + limit_s
    while not what():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.02)


def test_a_cluster_leaves_the_bytes_of_one_machine(cluster, tmp_path):
    varied = ["--vary", "duration_s=1,2", "--seeds", "0..4"]
    code, said = finish(start(cluster, tmp_path / "shared", *varied))
    assert code == 0, said
    assert trial.differences(alone(tmp_path / "alone", *varied), tmp_path / "shared") == []


def test_shards_of_several_cases_leave_the_same_bytes(cluster, tmp_path):
    varied = ["--vary", "duration_s=1,2", "--seeds", "0..5"]
    code, said = finish(start(cluster, tmp_path / "shared", *varied, "--cases-per-task", "4"))
    assert code == 0, said
    assert trial.differences(alone(tmp_path / "alone", *varied), tmp_path / "shared") == []


def test_recorded_cases_do_not_run_again_and_damaged_ones_do(cluster, tmp_path):
    varied = ["--vary", "duration_s=1", "--seeds", "0..4"]
    folder = alone(tmp_path / "shared", *varied)
    before = {case: (case / "timing.json").read_bytes() for case in (folder / "cases").iterdir()}
    damaged = min(before)
    (damaged / "steps.csv").write_text("damaged")
    code, said = finish(start(cluster, folder, *varied))
    assert code == 0 and "1 case run" in said and "3 recorded earlier" in said, said
    assert all((case / "timing.json").read_bytes() == timing for case, timing in before.items() if case != damaged)
    assert trial.differences(alone(tmp_path / "alone", *varied), folder) == []


def test_a_killed_driver_goes_on_where_it_stopped(cluster, tmp_path):
    running = start(cluster, tmp_path / "shared", *LONG)
    wait_for(lambda: trial.n_recorded(tmp_path / "shared") >= 2)
    running.send_signal(signal.SIGKILL)
    running.communicate()
    code, said = finish(start(cluster, tmp_path / "shared", *LONG))
    assert code == 0 and " 0 recorded earlier" not in said, said
    assert trial.differences(alone(tmp_path / "alone", *LONG), tmp_path / "shared") == []


def test_the_report_of_a_sweep_that_runs_names_the_missing_cases(cluster, tmp_path):
    running = start(cluster, tmp_path / "shared", *LONG)
    wait_for(lambda: trial.n_recorded(tmp_path / "shared") >= 1)
    partial = subprocess.run([PROGRAM, "report", tmp_path / "shared"], stdout=subprocess.DEVNULL)
    rows = (tmp_path / "shared/results.csv").read_text()
    assert partial.returncode == 2 and ",done," in rows and ",missing," in rows
    assert finish(running)[0] == 0


def test_cases_of_a_killed_node_run_elsewhere(tmp_path):
    with trial.LocalCluster(3) as cluster:
        running = start(cluster, tmp_path / "shared", *LONG)
        wait_for(cluster.kill_node)
        code, said = finish(running)
    assert code == 0 and "is run again: its node or worker died" in said, said
    assert trial.differences(alone(tmp_path / "alone", *LONG), tmp_path / "shared") == []


def test_a_stopped_worker_loses_its_case_to_another(cluster, tmp_path):
    running = start(cluster, tmp_path / "shared", *LONG, "--case-timeout-s", "15")
    wait_for(trial.stop_worker)
    code, said = finish(running)
    assert code == 0 and "did not answer" in said, said
    assert trial.differences(alone(tmp_path / "alone", *LONG), tmp_path / "shared") == []


def test_a_case_over_its_limit_is_tried_again_and_then_given_up(cluster, tmp_path):
    options = ["--vary", "duration_s=1,3000", "--case-timeout-s", "4", "--retries", "1"]
    code, said = finish(start(cluster, tmp_path / "shared", *options))
    assert code == 2 and "is run again: it took longer than 4 s" in said and "in 2 attempts" in said, said
    rows = (tmp_path / "shared/results.csv").read_text()
    assert rows.count(",done,") == 1 and rows.count(",missing,") == 1


def test_a_wrong_scene_is_refused_in_the_words_of_the_program_before_a_cluster_is_sought(cluster, tmp_path):
    said = subprocess.run(
        [PROGRAM, "sweep", SCENE, "--vary", "floor.frictoin=1", "--out", tmp_path],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    cluster = type("Nowhere", (), {"address": "nowhere:1"})
    assert finish(start(cluster, tmp_path, "--vary", "floor.frictoin=1")) == (2, said.stderr)


def test_files_that_a_scene_extends_and_names_travel(cluster, tmp_path):
    folder = tmp_path / "elsewhere" / "scenes"
    folder.mkdir(parents=True)
    (folder / "base.toml").write_text((ROOT / SCENE).read_text())
    (folder / "short.toml").write_text('extends = "base.toml"\nduration_s = 1\n')
    code, said = finish(start(cluster, tmp_path / "shared", scene=str(folder / "short.toml")))
    assert code == 0, said


def test_the_options_of_a_sweep_reach_the_cases_and_the_report(cluster, tmp_path):
    options = ["--vary", "duration_s=1,2", "--seeds", "1..3", "--subject", "ekf", "--baselines", "--frames", "all"]
    options += ["--columns", "error,nees"]
    alone(tmp_path / "alone", *options, "--junit", tmp_path / "alone.xml")
    shared = ["--junit", tmp_path / "shared.xml", "--jobs", "1"]
    code, said = finish(start(cluster, tmp_path / "shared", *options, *shared))
    assert code == 0 and "4 cases run" in said, said
    # The report tells how long a filter's readings took.
    assert set(trial.differences(tmp_path / "alone", tmp_path / "shared")) <= {"report.html", "summary.md"}
    texts = [(tmp_path / f"{name}.xml").read_text() for name in ("alone", "shared")]
    tests = [re.findall("<testcase [^>]*name=[^ ]*", text) for text in texts]
    assert len(tests[0]) == 4 and tests[0] == tests[1]
    summaries = [(tmp_path / name / "summary.md").read_text() for name in ("alone", "shared")]
    assert "| duration_s | passed | error, mm | NEES, mean |" in summaries[0]
    rows = [re.findall(r"^\|.*", summary, re.M)[:4] for summary in summaries]
    assert len(rows[0]) == 4 and rows[0] == rows[1]


def test_the_module_of_the_package_is_the_script(tmp_path):
    pytest.importorskip("wherein", reason="the package is not installed")
    script, module = (
        subprocess.run([sys.executable, *how, "--help"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
        for how in ([SCRIPT], ["-m", "wherein.ray"])
    )
    assert script == module and "usage: wherein.ray" in script


def test_what_is_shipped_and_what_a_command_names_travels(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    for name in ("filter.py", "data/noise.json", "data/map.json", "other.py"):
        (tmp_path / name).write_text(name)
    sweep = load("wherein_ray", "python/wherein/ray.py")
    asked = [str(ROOT / SCENE), "--subject", "python3 filter.py", "--ship", "data"]
    files = sweep.travelling(sweep.options().parse_args(asked))
    mine = {path: content for path, (_, content) in files.items() if path.startswith(str(tmp_path))}
    assert mine == {f"{tmp_path}/{name}": name.encode() for name in ("filter.py", "data/noise.json", "data/map.json")}
    # A sweep file's command runs in the present folder, wherever that file is.
    (tmp_path / "sweeps").mkdir()
    (tmp_path / "sweeps/sweep.toml").write_text(f'scene = "{ROOT / SCENE}"\nsubject = "python3 filter.py"\n')
    files = sweep.travelling(sweep.options().parse_args(["sweeps/sweep.toml"]))
    assert f"{tmp_path}/filter.py" in files
    with pytest.raises(sweep.Refused, match="failed to read .*nowhere"):
        sweep.travelling(sweep.options().parse_args([str(ROOT / SCENE), "--ship", "nowhere"]))


def test_folders_of_killed_workers_are_deleted(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    sweep = load("wherein_ray", "python/wherein/ray.py")
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    left, used = (sweep.node_folder() / f"shard-{pid}-x" for pid in (ended.pid, os.getpid()))
    left.mkdir()
    used.mkdir()
    with sweep.shard_folder() as folder:
        assert os.path.isdir(folder) and used.exists() and not left.exists()
    assert not os.path.exists(folder)


def test_an_address_at_which_nothing_listens_is_refused_at_once(tmp_path, monkeypatch):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    monkeypatch.setenv("RAY_ADDRESS", f"127.0.0.1:{port}")
    for address in (f"127.0.0.1:{port}", f"ray://127.0.0.1:{port}", "auto"):
        began = time.monotonic()
        nowhere = type("Nowhere", (), {"address": address})
        code, said = finish(start(nowhere, tmp_path / "none", "--vary", "duration_s=1"))
        assert code == 2 and "failed to connect to a Ray cluster at " in said and "Warning" not in said, said
        assert str(port) in said, said
        assert time.monotonic() - began < 30 and not (tmp_path / "none").exists()


def test_hidden_files_of_others_are_left_alone_and_no_number_is_no_limit(cluster, tmp_path):
    (tmp_path / "shared/cases").mkdir(parents=True)
    hidden = tmp_path / "shared/cases/.nfs0001"
    hidden.write_text("of the file system")
    options = ["--vary", "duration_s=1", "--junit", tmp_path / "new/folder/junit.xml"]
    code, said = finish(start(cluster, tmp_path / "shared", *options))
    assert code == 0 and hidden.exists() and (tmp_path / "new/folder/junit.xml").exists(), said
    code, said = finish(start(cluster, tmp_path / "other", "--case-timeout-s", "nan"))
    assert code == 2 and "--case-timeout-s: expected at least" in said, said


def test_two_drivers_do_not_write_into_one_folder(cluster, tmp_path):
    running = start(cluster, tmp_path / "shared", *LONG)
    wait_for(lambda: (tmp_path / "shared/sweep.json").exists())
    code, said = finish(start(cluster, tmp_path / "shared", *LONG))
    assert code == 2 and f"process {running.pid} is sweeping into it" in said, said
    assert finish(running)[0] == 0
