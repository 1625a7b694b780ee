"""Checks cases by a second program: python check.py [CASE ...]

The second program shares with the first one only the reader of the file. It takes from `events.csv` what happens (the kinds
of events, in order) and finds the motion again: event times by Newton's method from the listed ones, flights by
the exponential of a matrix in ball arithmetic (FLINT), or, if the machine is curved, by Gauss's collocation with 20 nodes.
Impacts are the minimum of a quadratic form by an active-set method. Every flight is sampled: a motion that obeys the equations,
the conditions of its events and all inequalities is the motion of the machine, since that motion is unique.
"""

import csv
import itertools
import sys
from fractions import Fraction

from flint import arb, fmpq

import cases
from machine import read
from second import SIDES, Second, ball, float_of, mid

AGREE = 1e-25  # largest difference from truth.csv, relative to the largest value of the state
SAMPLES = 12  # of each flight, at which all inequalities are looked at
SAMPLES_OF_CURVED = 4
HOLDS = -1e-20  # least margin of an inequality: events are found to 1e-60
NEAR = arb("1e-40")
STEP = 1e-60  # last step of Newton's method


class Disagrees(Exception):
    pass


class Replay:
    def __init__(self, case):
        self.case = case
        self.m = read(case.folder, case.stop)
        self.p = Second(self.m, case.stop)
        self.elements = {f"{el.kind}.{el.name}": el for el in self.m.elements}
        self.truth, self.events = cases.read_truth(case), cases.read_events(case)
        self.sizes = {name: max(abs(float(row[name])) for row in self.truth) or 1.0 for name in case.states(self.m)}
        self.worst, self.latest = 0.0, 0.0

    def start(self):
        p, n = self.p, self.p.n
        p.activate(Fraction(0))
        z = [arb(0)] * p.size
        z[p.one] = arb(1)
        for c, _ in p.wave.values():
            z[c] = arb(1)
        for i, b in enumerate(self.m.bodies):
            z[i], z[n + i] = ball(b.s), ball(b.v)
            if b.position:
                z[i] += p.waves(b.position, z, 0) + ball(b.position.constant)
                z[n + i] += p.waves(b.position, z, 1)
            if b.rate:
                z[n + i] += p.signal(b.rate, z)
        for el in p.sliders:
            z[p.x[el.name]] = p.number(el, "slider")
        self.mode = {el.name: "" for el in self.m.elements}
        for row in self.events:
            if row["kind"] == "start":
                state = row["value"]
                self.mode[row["element"].split(".")[1]] = int(state) if state.isdigit() else state
        first = [row for row in self.events if row["kind"] != "start" and float(row["time"]) == 0.0]
        z = self.sample(z, Fraction(0))
        return self.apply(z, first, Fraction(0)) if first else z

    def run(self):
        z, now = self.start(), arb(0)
        outputs = iter(self.truth)
        self.output = next(outputs)
        self.compare(z, None, now, outputs)
        rows = [row for row in self.events if row["kind"] != "start" and float(row["time"]) > 0]
        for time, group in itertools.groupby(rows, key=lambda row: row["time"]):
            group = list(group)
            z, now = self.to_instant(z, now, arb(time), group, outputs)
        self.flight(z, now, arb(fmpq(self.case.stop.numerator, self.case.stop.denominator)), outputs, last=True)
        return self.worst, self.latest

    def to_instant(self, z, now, listed, group, outputs):
        exact = self.exact_time(listed, group)
        if exact is not None:
            then = ball(exact)
            before = self.flight(z, now, then, outputs)
        else:
            before, then = self.search(z, now, listed, group)
            self.flight(z, now, then, outputs)
            self.latest = max(self.latest, abs(float_of(then - listed)) / float_of(then))
        after = self.apply(before, group, exact)
        self.compare(before, after, then, outputs)
        return after, then

    def exact_time(self, listed, group):
        """The exact time of a knot or a sample, None if the instant is an event of the state."""
        if not any(row["kind"] in ("knot", "sample") for row in group):
            return None
        times = self.m.knots(self.case.stop)
        for b in self.m.blocks:
            times.append(b["sample"] * round(float_of(listed) / float(b["sample"])))
        return min(times, key=lambda t: abs(float_of(ball(t) - listed)))

    def search(self, z, now, listed, group):
        """State and time at which the first usable condition of the instant is zero."""
        dt = listed - now
        self.p.elapsed, self.p.left = arb(0), dt
        arrived = self.p.flow(z, self.mode, dt)
        best = None
        for row in group:
            for g in self.conditions(row):
                slope = self.slope(g, arrived)
                if abs(float_of(slope)) > 1e-46 and (best is None or abs(float_of(g(arrived) / slope)) < best[0]):
                    best = abs(float_of(g(arrived) / slope)), g
        if best is None or best[0] > 1e-28 * (1 + abs(float_of(listed))):
            raise Disagrees(f"no condition of {[r['kind'] for r in group]} is zero at {float_of(listed)} s: off by {best and best[0]}")
        g = best[1]
        for _ in range(8):
            step = g(arrived) / self.slope(g, arrived)
            dt = mid(dt - step)
            self.p.elapsed, self.p.left = arb(0), arb(0)
            arrived = self.p.flow(arrived, self.mode, -mid(step))
            if abs(float_of(step)) < STEP:
                break
        return arrived, now + dt

    def slope(self, g, z):
        """Derivative over time of a condition, by a difference in many digits."""
        h = arb("1e-45")
        rates = self.p.derivative(z, self.mode)
        return mid((g([a + h * b for a, b in zip(z, rates)]) - g(z)) / h)

    def conditions(self, row):
        p, el = self.p, self.elements.get(row["element"])
        if el is None:
            return
        e, r = lambda z: p.e(el, z), lambda z: p.rate(el, z)
        x = lambda z: e(z) - p.number(el, "gap")
        held = lambda z: p.accelerations(z, self.mode)[1][el.name]
        state, kind = self.mode[el.name], row["kind"]
        if kind in ("impact", "close"):
            yield r if el.kind == "freewheel" else x
        elif kind == "open" and state == "closed":
            yield held
        elif el.name in p.x:
            branch = lambda z: p.stiffness(el) * (e(z) - z[p.x[el.name]])
            slip = p.number(el, "slip")
            yield from [r] if state in SIDES else [lambda z: branch(z) - slip, lambda z: branch(z) + slip]
        elif kind in ("stick", "slip", "level") and el.kind == "friction":
            if state in SIDES:
                yield r
            elif state == "stuck":
                yield lambda z: held(z) - p.level(el, z, "static")
                yield lambda z: held(z) + p.level(el, z, "static")
            yield lambda z: p.level(el, z)
            yield lambda z: p.level(el, z, "static")
        elif kind in ("press", "free", "cap"):
            yield x
            if "damping" in el.numbers and "exponent" not in el.numbers:
                yield lambda z: p.stiffness(el) * x(z) + p.number(el, "damping") * r(z)
                yield lambda z: p.number(el, "damping") * r(z) - p.stiffness(el) * x(z)
        elif kind == "corner":
            for point, _ in el.numbers["points"]:
                yield lambda z, point=point: e(z) - ball(point)

    def apply(self, z, group, exact):
        """State after an instant; sets the modes."""
        p = self.p
        if exact is not None:
            p.activate(exact)
            z = list(z)
            for i, b in enumerate(self.m.bodies):
                if b.rate:
                    z[p.n + i] = mid(p.signal(b.rate, z))
        for kind in ("stop", "freewheel") * 20:
            rigid = [el for el in self.m.elements if el.kind == kind and (kind == "freewheel" or "restitution" in el.numbers)]
            touching = [el for el in rigid if kind == "freewheel" or abs(p.e(el, z) - p.number(el, "gap")) < NEAR]
            if any(mid(p.rate(el, z)) > arb("1e-60") for el in touching):
                part = [el for el in touching if mid(p.rate(el, z)) > arb("1e-60")
                        or self.mode[el.name] == "closed" and mid(p.rate(el, z)) > arb("-1e-60")]
                z = p.impact(z, part)
        for row in group:
            if row["element"] in self.elements:
                el = self.elements[row["element"]]
                self.mode[el.name] = self.state(el, row, z)
        if exact is not None:
            z = self.sample(z, exact)
        return z

    def state(self, el, row, z):
        kind, state, value = row["kind"], self.mode[el.name], row["value"]
        fixed = {"impact": state, "close": "closed", "open": "open", "stick": "stuck"}  # a stop that leaves rest also has an `open`
        if kind in fixed:
            return fixed[kind]
        if kind in ("slip", "level"):
            return "off" if not value else "up" if float(value) > 0 else "down"
        if kind == "corner":
            return state + (1 if float(value) > 0 else -1)
        if kind == "cap":
            return "pressed" if state == "capped" else "capped"
        x, r = self.p.e(el, z) - self.p.number(el, "gap"), self.p.rate(el, z)
        if kind == "press":
            capped = el.numbers.get("law") == "elastogap" and "damping" in el.numbers and float_of(x) < 1e-30
            return "capped" if capped else "pressed"
        return "free" if float_of(x) > 1e-30 else "below"

    def sample(self, z, time):
        z = list(z)
        for b in self.m.blocks:
            if (time / b["sample"]).denominator != 1:
                continue
            x = self.p.blocks[b["name"]]
            u = [z[(0 if way == "s" else self.p.n) + i] for i, way in b["inputs"]]
            row = lambda key, w, k: sum((ball(g) * y for g, y in zip(b[key][k], w)), arb(0)) if b[key] else arb(0)
            for k, output in enumerate(b["outputs"]):
                z[self.p.y[f"{b['name']}.{output}"]] = mid(row("c", x, k) + row("d", u, k))
            self.p.blocks[b["name"]] = [mid(row("a", x, k) + row("b", u, k)) for k in range(b["states"])]
        return z

    def flight(self, z, now, then, outputs, last=False):
        """Follows a flight; compares outputs and samples inequalities on the way."""
        p, span, done = self.p, then - now, arb(0)
        whole, samples = span, SAMPLES_OF_CURVED if self.p.curved else SAMPLES
        stops = [span * k / samples for k in range(1, samples + 1)] if float_of(span) > 1e-12 else [span]
        while stops:
            p.elapsed, p.left = done, whole - done
            due = arb(self.output["time"]) - now if self.output else None
            output = due is not None and float_of(due - stops[0]) < (1e-60 if last else -1e-30)
            target = due if output else stops.pop(0)
            z, done = self.p.flow(z, self.mode, target - done), target
            if output:
                self.compare(z, None, now + done, outputs)
            elif stops:
                self.look(z, now + done)
        return z

    def look(self, z, time):
        for el in self.m.elements:
            if self.mode[el.name] == "free" and float_of(self.p.e(el, z) - self.p.number(el, "gap")) <= 0:
                self.mode[el.name] = "below"
        for name, margin in self.p.margins(z, self.mode):
            if float_of(margin) < HOLDS:
                raise Disagrees(f"{name} is {self.mode[name]} at {float_of(time)} s with margin {float_of(margin):.3e}")

    def compare(self, left, right, time, outputs):
        """Compares the rows of one output time, both sides of an event if the table has two."""
        while self.output and abs(float_of(arb(self.output["time"]) - time)) < 1e-35:
            row, self.output = self.output, next(outputs, None)
            twice = self.output and self.output["time"] == row["time"]
            z = left if right is None or twice else right
            for name in self.sizes:
                body, way = name.split(".")
                i = [b.name for b in self.m.bodies].index(body)
                off = abs(float_of(z[i if way == "s" else self.p.n + i] - arb(row[name]))) / self.sizes[name]
                self.worst = max(self.worst, off)


def check(name):
    replay = Replay(cases.Case(name))
    worst, latest = replay.run()
    if replay.output is not None:
        raise Disagrees(f"no comparison from {replay.output['time']} s on")
    if not worst < AGREE or not latest < AGREE:
        raise Disagrees(f"states differ by {worst:.1e}, event times by {latest:.1e}; expected less than {AGREE:g}")
    return worst, latest


def main():
    bad = 0
    for name in sys.argv[1:] or cases.names():
        try:
            worst, latest = check(name)
            print(f"{name}: states agree to {worst:.1e}, event times to {latest:.1e}", flush=True)
        except Disagrees as error:
            bad += 1
            print(f"{name}: {error}", flush=True)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
