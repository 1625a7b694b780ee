"""Runs solvers over the cases and writes tables for score.py: python truth/solvers/run.py scipy|cvode|heyoka FOLDER [CASE ...]

scipy: DOP853 of `solve_ivp` with events. cvode: CVODE of SUNDIALS with roots (pip install scikit-sundae). Both have the tolerance 1e-11.
heyoka: Taylor series with terminal events, to rounding (pip install heyoka).
"""

import sys
import time
from pathlib import Path

import numpy as np

from model import Model, Unsupported, cases

TOLERANCE = 1e-11
ZERO = 1e-12  # a watched function below it begins at zero
MOST = 5000  # events of a case
SECONDS = 120  # of processor time for a case


def watch(model, begin, y):
    """The watched functions; one that begins at zero is divided by the time since, so that its start is not a root."""
    at_zero = np.abs(model.watched(begin, y)) < ZERO

    def functions(t, y):
        values = model.watched(t, y)
        since = t - begin
        return np.where(at_zero, values / since if since > 0 else -1.0, values)
    return functions, len(at_zero)


def by_scipy(model, t, y, stop):
    """The state at `stop` or at the first event before it."""
    from scipy.integrate import solve_ivp

    watched, count = watch(model, t, y)
    functions = []
    for k in range(count):
        def event(t, y, k=k):
            return watched(t, y)[k]
        event.terminal, event.direction = True, 1
        functions.append(event)
    found = solve_ivp(model.rate, (t, stop), y, "DOP853", events=functions or None, rtol=TOLERANCE, atol=TOLERANCE * 1e-3)
    return found.t[-1], found.y[:, -1], found.status == 1


def by_cvode(model, t, y, stop):
    from sksundae.cvode import CVODE

    watched, count = watch(model, t, y)
    options = {"rtol": TOLERANCE, "atol": TOLERANCE * 1e-3, "max_num_steps": 100_000}
    if count:
        def roots(t, y, out):
            out[:] = watched(t, y)
        roots.terminal, roots.direction = [True] * count, [1] * count
        options |= {"eventsfn": roots, "num_events": count}

    def rate(t, y, out):
        out[:] = model.rate(t, y)
    found = CVODE(rate, **options).solve(np.array([t, stop]), y)
    return found.t[-1], np.array(found.y[-1]), found.t[-1] < stop


def by_heyoka(model, t, y, stop):
    import taylor

    return taylor.by_heyoka(model, t, y, stop)


def run(name, advance):
    """Rows of the output times, and events."""
    model, begun = Model(name), time.process_time()
    t, y, rows, switches = 0.0, model.start, [], 0
    stops = sorted({float(x) for x in model.case.times()} | set(model.knots))
    outputs = {float(x) for x in model.case.times()}
    for stop in stops:
        while t < stop:
            t, y, hit = advance(model, t, y, stop)
            if hit:
                y = model.switch(t, y)
            switches += hit
            if switches > MOST or time.process_time() - begun > SECONDS:
                raise RuntimeError(f"{switches} events in {time.process_time() - begun:.0f} s up to {t} s")
        if stop in model.knots:
            y = model.switch(stop, y)
        if stop in outputs:
            rows.append((stop, y))
    return model, rows


def write(folder, name, model, rows):
    free = model.m.free()
    names = model.case.states(model.m)
    lines = [",".join(["time", *names])]
    for t, y in rows:
        lines.append(",".join([repr(t)] + [repr(float(y[k])) for i in free for k in (i, model.n + i)]))
    (folder / f"{name}.csv").write_text("\n".join(lines) + "\n")
    events = ["time,kind,element"] + [f"{t!r},{kind},{element}" for t, kind, element in model.events]
    (folder / f"{name}.events.csv").write_text("\n".join(events) + "\n")


def main():
    solver, folder, *chosen = sys.argv[1:]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name in chosen or cases.names():
        try:
            write(folder, name, *run(name, {"scipy": by_scipy, "cvode": by_cvode, "heyoka": by_heyoka}[solver]))
            print(f"{name}: done", flush=True)
        except (Unsupported, RuntimeError, np.linalg.LinAlgError) as error:
            print(f"{name}: {error}", flush=True)


if __name__ == "__main__":
    main()
