"""Interrupts by Ctrl-C reach the program at once, and leave no thread behind and no file half-written."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import wherein

SCENES = Path(__file__).parents[2] / "scenes"
PLAIN = SCENES / "gnss.toml"

# Interrupts itself as Ctrl-C does, from the localizer under test in the midst of a run, and then ends as a program ends.
PROGRAM = """
import os, signal, sys, time
import wherein

class Slow:
    interrupted = False

    def __init__(self, told):
        pass

    def start(self, box):
        self.mean = box.mean(axis=1)

    def observe(self, reading):
        pass

    def answer(self, time_s):
        if time_s > 0.2 and not Slow.interrupted:
            Slow.interrupted = True
            os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        return self.mean

scene, out, how = sys.argv[1:]
tasks = lambda: len(os.listdir("/proc/self/task")) if os.path.exists("/proc/self/task") else 0
before = tasks()
try:
    if how == "run":
        wherein.run(scene, seeds=range(4), subject=Slow, out=out)
    else:
        wherein.sweep(scene, {"duration_s": [30, 40]}, seeds=range(4), subject=Slow, out=out, jobs=2)
except KeyboardInterrupt:
    time.sleep(0.2)  # a thread that has been joined may be listed a moment longer
    print("interrupted with", tasks() - before, "threads left")
"""


@pytest.mark.parametrize("how", ["run", "sweep"])
def test_an_interrupted_run_of_a_class_ends_its_threads_before_the_program_goes_on(how, tmp_path):
    began = time.monotonic()
    ended = subprocess.run(
        [sys.executable, "-c", PROGRAM, PLAIN, tmp_path, how], capture_output=True, text=True, timeout=100
    )
    # A thread that still called Python while the program ends would abort it.
    assert (ended.returncode, ended.stdout) == (0, "interrupted with 0 threads left\n"), ended.stderr
    assert list(tmp_path.rglob("summary.json")) == [] and list(tmp_path.rglob("*.html")) == []
    # Without an early end the four runs of a minute, each with 6000 answers, take four minutes.
    assert time.monotonic() - began < 60


def test_an_interrupted_run_of_a_built_in_localizer_ends_early(tmp_path):
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        wherein.run(PLAIN, seeds=range(100), subject="ekf", out=tmp_path)
    assert time.monotonic() - began < 30
    # What is recorded is recorded completely.
    for folder in tmp_path.glob("gnss/*"):
        assert (folder / "summary.json").exists() and (folder / "steps.csv").exists()


@pytest.mark.parametrize("what", [KeyboardInterrupt, SystemExit])
def test_what_is_no_error_of_a_localizer_ends_all_runs(what, tmp_path):
    class Ending:
        runs = 0

        def __init__(self, told):
            Ending.runs += 1

        def start(self, box):
            pass

        def observe(self, reading):
            pass

        def answer(self, time_s):
            raise what(3)

    with pytest.raises(what):
        wherein.run(PLAIN, seeds=range(3), subject=Ending, set={"duration_s": 1.0}, out=tmp_path)
    assert Ending.runs == 1 and list(tmp_path.rglob("summary.json")) == []


@pytest.mark.parametrize("how", ["pave", "sivia"])
def test_an_interrupt_ends_a_paving(how):
    room = wherein.IntervalVector([[-5, 5], [-5, 5]])
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    # To this resolution a paving of a ring would take minutes, and more memory than there is.
    with pytest.raises(KeyboardInterrupt):
        if how == "pave":
            wherein.CtcDist((0, 0), [1, 2]).pave(room, 1e-7)
        else:
            wherein.sivia(room, wherein.SepDist((0, 0), [1, 2]), 1e-7)
    assert time.monotonic() - began < 10
