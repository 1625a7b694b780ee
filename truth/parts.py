"""Forces, states and watched quantities of an element in the program of motion.py."""

from fractions import Fraction

import gmpy2
from gmpy2 import mpfr

import digits as d
from digits import power_term, real, times
from machine import Signal

SIDES = {"up": 1, "down": -1}


class Part:
    def __init__(self, element):
        self.element, self.kind, self.name = element, element.kind, element.name
        self.section = f"{element.kind}.{element.name}"
        self.numbers = element.numbers
        self.arms = [(i, real(a)) for i, a in element.arms]
        get = lambda key: real(element.numbers[key]) if isinstance(element.numbers.get(key), Fraction) else mpfr(0)
        self.gap, self.restitution, self.damping = get("gap"), get("restitution"), get("damping")
        self.preload, self.cubic, self.slip = get("preload"), get("cubic"), get("slip")
        self.quadratic, self.stribeck = get("quadratic"), get("stribeck")
        self.exponent = get("exponent") if "exponent" in self.numbers else mpfr(1)
        self.dissipation = get("dissipation")
        self.rigid = self.kind == "freewheel" or "restitution" in self.numbers
        self.slider = "slip" in self.numbers
        self.points = [(real(e), real(f)) for e, f in self.numbers.get("points", [])]
        self.law = self.numbers.get("law", "no-pull")
        self.curved = self.exponent != 1 or self.dissipation != 0

    def e(self, z):
        return sum((a * z.s[i] for i, a in self.arms), mpfr(0))

    def rate(self, z):
        return sum((a * z.v[i] for i, a in self.arms), mpfr(0))

    def touches(self, z):
        return self.kind == "freewheel" or abs(self.e(z) - self.gap) < d.NEAR

    def edge(self, z, state):
        """Whether a contact with an exponent is entered at its edge, where its force has a root of time."""
        return self.kind == "stop" and self.exponent != 1 and state == "pressed" and abs(self.e(z) - self.gap) < d.NEAR

    # The force

    def prepare(self, motion, z, state, order, clock):
        self.clock = clock
        self.work = {key: [] for key in ("x", "square", "power", "slow")}
        self.at_edge = self.edge(z, state)
        series = lambda key: motion.coefficients(self.numbers[key], z.time, order, clock)
        if "stiffness" in self.numbers:
            self.stiffness = series("stiffness")
        if self.kind == "friction":
            self.level = series("force")
            self.static = series("static") if "static" in self.numbers else self.level

    def force(self, k, e, r, slider, state):
        one = mpfr(k == 0)
        if self.kind == "damper":
            return self.damping * r[k] + self.third(r, k)
        if self.kind == "spring":
            if self.slider:
                return self.stiffness[0] * (e[k] - slider[k]) + self.damping * r[k]
            if self.points:
                (e0, f0), (e1, f1) = self.points[state], self.points[state + 1]
                slope = (f1 - f0) / (e1 - e0)
                return slope * e[k] + (f0 - slope * e0) * one + self.damping * r[k]
            stiff = self.stiffness[0] if "stiffness" in self.numbers else mpfr(0)
            return self.preload * one + stiff * e[k] + self.damping * r[k] + self.third(e, k)
        if self.kind == "friction":
            return self.rub(k, r, state)
        if self.kind == "stop" and not self.rigid and state in ("pressed", "capped"):
            self.work["x"].append(e[k] - self.gap * one)
            if self.curved:
                return self.hertz(k, r)
            x = self.stiffness[0] * self.work["x"][k]
            return 2 * x if state == "capped" else x + self.damping * r[k]
        return mpfr(0)

    def third(self, p, k):
        """cubic p^3."""
        if not self.cubic:
            return mpfr(0)
        square = self.work["square"]
        square.append(times(p, p, k))
        return self.cubic * sum(square[j] * p[k - j] for j in range(k + 1))

    def rub(self, k, r, state):
        if state == "off":
            return mpfr(0)
        side = SIDES[state]
        if not self.stribeck:
            return side * self.level[k]
        # exp(u) with u = -(rate/stribeck)^2: k w_k = sum of j u_j w_(k-j).
        u, w = self.work["square"], self.work["slow"]
        u.append(-times(r, r, k) / self.stribeck**2)
        w.append(gmpy2.exp(u[0]) if k == 0 else sum(j * u[j] * w[k - j] for j in range(1, k + 1)) / k)
        return side * (self.level[k] + (self.static[0] - self.level[0]) * w[k])

    def hertz(self, k, r):
        """stiffness x^p (1 + 3/2 dissipation x'), and the dashpot."""
        x, y, p = self.work["x"], self.work["power"], self.exponent
        if self.at_edge:  # x = tau^2 q, so that x^p = tau^(2p) q^p
            lag = int(2 * p)
            if k >= lag:
                q, j = x[2:], k - lag
                power_term(q, y, p, j)
            term = lambda i: y[i - lag] if i >= lag else mpfr(0)
        else:
            power_term(x, y, p, k)
            term = lambda i: y[i]
        force = term(k)
        if self.dissipation:
            force += gmpy2.mpfr(3) / 2 * self.dissipation * sum(term(i) * r[k - i] for i in range(k + 1))
        return self.stiffness[0] * force + self.damping * r[k]

    # The states

    def states(self, motion, z):
        """States that position and rate leave open."""
        e, r = self.e(z), self.rate(z)
        if self.kind == "stop" and self.rigid:
            return ["open"] if e < self.gap - d.NEAR or r < -d.TINY else ["closed", "open"]
        if self.kind == "freewheel":
            return ["open"] if r < -d.TINY else ["closed", "open"]
        if self.slider:
            b = self.branch(motion, z)
            return ["stuck"] + [w for w in SIDES if abs(b - SIDES[w] * self.slip) < d.NEAR * 1000 and SIDES[w] * r > -d.TINY]
        if self.kind == "friction":
            if not self.acts(motion, z):
                return ["off"]
            return ["up"] if r > d.TINY else ["down"] if r < -d.TINY else ["stuck", "up", "down"]
        if self.kind == "stop":
            if e < self.gap - d.NEAR:
                return ["below"]
            if self.curved:
                edge = e < self.gap + d.NEAR
                return ["below"] if edge and r < 0 else ["pressed"]
            beyond = ["pressed"] + (["free"] if self.damping else []) + (["capped"] if self.law == "elastogap" and self.damping else [])
            return beyond if e > self.gap + d.NEAR else ["below"] + beyond
        if self.points:
            return [k for k in range(len(self.points) - 1)
                    if (k == 0 or e > self.points[k][0] - d.NEAR) and (k + 2 == len(self.points) or e < self.points[k + 1][0] + d.NEAR)]
        return [""]

    def acts(self, motion, z):
        """Whether the first coefficient of the static level that is not zero is positive."""
        level = motion.coefficients(self.numbers.get("static", self.numbers["force"]), z.time, 4, 1)
        return next((c for c in level if abs(c) > d.TINY), mpfr(0)) > 0

    def branch(self, motion, z):
        stiff = motion.coefficients(self.numbers["stiffness"], z.time, 0, 1)[0]
        return stiff * (self.e(z) - z.x[self.name])

    def watched(self, series, state):
        """Rows (element, strict, series): each is negative in this state; a strict one is not zero throughout."""
        name = self.name
        E, R, F = series.E[name], series.R[name], series.F[name]
        minus = lambda p: [-c for c in p]
        less = lambda p, c: [p[0] - c] + p[1:]
        if self.kind == "stop" and self.rigid:
            return [(name, True, less(E, self.gap))] if state == "open" else [(name, False, minus(F))]
        if self.kind == "freewheel":
            return [(name, True, R)] if state == "open" else [(name, False, minus(F))]
        if self.slider:
            if state == "stuck":
                b = [self.stiffness[0] * (x - y) for x, y in zip(E, series.X[name])]
                return [(name, False, less(b, self.slip)), (name, False, less(minus(b), self.slip))]
            return [(name, True, R if state == "down" else minus(R))]
        if self.kind == "friction":
            if state == "off":
                return [(name, False, self.static)]
            both = list(zip(F, self.static))
            level = [] if self.numbers["force"].steady() else [(name, False, minus(self.level))]
            if state == "stuck":
                return [(name, False, [f - s for f, s in both]), (name, False, [-f - s for f, s in both])] + level
            return [(name, True, R if state == "down" else minus(R))] + level
        if self.kind == "stop":
            x = less(E, self.gap)
            if state == "below":
                return [(name, True, x)]
            if self.curved:
                q = [1 + 1.5 * self.dissipation * R[0]] + [1.5 * self.dissipation * c for c in R[1:]]
                return [(name, False, minus(x))] + ([(name, False, minus(q))] if self.dissipation else [])
            pull = [self.stiffness[0] * a + self.damping * b for a, b in zip(x, R)]
            cap = [self.damping * b - self.stiffness[0] * a for a, b in zip(x, R)]
            if state == "free":
                return [(name, True, minus(x)), (name, True, pull)]
            if state == "capped":
                return [(name, False, minus(cap)), (name, False, minus(x))]
            rows = [(name, False, minus(pull)), (name, False, minus(x))]
            return rows + ([(name, False, cap)] if self.law == "elastogap" and self.damping else [])
        if self.points:
            rows = []
            if state + 2 < len(self.points):
                rows.append((name, True, less(E, self.points[state + 1][0])))
            if state > 0:
                rows.append((name, False, less(minus(E), -self.points[state][0])))
            return rows
        return []

    def told(self, before, after, z):
        """Events of a change of state: (kind, section, value)."""
        if before == after:
            return []
        pair = (before, after)
        if self.points:
            return [("corner", self.section, self.rate(z))]
        kinds = {"closed": "close", "open": "open", "stuck": "stick", "off": "level"}
        if after in kinds:
            return [(kinds[after], self.section, None)]
        if self.kind == "stop":
            kind = {("below", "pressed"): "press", ("below", "capped"): "press", ("free", "below"): None,
                    ("capped", "pressed"): "cap", ("pressed", "capped"): "cap", ("free", "pressed"): "press"}
            kind = kind.get(pair, "free")
            return [(kind, self.section, self.rate(z))] if kind else []
        return [("level" if before == "off" else "slip", self.section, mpfr(SIDES[after]))]

