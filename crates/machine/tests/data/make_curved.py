"""Motions of chains with curved springs and dashpots in 40 digits, for `tests/curved.rs`.

    python3 crates/machine/tests/data/make_curved.py 40 > crates/machine/tests/data/curved.txt
    python3 crates/machine/tests/data/make_curved.py 6 by > crates/machine/tests/data/curved_by.txt

Each machine is a chain of bodies with springs whose forces are polynomials of e, dashpots with a
cubic term, a harmonic force and a rigid stop between the last two bodies or at the ground. The
motion is a Taylor series in mpmath with steps that leave out less than 1e-42, and impacts are
roots of the series. Nothing is taken from the engine. A row holds the machine as TOML (line breaks
as `|`), the end, the number of impacts, the coordinates and rates at the end, and the factor by
which the motion magnifies a change of the start. With `by`, a row holds the machine, the end, a
number of the machine, and the derivatives of coordinates and rates at the end by this number, from
motions that differ by 1e-25 of it.
"""

import copy
import random
import sys

from mpmath import cos, mp, mpf, nstr, pi, sin

mp.dps = 50
ORDERS = 44
LEFT_OUT = mpf(10) ** -42
END = mpf(3)


def exact(x):
    """A number of the file as it is written there, or a varied number."""
    return x if isinstance(x, mpf) else mpf(repr(x))


def machine(chance):
    """Bodies, springs, dashpots, stop and load of a random chain."""
    count = chance.randint(1, 4)
    number = lambda low, high: round(chance.uniform(low, high), 3)
    chain = {"mass": [number(0.5, 3) for _ in range(count)]}
    chain["start"] = [(number(-0.3, 0.3), number(-2, 2)) for _ in range(count)]
    chain["spring"] = []
    for _ in range(count):
        powers = {1: number(-20, 60), 3: number(50, 900)}
        if chance.random() < 0.5:
            powers[2] = number(-60, 60)
        if chance.random() < 0.4:
            powers[4] = number(-200, 200)
            powers[5] = number(500, 3000)
        chain["spring"].append((powers, number(0, 0.5), number(-3, 3)))
    chain["cubic"] = number(0, 0.2) if chance.random() < 0.5 else None
    chain["stop"] = (number(0.2, 0.35), number(0.3, 0.95), count > 1 and chance.random() < 0.5)
    if chain["stop"][2]:
        a, b = chain["start"][-2][0], chain["start"][-1][0]
        chain["stop"] = (round(b - a + abs(chain["stop"][0]), 3), *chain["stop"][1:])
    else:
        chain["stop"] = (round(chain["start"][-1][0] + chain["stop"][0], 3), *chain["stop"][1:])
    chain["load"] = (number(1, 20), number(0.3, 3))
    return chain


def text(chain):
    """The machine as TOML."""
    names = {2: "quadratic", 3: "cubic", 4: "quartic", 5: "quintic"}
    lines = ['name = "Chain"']
    for i, (mass, (s, v)) in enumerate(zip(chain["mass"], chain["start"])):
        lines.append(f"body.b{i} = {{ mass = {mass!r}, start = {{ s = {s!r}, v = {v!r} }} }}")
    for i, (powers, damping, preload) in enumerate(chain["spring"]):
        end = "ground" if i == 0 else f"b{i - 1}"
        curve = "".join(f", {names[m]} = {c!r}" for m, c in powers.items() if m > 1)
        lines.append(
            f'spring.k{i} = {{ between = ["{end}", "b{i}"], stiffness = {powers[1]!r}{curve}, '
            f"damping = {damping!r}, preload = {preload!r} }}"
        )
    last = len(chain["mass"]) - 1
    if chain["cubic"] is not None:
        lines.append(f'damper.d = {{ between = ["ground", "b{last}"], cubic = {chain["cubic"]!r} }}')
    gap, restitution, inner = chain["stop"]
    end = f"b{last - 1}" if inner else "ground"
    lines.append(
        f'stop.s = {{ between = ["{end}", "b{last}"], gap = {gap!r}, restitution = {restitution!r} }}'
    )
    lines.append(f'load.l = {{ on = "b0", amplitude = {chain["load"][0]!r}, frequency = {chain["load"][1]!r} }}')
    return "|".join(lines)


def product(a, b, k):
    """Coefficient of order k of a product of series."""
    return sum(a[j] * b[k - j] for j in range(k + 1))


def series(chain, t, s, v):
    """Taylor coefficients in time of coordinates and rates."""
    count = len(s)
    s, v = [[x] for x in s], [[x] for x in v]
    omega = 2 * pi * exact(chain["load"][1])
    wave = [sin(omega * t), cos(omega * t)]
    springs = [(x, []) for x in chain["spring"]]
    powers = [{1: [], **{m: [] for m in range(2, 6)}} for _ in springs]
    speed2, speed3 = [], []
    factorial = mpf(1)
    for k in range(ORDERS):
        if k:
            factorial *= k
        force = [mpf(0)] * count
        for i, ((curve, damping, preload), _) in enumerate(springs):
            e = s[i][k] - (s[i - 1][k] if i else 0)
            rate = v[i][k] - (v[i - 1][k] if i else 0)
            powers[i][1].append(e)
            for m in range(2, 6):
                powers[i][m].append(product(powers[i][m - 1], powers[i][1], k))
            f = sum(exact(c) * powers[i][m][k] for m, c in curve.items()) + exact(damping) * rate
            f += exact(preload) if k == 0 else 0
            force[i] -= f
            if i:
                force[i - 1] += f
        if chain["cubic"] is not None:
            speed2.append(product(v[-1], v[-1], k))
            speed3.append(product(speed2, v[-1], k))
            force[-1] -= exact(chain["cubic"]) * speed3[k]
        turn = [wave[0], wave[1], -wave[0], -wave[1]][k % 4]
        force[0] += exact(chain["load"][0]) * turn * omega**k / factorial
        for i in range(count):
            s[i].append(v[i][k] / (k + 1))
            v[i].append(force[i] / exact(chain["mass"][i]) / (k + 1))
    return s, v


def value(series, h):
    """Value of a polynomial."""
    total = mpf(0)
    for c in reversed(series):
        total = total * h + c
    return total


def first_root(c, h):
    """First root of a polynomial in (0, h] that is below zero before it, by fine sampling."""
    parts = 64
    before, low = c[0], mpf(0)
    for i in range(1, parts + 1):
        high = h * i / parts
        after = value(c, high)
        if after > 0 and (before < 0 or i > 1):
            for _ in range(170):
                middle = (low + high) / 2
                if value(c, middle) > 0:
                    high = middle
                else:
                    low = middle
            return high
        before, low = after, high
    return None


def follow(chain, shift):
    """End state and number of impacts of a motion whose start is shifted."""
    t = mpf(0)
    s = [exact(x[0]) for x in chain["start"]]
    v = [exact(x[1]) for x in chain["start"]]
    s[0] += shift
    impacts = 0
    gap, restitution, inner = chain["stop"]
    gap, restitution = exact(gap), exact(restitution)
    while t < END:
        ss, vs = series(chain, t, s, v)
        size = max(max(abs(x) for x in s), max(abs(x) for x in v))
        h = min(
            (LEFT_OUT * size / max(abs(c[k]) for c in ss + vs)) ** (mpf(1) / k) for k in (ORDERS - 1, ORDERS)
        )
        h = min(h, END - t)
        e = [a - b for a, b in zip(ss[-1], ss[-2])] if inner else list(ss[-1])
        e[0] -= gap
        root = first_root(e, h)
        h = h if root is None else root
        s, v = [value(c, h) for c in ss], [value(c, h) for c in vs]
        t += h
        if root is None:
            continue
        impacts += 1
        if impacts > 60:
            return None
        if inner:
            a, b = exact(chain["mass"][-2]), exact(chain["mass"][-1])
            impulse = (1 + restitution) * (v[-1] - v[-2]) * a * b / (a + b)
            v[-1] -= impulse / b
            v[-2] += impulse / a
            s[-1] = s[-2] + gap
        else:
            v[-1] = -restitution * v[-1]
            s[-1] = gap
    return s, v, impacts


def numbers_of(chain):
    """Numbers of a chain by their names in a file: the object and the key that hold each."""
    powers = {1: "stiffness", 2: "quadratic", 3: "cubic", 4: "quartic", 5: "quintic"}
    last = len(chain["mass"]) - 1
    found = {"body.b0.mass": (chain["mass"], 0), "body.b0.start.v": (chain["start"], (0, 1))}
    for m in chain["spring"][last][0]:
        found[f"spring.k{last}.{powers[m]}"] = (chain["spring"][last][0], m)
    found[f"spring.k{last}.damping"] = (chain["spring"], (last, 1))
    found["spring.k0.preload"] = (chain["spring"], (0, 2))
    if chain["cubic"] is not None:
        found["damper.d.cubic"] = (chain, "cubic")
    found["stop.s.gap"], found["stop.s.restitution"] = (chain, ("stop", 0)), (chain, ("stop", 1))
    found["load.l.amplitude"], found["load.l.frequency"] = (chain, ("load", 0)), (chain, ("load", 1))
    return found


def varied(chain, name, part):
    """A copy of a chain with one number changed by a part of it (of 1, if it is 0), and the change."""
    chain = copy.deepcopy(chain)
    holder, key = numbers_of(chain)[name]
    place, i = key if isinstance(key, tuple) else (key, None)
    before = exact(holder[place] if i is None else holder[place][i])
    change = part * before if before else part
    if i is None:
        holder[place] = before + change
    else:
        numbers = list(holder[place])
        numbers[i] = before + change
        holder[place] = tuple(numbers)
    return chain, change


def print_derivatives(chain, end):
    """A row for each number of a chain."""
    rows = []
    for name in numbers_of(chain):
        other, change = varied(chain, name, mpf(10) ** -25)
        beside = follow(other, mpf(0))
        if beside is None or beside[2] != end[2]:
            return False
        both = zip([*end[0], *end[1]], [*beside[0], *beside[1]])
        numbers = ",".join(nstr((b - a) / change, 22) for a, b in both)
        rows.append(f"{text(chain)};{nstr(END, 5)};{name};{numbers}")
    print("\n".join(rows), flush=True)
    return True


def main():
    chance = random.Random(20261129)
    made = 0
    while made < int(sys.argv[1]):
        chain = machine(chance)
        end = follow(chain, mpf(0))
        if end is None:
            continue
        shift = mpf(10) ** -25
        beside = follow(chain, shift)
        if beside is None or beside[2] != end[2]:
            continue
        if "by" in sys.argv:
            made += print_derivatives(chain, end)
            continue
        own = [*end[0], *end[1]]
        factor = max(abs(a - b) for a, b in zip(own, [*beside[0], *beside[1]])) / shift
        numbers = ",".join(nstr(x, 25) for x in own)
        print(f"{text(chain)};{nstr(END, 5)};{end[2]};{nstr(factor, 3)};{numbers}", flush=True)
        made += 1


main()
