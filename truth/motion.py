"""The motion of a machine in 96 digits, by power series in each mode and roots of polynomials.

This program shares no code and no law with the engine. Its rules:
- A *mode* gives each element a state. In a mode all forces are smooth, and the motion is a power series,
  found order by order from M s'' = F - W lambda, with lambda from e'' = 0 of the held contacts.
- A mode is right if in its own series each watched quantity begins negative. After an event all
  combinations of states are tried, held ones first; the first right one is taken.
- An event is the first root of a watched quantity. An interval is cleared only if a bound of the series proves it.
- Impacts: Newton's law in Moreau's form; all sets of impulses are tried.
"""

import itertools
from dataclasses import dataclass, field

import gmpy2
from gmpy2 import mpfr

import digits as d
from digits import advanced, as_fraction, first_root, inverse_of, real, sine, value
from parts import Part

NUDGE = mpfr("1e-20")  # of a state, for its effect on an event's time
LEADING = 12  # orders that decide a mode
HELD = ("closed", "stuck")


@dataclass
class State:
    time: mpfr
    s: list
    v: list
    x: dict = field(default_factory=dict)  # sliders
    y: dict = field(default_factory=dict)  # loads held by sampled blocks
    xb: dict = field(default_factory=dict)  # states of sampled blocks
    mode: dict = field(default_factory=dict)

    def copy(self):
        parts = (self.x, self.y, self.xb, self.mode)
        return State(self.time, list(self.s), list(self.v), *(dict(p) for p in parts))


class Motion:
    def __init__(self, machine, stop):
        self.m, self.stop = machine, stop
        self.n = len(machine.bodies)
        self.inverse = [1 / real(b.mass) if b.mass is not None else mpfr(0) for b in machine.bodies]
        self.weights = [real(b.weight) for b in machine.bodies]
        self.elements = [Part(e) for e in machine.elements]
        knots = {real(t): "knot" for t in machine.knots(stop)}
        for block in machine.blocks:
            k = 1
            while k * block["sample"] <= stop:
                knots[real(k * block["sample"])] = "sample"
                k += 1
        self.knots = sorted(knots)
        self.grams = {}
        self.size_v = mpfr(0)

    # Signals

    def coefficients(self, signal, time, order, clock, derivative=0):
        """Series of a signal about `time`, in tau with t = time + tau^clock."""
        out = [mpfr(0)] * (order + 1)
        if derivative == 0:
            out[0] += real(signal.constant)
        top = order // clock if signal.harmonics else 1
        for k in range(top + 1):
            if k * clock <= order and signal.harmonics:
                out[k * clock] += sine(signal.harmonics, time, k, derivative)
        fraction = as_fraction(time)
        for begin, value, slope in signal.active(fraction):
            if derivative == 0:
                out[0] += real(value) + real(slope) * (time - real(begin))
                if clock <= order:
                    out[clock] += real(slope)
            else:
                out[0] += real(slope)
        return out

    def acceleration(self, body, time, order, clock):
        if body.acceleration:
            return self.coefficients(body.acceleration, time, order, clock)
        if body.rate:
            return self.coefficients(body.rate, time, order, clock, 1)
        return self.coefficients(body.position, time, order, clock, 2) if body.position.harmonics else [mpfr(0)] * (order + 1)

    # The power series of a mode

    def gram(self, held):
        key = tuple(p.name for p in held)
        if key not in self.grams:
            rows = [[sum((a * b * self.inverse[i] for i, a in p.arms for j, b in q.arms if i == j), mpfr(0)) for q in held]
                    for p in held]
            self.grams[key] = inverse_of(rows)
        return self.grams[key]

    def expand(self, z, mode, order=None):
        """Series of positions, speeds, sliders, elongations, rates and forces in a mode."""
        order = order or d.ORDER
        clock = 2 if any(p.edge(z, mode[p.name]) for p in self.elements) else 1
        bodies, n = self.m.bodies, self.n
        S, V, A = [[x] for x in z.s], [[x] for x in z.v], [[] for _ in bodies]
        X = {name: [x] for name, x in z.x.items()}
        E, R, F = ({p.name: [] for p in self.elements} for _ in range(3))
        held = [p for p in self.elements if mode[p.name] in HELD and not p.slider]
        solve = self.gram(held) if held else None
        loads = [(l["on"], self.coefficients(l["signal"], z.time, order, clock)) for l in self.m.loads]
        for load in self.m.loads:
            if load["from"]:
                loads.append((load["on"], [real(load["factor"]) * z.y[load["from"]]] + [mpfr(0)] * order))
        given = {i: self.acceleration(b, z.time, order, clock) for i, b in enumerate(bodies) if b.mass is None}
        for p in self.elements:
            p.prepare(self, z, mode[p.name], order, clock)
        for k in range(order):
            for p in self.elements:
                E[p.name].append(sum((a * S[i][k] for i, a in p.arms), mpfr(0)))
                R[p.name].append(sum((a * V[i][k] for i, a in p.arms), mpfr(0)))
            acc = [given[i][k] if i in given else (self.weights[i] if k == 0 else mpfr(0)) for i in range(n)]
            for i, series in loads:
                acc[i] += series[k] * self.inverse[i]
            for p in self.elements:
                if p not in held:
                    f = p.force(k, E[p.name], R[p.name], X.get(p.name), mode[p.name])
                    F[p.name].append(f)
                    if f:
                        for i, a in p.arms:
                            acc[i] -= a * f * self.inverse[i]
            if held:
                wanted = [sum((a * acc[i] for i, a in p.arms), mpfr(0)) for p in held]
                for p, row in zip(held, solve):
                    force = sum((g * w for g, w in zip(row, wanted)), mpfr(0))
                    F[p.name].append(force)
                    for i, a in p.arms:
                        acc[i] -= a * force * self.inverse[i]
            for i in range(n):
                A[i].append(acc[i])
                V[i].append(advanced(A[i], k, clock))
                S[i].append(advanced(V[i], k, clock))
            for p in self.elements:
                if p.slider:
                    slips = mode[p.name] in ("up", "down")
                    X[p.name].append(advanced(R[p.name], k, clock) if slips else mpfr(0))
        return Series(S, V, X, E, R, F, clock)

    def watched(self, series, mode):
        return [row for p in self.elements for row in p.watched(series, mode[p.name])]

    # Events

    def right(self, z, mode):
        """Whether every watched quantity of a mode begins negative."""
        series = self.expand(z, mode, LEADING + 2)
        h = series.scale()
        for _, strict, p in self.watched(series, mode):
            first = next((c for k, c in enumerate(p[:LEADING]) if abs(c) * h**k > d.TINY), None)
            if first is None and strict or first is not None and first > 0:
                return False
        return True

    def select(self, z):
        """The mode that follows."""
        ways = [p.states(self, z) for p in self.elements]
        names = [p.name for p in self.elements]
        rank = {"closed": 0, "stuck": 0}
        choices = sorted(itertools.product(*ways), key=lambda c: sum(rank.get(s, 1) for s in c))
        for choice in choices:
            mode = dict(zip(names, choice))
            if self.right(z, mode):
                return mode
        raise RuntimeError(f"no mode at {float(z.time)}: {ways}")

    def impacts(self, z, told):
        """Impacts of this instant: rigid stops first, then freewheels."""
        for kind in ("stop", "freewheel") * 40:
            parts = [p for p in self.elements if p.kind == kind and p.rigid and p.touches(z)]
            if all(p.rate(z) <= d.TINY for p in parts):
                if kind == "freewheel" and not any(
                    p.rate(z) > d.TINY for p in self.elements if p.rigid and p.touches(z)):
                    return
                continue
            self.impact(z, [p for p in parts if self.takes_part(z, p)], told)
        raise RuntimeError(f"too many impacts at {float(z.time)}")

    def takes_part(self, z, part):
        """A stop that closes, or one that was closed and does not separate."""
        rate = part.rate(z)
        return rate > d.TINY or rate > -d.TINY and z.mode.get(part.name, "closed") == "closed"

    def impact(self, z, parts, told):
        u = [p.rate(z) for p in parts]
        slow = all(x < d.SLOW * self.size_v for x in u)
        back = [mpfr(0) if slow else p.restitution for p in parts]
        for size in range(1, len(parts) + 1):
            for chosen in itertools.combinations(range(len(parts)), size):
                solve = self.gram([parts[c] for c in chosen])
                if solve is None:
                    continue
                P = [sum(g * (1 + back[c]) * u[c] for g, c in zip(row, chosen)) for row in solve]
                if min(P) < -d.TINY:
                    continue
                v = list(z.v)
                for c, impulse in zip(chosen, P):
                    for i, a in parts[c].arms:
                        v[i] -= a * impulse * self.inverse[i]
                if all(sum(a * v[i] for i, a in p.arms) <= -r * x + d.TINY for p, r, x in zip(parts, back, u)):
                    for c, impulse in zip(chosen, P):
                        if impulse > d.TINY and not slow:
                            told.append(("impact", parts[c].section, u[c]))
                    z.v = v
                    return
        raise RuntimeError(f"no impact at {float(z.time)}")

    def settle(self, z, told, first=False):
        """Applies impacts and selects the next mode; appends the events to `told`."""
        before = dict(z.mode)
        self.impacts(z, told)
        z.mode = self.select(z)
        if not first:
            for p in self.elements:
                told.extend(p.told(before[p.name], z.mode[p.name], z))

    # Time

    def begin(self):
        s, v = [], []
        for b in self.m.bodies:
            at, rate = real(b.s), real(b.v)
            if b.position:
                at += real(b.position.constant) + sine(b.position.harmonics, mpfr(0), 0)
                rate += sine(b.position.harmonics, mpfr(0), 0, 1)
            if b.rate:
                rate += self.coefficients(b.rate, mpfr(0), 0, 1)[0]
            s.append(at)
            v.append(rate)
        z = State(mpfr(0), s, v)
        z.x = {p.name: real(p.numbers.get("slider", 0 * self.stop)) for p in self.elements if p.slider}
        for block in self.m.blocks:
            z.xb[block["name"]] = [mpfr(0)] * block["states"]
            for output in block["outputs"]:
                z.y[f"{block['name']}.{output}"] = mpfr(0)
        self.sample(z)
        told = []
        self.size_v = max([abs(x) for x in v] + [mpfr(1)])
        self.settle(z, told, True)
        return z, [(z.time, *row) for row in told]

    def sampled(self, z):
        """Blocks that sample now."""
        ticks = lambda b: z.time / real(b["sample"])
        return [b for b in self.m.blocks if abs(ticks(b) - gmpy2.rint(ticks(b))) < d.NEAR]

    def sample(self, z):
        for b in self.sampled(z):
            u = [(z.s if way == "s" else z.v)[i] for i, way in b["inputs"]]
            x, row = z.xb[b["name"]], lambda m, w, k: sum((real(g) * y for g, y in zip(m[k], w)), mpfr(0)) if m else mpfr(0)
            for k, output in enumerate(b["outputs"]):
                z.y[f"{b['name']}.{output}"] = row(b["c"], x, k) + row(b["d"], u, k)
            z.xb[b["name"]] = [row(b["a"], x, k) + row(b["b"], u, k) for k in range(b["states"])]

    def jump(self, z):
        """A knot of a prescribed rate."""
        for i, b in enumerate(self.m.bodies):
            if b.rate:
                z.v[i] = self.coefficients(b.rate, z.time, 0, 1)[0]

    def run(self, outputs, z=None):
        """States at the outputs, as (left, right) pairs, and events (time, kind, section, value)."""
        events, states, self.slopes = [], [], []
        fresh = z is None
        if z is None:
            z, events = self.begin()
        z = z.copy()
        todo = [t for t in outputs if t > z.time]
        if fresh:
            states.append((outputs[0], None, z.copy()))
        knots = [t for t in self.knots if t > z.time]
        while todo:
            target = min([todo[0]] + knots[:1])
            span = target - z.time
            root, reached = None, span < d.NEAR
            if not reached:
                self.size_v = max([self.size_v] + [abs(x) for x in z.v])
                series = self.expand(z, z.mode)
                h = series.length(span)
                root = series.first_root([p for _, _, p in self.watched(series, z.mode)], h)
                reached = root is None and series.whole(h, span)
                series.move(z, h if root is None else root)
            left, told = None, []
            if reached:
                z.time = target
            if root is not None:
                left = z.copy()
                self.settle(z, told)
                self.slopes.append((z.time, self.sensitivity(left)))
            elif reached and knots and target == knots[0]:
                left = z.copy()
                knots.pop(0)
                told = self.knot(z)
            events.extend((z.time, *row) for row in told)
            if left and states and abs(z.time - states[-1][0]) < d.NEAR:  # an event of the output time itself
                states[-1] = (states[-1][0], states[-1][1] or left, z.copy())
            if abs(z.time - todo[0]) < d.NEAR and not (knots and knots[0] <= z.time + d.NEAR):
                states.append((todo.pop(0), left, z.copy()))
        return states, events

    def sensitivity(self, z):
        """Effect of each position and speed on the time of an event, for each element that takes part."""
        zero = lambda at: self.watched(self.expand(at, z.mode, 3), z.mode)
        found = []
        for place, (name, _, p) in enumerate(zero(z)):
            if abs(p[0]) < d.NEAR and p[1] > d.TINY:
                effects = []
                for group in ("s", "v"):
                    for i in self.m.free():
                        moved = z.copy()
                        getattr(moved, group)[i] += NUDGE
                        effects.append(abs(zero(moved)[place][2][0] - p[0]) / NUDGE / p[1])
                found.append((name, effects))
        return found

    def hold(self, z):
        """Puts a moved state back onto its held contacts, by the least change in the metric of the masses."""
        held = [p for p in self.elements if z.mode[p.name] in HELD and not p.slider]
        for places, wanted in ((z.v, lambda p: p.rate(z)), (z.s, lambda p: p.e(z) - p.gap)):
            parts = [p for p in held if places is z.v or p.kind == "stop"]
            if not parts:
                continue
            off = [wanted(p) for p in parts]
            for p, row in zip(parts, self.gram(parts)):
                share = sum((g * x for g, x in zip(row, off)), mpfr(0))
                for i, a in p.arms:
                    places[i] -= a * share * self.inverse[i]

    def knot(self, z):
        """Jumps of prescribed rates, then samples."""
        told = []
        self.jump(z)
        self.settle(z, told)
        before = dict(z.y)
        self.sample(z)
        if self.sampled(z):
            if z.y != before:
                self.settle(z, told)
            return told + [("sample", "", None)]
        return told + [("knot", "", None)]


class Series:
    def __init__(self, S, V, X, E, R, F, clock):
        self.S, self.V, self.X, self.E, self.R, self.F, self.clock = S, V, X, E, R, F, clock

    def length(self, longest):
        """Length in tau of a step whose last coefficients are below d.TAIL."""
        h = longest if self.clock == 1 else gmpy2.sqrt(longest)
        for group in (self.S, self.V):
            size = max(abs(p[0]) + abs(p[1]) * h for p in group) or mpfr(1)
            for p in group:
                for k in (len(p) - 1, len(p) - 2, len(p) - 3):
                    if p[k]:
                        h = min(h, gmpy2.exp(gmpy2.log(d.TAIL * size / abs(p[k])) / k))
        return h

    def scale(self):
        """A time over which the motion changes by its own size."""
        k = len(self.V[0]) - 1
        rates = [mpfr("1e-3")]
        for p in self.V:
            size = max(abs(c) for c in p[:3]) or mpfr(1)
            rates += [gmpy2.exp(gmpy2.log(abs(c) / size) / i) for i, c in ((k, p[k]), (k - 1, p[k - 1])) if c]
        return 1 / max(rates)

    def whole(self, h, longest):
        return h == (longest if self.clock == 1 else gmpy2.sqrt(longest))

    def move(self, z, h):
        z.s = [value(p, h) for p in self.S]
        z.v = [value(p, h) for p in self.V]
        z.x = {name: value(p, h) for name, p in self.X.items()}
        z.time += h if self.clock == 1 else h * h

    def first_root(self, polynomials, h):
        best = None
        for p in polynomials:
            root = first_root(p, h if best is None else best)
            if root is not None and (best is None or root < best):
                best = root
        return best


