"""The planar problem of rigid_motion.rs in Codac: reads landmark boxes from standard input, prints seconds of one 3-D `pave`.

One line for each landmark: a_x.lo a_x.hi a_y.lo a_y.hi b_x.lo b_x.hi b_y.lo b_y.hi. Exits with status 3 when Codac cannot be imported.
"""

import sys
import time

try:
    from codac import AnalyticFunction, CtcInverse, Interval, IntervalVector, VectorVar, cos, pave, sin, vec
except ImportError:
    sys.exit(3)

landmarks = [[float(number) for number in line.split()] for line in sys.stdin if line.strip()]
pose = VectorVar(3)
rows = []
for a_x_lo, a_x_hi, a_y_lo, a_y_hi, b_x_lo, b_x_hi, b_y_lo, b_y_hi in landmarks:
    a_x, a_y = Interval(a_x_lo, a_x_hi), Interval(a_y_lo, a_y_hi)
    b_x, b_y = Interval(b_x_lo, b_x_hi), Interval(b_y_lo, b_y_hi)
    rows.append(pose[0] + cos(pose[2]) * b_x - sin(pose[2]) * b_y - a_x)
    rows.append(pose[1] + sin(pose[2]) * b_x + cos(pose[2]) * b_y - a_y)
constraint = CtcInverse(AnalyticFunction([pose], vec(*rows)), IntervalVector([[0, 0]] * len(rows)))
prior = IntervalVector([[-3, 3], [-3, 3], [-3.14, 3.14]])
best = float("inf")
for _ in range(5):
    start = time.perf_counter()
    paving = pave(prior, constraint, 0.05)
    best = min(best, time.perf_counter() - start)
print(best)
