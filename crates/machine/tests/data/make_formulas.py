"""Motions of chains whose springs and dampers have formulas, in 40 digits, for `tests/formulas.rs`.

    python3 crates/machine/tests/data/make_formulas.py 30 > crates/machine/tests/data/formulas.txt
    python3 crates/machine/tests/data/make_formulas.py 10 by > crates/machine/tests/data/formulas_by.txt

Each machine is a chain of bodies with one formula a spring, a harmonic force and a rigid stop of
the last body. A step is extrapolated from explicit midpoint rules (Gragg, Bulirsch and Stoer) in 50
digits: the formulas are only evaluated, so that no series and no derivative is needed, and nothing
is taken from the engine. Impacts are roots of the step's length. A row holds the machine as TOML
(line breaks as `|`), the end, the number of impacts, the factor by which the motion magnifies a
change of the start, and coordinates and rates at the end. With `by`, a row holds the machine, the
end, a number of the machine, and the derivatives of coordinates and rates at the end by it, from
motions that differ by 1e-22 of it.
"""

import random
import re
import sys

from mpmath import atan, cos, exp, log, mp, mpf, nstr, pi, sin, sqrt, tanh

mp.dps = 50
END = mpf(2)
STEP = mpf(1) / 20
SMALL = mpf(10) ** -42
EVENT = mpf(10) ** -39
ROWS = 26

# A formula with its parameters and the range of each.
FORMULAS = [
    ("k * sin(e / a)", {"k": (1, 40), "a": (0.2, 1)}),
    ("k * tanh(e / a) + 4 * e", {"k": (-10, 40), "a": (0.2, 1)}),
    ("k * e / sqrt(a^2 + e^2)", {"k": (5, 40), "a": (0.2, 1)}),
    ("k * (exp(e / a) - 1)", {"k": (1, 20), "a": (0.3, 1)}),
    ("k * e * ln(1 + e^2 / a) + 10 * e", {"k": (5, 60), "a": (0.05, 1)}),
    ("k * atan(e / a)", {"k": (5, 60), "a": (0.1, 1)}),
    ("k * e - c / (4 - e)^2", {"k": (5, 40), "c": (0.1, 3)}),
    ("m * (e^2 - 0.2) * rate + k * e", {"m": (0.5, 4), "k": (5, 40)}),
    ("c * tanh(rate / v) + k * e", {"c": (0.1, 2), "v": (0.3, 1), "k": (5, 40)}),
    ("k * e^3 * exp(-e^2) + 5 * e", {"k": (5, 60)}),
    ("k * cos(e) * rate^2 + 9 * e", {"k": (0.05, 0.5)}),
    ("k * ((3 + e)^1.5 - 3^1.5)", {"k": (5, 30)}),
    ("k * e / (1 + e^2)", {"k": (5, 60)}),
    ("sin(k * e) * (1 + tanh(rate)) + 3 * e^7", {"k": (0.5, 5)}),
    ("k * (e - sin(a * e) / a) + c * atan(e * rate)", {"k": (5, 40), "a": (0.5, 2), "c": (0.1, 2)}),
]
FUNCTIONS = {"sin": sin, "cos": cos, "tanh": tanh, "exp": exp, "ln": log, "atan": atan, "sqrt": sqrt, "mpf": mpf}


def compiled(formula):
    """The formula as a function of mpmath's numbers."""
    code = re.sub(r"(?<![A-Za-z_0-9.])(\d+(\.\d+)?)", r"mpf('\1')", formula).replace("^", "**")
    code = re.sub(r"\b([akcmv])\b", r"p['\1']", code)
    return eval(f"lambda e, rate, p: {code}", FUNCTIONS)


def machine(chance):
    """Masses, starts, springs with formulas and parameters, damping, stop and load of a chain."""
    number = lambda low, high: mpf(str(round(chance.uniform(low, high), 3)))
    count = chance.randint(1, 3)
    own = {"mass": [number(0.5, 2) for _ in range(count)]}
    own["start"] = [(number(-0.4, 0.4), number(-1.5, 1.5)) for _ in range(count)]
    own["spring"] = []
    for _ in range(count):
        formula, ranges = chance.choice(FORMULAS)
        own["spring"].append((formula, {name: number(*range) for name, range in ranges.items()}))
    own["damping"] = number(0.05, 0.3)
    own["stop"] = (own["start"][-1][0] + number(0.1, 0.4), number(0.4, 0.9))
    own["load"] = (number(1, 12), number(0.3, 2))
    return own


def text(own):
    """The machine as TOML, with one named parameter for each number of a formula."""
    plain = lambda x: nstr(x, 20)
    lines = ['name = "F"', "[parameters]"]
    for i, (_, parameters) in enumerate(own["spring"]):
        lines += [f"{name}{i} = {plain(x)}" for name, x in parameters.items()]
    for i, (mass, (s, v)) in enumerate(zip(own["mass"], own["start"])):
        lines += [f"[body.b{i}]", f"mass = {plain(mass)}", f"start = {{ s = {plain(s)}, v = {plain(v)} }}"]
    last = len(own["mass"]) - 1
    for i, (formula, parameters) in enumerate(own["spring"]):
        ends = ["ground" if i == 0 else f"b{i - 1}", f"b{i}"]
        numbered = re.sub(r"\b([akcmv])\b", rf"\g<1>{i}", formula)
        lines += [f"[spring.k{i}]", f'between = ["{ends[0]}", "{ends[1]}"]', f'force = "= {numbered}"']
    lines += ["[damper.d]", f'between = ["ground", "b{last}"]', f"damping = {plain(own['damping'])}"]
    gap, restitution = own["stop"]
    lines += ["[stop.s]", f'between = ["ground", "b{last}"]', f"gap = {plain(gap)}"]
    lines += [f"restitution = {plain(restitution)}"]
    amplitude, frequency = own["load"]
    lines += ["[load.l]", 'on = "b0"', f"amplitude = {plain(amplitude)}", f"frequency = {plain(frequency)}"]
    return "|".join(lines)


class Motion:
    """The equations of a machine."""

    def __init__(self, own):
        self.own, self.count = own, len(own["mass"])
        self.forces = [compiled(formula) for formula, _ in own["spring"]]

    def rates(self, t, z):
        n, own = self.count, self.own
        q, v, f = z[:n], z[n:], [mpf(0)] * self.count
        for i, force in enumerate(self.forces):
            e = q[i] - (q[i - 1] if i else 0)
            rate = v[i] - (v[i - 1] if i else 0)
            pull = force(e, rate, own["spring"][i][1])
            f[i] -= pull
            if i:
                f[i - 1] += pull
        f[-1] -= own["damping"] * v[-1]
        f[0] += own["load"][0] * sin(2 * pi * own["load"][1] * t)
        return v + [x / m for x, m in zip(f, own["mass"])]

    def step(self, t, z, h):
        """The state after a time h, by extrapolation."""
        table = []
        for row in range(ROWS):
            parts = 2 * (row + 1)
            part = h / parts
            before, now = z, [x + part * r for x, r in zip(z, self.rates(t, z))]
            for k in range(1, parts):
                rates = self.rates(t + k * part, now)
                before, now = now, [x + 2 * part * r for x, r in zip(before, rates)]
            rates = self.rates(t + h, now)
            values = [[(x + y + part * r) / 2 for x, y, r in zip(now, before, rates)]]
            for j in range(1, row + 1):
                ratio = mpf(parts) / (2 * (row - j + 1))
                factor = 1 / (ratio**2 - 1)
                values.append([x + (x - y) * factor for x, y in zip(values[-1], table[-1][j - 1])])
            table.append(values)
            if row > 3:
                off = max(abs(x - y) for x, y in zip(values[-1], values[-2]))
                if off < SMALL:
                    return values[-1]
        half = self.step(t, z, h / 2)
        return self.step(t + h / 2, half, h / 2)

    def run(self):
        """The state at the end, and the number of impacts."""
        z = [s for s, _ in self.own["start"]] + [v for _, v in self.own["start"]]
        t, impacts, n = mpf(0), 0, self.count
        gap, restitution = self.own["stop"]
        excess = lambda z: z[n - 1] - gap
        while t < END:
            h = min(STEP, END - t)
            after = self.step(t, z, h)
            if excess(after) < 0:
                t, z = t + h, after
                continue
            # The last body passes the stop once within the step: secants.
            low, high = mpf(0), h
            a, b = excess(z), excess(after)
            for turn in range(41):
                if abs(b) <= EVENT:
                    break
                assert turn < 40, "no passage"
                x = high - b * (high - low) / (b - a)
                if not 0 < x < 2 * h:
                    x = high / 2
                (low, a, high, b) = (high, b, x, excess(self.step(t, z, x)))
            z = self.step(t, z, high)
            t += high
            assert z[2 * n - 1] > 0
            z[2 * n - 1] *= -restitution
            z[n - 1] = gap
            impacts += 1
            # A first short step moves away from the stop.
            z = self.step(t, z, mpf(10) ** -4)
            t += mpf(10) ** -4
            assert excess(z) < 0, "chattering"
        return z, impacts


def shifted(own, shift):
    """The machine whose first body starts at another place."""
    starts = [(own["start"][0][0] + shift, own["start"][0][1]), *own["start"][1:]]
    return {**own, "start": starts}


def varied(own, spring, name, factor):
    """The machine with another parameter."""
    springs = list(own["spring"])
    formula, parameters = springs[spring]
    springs[spring] = (formula, {**parameters, name: parameters[name] * factor})
    return {**own, "spring": springs}


def main():
    count, by = int(sys.argv[1]), len(sys.argv) > 2
    chance = random.Random(8 if by else 5)
    made = 0
    while made < count:
        own = machine(chance)
        try:
            z, impacts = Motion(own).run()
            small = mpf(10) ** -22
            if by:
                spring = chance.randrange(len(own["spring"]))
                name = chance.choice(list(own["spring"][spring][1]))
                up, some = Motion(varied(own, spring, name, 1 + small)).run()
                assert some == impacts
                by_it = [(x - y) / (small * own["spring"][spring][1][name]) for x, y in zip(up, z)]
                states = ", ".join(nstr(x, 18) for x in by_it)
                print(f"{text(own)};{END};{name}{spring};{states}", flush=True)
            else:
                moved, some = Motion(shifted(own, small)).run()
                assert some == impacts
                factor = max(abs(x - y) for x, y in zip(moved, z)) / small
                states = ", ".join(nstr(x, 25) for x in z)
                print(f"{text(own)};{END};{impacts};{nstr(factor, 5)};{states}", flush=True)
        except (AssertionError, OverflowError, RecursionError, TypeError, ValueError) as fault:
            print(f"# {type(fault).__name__} {fault}", file=sys.stderr)
            continue
        made += 1


main()
