"""Intervals, contractors, pavings, and the interval localizer on own readings; expected values by hand."""

import math

import numpy as np
import pytest

import wherein
from wherein import CtcBox, CtcDist, CtcPolar, CtcQInter, Interval, IntervalVector, SepDist


def test_arithmetic_holds_every_result():
    third = Interval(1) / 3
    assert third.lb < third.ub and 1 / 3 in third and third.diam() < 1e-15
    difference, square = Interval(1, 2) - Interval(1, 2), Interval(-1, 2).sqr()
    assert -1 in difference and 1 in difference and difference.diam() < 2 + 1e-14
    assert 0 in square and 4 in square and square.diam() < 4 + 1e-14
    assert Interval(3, 3).hypot(4).lb <= 5 <= Interval(3).hypot(4).ub
    assert (Interval(0, 1) & Interval(2, 3)).is_empty() and (Interval(0, 1) | 3) == Interval(0, 3)
    with pytest.raises(ValueError, match="2 and 1"):
        Interval(2, 1)
    with pytest.raises(ValueError):
        Interval(math.nan)


def test_two_distances_leave_a_place():
    # 5 m from two pegs that are 6 m apart: 3 m along and 4 m away.
    room = IntervalVector([[0, 10], [0, 10]])
    both = CtcDist((0, 0), Interval.centred(5, 0.01)) & CtcDist((6, 0), Interval.centred(5, 0.01))
    assert [3, 4] in both.contract(room)
    boxes = both.pave(room, 0.01)
    low, high = boxes[:, :, 0].min(axis=0), boxes[:, :, 1].max(axis=0)
    assert (low <= [3, 4]).all() and ([3, 4] <= high).all() and (high - low < 0.1).all()
    assert CtcDist((0, 0), [20, 21]).contract(room).is_empty()


def test_a_bearing_and_a_range_leave_a_place():
    # 2 m away at 30°, seen from (1, 1).
    place = CtcPolar((1, 1), 2, Interval.centred(math.pi / 6, 1e-6)).contract(IntervalVector([[-9, 9], [-9, 9]]))
    assert [1 + math.sqrt(3), 2] in (place | place) and max(place.diam()) < 1e-4


def test_one_wrong_of_three_ranges_is_survived():
    truth, beacons = (3.0, 4.0), [(0, 0), (8, 0), (4, 6), (0, 6)]
    ranges = [Interval.centred(math.dist(truth, at), 0.05) for at in beacons]
    ranges[0] = ranges[0] + 2
    room = IntervalVector([[0, 8], [0, 6]])
    contractors = [CtcDist(at, one) for at, one in zip(beacons, ranges)]
    everything = contractors[0] & contractors[1] & contractors[2] & contractors[3]
    assert everything.contract(room).is_empty()
    boxes = CtcQInter(contractors, 1).pave(room, 0.05)
    assert ((boxes[:, :, 0] <= truth) & (truth <= boxes[:, :, 1])).all(axis=1).any()
    assert np.ptp(boxes) < 8


def test_a_paving_tells_inside_from_outside():
    ring = SepDist((0, 0), [1, 2])
    inner, outer, boundary = wherein.sivia(IntervalVector([[-3, 3], [-3, 3]]), ring, 0.1)
    area = lambda boxes: np.prod(boxes[:, :, 1] - boxes[:, :, 0], axis=1).sum()
    exact = math.pi * (4 - 1)
    assert area(inner) <= exact <= area(inner) + area(boundary)
    assert area(inner) + area(outer) + area(boundary) == pytest.approx(36)
    assert len(wherein.sivia(IntervalVector([[-3, 3], [-3, 3]]), ring & ~ring, 0.5)[0]) == 0


def test_the_localizer_holds_a_robot_with_odometry_and_beacons():
    # The robot drives straight ahead along x from (1, 2) at 0.25 m/s, and every second measures its distance from two beacons, each within 5 cm.
    beacons = [(4, 5), (7, 0)]
    beacon = lambda numbers: CtcDist((numbers[0], numbers[1]), Interval.centred(numbers[2], 0.05))
    localizer = wherein.Localizer(
        IntervalVector([[0, 8], [0, 6]]),
        IntervalVector([[0.8, 1.2], [1.8, 2.2], [-0.1, 0.1]]),
        track_m=Interval.centred(0.4, 0.001),
        devices={"beacon": beacon},
    )
    widths = []
    for step in range(1, 801):
        time_s = step / 100
        x_m = 1 + 0.25 * time_s
        assert localizer.observe(wherein.WheelsReading.of_odometry(time_s, (x_m - 1, x_m - 1))) is None
        if step % 100 == 0:
            for at in beacons:
                localizer.observe(wherein.OtherReading(time_s, "beacon", [*at, math.dist(at, (x_m, 2))]))
            union = localizer.estimate_at(time_s)
            assert [x_m, 2.0, 0.0] in union
            widths.append(union.hull[1].diam())
    # Without beacons the start's 0.4 m could only grow.
    assert widths[-1] < 0.4 and [x_m, 2.5, 0.0] not in union and not union.recovering and union.boxes.shape[1:] == (3, 2)


def test_an_exception_of_a_device_reaches_whoever_gives_the_reading():
    def device(numbers):
        raise ZeroDivisionError("no range")

    localizer = wherein.Localizer(
        IntervalVector([[0, 8], [0, 6]]), IntervalVector([[1, 1], [1, 1], [0, 0]]), track_m=0.4, devices={"beacon": device}
    )
    localizer.observe(wherein.WheelsReading.of_odometry(0.01, (0, 0)))
    with pytest.raises(ZeroDivisionError, match="no range"):
        localizer.observe(wherein.OtherReading(0.01, "beacon", [1.0]))
