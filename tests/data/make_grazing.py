#!/usr/bin/env python3
"""Makes grazing.csv: states whose free flight touches a stop with a given depth, in 60 digits.

Regenerate with `python3 tests/data/make_grazing.py` (needs mpmath; 7 CPU minutes on a busy machine; reproducible).

A state at the top of the flight is drawn: w = side (1 + depth) L, w' = 0, side w'' < 0. It is integrated backwards, without stops,
over a span in which the flight touches none. The start is rounded to doubles; every expected value is
then computed from these doubles. Kinds: `short` starts 0.03-0.4 periods before the top, `long` 1.02-1.5 periods,
`stop` exactly on a stop and leaving it, as after an impact.

Columns: id, kind, set, side, depth (nominal, of L; negative: misses), the 13 parameters (SI), t0 (start time, s),
x1..v3 (start), contact (1 or 0), delay (contact instant - t0, s), speed (approach speed, m/s), clearance (L - max side w
of the flight without stops, m; for a miss the closest distance to the stop), t_end (s), e_x1..e_v3 (state there, the
impact law applied; exactly `contact` impacts lie in (t0, t_end]). A rounding error of r in w moves the instant by r / speed.
"""

import math
import os
import random

from mpmath import mp, mpf

from exact import FIELDS, FLIGHT, STATE, System, check_against_expm, doubles, exactly_on_stop, horner, write

mp.dps = 60
DEPTHS = [10.0**-k for k in range(1, 11)] + [-1e-10]
KINDS = ("short", "long", "stop")


def parameter_set(*values):
    return dict(zip(FIELDS, map(float, values)))


#        m1     k1   c1    m2    m3    k3     c3     k23    L     kappa F10   omega phase
SETS = {
    "basic": parameter_set(1, 1, 0.1, 0.1, 0.1, 0.1, 0.006, 0.006, 1, 0.75, 0.15, 1.04, 0),
    "standard": parameter_set(1, 1, 0.04, 0.1, 0.1, 0.1, 0.004, 0.002, 1, 0.75, 0.15, 1, 0),
    "undamped": parameter_set(1, 1, 0, 0.1, 0.1, 0.12, 0, 0.006, 1, 1, 0.15, 1.04, 0.3),
    "stiff": parameter_set(1, 4, 0.1, 0.1, 0.1, 9, 0.02, 4, 1, 0.6, 0.5, 1.7, 0),
    "heavy": parameter_set(1, 1, 0.1, 20, 2, 1.5, 0.1, 1, 0.75, 0.5, 0.4, 0.9, 1),
    "millimetre": parameter_set(12.5, 80000, 90, 2.5, 1.5, 9000, 20, 400, 2.0**-9, 0.8, 60, 83, -2),
    "strong": parameter_set(1, 1, 0.05, 0.1, 0.5, 0.5, 0.03, 0.06, 1, 0.3, 0.3, 1.02, 0),
    "uncoupled": parameter_set(1, 1, 0.02, 0.3, 0.1, 0.2, 0.01, 0, 1, 0.9, 0.2, 1.1, 0),
    "loose": parameter_set(1, 0, 0, 0.5, 0.2, 0, 0, 0.05, 1, 0.75, 0.3, 1.3, 0.7),
    "constant": parameter_set(1, 1, 0.1, 0.1, 0.1, 0.1, 0.006, 0.006, 1, 0, 0.15, 0, 0.9),
}


def draw(rng, quick, side, depth, calm):
    """A state at the top of the flight."""
    gap, rate = quick.gap, float(quick.omega or 1)
    scale = rng.uniform(0.1, 1.0) * calm
    x1 = rng.uniform(-1, 1) * gap * scale
    v1 = rng.uniform(-1, 1) * gap * rate * scale
    x3 = rng.uniform(-1, 1) * gap
    v3 = rng.uniform(-1, 1) * gap * rate
    return [x1, x1 + side * (1 + depth) * gap, x3, v1, v1, v3]


def last_touch(quick, y, t, span, side, depth):
    """Goes back from the top in floats; returns when the flight without stops was last outside |w| < L before the touch
    at the top, or None if it stayed inside for the whole span, and the time at which the touch begins."""
    n = max(40, int(span / quick.window * 3))
    h, inside, begun = -span / n, depth < 0, None
    for k in range(n):
        y = quick.flow(FLIGHT, y, t + h * k, t + h * (k + 1))
        w = abs(y[1] - y[0])
        if not inside and w < quick.gap:
            inside, begun = True, -h * (k + 1)
        elif inside and w >= quick.gap and not (depth < 0 and k < 2):
            return begun, (-h * k, -h * (k + 1))
    return begun, None


def candidate(rng, parameters, kind, side, depth):
    """Start time and state in doubles, and the time from start to the top; None if the draw does not fit."""
    quick, exact = System(parameters, float), System(parameters)
    period = quick.period()
    t0 = rng.uniform(0, 3) * period
    low, high = {"short": (0.03, 0.4), "long": (1.02, 1.5), "stop": (0.03, 1.5)}[kind]
    span = rng.uniform(low, high) * period if kind != "stop" else high * period
    top = mpf(t0) + mpf(span)
    y = draw(rng, quick, side, depth, 0.6 if kind == "long" else 1.0)
    acceleration = side * quick.relative_acceleration(y, float(top))
    rate = float(quick.omega or 1)
    if acceleration > -0.02 * quick.gap * rate**2:
        return None
    begun, left = last_touch(quick, y, float(top), span, side, depth)
    # Evaluated again in full precision, so that the depth is not lost to rounding.
    y = [mpf(a) for a in y]
    y[1] = y[0] + side * (1 + mpf(depth)) * exact.gap
    if kind != "stop":
        if left is not None or (depth > 0 and begun is None):
            return None
        return t0, doubles(exact.flow(FLIGHT, y, top, t0)), span
    if left is None or (depth > 0 and begun is None) or left[0] < low * period:
        return None
    lo, hi = (top - mpf(b) for b in left)
    ya = exact.flow(FLIGHT, y, top, lo)
    was = 1 if ya[1] > ya[0] else -1
    for _ in range(80):  # Newton's method on |w| = L, going back
        f = was * (ya[1] - ya[0]) - exact.gap
        step = f / (was * (ya[4] - ya[3]))
        if not abs(step) < period:
            return None
        new = lo - step
        ya, lo = exact.flow(FLIGHT, ya, lo, new), new
        if abs(step) < mpf(10) ** -40:
            break
    if was * (ya[4] - ya[3]) > -0.05 * exact.gap * rate or not low * period < top - lo < span:
        return None
    t0 = float(lo)
    start = exactly_on_stop(exact.flow(FLIGHT, ya, lo, t0), parameters["stop_gap"], was)
    return None if start is None else (t0, start, float(top - lo))


def peak(s, y, t0, guess):
    """Time and state of the top, from the rounded start (Newton's method on w')."""
    t = mpf(t0) + guess
    y = s.flow(FLIGHT, y, t0, t)
    for _ in range(60):
        step = (y[4] - y[3]) / s.relative_acceleration(y, t)
        y, t = s.flow(FLIGHT, y, t, t - step), t - step
        if abs(step) < mpf(10) ** -50 * (1 + abs(t)):
            break
    return t, y


def solve(parameters, t0, start, span, side, depth):
    """Expected values, or None if the flight has another contact or does not fit."""
    s = System(parameters)
    period = mpf(s.period())
    y = [mpf(a) for a in start]
    w = start[1] - start[0]
    touching = (1 if w > 0 else -1) if abs(w) == parameters["stop_gap"] else 0
    top, y_top = peak(s, y, t0, mpf(span))
    clearance = s.gap - side * (y_top[1] - y_top[0])
    if abs(clearance + mpf(depth) * s.gap) > abs(mpf(depth)) * s.gap / 100:
        return None
    hit = s.first_contact(y, t0, top + period / 10, touching)
    if depth < 0:
        if hit is not None:
            return None
        # Nowhere else does the flight come as close: a stop moved inwards by 1e-14 is first hit
        # just before the top.
        level = (s.gap - clearance) * (1 - mpf(10) ** -14)
        if touching == 0:
            closest = s.first_contact(y, t0, top, 0, level)
            if closest is None or top - closest[0] > period * mpf(10) ** -5:
                return None
        t_end = float(top + period / 10)
        return 0, None, None, clearance, t_end, s.flow(FLIGHT, y, t0, t_end)
    if hit is None or hit[1] != side or hit[0] > top:
        return None
    t_hit = hit[0]
    y_hit = s.flow(FLIGHT, y, t0, t_hit)
    if s.first_contact(y_hit, t_hit, top, side) is not None:
        return None  # an earlier, deeper crossing, not the touch at the top
    after, speed = s.impact(y_hit, side)
    if s.kappa == 0 and side * s.relative_acceleration(after, t_hit) >= 0:
        return None
    next_hit = s.first_contact(after, t_hit, t_hit + period / 10, side)
    t_end = t_hit + period / 10 if next_hit is None else (t_hit + next_hit[0]) / 2
    if t_end - t_hit < period / 100:
        return None
    t_end = float(t_end)
    return 1, t_hit - mpf(t0), speed, clearance, t_end, s.flow(FLIGHT, after, t_hit, t_end)


def main():
    rng = random.Random(20210)
    for parameters in SETS.values():
        check_against_expm(parameters)
    rows = []
    for name, parameters in SETS.items():
        for j, depth in enumerate(DEPTHS):
            for k, kind in enumerate(KINDS):
                for side in (1, -1) if kind != "long" else ((1, -1)[(j + k) % 2],):
                    for _ in range(600):
                        found = candidate(rng, parameters, kind, side, depth)
                        expected = found and solve(parameters, *found, side, depth)
                        if expected:
                            break
                    else:
                        print("none:", name, depth, kind, side)
                        continue
                    t0, start, _ = found
                    contact, delay, speed, clearance, t_end, end = expected
                    rows.append(
                        [len(rows), kind, name, side, depth]
                        + [parameters[f] for f in FIELDS]
                        + [t0, *start, contact, delay, speed, clearance, t_end, *end]
                    )
        print(name, len(rows), flush=True)
    columns = ["id", "kind", "set", "side", "depth", *FIELDS, "t0", *STATE, "contact", "delay", "speed"]
    columns += ["clearance", "t_end", *("e_" + q for q in STATE)]
    write(os.path.join(os.path.dirname(os.path.abspath(__file__)), "grazing.csv"), columns, rows)


if __name__ == "__main__":
    main()
