"""An independent model, written from its equations alone: DOP853 in flight, impacts by event."""

import numpy as np
from scipy.integrate import solve_ivp

TOLERANCE = 1e-12  # the tightest that DOP853 supports in double precision


def simulate(p, state, times, f=(0.0, 0.0, 0.0), offset=0.0):
    """States [x1 x2 x3 v1 v2 v3] at the given times, and the instants of impact.

    p      start values by variable name
    state  state at times[0]
    f      loads on the three bodies, constant or a function of time
    offset the distance of the middle of the gap above the block's position with relaxed coupling spring
    """
    loads = f if callable(f) else lambda t: f
    m1, m2, m3 = p["box.m"], p["block.m"], p["secondary.m"]
    gap, kappa = p["stop.gap"], p["stop.restitution"]

    def flight(t, y):
        x1, x2, x3, v1, v2, v3 = y
        drive = p["drive.amplitude"] * np.sin(p["drive.frequency"] * t + p["drive.phase"])
        spring = p["coupling.k"] * (x2 - x3)
        f = loads(t)
        a1 = (drive + f[0] - p["box.c"] * v1 - p["box.k"] * x1) / m1
        a2 = (f[1] - spring) / m2
        a3 = (f[2] + spring - p["secondary.c"] * v3 - p["secondary.k"] * x3) / m3
        return [v1, v2, v3, a1, a2, a3]

    def upper(t, y):
        return y[1] - y[0] - (offset + gap)

    def lower(t, y):
        return y[0] - y[1] - (gap - offset)

    for event in (upper, lower):
        event.terminal, event.direction = True, 1.0

    states, impacts = np.empty((len(times), 6)), []
    now, y = times[0], np.array(state, dtype=float)
    done = 0
    while done < len(times):
        # No step is long enough to contain a whole short contact.
        step = 0.02 * 2.0 * np.pi / p["drive.frequency"]
        run = solve_ivp(flight, (now, times[-1]), y, "DOP853", times[done:], events=(upper, lower),
                        rtol=TOLERANCE, atol=TOLERANCE, max_step=step)
        assert run.success, run.message
        count = len(run.t)
        states[done:done + count] = run.y.T
        done += count
        if run.status == 0:
            break
        hit = next(i for i in (0, 1) if len(run.t_events[i]))
        now, y = run.t_events[hit][0], run.y_events[hit][0].copy()
        impulse = (1.0 + kappa) * m1 * m2 / (m1 + m2) * (y[4] - y[3])
        y[3] += impulse / m1
        y[4] -= impulse / m2
        impacts.append(now)
    return states, impacts
