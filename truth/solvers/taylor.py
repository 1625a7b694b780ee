"""A mode of the model in heyoka's expressions, for its Taylor integrator with events (pip install heyoka)."""

import heyoka as hy
import numpy as np

#: Integrators by case, mode and lines of the signals: compiling one takes longer than a flight.
COMPILED = {}
ZERO = 1e-12  # a watched function below it begins at zero
LITTLE = 1e-16


def of_signal(value, order=0):
    """A signal or its derivative as an expression."""
    total = hy.expression(value.constant if order == 0 else 0.0)
    for amplitude, frequency, phase in value.waves:
        w = 2 * np.pi * frequency
        total += amplitude * w**order * hy.sin(w * hy.time + (phase + order * np.pi / 2))
    for begin, start, slope in value.lines:
        total += start + slope * (hy.time - begin) if order == 0 else slope if order == 1 else 0.0
    return total


def is_constant(f):
    try:
        return np.isfinite(float(str(f)))
    except ValueError:
        return False


class Mode:
    """Right sides and watched functions of the model's present mode."""

    def __init__(self, model):
        self.model, n = model, model.n
        self.s = [hy.expression(f"s{i}") for i in range(n)]
        self.v = [hy.expression(f"v{i}") for i in range(n)]
        self.elements, self.forces = model.m.elements, {}
        self.a = self.accelerations()

    def along(self, e, of):
        """The weighted sum of an element's arms."""
        return sum((float(w) * x for w, x in zip(self.model.w[e.name], of) if w), hy.expression(0.0))

    def signal(self, e, key, missing=0.0):
        value = self.model.signals.get((e.name, key))
        return of_signal(value) if value else hy.expression(missing)

    def force(self, e):
        """The force of an element that is not held."""
        x, v, k, mode = self.along(e, self.s), self.along(e, self.v), self.model.numbers[e.name], self.model.mode[e.name]
        if e.kind in ("spring", "damper"):
            return k.get("preload", 0) + self.signal(e, "stiffness") * x + k.get("damping", 0) * v + k.get("cubic", 0) * x * x * x
        if e.kind == "friction":
            level = self.signal(e, "force")
            if "stribeck" in k:
                level += (self.signal(e, "static") - level) * hy.exp(-(v * v) / k["stribeck"] ** 2)
            return {"up": 1.0, "down": -1.0, "off": 0.0}[mode] * level
        if mode == "open":
            return hy.expression(0.0)
        return self.pressed(e)

    def pressed(self, e):
        k = self.model.numbers[e.name]
        x, v, power = self.along(e, self.s) - k["gap"], self.along(e, self.v), k.get("exponent", 1)
        elastic = self.signal(e, "stiffness") * (x if power == 1 else x**power)
        return elastic * (1 + 1.5 * k.get("dissipation", 0) * v) + k.get("damping", 0) * v

    def accelerations(self):
        model = self.model
        a = [hy.expression(float(x)) for x in model.weights]
        for i, value in model.loads:
            a[i] += of_signal(value) * float(model.inverse[i])
        for i, b, value in model.given:
            a[i] = of_signal(value, 2 if b.position else 1 if b.rate else 0)
        held = model.held()
        free = [(e, self.force(e)) for e in self.elements if e not in held]
        for e, f in free:
            a = [x - float(c) * f if c else x for x, c in zip(a, model.w[e.name] * model.inverse)]
        if held:
            W = np.array([model.w[e.name] for e in held])
            inverse = np.linalg.pinv(W * model.inverse @ W.T)
            rates = [self.along(e, a) for e in held]
            found = [sum((float(c) * r for c, r in zip(row, rates) if c), hy.expression(0.0)) for row in inverse]
            self.forces = {e.name: f for e, f in zip(held, found)}
            for e in held:
                a = [x - float(c) * self.forces[e.name] if c else x for x, c in zip(a, model.w[e.name] * model.inverse)]
        return a

    def watched(self):
        """Functions whose rise through zero ends the mode."""
        out = []
        for e in self.elements:
            mode, k = self.model.mode[e.name], self.model.numbers[e.name]
            if e.kind == "stop":
                beyond = self.along(e, self.s) - k["gap"]
                out.append(-self.forces[e.name] if mode == "closed" else beyond if mode == "open" else -self.pressed(e) if k.get("damping") else -beyond)
            elif e.kind == "friction":
                level = self.signal(e, "static" if (e.name, "static") in self.model.signals else "force")
                v = self.along(e, self.v)
                out.append(self.forces[e.name] * self.forces[e.name] - level * level if mode == "stuck" else {"up": -v, "down": v}.get(mode, level))
        return out



class Integrator:
    """The compiled integrator of a mode, for any start."""

    def __init__(self, model, y):
        mode = Mode(model)
        functions = [f for f in mode.watched() if not is_constant(f)]
        states = mode.s + mode.v
        self.values = hy.cfunc(functions, states) if functions else None
        rise = hy.event_direction.positive
        events = [hy.t_event(f + hy.par[k], direction=rise) for k, f in enumerate(functions)]
        self.taylor = hy.taylor_adaptive(list(zip(states, mode.v + mode.a)), list(y), t_events=events)

    def advance(self, t, y, stop):
        """The state at `stop` or at the first event before it."""
        taylor = self.taylor
        taylor.time, taylor.state[:] = t, y
        if self.values:
            # A function that begins at zero exactly has no root that is found: it begins a little below.
            now = self.values(np.array(y, dtype=float), time=t)
            taylor.pars[:] = np.where(np.abs(now) < ZERO, -now - LITTLE, 0.0)
            taylor.reset_cooldowns()
        outcome = taylor.propagate_until(stop)[0]
        if outcome == hy.taylor_outcome.time_limit:
            return stop, taylor.state.copy(), False
        # Terminal events have the outcomes -1, -2, ...
        if not -len(taylor.pars) <= int(outcome) < 0:
            raise RuntimeError(f"heyoka ends with {outcome} at {taylor.time} s")
        return taylor.time, taylor.state.copy(), True


def by_heyoka(model, t, y, stop):
    """The state at `stop` or at the first event before it."""
    key = model.case.name, tuple(model.mode.items()), tuple(tuple(value.lines) for value in model.values)
    if key not in COMPILED:
        COMPILED[key] = Integrator(model, y)
    return COMPILED[key].advance(t, y, stop)
