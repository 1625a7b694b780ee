#!/usr/bin/env python3
"""The chains of benches/curved.rs with heyoka: microseconds of a simulated second.

    pip install heyoka
    python benches/curved_beside_heyoka.py

heyoka's tolerance is 1e-16; its compilation is not counted. Impacts are terminal events, whose
callback reverses the rate of the last body. It keeps no energy accounts and proves no remainder.
"""

import time

import heyoka as hy
import numpy as np

END = 100.0
ROUNDS = 30


def chain(bodies: int) -> "tuple[hy.taylor_adaptive, list[float]]":
    names = [f"x{i}" for i in range(bodies)] + [f"v{i}" for i in range(bodies)]
    symbols = hy.make_vars(*names)
    x, v = symbols[:bodies], symbols[bodies:]
    springs = []
    for i in range(bodies):
        e = x[i] - (x[i - 1] if i else 0.0)
        rate = v[i] - (v[i - 1] if i else 0.0)
        springs.append(e + e * e * e + 0.02 * rate)
    system = [(x[i], v[i]) for i in range(bodies)]
    for i in range(bodies):
        force = -springs[i] + (springs[i + 1] if i + 1 < bodies else 0.0)
        force += 0.8 * hy.sin(0.9 * hy.time) if i == 0 else 0.0
        system.append((v[i], force))
    impacts = []

    def rebound(integrator: "hy.taylor_adaptive", *_: object) -> bool:
        if integrator.state[2 * bodies - 1] > 0.0:
            integrator.state[2 * bodies - 1] *= -0.8
            impacts.append(integrator.time)
        return True

    event = hy.t_event(x[-1] - 0.9, callback=rebound, direction=hy.event_direction.positive)
    state = [0.0] * (2 * bodies)
    state[bodies - 1] = 0.5
    return hy.taylor_adaptive(system, state, tol=1e-16, t_events=[event]), impacts


print("| bodies | impacts | µs a second |\n|---|---|---|")
for bodies in (1, 2, 5, 20):
    integrator, impacts = chain(bodies)
    start = np.array(integrator.state)
    best = np.inf
    for _ in range(ROUNDS):
        integrator.time = 0.0
        integrator.state[:] = start
        integrator.reset_cooldowns()
        impacts.clear()
        begin = time.perf_counter()
        integrator.propagate_until(END)
        best = min(best, time.perf_counter() - begin)
    print(f"| {bodies} | {len(impacts)} | {1e6 * best / END:.2f} |", flush=True)
