"""A driven chain of bodies with clearances by SciPy's solver with events, beside the figures of `cargo bench -p benches --bench assembly`.

Each solver is at relative and absolute tolerances of 1e-10. An event is one stop's e - gap passing zero from below; the integration begins
anew after each. Needs SciPy. Usage: python benches/assembly_beside_scipy.py [BODIES]
"""

import math
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp

GAP, RESTITUTION, END = 0.05, 0.6, 10.0
TOLERANCE = 1e-10
# Seconds of work after which a solver is not followed further.
PATIENCE = 60.0


def chain(bodies):
    """The machine of `chain` in benches/assembly.rs: every second joint has play on both sides, the others a spring."""
    k, c = np.diag(np.full(bodies, 20.0)), np.diag(np.full(bodies, 0.2))
    stops = []
    for i in range(1, bodies):
        if i % 2 == 1:
            stops += [(i - 1, i), (i, i - 1)]
        else:
            for m, x in ((k, 400.0), (c, 0.1)):
                m[[i - 1, i], [i - 1, i]] += x
                m[[i - 1, i], [i, i - 1]] -= x
    return k, c, stops


def simulate(bodies, method):
    k, c, stops = chain(bodies)

    def rate(t, z):
        a = -k @ z[:bodies] - c @ z[bodies:]
        a[0] += 10.0 * math.sin(2.0 * math.pi * t)
        return np.concatenate([z[bodies:], a])

    def event(a, b):
        def excess(t, z):
            return z[b] - z[a] - GAP

        excess.terminal, excess.direction = True, 1.0
        return excess

    events = [event(a, b) for a, b in stops]
    t, z, impacts, begin = 0.0, np.zeros(2 * bodies), 0, time.process_time()
    while t < END and time.process_time() - begin < PATIENCE:
        found = solve_ivp(rate, (t, END), z, method=method, rtol=TOLERANCE, atol=TOLERANCE, events=events)
        t, z = found.t[-1], found.y[:, -1].copy()
        for (a, b), times in zip(stops, found.t_events):
            if len(times):
                impacts += 1
                speed = z[bodies + b] - z[bodies + a]
                change = 0.5 * (1.0 + RESTITUTION) * speed  # both bodies weigh 1 kg
                z[bodies + a] += change
                z[bodies + b] -= change
                # SciPy finds no event that begins at zero: the stop is left by a rounding.
                z[b] -= max(0.0, z[b] - z[a] - GAP) + 1e-14
    return time.process_time() - begin, impacts, t


def main():
    bodies = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    print(f"| {bodies} bodies, {bodies // 2} clearances | s of processor time | impacts | reached, s |\n|---|---|---|---|")
    for method in ("DOP853", "RK45", "LSODA"):
        work, impacts, reached = simulate(bodies, method)
        print(f"| SciPy {method}, tolerances {TOLERANCE:g} | {work:.2f} | {impacts} | {reached:.2f} |")


if __name__ == "__main__":
    main()
