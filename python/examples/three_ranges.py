"""Where is a robot that measures its distance from three beacons, each within 10 cm, when one of them may be wrong?"""

import wherein

BEACONS_M = {(0.0, 0.0): 5.0, (8.0, 0.0): 5.0, (4.0, 6.0): 3.0}

room = wherein.IntervalVector([[0, 8], [0, 6]])
ranges = [wherein.CtcDist(at, wherein.Interval.centred(range_m, 0.1)) for at, range_m in BEACONS_M.items()]
print("all three are right:", (ranges[0] & ranges[1] & ranges[2]).contract(room))

boxes = wherein.CtcQInter(ranges, 1).pave(room, 0.05)
print("one may be wrong:", len(boxes), "boxes, x from", boxes[:, 0, 0].min(), "to", boxes[:, 0, 1].max())

within_1_m = wherein.SepDist((0, 0), [4, 6]) & wherein.SepDist((8, 0), [4, 6]) & wherein.SepDist((4, 6), [2, 4])
inner, outer, boundary = wherein.sivia(room, within_1_m, 0.1)
print("ranges within 1 m:", len(inner), "boxes surely inside,", len(boundary), "undecided")
