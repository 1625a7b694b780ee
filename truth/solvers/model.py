"""A case as a switched ordinary differential equation in doubles, for solvers with event functions.

`rate(t, y)` is y' in the present mode, `watched(t, y)` the functions whose rise through zero ends the mode, and `switch(t, y)`
applies impacts and chooses the next mode, one contact after the other. This is a plain method of a solver's author: it does not
find which of several contacts change together, and takes slow bounces for rest. The score shows where this matters.
Not supported: freewheels, sliders, springs by points, sampled blocks (error `Unsupported`).
"""

import sys
from fractions import Fraction
from math import cos, exp, pi, sin
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cases  # noqa: E402
from machine import Signal, read  # noqa: E402

REST = 1e-7  # closing speed in m/s below which a bounce counts as rest
TOUCH = 1e-9  # distance in m within which a stop counts as touching
NO_FORCE = 1e-9  # force in N below which a closed stop opens
STILL = 1e-9  # sliding speed in m/s that counts as zero


class Unsupported(Exception):
    """An element that this model does not have."""


class Value:
    """A signal and its first two derivatives in doubles."""

    def __init__(self, signal):
        self.signal = signal
        self.constant = float(signal.constant)
        self.waves = [tuple(map(float, h)) for h in signal.harmonics]
        self.activate(Fraction(0))

    def activate(self, time):
        self.lines = [tuple(map(float, line)) for line in self.signal.active(time)]

    def __call__(self, t, order=0):
        total = self.constant if order == 0 else 0.0
        for amplitude, frequency, phase in self.waves:
            w = 2 * pi * frequency
            total += amplitude * w**order * (sin, cos, lambda x: -sin(x))[order](w * t + phase)
        for begin, value, slope in self.lines:
            total += value + slope * (t - begin) if order == 0 else slope if order == 1 else 0.0
        return total


class Model:
    def __init__(self, name):
        self.case = cases.Case(name)
        self.m = read(self.case.folder, self.case.stop)
        n = self.n = len(self.m.bodies)
        if self.m.blocks:
            raise Unsupported("sampled blocks")
        for e in self.m.elements:
            if e.kind == "freewheel" or {"slip", "points"} & set(e.numbers) or e.numbers.get("law"):
                raise Unsupported(f"{e.kind} with {', '.join(e.numbers) or 'no numbers'}")
        self.weights = np.array([float(b.weight) for b in self.m.bodies])
        self.inverse = np.array([0.0 if b.mass is None else 1 / float(b.mass) for b in self.m.bodies])
        self.w = {e.name: np.array([float(dict(e.arms).get(i, 0)) for i in range(n)]) for e in self.m.elements}
        self.numbers = {e.name: {k: float(v) for k, v in e.numbers.items() if isinstance(v, Fraction)} for e in self.m.elements}
        self.signals = {(e.name, k): Value(v) for e in self.m.elements for k, v in e.numbers.items() if isinstance(v, Signal)}
        self.loads = [(load["on"], Value(load["signal"])) for load in self.m.loads]
        self.given = [(i, b, Value(b.position or b.rate or b.acceleration)) for i, b in enumerate(self.m.bodies) if b.mass is None]
        self.values = [*self.signals.values(), *(v for _, v in self.loads), *(v for _, _, v in self.given)]
        self.exact = {float(t): t for t in self.m.knots(self.case.stop)}
        self.knots = sorted(self.exact)
        y = [float(b.s) for b in self.m.bodies] + [float(b.v) for b in self.m.bodies]
        for i, b, value in self.given:
            y[i] += value(0) if b.position else 0.0
            y[n + i] += value(0, 1) if b.position else value(0) if b.rate else 0.0
        self.mode = {e.name: {"stop": "open", "friction": "up"}.get(e.kind, "") for e in self.m.elements}
        self.events = []
        self.start = self.switch(0.0, np.array(y), first=True)

    def activate(self, t):
        """Takes the lines of all signals after the knot t."""
        exact = self.exact.get(t)
        if exact is not None:
            for value in self.values:
                value.activate(exact)

    # Forces

    def force(self, e, t, y):
        x, v, k = self.w[e.name] @ y[: self.n], self.w[e.name] @ y[self.n :], self.numbers[e.name]
        stiff = self.signals[e.name, "stiffness"](t) if (e.name, "stiffness") in self.signals else 0.0
        if e.kind in ("spring", "damper"):
            return k.get("preload", 0) + stiff * x + k.get("damping", 0) * v + k.get("cubic", 0) * x**3
        if e.kind == "friction":
            level = self.signals[e.name, "force"](t)
            if "stribeck" in k:
                level += (self.signals[e.name, "static"](t) - level) * exp(-((v / k["stribeck"]) ** 2))
            return {"up": 1, "down": -1, "off": 0}[self.mode[e.name]] * max(level, 0.0)
        x -= k["gap"]
        if "restitution" in k or self.mode[e.name] == "open":
            return 0.0
        return max(0.0, stiff * max(x, 0.0) ** k.get("exponent", 1) * (1 + 1.5 * k.get("dissipation", 0) * v) + k.get("damping", 0) * v)

    def held(self):
        return [e for e in self.m.elements if self.mode[e.name] in ("closed", "stuck")]

    def accelerations(self, t, y):
        a = self.weights.copy()
        for i, value in self.loads:
            a[i] += value(t) * self.inverse[i]
        for i, b, value in self.given:
            a[i] = value(t, 2 if b.position else 1 if b.rate else 0)
        held = self.held()
        for e in self.m.elements:
            if e not in held:
                a -= self.w[e.name] * self.inverse * self.force(e, t, y)
        forces = {}
        if held:
            W = np.array([self.w[e.name] for e in held])
            found = np.linalg.lstsq(W * self.inverse @ W.T, W @ a, rcond=None)[0]
            a = a - self.inverse * (W.T @ found)
            forces = {e.name: f for e, f in zip(held, found)}
        return a, forces

    def rate(self, t, y):
        return np.concatenate([y[self.n :], self.accelerations(t, y)[0]])

    # Events

    def watched(self, t, y):
        values = []
        forces = self.accelerations(t, y)[1] if self.held() else {}
        for e in self.m.elements:
            x, v, state = self.w[e.name] @ y[: self.n], self.w[e.name] @ y[self.n :], self.mode[e.name]
            if e.kind == "stop":
                gap = self.numbers[e.name]["gap"]
                if state == "closed":
                    values.append(-forces[e.name])
                elif state == "open":
                    values.append(x - gap)
                else:
                    values.append(gap - x if not self.numbers[e.name].get("damping") else -self.raw(e, t, y))
            elif e.kind == "friction":
                level = self.signals.get((e.name, "static"), self.signals[e.name, "force"])(t)
                values.append(abs(forces[e.name]) - level if state == "stuck" else {"up": -v, "down": v}.get(state, level))
        return np.array(values)

    def raw(self, e, t, y):
        """The force of a pressed stop without its limit."""
        x, v = self.w[e.name] @ y[: self.n] - self.numbers[e.name]["gap"], self.w[e.name] @ y[self.n :]
        return self.signals[e.name, "stiffness"](t) * x + self.numbers[e.name].get("damping", 0) * v

    def tell(self, t, kind, e):
        self.events.append((float(t), kind, f"{e.kind}.{e.name}"))

    def switch(self, t, y, first=False):
        """State and mode after an instant."""
        self.activate(t)
        y = y.copy()
        for i, b, value in self.given:
            if b.rate:
                y[self.n + i] = value(t)
        before = dict(self.mode)
        self.impacts(t, y)
        for e in self.m.elements:
            self.choose(e, t, y)
        for _ in self.m.elements:
            for e in self.held():
                if self.mode[e.name] == "closed" and self.accelerations(t, y)[1][e.name] < NO_FORCE:
                    self.mode[e.name] = "open"
        kinds = {"closed": "close", "open": "open", "stuck": "stick", "up": "slip", "down": "slip", "pressed": "press", "off": "level"}
        for e in self.m.elements:
            if self.mode[e.name] != before[e.name] and not first:
                rigid = "restitution" in self.numbers[e.name]
                if before[e.name] == "off":
                    self.tell(t, "level", e)
                    continue
                self.tell(t, "free" if e.kind == "stop" and not rigid and self.mode[e.name] == "open" else kinds[self.mode[e.name]], e)
        return y

    def impacts(self, t, y):
        rigid = [e for e in self.m.elements if "restitution" in self.numbers[e.name]]
        for _ in range(100):
            v = y[self.n :]
            touching = [e for e in rigid if abs(self.w[e.name] @ y[: self.n] - self.numbers[e.name]["gap"]) < TOUCH]
            closing = [e for e in touching if self.w[e.name] @ v > REST]
            for e in touching:
                if e not in closing:
                    self.mode[e.name] = "closed" if abs(self.w[e.name] @ v) <= REST else "open"
            if not closing:
                return
            e = max(closing, key=lambda e: self.w[e.name] @ v)
            w, speed = self.w[e.name], self.w[e.name] @ v
            back = self.numbers[e.name]["restitution"]
            self.tell(t, "impact", e)
            self.mode[e.name] = "closed" if back * speed <= REST else "open"
            y[self.n :] = v - self.inverse * w * ((1 + back) * speed / (w * self.inverse @ w))

    def choose(self, e, t, y):
        """The state of a compliant stop or a friction."""
        x, v = self.w[e.name] @ y[: self.n], self.w[e.name] @ y[self.n :]
        if e.kind == "stop" and "restitution" not in self.numbers[e.name]:
            gap = self.numbers[e.name]["gap"]
            edge = TOUCH * self.signals[e.name, "stiffness"](t) if v < 0 else 0.0
            pulls = self.numbers[e.name].get("damping") and self.raw(e, t, y) < edge
            inside = x > gap + TOUCH or abs(x - gap) <= TOUCH and v > 0
            self.mode[e.name] = "pressed" if inside and not pulls else "open"
        elif e.kind == "friction":
            level = self.signals[e.name, "force"](t)
            held = self.signals.get((e.name, "static"), self.signals[e.name, "force"])(t)
            if held <= 0:
                self.mode[e.name] = "off"
            elif abs(v) > STILL:
                self.mode[e.name] = "up" if v > 0 else "down"
            else:
                was, self.mode[e.name] = self.mode[e.name], "stuck"
                force = self.accelerations(t, y)[1][e.name]
                most = held if was != "stuck" else held * (1 - 1e-9)
                if abs(force) >= most:
                    self.mode[e.name] = "up" if force > 0 else "down"
