"""Drives step by step."""

import gc
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

import wherein

SCENES = Path(__file__).parents[2] / "scenes"
# A robot with wheels and satellite navigation, without a camera.
PLAIN = SCENES / "gnss.toml"
SHORT = {"duration_s": 2.0}
COVARIANCE = np.diag([0.01, 0.01, 0.001])


def answered(drive):
    """Drives with the middle of the start box as every answer."""
    for step in drive:
        if step.start is not None:
            mean = step.start.mean(axis=1)
        step.answer(mean, COVARIANCE)
    return drive.result


def test_a_drive_has_a_step_for_every_10_ms_and_readings_in_the_order_of_arrival():
    times, arrivals, devices = [], [], set()
    drive = wherein.Drive(PLAIN, set=SHORT)
    assert drive.start.shape == (3, 2) and (drive.start[:, 0] <= drive.start[:, 1]).all()
    for step in drive:
        times.append(step.time_s)
        for reading in step.readings:
            arrivals.append(reading.arrived_s)
            devices.add(reading.device)
            assert reading.arrived_s <= step.time_s + 1e-9
        step.answer(drive.start.mean(axis=1), COVARIANCE)
    assert np.allclose(np.diff(times), 0.01) and times[0] == 0.0
    assert arrivals == sorted(arrivals) and {"wheels", "gnss"} <= devices


def test_the_truth_comes_only_after_the_drive():
    drive = wherein.Drive(PLAIN, set=SHORT)
    with pytest.raises(wherein.WhereinError, match="after the last step"):
        drive.result
    for step in drive:
        step.answer([0, 0, 0])
        with pytest.raises(wherein.WhereinError, match="after the last step"):
            drive.result
        assert not any("truth" in name for name in dir(step) + dir(drive))
    result = drive.result
    assert result.truth.shape[1] == 4 and len(result.truth) == len(result.estimate)
    assert (result.estimate[:, 1:] == 0).all()
    assert result.hulls.shape == (len(result.truth), 3, 2)
    assert result._repr_png_()[:4] == b"\x89PNG"


def test_the_same_answers_give_the_same_drive_and_another_seed_another():
    one, two, three = (answered(wherein.Drive(PLAIN, seed, set=SHORT)) for seed in (1, 1, 2))
    assert one.summary["digest"] == two.summary["digest"]
    assert one.summary["digest"]["readings"] != three.summary["digest"]["readings"]


@pytest.mark.parametrize(
    "given, said",
    [
        (lambda step: step.answer([0, 0]), r"mean: expected numbers of shape \(3,\)"),
        (lambda step: step.answer([0, 0, np.nan]), "expected finite numbers"),
        (lambda step: step.answer(np.zeros(3), np.zeros((2, 2))), r"shape \(3, 3\), found shape \(2, 2\)"),
        (lambda step: step.answer(np.zeros(3), np.diag([1, 1, -1])), "negative eigenvalue"),
        (lambda step: step.answer_samples(np.zeros((4, 3)), np.zeros(4)), "add up to 0"),
        (lambda step: step.answer_samples(np.zeros((4, 3)), np.ones(3)), "expected 4"),
        (lambda step: step.answer_boxes([[[1, 0], [0, 1], [0, 1]]]), r"\[1, 0\]"),
        (lambda step: step.answer_boxes([[0, 1], [0, 1], [0, 1]], relies_on=["luck"]), "luck"),
    ],
)
def test_a_wrong_answer_is_refused_where_it_is_given(given, said):
    with wherein.Drive(PLAIN, set=SHORT) as drive:
        step = next(iter(drive))
        with pytest.raises(wherein.AnswerError, match=said):
            given(step)


def test_an_answer_of_another_kind_than_those_before_is_refused():
    with wherein.Drive(PLAIN, set=SHORT) as drive:
        next(drive).answer_boxes([[0, 20], [0, 20], [0, 6]])
        with pytest.raises(wherein.AnswerError, match="a pose without bounds after boxes, expected one kind"):
            next(drive).answer([0, 0, 0])


def test_a_result_says_whether_its_answers_were_overconfident():
    drive = wherein.Drive(PLAIN, set=SHORT)
    for step in drive:
        step.answer([100, 100, 0], COVARIANCE)
    assert "overconfident: truth in its 95 % regions at" in repr(drive.result) and "at 0.0 % of steps" in repr(drive.result)


def test_a_step_that_is_not_answered_ends_the_drive():
    drive = wherein.Drive(PLAIN, set=SHORT)
    steps = iter(drive)
    next(steps)
    with pytest.raises(wherein.AnswerError, match="0.00 s was not answered"):
        next(steps)
    with pytest.raises(wherein.WhereinError, match="no result"):
        drive.result


def test_the_age_of_answers_is_counted_from_the_newest_reading_that_they_use():
    drive = wherein.Drive(PLAIN, set=SHORT)
    for step in drive:
        step.answer(drive.start.mean(axis=1), COVARIANCE, newest_s=step.time_s - 0.03)
        with pytest.raises(wherein.AnswerError, match="newest_s NaN, expected the stamp"):
            step.answer([0, 0, 0], newest_s=np.nan)
        with pytest.raises(wherein.AnswerError, match="newest_s 1700000000"):
            step.answer_samples([[0, 0, 0]], newest_s=1.7e9)
    latency_s = drive.result.summary["latency_s"]
    assert latency_s["mean"] == pytest.approx(0.03) and latency_s["max"] == pytest.approx(0.03)
    assert answered(wherein.Drive(PLAIN, set=SHORT)).summary["latency_s"] is None


def test_an_answer_to_a_past_step_is_refused():
    with wherein.Drive(PLAIN, set=SHORT) as drive:
        first = next(drive)
        first.answer([0, 0, 0])
        next(drive)
        with pytest.raises(wherein.AnswerError, match="is over"):
            first.answer([0, 0, 0])


def test_leaving_a_drive_early_leaves_no_file_and_no_thread(tmp_path):
    before = threading.active_count(), native_threads()
    for leave in ("break", "exception", "with", "drop"):
        out = tmp_path / leave
        drive = wherein.Drive(PLAIN, set=SHORT, out=out)
        try:
            if leave == "with":
                with drive:
                    next(drive)
            for step in drive if leave != "with" else []:
                if leave == "exception":
                    raise ZeroDivisionError
                break
        except ZeroDivisionError:
            pass
        if leave != "drop":
            drive.close()
        del drive, leave
        step = None
        gc.collect()
        assert list(out.rglob("*.json")) == [] and list(out.rglob("*.*")) == []
    assert (threading.active_count(), native_threads()) == before


def native_threads():
    tasks = Path("/proc/self/task")
    return len(list(tasks.iterdir())) if tasks.exists() else 0


def test_a_drive_leaves_the_files_of_a_run_and_its_report_can_be_written(tmp_path):
    result = answered(wherein.Drive(PLAIN, 5, set=SHORT, out=tmp_path, name="still"))
    folder = tmp_path / "gnss" / "5"
    assert {"summary.json", "timing.json", "truth.tum", "estimate.tum", "steps.csv"} <= {p.name for p in folder.iterdir()}
    assert len(wherein.report(tmp_path)) == 1
    report = (tmp_path / "report.html").read_text()
    assert "still" in report
    # No command can start a loop of a program in Python again: the report says what can.
    assert "--subject still" not in report and "the localizer still lives in a program of its own" in report
    assert "duration_s=2 and seed 5" in report or "duration_s=2.0 and seed 5" in report
    assert result.save(tmp_path / "again") == tmp_path / "again" / "gnss" / "5"
    assert (tmp_path / "again/gnss/5/summary.json").read_bytes() == (folder / "summary.json").read_bytes()


def test_a_scene_that_is_refused_names_file_key_and_value(tmp_path):
    with pytest.raises(wherein.SceneError, match="no_such.toml"):
        wherein.Drive(tmp_path / "no_such.toml")
    with pytest.raises(wherein.SceneError, match="duration"):
        wherein.Drive(PLAIN, set={"duraton_s": 1})
    bad = tmp_path / "bad.toml"
    bad.write_text('description = "x"\nduration_s = "long"\n')
    with pytest.raises(wherein.SceneError, match=r"(?s)bad.toml.*duration_s"):
        wherein.Drive(bad)


def test_an_interrupt_reaches_a_loop_that_waits_for_a_step():
    with wherein.Drive(PLAIN, set={"duration_s": 600}) as drive:
        threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            for step in drive:
                step.answer([0, 0, 0])


def test_boxes_that_lose_the_truth_count_as_unsound():
    drive = wherein.Drive(PLAIN, set=SHORT)
    for step in drive:
        step.answer_boxes([[100, 101], [100, 101], [0, 1]])
    containment = drive.result.summary["containment"]
    assert containment["contained"] == 0 and containment["unsound"] == containment["checks"]


def test_images_reach_numpy_without_a_copy():
    """One camera image of 640 × 480: numpy's pointer is that of the simulator's own image."""
    found = None
    with wherein.Drive(SCENES / "home.toml", set={"duration_s": 1.0}) as drive:
        for step in drive:
            step.answer(drive.start.mean(axis=1))
            images = [one for one in step.readings if isinstance(one, wherein.ImageReading)]
            found = next((one for one in images if one.pixels.shape == (480, 640)), found)
            if found is not None:
                break
    assert found is not None
    pixels = found.pixels
    assert pixels.dtype == np.uint8 and pixels.shape == (480, 640)
    assert pixels.ctypes.data == found.address == found.pixels.ctypes.data
    assert not pixels.flags.owndata and not pixels.flags.writeable
    with pytest.raises(ValueError):
        pixels[0, 0] = 0
    levels = pixels.copy()
    del found, drive, images, step
    gc.collect()
    assert (pixels == levels).all() and pixels.std() > 0
