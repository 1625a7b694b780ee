#!/usr/bin/env python3
"""Makes newton.csv: Newton's method on polynomials, ended early by the estimate 4 K m^2 <= eps |u|, in 60 digits.

Regenerate with `python3 crates/numerics/tests/make_newton.py` (needs mpmath; seconds; reproducible).

Each row is a polynomial p of degree 2 or 4 that rises on [-1, 1], with a start for a tight estimate: at step number `step` it is `part`
times the resolution eps |u|, where u is the point before the step and m the step's length. If `part` is slightly less than 1, the method
ends with this step; if slightly more, with the next one. Everything is recomputed with 60 digits from the rounded coefficients and start.

Columns: id, c0..c4, start, factor (K >= |p''|/(2p') on [-1, 1]), step, part, iterations (how many the method takes), root_hi and
root_lo (the root as the sum of two doubles).
"""

import csv
import os
import random

from mpmath import findroot, mp, mpf

mp.dps = 60
EPS = mpf(2) ** -52
PARTS = (0.7, 0.93, 1.07, 1.4)
MOST = 30


def value(c, u):
    return sum(a * u**k for k, a in enumerate(c))


def slope(c, u):
    return sum(k * a * u ** (k - 1) for k, a in enumerate(c) if k)


def bound(c):
    """K by the sizes of the coefficients, as a double."""
    slopes = sum(k * abs(a) for k, a in enumerate(c) if k > 1)
    curvatures = sum(k * (k - 1) * abs(a) for k, a in enumerate(c) if k > 1)
    return float(curvatures / (2 * (c[1] - slopes)))


def newton(c, start, factor):
    """The number of iterations, and the ratio of estimate to resolution at each step."""
    u, ratios = mpf(start), []
    for _ in range(MOST):
        m = value(c, u) / slope(c, u)
        resolution = EPS * abs(u)
        ratios.append(4 * mpf(factor) * m * m / resolution)
        if abs(m) <= 2 * resolution:
            break
        u -= m
        assert abs(u) < 1
        if ratios[-1] <= 1:
            break
    return len(ratios), ratios


def tight_start(c, root, factor, step, part):
    """A start above the root for which the estimate at `step` is `part` times the resolution."""

    def estimate(distance):
        u = root + distance
        for _ in range(step - 1):
            u -= value(c, u) / slope(c, u)
        m = value(c, u) / slope(c, u)
        return 4 * mpf(factor) * m * m / (EPS * abs(u))

    low, high = mpf("1e-30"), (1 - abs(root)) / 2
    if estimate(high) < part:
        return None
    for _ in range(200):
        mid = mp.sqrt(low * high)
        low, high = (mid, high) if estimate(mid) < part else (low, mid)
    return float(root + low)


def main():
    draw = random.Random(16)
    rows = []
    while len(rows) < 96:
        step, part = 1 + len(rows) % 3, PARTS[len(rows) // 3 % 4]
        root = 10 ** draw.uniform(-2, -0.1) * draw.choice((-1, 1))
        # The ratio of curvature and slope determines K, from 0.02 to several hundred.
        bend = 0.5 * (1 - 10 ** draw.uniform(-2.5, -0.05)) * draw.choice((-1, 1))
        twist = (0.5 - abs(bend)) * draw.uniform(-0.2, 0.2)
        c = [0.0, 1.0, bend, twist, 0.2 * twist]
        c[0] = float(-value([mpf(a) for a in c], mpf(root)))
        exact = [mpf(a) for a in c]
        root = findroot(lambda u: value(exact, u), mpf(root))
        factor = bound(exact)
        start = tight_start(exact, root, factor, step, part)
        if start is None or not -1 < start < 1:
            continue
        iterations, ratios = newton(exact, start, factor)
        # The earlier steps are far from the resolution.
        if abs(ratios[step - 1] / part - 1) > 1e-3 or any(r < 100 for r in ratios[: step - 1]):
            continue
        assert iterations == (step if part < 1 else step + 1)
        high = float(root)
        numbers = [*c, start, factor, step, part, iterations, high, float(root - mpf(high))]
        rows.append([len(rows), *map(repr, numbers)])
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "newton.csv")
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow("id c0 c1 c2 c3 c4 start factor step part iterations root_hi root_lo".split())
        out.writerows(rows)


if __name__ == "__main__":
    main()
