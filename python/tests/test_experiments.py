"""Runs, sweeps, reports and comparisons."""

import sys
from pathlib import Path

import pytest

import wherein

SCENES = Path(__file__).parents[2] / "scenes"
PLAIN = SCENES / "gnss.toml"


class Still:
    """Answers with the middle of the box in which the drive starts."""

    def __init__(self, told):
        assert set(told) == {"protocol", "map", "robot", "cues"}

    def start(self, box):
        self.mean = box.mean(axis=1)

    def observe(self, reading):
        self.newest = reading

    def answer(self, time_s):
        assert self.newest.arrived_s <= time_s + 1e-9
        return self.mean


class Telling(Still):
    def answer(self, time_s):
        return {"mean": self.mean, "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "newest_s": time_s - 0.02}


class Broken(Still):
    def answer(self, time_s):
        if time_s > 0.5:
            raise ZeroDivisionError("the filter diverged")
        return self.mean


def test_runs_give_a_row_for_each_seed(tmp_path):
    frame = wherein.run(PLAIN, seeds=range(2, 4), subject="ekf", set={"duration_s": 3.0}, out=tmp_path)
    assert list(frame["seed"]) == [2, 3] and list(frame["subject"]) == ["ekf", "ekf"]
    assert (frame["error.position_m.mean"] < 1.0).all()
    assert all((Path(folder) / "summary.json").exists() for folder in frame["folder"])


def test_other_methods_run_when_they_are_asked_for(tmp_path):
    scene = SCENES / "papers" / "rigid_transform_wrong_matches.toml"
    for asked in (False, True):
        frame = wherein.run(scene, set={"duration_s": 3.0}, out=tmp_path / str(asked), baselines=asked)
        assert ("baselines.ransac.error.x_m.rmse" in frame) == asked


def test_a_class_can_be_the_localizer_under_test(tmp_path):
    frame = wherein.run(PLAIN, subject=Still, set={"duration_s": 2.0}, out=tmp_path)
    assert list(frame["subject"]) == ["Still"] and list(frame["scene"]) == ["gnss"]


def test_a_class_may_tell_the_newest_reading_that_its_answers_use(tmp_path):
    frame = wherein.run(PLAIN, subject=Telling, set={"duration_s": 2.0}, out=tmp_path)
    assert frame["latency_s.mean"][0] == pytest.approx(0.02)


@pytest.mark.parametrize(
    "given, said",
    [
        ({"mean": [0, 0, 0], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "pose": [0, 0, 0]}, "pose and mean"),
        ({"pose": [0, 0, 0], "colour": 1}, "`colour`: unknown key"),
        ({"boxes": [[[0, 1], [0, 1], [0, 1]]], "status": "recoverin"}, 'expected "sound" or "recovering"'),
        ({"boxes": [[[0, 1], [0, 1], [0, 1]]], "relies_on": 7}, "expected a list of names"),
    ],
)
def test_a_dict_that_is_no_answer_is_a_failure_that_says_why(given, said, tmp_path):
    class Given(Still):
        def answer(self, time_s):
            return given

    frame = wherein.run(PLAIN, subject=Given, set={"duration_s": 1.0}, out=tmp_path)
    assert not frame["passed"][0] and said in frame["missed_expectations"][0]


def test_a_report_leaves_junit(tmp_path):
    wherein.run(PLAIN, seeds=range(2), subject="ekf", set={"duration_s": 1.0}, out=tmp_path)
    wherein.report(tmp_path, junit=tmp_path / "junit.xml")
    assert 'tests="2"' in (tmp_path / "junit.xml").read_text()


def test_an_exception_of_a_class_is_its_failure_with_the_traceback_beside_the_results(tmp_path):
    frame = wherein.run(PLAIN, subject=Broken, set={"duration_s": 2.0}, out=tmp_path)
    assert not frame["passed"][0] and "the filter diverged" in frame["missed_expectations"][0]
    assert "ZeroDivisionError" in (Path(frame["folder"][0]) / "subject.log").read_text()


def test_sweeps_go_on_where_they_stopped_and_can_be_compared(tmp_path):
    vary = {"duration_s": [1.0, 2.0]}
    one = wherein.sweep(PLAIN, vary, seeds=2, out=tmp_path / "a", jobs=2)
    again = wherein.sweep(PLAIN, vary, seeds=range(2, 3), out=tmp_path / "a")
    assert len(one) == 2 and list(one["digest.estimates"]) == list(again["digest.estimates"])
    assert list(one["set.duration_s"]) == [1.0, 2.0]
    assert (tmp_path / "a" / "report.html").exists()
    wherein.sweep(PLAIN, vary, seeds=2, out=tmp_path / "b")
    comparison = wherein.compare(tmp_path / "a", tmp_path / "b")
    assert not comparison.is_worse and (comparison.table["first"] == comparison.table["second"]).all()
    assert str(comparison)


@pytest.mark.parametrize(
    "arguments, said",
    [
        ({"seeds": range(3, 3)}, "seeds"),
        ({"subject": "ekff"}, "no such localizer"),
        ({"subject": 3}, "expected a name, a command or a class"),
        ({"frames": "some"}, "frames"),
    ],
)
def test_wrong_arguments_are_refused(arguments, said, tmp_path):
    with pytest.raises(ValueError, match=said):
        wherein.run(PLAIN, out=tmp_path, **arguments)
    assert list(tmp_path.iterdir()) == []


def test_without_pandas_and_polars_a_frame_is_a_list_of_rows(monkeypatch):
    for package in ("pandas", "polars"):
        monkeypatch.setitem(sys.modules, package, None)
    from wherein.experiments import frame

    assert frame({"a": [1, 2], "b": [3, 4]}) == [{"a": 1, "b": 3}, {"a": 2, "b": 4}]
