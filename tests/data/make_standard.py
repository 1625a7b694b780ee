#!/usr/bin/env python3
"""Makes standard_*.csv: the standard work of benches/README.md over its first 20 drive periods, in 60 digits.

Regenerate with `python3 tests/data/make_standard.py` (needs mpmath; about a minute; the output is reproducible).

    x1'' = -x1 - e 0.4 x1' + e 1.5 sin t     x2'' = -e 0.2 (x2 - x3)     x3'' = -x3 - e 0.4 x3' - e 0.2 (x3 - x2)
    e = 0.1, L = 1, kappa = 0.75, start x = (0, 0.9, 0), v = (0, 0.5, 0)

Two versions: `decimal` takes these decimal numbers as exact (k23 = 0.002, c1 = 0.04, ...) and gives states at exactly
2 pi n; `double` takes the doubles that `Groups::weak(0.1, 0.75, 1.5, 0, 0.4, 0.2, 0, 0.4).to_parameters(..)` returns and
gives states at the doubles n * TAU. Their difference is the effect of rounding the parameters.

standard_<version>_periods.csv: period n, t, x1..v3, impacts (count so far).
standard_<version>_impacts.csv: number (from 1), t, side, speed (approach), impulse, x1..v3 (state just after).
The decimal version continues to period 500 and is compared with an end state that was certified by interval arithmetic.
"""

import math
import os

from mpmath import mp, mpf

from exact import FIELDS, FLIGHT, STATE, System, check_against_expm, write

mp.dps = 60
PERIODS = 20
# Certified by interval arithmetic: after period 500, the state at whole periods is constant
# to 15 digits.
SETTLED = 500
CERTIFIED = """-0.4253110842429075 0.2872634800253607 0.4900836440556809
               -0.7166788315354791 -1.2876764920670574 -0.3927812190837065""".split()


def decimal():
    values = "1 1 0.04 0.1 0.1 0.1 0.004 0.002 1 0.75 0.15 1 0".split()
    return {f: mpf(v) for f, v in zip(FIELDS, values)}


def double():
    """Parameters by the operations of `Groups::weak` and `to_parameters` in unit scales, in their order."""
    e = 0.1
    m2, m3, beta2 = e * 1.0, 1.0 / (1.0 / e), e * 0.2
    values = (1.0, 1.0, 0.4 * e, m2, m3, (1.0 + e * 0.0) * m3, 0.4 * m3 * e, beta2 * m2, 1.0, 0.75, 1.5 * e, 1.0 + e * 0.0, 0.0)
    return dict(zip(FIELDS, values))


def follow(s, times, start):
    """States at the times, and all impacts before the last of these times."""
    y = [mpf(0), start, mpf(0)]
    y += [mpf(0), mpf("0.5"), mpf(0)]
    t, touching, states, impacts = mpf(0), 0, [], []
    for end in times:
        while True:
            hit = s.first_contact(y, t, end, touching)
            if hit is None:
                break
            at, side = hit
            y, speed = s.impact(s.flow(FLIGHT, y, t, at), side)
            impulse = (1 + s.kappa) * s.m1 * s.m2 / (s.m1 + s.m2) * speed
            t, touching = at, side
            impacts.append([t, side, speed, impulse, *y])
            # A pressed block would come to rest; this does not happen in these periods, which the
            # assertion checks.
            assert speed > mpf(10) ** -12
        y, t, touching = s.flow(FLIGHT, y, t, end), end, 0
        states.append((y, len(impacts)))
    return states, impacts


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    for version, parameters in (("decimal", decimal()), ("double", double())):
        check_against_expm(parameters)
        s = System(parameters)
        if version == "decimal":
            times, start = [2 * mp.pi * n for n in range(1, PERIODS + 1)], mpf("0.9")
        else:
            times, start = [mpf(n * math.tau) for n in range(1, PERIODS + 1)], mpf(0.9)
        states, impacts = follow(s, times, start)
        rows = [[n, t, *y, count] for n, t, (y, count) in zip(range(1, PERIODS + 1), times, states)]
        write(os.path.join(here, f"standard_{version}_periods.csv"), ["period", "t", *STATE, "impacts"], rows)
        rows = [[n, *row] for n, row in enumerate(impacts, 1)]
        columns = ["number", "t", "side", "speed", "impulse", *STATE]
        write(os.path.join(here, f"standard_{version}_impacts.csv"), columns, rows)
        print(version, "impacts:", len(impacts), "last state:", [mp.nstr(a, 17) for a in states[-1][0]], flush=True)
    mp.dps = 40
    s = System(decimal())
    states, impacts = follow(s, [2 * mp.pi * n for n in range(1, SETTLED + 1)], mpf("0.9"))
    error = max(abs(a - mpf(b)) for a, b in zip(states[-1][0], CERTIFIED))
    print("period", SETTLED, "impacts:", len(impacts), "from the certified state:", mp.nstr(error, 3))
    assert error < 1e-14


if __name__ == "__main__":
    main()
