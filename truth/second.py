"""The second program: the motion of a case found again from the kinds of its events. See check.py."""

import math
from fractions import Fraction

from flint import arb, arb_mat, ctx, fmpq

from machine import Signal

ctx.prec = 400
STAGES = 20
PI = arb.pi()
AGREE = 1e-34  # two lengths of a step of collocation agree to this; the tables are compared to 1e-25
SETTLED = 1e-46  # change of the last iteration of a step of collocation
SIDES = {"up": 1, "down": -1}


def ball(x):
    return arb(fmpq(x.numerator, x.denominator))


def mid(x):
    return x.mid()


class Second:
    def __init__(self, machine, stop):
        self.m, self.n = machine, len(machine.bodies)
        self.inverse = [arb(0) if b.mass is None else 1 / ball(b.mass) for b in machine.bodies]
        self.sliders = [e for e in machine.elements if "slip" in e.numbers]
        self.outputs = [f"{b['name']}.{o}" for b in machine.blocks for o in b["outputs"]]
        signals = [l["signal"] for l in machine.loads] + [
            s for b in machine.bodies for s in (b.position, b.rate, b.acceleration) if s]
        signals += [s for e in machine.elements for s in e.numbers.values() if isinstance(s, Signal)]
        self.frequencies = sorted({h[1] for s in signals for h in s.harmonics})
        at = 2 * self.n
        self.x = {e.name: at + k for k, e in enumerate(self.sliders)}
        at += len(self.sliders)
        self.y = {o: at + k for k, o in enumerate(self.outputs)}
        at += len(self.outputs)
        self.one, self.t = at, at + 1
        self.wave = {f: (at + 2 + 2 * k, at + 3 + 2 * k) for k, f in enumerate(self.frequencies)}
        self.size = at + 2 + 2 * len(self.frequencies)
        self.curved = any(key in e.numbers for e in machine.elements
                          for key in ("cubic", "quadratic", "exponent", "dissipation", "stribeck"))
        plain = lambda e: {k: ball(v) for k, v in e.numbers.items() if isinstance(v, Fraction)}
        self.numbers = {e.name: plain(e) for e in machine.elements}
        self.weights = [ball(b.weight) for b in machine.bodies]
        self.turned = {id(s): [self.turn(*h) for h in s.harmonics] for s in signals}
        self.constants = {id(s): ball(s.constant) for s in signals}
        ctx.prec = 260 if self.curved else 400
        self.arms = {e.name: [(i, ball(a)) for i, a in e.arms] for e in machine.elements}
        self.length, self.elapsed, self.left = 1e-3, arb(0), arb(1)
        self.blocks = {b["name"]: [arb(0)] * b["states"] for b in machine.blocks}

    # Signals, from the coordinates one, t, cos, sin

    def waves(self, signal, z, order):
        total = arb(0)
        for (i, j), w, by_cos, by_sin in self.turned[id(signal)]:
            up = z[j] * by_cos + z[i] * by_sin
            total += (up, w * (z[i] * by_cos - z[j] * by_sin), -w * w * up)[order] if order else up
        return total

    def turn(self, amplitude, frequency, phase):
        """Places of cosine and sine, angular frequency, and the amplitude's parts for a harmonic."""
        a, p = ball(amplitude), ball(phase)
        return self.wave[frequency], 2 * PI * ball(frequency), a * p.cos(), a * p.sin()

    def signal(self, signal, z, order=0):
        total = self.waves(signal, z, order)
        if order == 0:
            total += self.constants[id(signal)] * z[self.one]
        for begin, value, slope in self.active[id(signal)]:
            if order == 0:
                total += value * z[self.one] + slope * (z[self.t] - begin * z[self.one])
            else:
                total += slope * z[self.one]
        return total

    def activate(self, time):
        """Chooses the lines of all signals after `time`."""
        signals = [l["signal"] for l in self.m.loads] + [s for b in self.m.bodies for s in (b.position, b.rate, b.acceleration) if s]
        signals += [s for e in self.m.elements for s in e.numbers.values() if isinstance(s, Signal)]
        self.active = {id(s): [tuple(map(ball, line)) for line in s.active(time)] for s in signals}
        self.flows = {}

    # Forces

    def e(self, el, z):
        return sum((a * z[i] for i, a in self.arms[el.name]), arb(0))

    def rate(self, el, z):
        return sum((a * z[self.n + i] for i, a in self.arms[el.name]), arb(0))

    def number(self, el, key, default=0):
        return self.numbers[el.name].get(key, arb(default))

    def level(self, el, z, key="force"):
        return self.signal(el.numbers.get(key, el.numbers["force"]), z)

    def stiffness(self, el):
        return self.signal(el.numbers["stiffness"], [arb(i == self.one) for i in range(self.size)])

    def force(self, el, state, z):
        e, r, one = self.e(el, z), self.rate(el, z), z[self.one]
        get = lambda key, default=0: self.number(el, key, default)
        if el.kind == "damper":
            return get("damping") * r + get("cubic") * r**3
        if el.kind == "spring":
            if "points" in el.numbers:
                (e0, f0), (e1, f1) = [(ball(a), ball(b)) for a, b in el.numbers["points"][state : state + 2]]
                return (f1 - f0) / (e1 - e0) * (e - e0 * one) + f0 * one + get("damping") * r
            k = self.stiffness(el) if "stiffness" in el.numbers else arb(0)
            if el.name in self.x:
                return k * (e - z[self.x[el.name]]) + get("damping") * r
            straight = get("preload") * one + k * e + get("damping") * r
            return straight + get("cubic") * e**3 if "cubic" in el.numbers else straight
        if el.kind == "friction":
            if state == "off":
                return arb(0)
            force = self.level(el, z)
            if "stribeck" in el.numbers:
                force += (self.level(el, z, "static") - force) * (-((r / get("stribeck")) ** 2)).exp()
            return SIDES[state] * force
        if el.kind == "stop" and state in ("pressed", "capped"):
            x, k = e - get("gap") * one, self.stiffness(el)
            if "exponent" in el.numbers or "dissipation" in el.numbers:
                power = mid(x) ** get("exponent", 1) if mid(x) > 0 else arb(0)
                return k * power * (1 + arb(3) / 2 * get("dissipation") * r) + get("damping") * r
            return 2 * k * x if state == "capped" else k * x + get("damping") * r
        return arb(0)

    def accelerations(self, z, mode):
        acc = []
        for i, b in enumerate(self.m.bodies):
            if b.mass is not None:
                acc.append(self.weights[i] * z[self.one])
            elif b.acceleration:
                acc.append(self.signal(b.acceleration, z))
            elif b.rate:
                acc.append(self.signal(b.rate, z, 1))
            else:
                acc.append(self.waves(b.position, z, 2))
        for load in self.m.loads:
            force = ball(load["factor"]) * z[self.y[load["from"]]] if load["from"] else self.signal(load["signal"], z)
            acc[load["on"]] += force * self.inverse[load["on"]]
        held = [el for el in self.m.elements if mode[el.name] in ("closed", "stuck") and el.name not in self.x]
        for el in self.m.elements:
            if el not in held:
                f = self.force(el, mode[el.name], z)
                for i, a in self.arms[el.name]:
                    acc[i] -= a * f * self.inverse[i]
        forces = {}
        if held:
            gram = arb_mat([[self.mobility(p, q) for q in held] for p in held])
            wanted = arb_mat([[sum((a * acc[i] for i, a in self.arms[el.name]), arb(0))] for el in held])
            found = gram.solve(wanted)
            for k, el in enumerate(held):
                forces[el.name] = found[k, 0]
                for i, a in self.arms[el.name]:
                    acc[i] -= a * found[k, 0] * self.inverse[i]
        return acc, forces

    def mobility(self, p, q):
        return sum((a * b * self.inverse[i] for i, a in self.arms[p.name] for j, b in self.arms[q.name] if i == j), arb(0))

    def derivative(self, z, mode):
        out = [arb(0)] * self.size
        out[: self.n] = z[self.n : 2 * self.n]
        out[self.n : 2 * self.n] = self.accelerations(z, mode)[0]
        for el in self.sliders:
            out[self.x[el.name]] = self.rate(el, z) if mode[el.name] in SIDES else arb(0)
        out[self.t] = z[self.one]
        for f, (c, s) in self.wave.items():
            w = 2 * PI * ball(f)
            out[c], out[s] = -w * z[s], w * z[c]
        return out

    # Flights

    def flow(self, z, mode, dt):
        if not self.curved:
            key = tuple(sorted(mode.items()))
            if key not in self.flows:
                columns = [self.derivative([arb(i == j) for i in range(self.size)], mode) for j in range(self.size)]
                self.flows[key] = arb_mat([[columns[j][i] for j in range(self.size)] for i in range(self.size)])
            moved = (self.flows[key] * dt).exp() * arb_mat([[x] for x in z])
            return [mid(moved[i, 0]) for i in range(self.size)]
        return self.collocate(z, mode, dt)

    def collocate(self, z, mode, dt):
        """Gauss's collocation of a part of a flight, `self.elapsed` after its begin and `self.left` before its end.

        At the edges of a contact with an exponent the motion has roots of the time since, or until, the edge. So the first half
        of such a flight is followed in the square root of the elapsed time, and the second half in the square root of the
        remaining time.
        """
        if abs(dt) < arb("1e-30"):
            return [mid(a + dt * b) for a, b in zip(z, self.derivative(z, mode))]
        edges = any("exponent" in el.numbers and mode[el.name] == "pressed" for el in self.m.elements)
        if not edges:
            return self.pieces(lambda u, y: self.derivative(y, mode), z, arb(0), dt)
        begin, whole = self.elapsed, self.elapsed + self.left
        end, half = begin + dt, (self.elapsed + self.left) / 2
        grow = lambda u, y: [2 * u * x for x in self.derivative(y, mode)]
        fall = lambda u, y: [-2 * u * x for x in self.derivative(y, mode)]
        if float_of(begin - half) < 0:
            first = min(end, half)
            z = self.pieces(grow, z, root(begin), root(first))
            begin = first
        if float_of(end - begin) > 0:
            z = self.pieces(fall, z, root(whole - begin), root(whole - end))
        return z

    def pieces(self, f, z, a, b):
        """From a to b in equal steps; half the length until both agree. The next flight begins with the length that just agrees."""
        span = float_of(abs(b - a))
        count, last = max(1, math.ceil(span / self.length)), None
        for _ in range(12):
            h = (b - a) / count
            now = z
            for k in range(count):
                now = gauss_step(f, now, a + k * h, h)
                if now is None:
                    break
            if now and last:
                off = max(abs(float_of(p - q)) / (1 + abs(float_of(p))) for p, q in zip(now, last))
                if off < AGREE:
                    allowed = (AGREE / max(off, AGREE**2)) ** (0.5 / STAGES)
                    self.length = 0.8 * min(allowed, 4.0) * 2 * span / count
                    return now
            last, count = now, 2 * count
        raise RuntimeError("collocation does not settle")

    # Impacts

    def impact(self, z, touching):
        """Impulses P >= 0 with the least (1/2) P G P - P (1 + restitution) u, by an active set."""
        u = [mid(self.rate(el, z)) for el in touching]
        b = [(1 + self.number(el, "restitution")) * x for el, x in zip(touching, u)]
        gram = [[self.mobility(p, q) for q in touching] for p in touching]
        P, active = [arb(0)] * len(touching), set()
        for _ in range(200):
            slack = [b[i] - sum(g * p for g, p in zip(gram[i], P)) for i in range(len(P))]
            worst = max((i for i in range(len(P)) if i not in active), key=lambda i: float_of(slack[i]), default=None)
            if worst is None or mid(slack[worst]) < arb("1e-60"):
                break
            active.add(worst)
            while True:
                rows = sorted(active)
                found = arb_mat([[gram[i][j] for j in rows] for i in rows]).solve(arb_mat([[b[i]] for i in rows]))
                trial = {i: mid(found[k, 0]) for k, i in enumerate(rows)}
                if all(x >= 0 for x in trial.values()):
                    P = [trial.get(i, arb(0)) for i in range(len(P))]
                    break
                reach = min(P[i] / (P[i] - x) for i, x in trial.items() if x < 0)
                P = [p + reach * (trial.get(i, arb(0)) - p) for i, p in enumerate(P)]
                active = {i for i in active if P[i] > arb("1e-80")}
        out = list(z)
        for el, p in zip(touching, P):
            for i, a in self.arms[el.name]:
                out[self.n + i] = mid(out[self.n + i] - a * p * self.inverse[i])
        return out

    # Inequalities: each margin is at least 0 in a right motion

    def margins(self, z, mode):
        _, held = self.accelerations(z, mode)
        for el in self.m.elements:
            state, e, r = mode[el.name], self.e(el, z), self.rate(el, z)
            gap = self.number(el, "gap")
            if el.kind == "freewheel" or el.kind == "stop" and "restitution" in el.numbers:
                if state == "closed":
                    yield el.name, held[el.name]
                else:
                    yield el.name, -r if el.kind == "freewheel" else gap - e
            elif el.name in self.x:
                b, slip = self.stiffness(el) * (e - z[self.x[el.name]]), self.number(el, "slip")
                yield el.name, slip - abs(b)
                if state in SIDES:
                    yield el.name, SIDES[state] * r
            elif el.kind == "friction":
                level = self.level(el, z, "static") if state == "stuck" else self.level(el, z)
                if state == "stuck":
                    yield el.name, level - abs(held[el.name])
                elif state in SIDES:
                    yield el.name, SIDES[state] * r
                yield el.name, -level if state == "off" else level
            elif el.kind == "stop":
                x, pull = e - gap, self.force(el, "pressed", z)
                if state == "below":
                    yield el.name, -x
                else:
                    yield el.name, x if state != "free" else -pull
                    if state != "free":
                        yield el.name, pull
                if el.numbers.get("law") == "elastogap" and state in ("pressed", "capped"):
                    cap = self.number(el, "damping") * r - self.stiffness(el) * x
                    yield el.name, cap if state == "capped" else -cap
            elif "points" in el.numbers:
                points = el.numbers["points"]
                if state > 0:
                    yield el.name, e - ball(points[state][0])
                if state + 2 < len(points):
                    yield el.name, ball(points[state + 1][0]) - e


def float_of(x):
    return float(x.mid().str(20, radius=False))


def gauss(stages):
    """Nodes and matrix of Gauss's collocation on [0, 1]; the inverse of the powers of the nodes loses forty digits."""
    precision, ctx.prec = ctx.prec, 600
    roots = [arb.legendre_p_root(stages, k) for k in range(stages)]
    nodes = [(1 + x) / 2 for x in roots]
    powers = arb_mat([[c**j for j in range(stages)] for c in nodes])
    integrals = arb_mat([[c ** (j + 1) / (j + 1) for j in range(stages)] for c in nodes + [arb(1)]])
    a = integrals * powers.inv()
    ctx.prec = precision
    return [[mid(a[i, j]) for j in range(stages)] for i in range(stages + 1)]


TABLE = []


def gauss_step(f, z, a, h):
    """A step from a to a + h of z' = f(u, z); None if the iteration does not contract."""
    if not TABLE:
        rows = gauss(STAGES)
        TABLE.extend([arb_mat(rows[:-1]), arb_mat([rows[-1]]), [sum(row, arb(0)) for row in rows[:-1]]])
    inner, last, nodes = TABLE
    slopes = arb_mat([f(a, z)] * STAGES)
    n, old = len(z), None
    for count in range(100):
        moved = inner * slopes
        points = [[mid(z[i] + h * moved[k, i]) for i in range(n)] for k in range(STAGES)]
        change = math.inf if old is None else max(abs(float_of(p[i] - q[i])) for p, q in zip(points, old) for i in range(n))
        if change < SETTLED:
            break
        if old is not None and not change < 1e6 or count > 80:
            return None
        slopes, old = arb_mat([f(a + c * h, p) for c, p in zip(nodes, points)]), points
    moved = last * slopes
    return [mid(z[i] + h * moved[0, i]) for i in range(n)]


def root(x):
    return x.sqrt() if float_of(x) > 0 else arb(0)
