#!/usr/bin/env python3
"""Makes chatter.csv: states that run into a complete chatter, followed impact by impact in 80 digits.

Regenerate with `python3 tests/data/make_chatter.py` (needs mpmath; about two CPU minutes; reproducible).

Every impact is located exactly until the approach speed is below 1e-30 of the first one; the rest of the series
(duration 2 v / (a (1 - kappa)), below 1e-29) is summed, and the rest mode is integrated exactly from there. With
kappa = 0 the first impact merges at once; kind `start` begins at rest, pressed against the stop.

Columns: id, kind (chatter, merge, start), set, side, the 13 parameters (SI), t0 (start time, s), x1..v3 (start), first
(first impact - t0, s) and first_speed (m/s), empty for `start`; rest (end of the chatter - t0, s), r_x1..r_v3 (state
there); release (instant at which the contact force has fallen to zero - t0, s), empty when t_end comes before it;
t_end (s), mode (1: at rest at t_end, 0: released and not yet in contact again), force (contact force at t_end, N),
e_x1..e_v3 (state at t_end).
"""

import math
import os
import random

from mpmath import mp, mpf

from exact import FIELDS, FLIGHT, STATE, System, check_against_expm, doubles, exactly_on_stop, first_root, horner, write

mp.dps = 80
END_SPEED = mpf(10) ** -30


def parameter_set(*values):
    return dict(zip(FIELDS, map(float, values)))


#        m1     k1   c1    m2    m3    k3     c3     k23    L     kappa F10   omega phase
SETS = {
    "basic": parameter_set(1, 1, 0.1, 0.1, 0.1, 0.1, 0.006, 0.006, 1, 0.75, 0.15, 1.04, 0),
    "undamped": parameter_set(1, 1, 0, 0.1, 0.1, 0.12, 0, 0.006, 1, 1, 0.15, 1.04, 0.3),
    "heavy": parameter_set(1, 1, 0.1, 20, 2, 1.5, 0.1, 1, 0.75, 0.5, 0.4, 0.9, 1),
    "millimetre": parameter_set(12.5, 80000, 90, 2.5, 1.5, 9000, 20, 400, 2.0**-9, 0.8, 60, 83, -2),
    "strong": parameter_set(1, 1, 0.05, 0.1, 0.5, 0.5, 0.03, 0.06, 1, 0.3, 0.3, 1.02, 0),
}
KAPPAS = (0.0, 0.1, 0.3, 0.5, 0.75, 0.9)


def chatter(s, y, t, side, limit):
    """Follows the impacts; returns ((first instant, speed), end of the chatter, state there), or None if it is not complete
    before `limit`."""
    first = None
    touching, reach = 0, limit
    while True:
        # A short span first, because rebounds become far shorter than a period.
        hit = s.first_contact(y, t, min(limit, reach), touching)
        if hit is None and reach < limit:
            hit = s.first_contact(y, t, limit, touching)
        if hit is None or hit[1] != side:
            return None
        y, speed = s.impact(s.flow(FLIGHT, y, t, hit[0]), side)
        t, touching = hit[0], side
        first, reach = first or (t, speed), limit
        pressing = side * s.relative_acceleration(y, t)
        if pressing > 0:
            reach = t + 4 * s.kappa * speed / pressing
        if speed <= END_SPEED * first[1] or s.kappa == 0:
            if pressing <= 0:
                return None
            rebound = s.kappa * speed
            duration = 2 * rebound / (pressing * (1 - s.kappa))
            y = merge(s, y, side)
            return first, t + duration, s.flow(side, y, t, t + duration)


def merge(s, y, side):
    y = list(y)
    y[3] = y[4] = (s.m1 * y[3] + s.m2 * y[4]) / (s.m1 + s.m2)
    y[1] = y[0] + side * s.gap
    return y


def force_polynomial(s, y, t, side, h):
    """Taylor coefficients of the contact force: m2 x2'' = -k23 (x2 - x3) - side force."""
    x, v = s.expand(side, y, t, h)
    n = len(x[0])
    acceleration = [(k + 1) * v[1][k + 1] for k in range(n - 1)]
    return x, v, [-side * (s.k23 * (x[1][k] - x[2][k]) + s.m2 * acceleration[k]) for k in range(n - 1)]


def release(s, y, t, side, limit):
    """Instant and state of the release, or None before `limit`."""
    h = mpf(s.window)
    while t < limit:
        x, v, force = force_polynomial(s, y, t, side, h)
        u = first_root(force, mpf(0), h)
        step = h if u is None else u
        y = [horner(p, step) for p in x] + [horner(p, step) for p in v]
        t += step
        if u is not None:
            return t, y
    return None


def draw(rng, quick, side, kind):
    gap, rate = quick.gap, float(quick.omega)
    x1, x3 = rng.uniform(-1, 1) * gap, rng.uniform(-2, 2) * gap
    v1, v3 = rng.uniform(-1, 1) * gap * rate, rng.uniform(-1, 1) * gap * rate
    below = 0 if kind == "start" else rng.choice((0.003, 0.02, 0.1)) * rng.random() * gap
    speed = 0 if kind == "start" else rng.uniform(-0.15, 0.25) * gap * rate
    return [x1, x1 + side * (gap - below), x3, v1, v1 + side * speed, v3]


def solve(rng, parameters, kind, side, want_release):
    """The values of a row after the parameters, or None."""
    quick, s = System(parameters, float), System(parameters)
    period = s.period()
    t0 = rng.uniform(0, 2) * period
    start = doubles(draw(rng, quick, side, kind))
    pressing = side * quick.relative_acceleration(start, t0)
    if pressing < 0.1 * quick.gap * quick.omega**2:
        return None
    if kind == "start":
        start = exactly_on_stop(start, parameters["stop_gap"], side)
        if start is None:
            return None
        y, t_rest, first, first_speed = [mpf(a) for a in start], mpf(t0), None, None
    else:
        # A quick check: the series must end well before the block stops being pressed.
        speed = max(abs(start[4] - start[3]), math.sqrt(2 * pressing * (quick.gap - abs(start[1] - start[0]))))
        if 2 * speed / (pressing * max(1 - quick.kappa, 0.05)) > period * 0.6:
            return None
        found = chatter(s, [mpf(a) for a in start], mpf(t0), side, mpf(t0) + period)
        if found is None:
            return None
        (instant, first_speed), t_rest, y = found
        first = instant - mpf(t0)
    if s.contact_force(y, t_rest, side) < mpf("0.01") * s.m2 * s.gap * s.omega**2:
        return None
    let_go = release(s, y, t_rest, side, t_rest + 2 * period)
    if want_release:
        if let_go is None:
            return None
        t_go, y_go = let_go
        # The root of the third-order departure is not divided out: a short flight first, then a
        # search.
        leave = t_go + period / 1000
        y_leave = s.flow(FLIGHT, y_go, t_go, leave)
        hit = s.first_contact(y_leave, leave, t_go + period / 4)
        t_end = float(t_go + period / 4 if hit is None else (t_go + hit[0]) / 2)
        if t_end - t_go < period / 50:
            return None
        end, mode, force = s.flow(FLIGHT, y_go, t_go, t_end), 0, mpf(0)
        go = t_go - mpf(t0)
    else:
        stay = (let_go[0] - t_rest) if let_go else 2 * mpf(period)
        if stay < period / 50:
            return None
        t_end = float(t_rest + stay * mpf(rng.uniform(0.3, 0.9)))
        end, mode, go = s.flow(side, y, t_rest, t_end), 1, None
        force = s.contact_force(end, t_end, side)
    return [t0, *start, first, first_speed, t_rest - mpf(t0), *y, go, t_end, mode, force, *end]


def main():
    rng = random.Random(20211)
    rows = []
    for name, base in SETS.items():
        check_against_expm(base)
        for kappa in KAPPAS + (None,):
            kind = "start" if kappa is None else "merge" if kappa == 0 else "chatter"
            parameters = dict(base, stop_restitution=base["stop_restitution"] if kappa is None else kappa)
            for side in (1, -1):
                for want_release in (False, True):
                    for _ in range(3000):
                        row = solve(rng, parameters, kind, side, want_release)
                        if row:
                            break
                    else:
                        print("none:", name, kappa, side, want_release)
                        continue
                    rows.append([len(rows), kind, name, side, *(parameters[f] for f in FIELDS), *row])
        print(name, len(rows), flush=True)
    columns = ["id", "kind", "set", "side", *FIELDS, "t0", *STATE, "first", "first_speed", "rest"]
    columns += ["r_" + q for q in STATE] + ["release", "t_end", "mode", "force"] + ["e_" + q for q in STATE]
    write(os.path.join(os.path.dirname(os.path.abspath(__file__)), "chatter.csv"), columns, rows)


if __name__ == "__main__":
    main()
