"""Intervals, contractors, pavings, and the interval localizer on own readings; expected values by hand."""

import math
from pathlib import Path

import numpy as np
import pytest

import wherein
from wherein import Ctc, CtcBox, CtcDist, CtcInter, CtcPolar, CtcQInter, CtcUnion, Interval, IntervalVector, SepDist


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


def near(found, low, high):
    """Whether an interval holds all of [low, high] and hardly more."""
    return found.lb <= low and high <= found.ub and found.diam() < high - low + 1e-12


def test_functions_hold_every_value_and_hardly_more():
    third, half = math.pi / 3, math.pi / 2
    assert near(Interval(0, 1).exp(), 1, math.e) and near(Interval(1, math.e).log(), 0, 1)
    assert near(Interval(-1, 4).sqrt(), 0, 2) and Interval(-4, -1).sqrt().is_empty()
    assert Interval(-4, 0).log().is_empty()
    assert near(Interval(0, math.pi / 4).tan(), 0, 1) and near(Interval(-1, 1).atan(), -math.pi / 4, math.pi / 4)
    assert near(Interval(0, 1).asin(), 0, half) and near(Interval(0.5, 1).acos(), 0, third)
    # Directions of (1, 1) and of (−1, 1), at 45° and 135°, and a box across the cut.
    assert near(Interval(1).atan2(Interval(-1, 1)), math.pi / 4, 3 * math.pi / 4)
    assert near(Interval(-1, 1).atan2(-1), -math.pi, math.pi)
    assert near(abs(Interval(-1, 2)), 0, 2) and near(abs(Interval(-3, -2)), 2, 3)
    assert near(Interval(-2, 3) ** 2, 0, 9) and near(Interval(-2, 3) ** 3, -8, 27)
    assert near(Interval(2, 4) ** -1, 0.25, 0.5) and Interval(2, 4) ** 0 == Interval(1)
    with pytest.raises(TypeError):
        Interval(2, 4) ** 0.5


def test_intervals_can_be_compared_and_taken_apart():
    one = Interval(-3, 1)
    assert (one.mid(), one.mag(), one.mig()) == (-1, 3, 0) and 2 <= one.rad() < 2 + 1e-14
    assert one.is_subset(Interval(-3, 2)) and not one.is_subset([-2, 2]) and Interval.empty().is_subset(one)
    assert near(one.inflate(0.5), -3.5, 1.5) and one.bisect() == (Interval(-3, -1), Interval(-1, 1))
    assert {Interval(0, 1), Interval(-0.0, 1), Interval(0, 2)} == {Interval(0, 1), Interval(0, 2)}
    for wrong in (lambda: one.inflate(-1), lambda: one.inflate(math.nan), Interval(1).bisect, Interval.empty().bisect):
        with pytest.raises(ValueError, match="expected"):
            wrong()


def test_boxes_are_equal_by_what_they_hold():
    box, same = IntervalVector([[0, 1], [2, 3]]), IntervalVector(np.array([[0, 1], [2, 3]]))
    assert box == same and not box != same and hash(box) == hash(same)
    assert box != IntervalVector([[0, 1], [2, 4]]) and box != IntervalVector([[0, 1]]) and box != 3
    empty = box & [[5, 6], [2, 3]]
    assert empty.is_empty() and empty == (box & [[0, 1], [7, 8]]) and hash(empty) == hash(box & [[0, 1], [7, 8]])


def test_components_of_boxes_are_counted_as_those_of_lists_are():
    box = IntervalVector([[0, 1], [2, 3]])
    assert (box[0], box[1], box[-1], box[-2]) == (Interval(0, 1), Interval(2, 3), Interval(2, 3), Interval(0, 1))
    assert list(box) == [Interval(0, 1), Interval(2, 3)]
    for beyond in (2, -3):
        with pytest.raises(IndexError, match=f"found {beyond}"):
            box[beyond]


def test_boxes_can_be_computed_with():
    box = IntervalVector([[0, 1], [2, 6]])
    assert near((box + [1, [-1, 1]])[0], 1, 2) and near((box + [1, [-1, 1]])[1], 1, 7)
    assert near((box - box)[1], -4, 4)
    assert box & [[0.5, 2], [0, 3]] == IntervalVector([[0.5, 1], [2, 3]])
    assert box | [[0.5, 2], [0, 3]] == IntervalVector([[0, 2], [0, 6]])
    assert 4 <= box.max_diam() < 4 + 1e-14 and box.rad()[0] == pytest.approx(0.5)
    assert near(box.inflate(1)[0], -1, 2) and near(box.inflate(1)[1], 1, 7)
    assert box.bisect() == (IntervalVector([[0, 1], [2, 4]]), IntervalVector([[0, 1], [4, 6]]))
    assert box.bisect(0) == box.bisect(-2) == (IntervalVector([[0, 0.5], [2, 6]]), IntervalVector([[0.5, 1], [2, 6]]))
    assert box.is_subset([[0, 1], [2, 7]]) and not box.is_subset([[0, 1], [3, 7]])
    assert np.array([0.5, 3]) in box and (0.5, 7) not in box
    with pytest.raises(ValueError, match="boxes of 2 intervals, found 1"):
        box + [1]


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


def test_contractors_of_a_list_are_those_of_the_operators():
    room = IntervalVector([[-9, 9], [-9, 9]])
    peg, other, third = CtcDist((0, 0), [4.9, 5.1]), CtcDist((6, 0), [4.9, 5.1]), CtcBox(IntervalVector([[0, 9], [0, 9]]))
    assert CtcInter([peg, other, third]).contract(room) == (peg & other & third).contract(room)
    assert CtcUnion([peg, other]).contract(room) == (peg | other).contract(room)
    # 5 m from both pegs is 3 m along and 4 m to either side; either peg alone allows 5.1 m to the left of the first.
    assert [3, 4] in CtcInter([peg, other]).contract(room) and CtcInter([peg, other]).contract(room)[0].lb > 0
    assert CtcUnion([peg, other]).contract(room)[0].lb < -5
    for join in (CtcInter, CtcUnion):
        with pytest.raises(ValueError, match="at least one"):
            join([])


def test_a_function_can_be_a_contractor():
    # Places with x ≤ y.
    def left_of_diagonal(box):
        x, y = box[0], box[1]
        return IntervalVector([x & [-math.inf, y.ub], y & [x.lb, math.inf]])

    room, diagonal = IntervalVector([[0, 9], [-9, 4]]), Ctc(left_of_diagonal)
    assert diagonal.contract(room) == IntervalVector([[0, 4], [0, 4]])
    # At 5 m from the origin and above the diagonal, x is at most 5/√2 and y at least that.
    boxes = (CtcDist((0, 0), 5) & diagonal).pave(IntervalVector([[0, 9], [0, 9]]), 0.01)
    assert boxes[:, 0, 1].max() == pytest.approx(5 / math.sqrt(2), abs=0.02)
    assert boxes[:, 1, 0].min() == pytest.approx(5 / math.sqrt(2), abs=0.02)
    # What a function adds to the box that it was given does not count.
    assert Ctc(lambda box: box.inflate(1)).contract(room) == room


@pytest.mark.parametrize("use", [lambda own, room: own.contract(room), lambda own, room: (own | own).pave(room, 0.1)])
def test_an_exception_of_a_contractor_reaches_whoever_uses_it(use):
    room, calls = IntervalVector([[0, 8], [0, 6]]), []

    def broken(box):
        calls.append(box)
        raise ZeroDivisionError("no constraint")

    with pytest.raises(ZeroDivisionError, match="no constraint"):
        use(Ctc(broken), room)
    assert len(calls) == 1
    with pytest.raises(TypeError, match="expected an IntervalVector .* found None"):
        use(Ctc(lambda box: None), room)
    with pytest.raises(TypeError, match="expected a function"):
        Ctc(3)


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


HALL = IntervalVector([[0, 8], [0, 6]])
START = IntervalVector([[3.9, 4.1], [2.9, 3.1], [-0.01, 0.01]])
GYRO = {"bias_rad_per_s": [-0.001, 0.001], "scale": [0.999, 1.001], "noise_rad_per_s": 0.001, "period_s": 0.01}


def turned(**robot):
    """The box after a turn by 2 rad in 4 s on the spot, by wheels that slip a lot, and by a gyroscope if the robot has one."""
    localizer = wherein.Localizer(HALL, START, track_m=0.4, along=(0.002, 0.2, 0.0), turn_rate_rad_per_s=2.0, **robot)
    for step in range(401):
        time_s = step / 100
        dropped = localizer.observe(wherein.GyroReading(time_s, 0.5))
        assert (dropped is None) == ("gyro" in robot)
        assert localizer.observe(wherein.WheelsReading.of_odometry(time_s, (-0.1 * time_s, 0.1 * time_s))) is None
    return localizer.estimate_at(4.0)


def test_a_gyroscope_makes_the_heading_sharper_than_wheels_that_slip():
    without, with_gyro = turned(), turned(gyro=GYRO)
    assert [4.0, 3.0, 2.0] in without and [4.0, 3.0, 2.0] in with_gyro
    # Over 4 s, 2 mrad/s of bias and noise are 8 mrad, and 1 ‰ of scale is 2 mrad, to both sides of the start's 0.02 rad: together 0.04 rad.
    assert 0.04 <= with_gyro.hull[2].diam() < 0.041
    # Each wheel rolls 0.4 m, with an error of 2 mm and a fifth of that: 2 · 0.082 m / 0.4 m, to both sides of the start.
    assert 0.84 <= without.hull[2].diam() < 0.841
    assert "gyro.bias" in with_gyro.relies_on and "gyro.bias" not in without.relies_on


def test_a_gyroscope_is_told_as_a_drive_tells_it():
    drive = wherein.Drive(Path(__file__).parents[2] / "scenes" / "gnss.toml")
    wherein.Localizer(HALL, START, track_m=0.4, gyro=drive.told["robot"]["gyro"])


@pytest.mark.parametrize(
    "robot, said",
    [
        ({"track_m": -0.3}, r"track_m: expected .* above 0, found \[-0.3, -0.3\]"),
        ({"track_m": [0, 0.3]}, "track_m: "),
        ({"along": (math.nan, 0, 0)}, "along: metres at any time: expected .* at least 0, found NaN"),
        ({"along": (0, -1, 0)}, "along: share of the way: .* found -1"),
        ({"aside": (0, 0, math.inf)}, "aside: metres per second: .* found inf"),
        ({"speed_m_per_s": math.nan}, "speed_m_per_s: expected a finite number above 0, found NaN"),
        ({"turn_rate_rad_per_s": 0}, "turn_rate_rad_per_s: .* found 0"),
        ({"acceleration_m_per_s2": -1}, "acceleration_m_per_s2: .* found -1"),
        ({"room": IntervalVector([[0, math.inf], [0, 6]])}, "room: expected bounded intervals"),
        ({"start": IntervalVector([[0, 1], [0, 6]])}, "a start of 3"),
        ({"gyro": {}}, "gyro: expected the key `bias_rad_per_s`"),
        ({"gyro": {**GYRO, "bias": 1}}, "gyro: expected keys of bias_rad_per_s, .* found `bias`"),
        ({"gyro": {**GYRO, "scale": [-1, 1]}}, r"gyro: scale: .* found \[-1, 1\]"),
        ({"gyro": {**GYRO, "noise_rad_per_s": math.nan}}, "gyro: noise_rad_per_s: .* found NaN"),
        ({"gyro": {**GYRO, "period_s": 0}}, "gyro: period_s: .* found 0"),
    ],
)
def test_a_robot_that_cannot_be_is_refused_by_name_and_value(robot, said):
    given = {"room": HALL, "start": START, "track_m": 0.4, **robot}
    with pytest.raises(ValueError, match=said):
        wherein.Localizer(given.pop("room"), given.pop("start"), **given)


def test_devices_are_functions():
    with pytest.raises(TypeError, match="devices: beacon: expected a function"):
        wherein.Localizer(HALL, START, track_m=0.4, devices={"beacon": 3})
