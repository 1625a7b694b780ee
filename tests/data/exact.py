"""The model in extended precision, shared by the make_*.py scripts of this folder.

A smooth mode is a linear system with a harmonic force, so exp(A h) applied to a state is its Taylor series;
the series is summed until its remainder is below the working precision. Contacts are found by bisection with a bound
on the polynomial over each interval: none is missed, however shallow. Nothing here is taken from the crate.
"""

import math
import sys
from fractions import Fraction

from mpmath import mp, mpf

FIELDS = (
    "box_mass box_stiffness box_damping block_mass secondary_mass secondary_stiffness secondary_damping "
    "coupling_stiffness stop_gap stop_restitution drive_amplitude drive_frequency drive_phase"
).split()
STATE = "x1 x2 x3 v1 v2 v3".split()
FLIGHT, UPPER, LOWER = 0, 1, -1


class System:
    """One parameter set, computed in `num` (mpf, or float for a quick search)."""

    def __init__(self, parameters, num=mpf):
        self.num, self.parameters = num, dict(parameters)
        p = [num(parameters[name]) for name in FIELDS]
        (self.m1, self.k1, self.c1, self.m2, self.m3, self.k3, self.c3, self.k23) = p[:8]
        (self.gap, self.kappa, self.force, self.omega, self.phase) = p[8:]
        self.sin, self.cos = (math.sin, math.cos) if num is float else (mp.sin, mp.cos)
        self.digits = 17 if num is float else mp.dps + 5
        fast = [
            self.omega,
            mp.sqrt(self.k1 / self.m1) + self.c1 / self.m1,
            mp.sqrt(self.k23 / self.m2),
            mp.sqrt((self.k3 + self.k23) / self.m3) + self.c3 / self.m3,
        ]
        self.rate = float(max(fast)) * 1.5 + 1e-9
        self.window = 0.6 / self.rate * 1.5

    def period(self):
        return 2 * math.pi / float(self.omega) if self.omega else 2 * math.pi

    def terms(self, span):
        """Terms of the Taylor series that reach the working precision over |span|."""
        reach, size, n = max(self.rate * abs(float(span)), 1e-6), 1.0, 0
        while size > 10.0**-self.digits or n < reach:
            n += 1
            size *= reach / n
        return n + 3

    def expand(self, mode, y, t, span):
        """Taylor coefficients in time about t: [x1, x2, x3] and [v1, v2, v3]."""
        n, num = self.terms(span), self.num
        theta = self.omega * num(t) + self.phase
        s, c = self.force * self.sin(theta), self.force * self.cos(theta)
        x, v = [[y[0]], [y[1]], [y[2]]], [[y[3]], [y[4]], [y[5]]]
        both = self.m1 + self.m2
        for k in range(n):
            pull = self.k23 * (x[1][k] - x[2][k])
            box = s - self.c1 * v[0][k] - self.k1 * x[0][k]
            third = (pull - self.c3 * v[2][k] - self.k3 * x[2][k]) / self.m3
            if mode == FLIGHT:
                a = (box / self.m1, -pull / self.m2, third)
            else:
                a = ((box - pull) / both, (box - pull) / both, third)
            for i in range(3):
                x[i].append(v[i][k] / (k + 1))
                v[i].append(a[i] / (k + 1))
            s, c = self.omega * c / (k + 1), -self.omega * s / (k + 1)
        return x, v

    def flow(self, mode, y, t, end):
        """State at `end`, forward or backward."""
        t, end = self.num(t), self.num(end)
        steps = max(1, math.ceil(abs(float(end - t)) / self.window))
        h = (end - t) / steps
        for k in range(steps):
            x, v = self.expand(mode, y, t + h * k, h)
            y = [horner(p, h) for p in x] + [horner(p, h) for p in v]
        return y

    def relative_acceleration(self, y, t):
        """x2'' - x1'' of the free bodies."""
        x, v = self.expand(FLIGHT, y, t, 0)
        return v[1][1] - v[0][1]

    def contact_force(self, y, t, side):
        """Force at the stop that keeps the block at rest on the stop."""
        mu = self.m1 * self.m2 / (self.m1 + self.m2)
        return mu * side * self.relative_acceleration(y, t)

    def impact(self, y, side):
        """State after an impact, set exactly on the stop, and the approach speed."""
        y = list(y)
        speed = side * (y[4] - y[3])
        p = (1 + self.kappa) * self.m1 * self.m2 / (self.m1 + self.m2) * speed
        y[3] += side * p / self.m1
        y[4] -= side * p / self.m2
        y[1] = y[0] + side * self.gap
        return y, speed

    def first_contact(self, y, t, end, touching=0, level=None):
        """First time in (t, end] with |w| = level (default L), as (time, side), or None.

        `touching` is the stop at which the flight starts: the root there is divided out, not stepped over.
        """
        level = self.gap if level is None else level
        t, end = self.num(t), self.num(end)
        steps = max(1, math.ceil(float(end - t) / self.window))
        h = (end - t) / steps
        for k in range(steps):
            x, v = self.expand(FLIGHT, y, t + h * k, h)
            w = [b - a for a, b in zip(x[0], x[1])]
            found = None
            for side in (UPPER, LOWER):
                g = [-side * a for a in w]
                g[0] += level
                if k == 0 and touching == side:
                    g = g[1:]
                u = first_root(g, self.num(0), h)
                if u is not None and (found is None or u < found[0]):
                    found = (u, side)
            if found:
                return t + h * k + found[0], found[1]
            y = [horner(p, h) for p in x] + [horner(p, h) for p in v]
        return None


def horner(p, u):
    r = p[-1]
    for a in reversed(p[:-1]):
        r = r * u + a
    return r


def shift(p, c):
    """Coefficients of p(c + u)."""
    b = list(p)
    for i in range(len(b) - 1):
        for j in range(len(b) - 2, i - 1, -1):
            b[j] += c * b[j + 1]
    return b


def first_root(p, lo, hi):
    """Smallest root of p in (lo, hi]; p(lo) = 0 exactly must have been divided out."""
    # A cheap bound first, because most windows stay far from the stop.
    rest, power = 0, 1
    for a in p[1:]:
        power = power * hi
        rest += abs(a) * power
    if abs(p[0]) > rest:
        return None
    c, r = (lo + hi) / 2, (hi - lo) / 2
    # A bound about the centre, in doubles with a margin far above rounding, which decides most
    # intervals.
    b, scale = [float(a) for a in p], sum(abs(float(a)) * float(hi) ** k for k, a in enumerate(p))
    b = shift(b, float(c))
    if abs(b[0]) > sum(abs(a) * float(r) ** k for k, a in enumerate(b) if k) + 1e-9 * scale:
        return None
    b = shift(p, c)
    value = slope = 0
    power = type(r)(1)
    for k in range(1, len(b)):
        if k > 1:
            slope += k * abs(b[k]) * power
        power = power * r
        value += abs(b[k]) * power
    if abs(b[0]) > value:
        return None
    if abs(b[1]) > slope:
        f_lo, f_hi = horner(b, -r), horner(b, r)
        if (f_lo > 0) == (f_hi > 0) and f_hi != 0:
            return None
        return c + newton(b, -r, r)
    if r < mpf(10) ** -(mp.dps * 3 // 4):
        raise ArithmeticError("a double root: not resolved at this precision")
    u = first_root(p, lo, c)
    return u if u is not None else first_root(p, c, hi)


def newton(p, lo, hi):
    """The root of a polynomial that is monotone on [lo, hi]: Newton's method kept inside the bracket."""
    d = [k * a for k, a in enumerate(p)][1:]
    sign = 1 if horner(p, hi) > horner(p, lo) else -1
    u = (lo + hi) / 2
    eps = mpf(10) ** -mp.dps
    for _ in range(400):
        f = horner(p, u)
        if f == 0:
            return u
        if sign * f > 0:
            hi = u
        else:
            lo = u
        step = f / horner(d, u)
        new = u - step
        if not lo <= new <= hi:
            new = (lo + hi) / 2
        if abs(new - u) <= eps * (abs(u) + eps):
            return new
        u = new
    return u


def doubles(values):
    return [float(a) for a in values]


def exactly_on_stop(y, gap, side):
    """Rounds the state so that x2 - x1 = side * gap holds exactly in doubles, or None."""
    y = doubles(y)
    grid = Fraction(math.ulp(max(abs(y[0]), abs(y[1]), gap)))
    x1 = Fraction(round(Fraction(y[0]) / grid)) * grid
    x2 = x1 + side * Fraction(gap)
    if Fraction(float(x1)) != x1 or Fraction(float(x2)) != x2:
        return None
    return [float(x1), float(x2)] + y[2:]


def text(value, digits=20):
    """A CSV field: doubles with the shortest digits that restore them, mpf with `digits`."""
    if value is None:
        return ""
    if isinstance(value, mpf):
        return mp.nstr(value, digits, strip_zeros=True)
    return repr(value) if isinstance(value, float) else str(value)


def write(path, columns, rows):
    with open(path, "w", encoding="ascii", newline="\n") as out:
        out.write(",".join(columns) + "\n")
        for row in rows:
            assert len(row) == len(columns)
            out.write(",".join(text(a) for a in row) + "\n")
    print(f"{path}: {len(rows)} rows", file=sys.stderr)


def check_against_expm(parameters):
    """Compares the series with mpmath's matrix exponential of the augmented 8 x 8 system, an independent evaluation."""
    s = System(parameters)
    a = mp.zeros(8)
    for i in range(3):
        a[i, 3 + i] = 1
    a[3, 0], a[3, 3], a[3, 6] = -s.k1 / s.m1, -s.c1 / s.m1, s.force / s.m1
    a[4, 1], a[4, 2] = -s.k23 / s.m2, s.k23 / s.m2
    a[5, 1], a[5, 2], a[5, 5] = s.k23 / s.m3, -(s.k3 + s.k23) / s.m3, -s.c3 / s.m3
    a[6, 7], a[7, 6] = s.omega, -s.omega
    y = [mpf(k + 1) / 7 * s.gap for k in range(6)]
    t, span = mpf(1) / 3, mpf(s.period()) * 1.3
    theta = s.omega * t + s.phase
    full = mp.expm(a * span) * mp.matrix(y + [mp.sin(theta), mp.cos(theta)])
    series = s.flow(FLIGHT, y, t, t + span)
    error = max(abs(full[i] - series[i]) for i in range(6)) / max(abs(q) for q in series)
    assert error < mpf(10) ** (15 - mp.dps), error
