"""Derivatives of random machines' motions with respect to their numbers, in 60 or more digits: python make_derivatives.py > derivatives.txt

Central differences of the motions of make_motions.py, whose method shares nothing with the crate. Steps of 1e-18 leave 1e-36 of the
third derivative, and motions in 72 digits leave 1e-40 of rounding. Numbers with different one-sided differences have no derivative
and are omitted, as are numbers for which the law has no mode or several modes.
"""

import random
import sys
from copy import deepcopy

import make_motions as second
from mpmath import mp, mpf

mp.dps = 72
second.ZERO = mpf(10) ** -46  # far below a step's effect, above the rounding of sums and roots
second.ORDERS = 54
second.Machine.series.__defaults__ = (second.ORDERS,)
second.TAIL = mpf(10) ** -62
second.SLOW = mpf(10) ** -38
STEP = mpf(10) ** -18
TIMES = [mpf(1) / 4, mpf(1) / 2]
MACHINES = 50
NUMBERS = 6  # of each machine, of the kinds that have been compared least
ROUNDED = mpf(10) ** -36  # derivatives below this are 0
SAME = mpf(10) ** -9  # tolerance of one-sided differences, relative to 1 and the derivative; their step contributes 1e-18


def machine(r):
    """A machine of make_motions.py, some with a prescribed body, static levels and a step."""
    d = second.machine(r)
    n = len(d["bodies"])
    if r.random() < 0.4:
        other = r.randrange(n)
        d["bodies"].append({"motion": {"constant": "0", "rate": f"{r.uniform(-1, 1):.2f}", "amplitude": "0.15", "frequency": f"{r.uniform(0.5, 2):.2f}", "phase": f"{6 * r.random():.2f}"}})
        arms = [(n, -1), (other, 1)]
        d["springs"].append({"arms": arms, "stiffness": f"{r.uniform(5, 50):.1f}", "damping": "0.30"})
        d["frictions"].append({"arms": list(arms), "force": {"constant": f"{r.uniform(0.2, 2):.2f}"}})
    for friction in d["frictions"]:
        force = friction["force"]
        if "amplitude" not in force and r.random() < 0.5:
            friction["static"] = {"constant": f"{1.4 * float(force['constant']):.3f}"}
    if r.random() < 0.5:
        d["loads"][0]["steps"] = [(f"{r.uniform(0.05, 0.45):.3f}", f"{r.uniform(-3, 3):.2f}")]
    return d


def numbers(d):
    """Returns the numbers of a machine: name, kind, and location: a list or dictionary with the key in it."""

    def signal(name, kind, s):
        if set(s) == {"constant"} and kind.startswith("friction"):
            yield name, f"{kind}.constant", (s, "constant")
            return
        for key in ("constant", "rate", "amplitude", "frequency", "phase"):
            if key in s:
                yield f"{name}.{key}", f"{kind}.{key}", (s, key)
        for k, step in enumerate(s.get("steps", [])):
            for j, key in enumerate(("time", "height")):
                yield f"{name}.steps[{k}].{key}", f"{kind}.step.{key}", (s, ("steps", k, j))

    yield "gravity", "gravity", (d, "gravity")
    for i, b in enumerate(d["bodies"]):
        if "motion" in b:
            yield from signal(f"body.b{i}.motion", "motion", b["motion"])
            continue
        for key, name in (("mass", "mass"), ("gravity", "gravity"), ("s", "start.s"), ("v", "start.v")):
            yield f"body.b{i}.{name}", name, (b, key)
    for key, letter, name in (("springs", "k", "spring"), ("stops", "s", "stop"), ("frictions", "f", "friction")):
        for i, x in enumerate(d[key]):
            for own in ("stiffness", "damping", "gap", "restitution"):
                if own in x:
                    yield f"{name}.{letter}{i}.{own}", f"{name}.{own}", (x, own)
            for place, (body, _) in enumerate(x["arms"]):
                yield f"{name}.{letter}{i}.arms.b{body}", f"{name}.arms", (x, ("arms", place, 1))
            for own in ("force", "static"):
                if own in x:
                    yield from signal(f"{name}.{letter}{i}.{own}", f"{name}.{own}", x[own])
    for i, load in enumerate(d["loads"]):
        yield from signal(f"load.l{i}", "load", load)


def moved(d, name, by):
    """The machine with one number moved."""
    d = deepcopy(d)
    where, key = next(place for own, _, place in numbers(d) if own == name)
    if isinstance(key, tuple):
        key, place, part = key
        pair = list(where[key][place])
        pair[part] = mp.nstr(mpf(pair[part]) + by, 71)
        where[key][place] = tuple(pair)
    else:
        where[key] = mp.nstr(mpf(where[key]) + by, 71)
    return d


def run(d):
    m = second.Machine(d, times=TIMES)
    return [[x for pair in zip(q, v) for x in pair] for _, q, v in m.run()], m


def derivative(d, name, here):
    """The derivatives by time and value; None if a derivative does not exist."""
    try:
        (above, _), (below, _) = (run(moved(d, name, sign * STEP)) for sign in (1, -1))
    except (ArithmeticError, ZeroDivisionError, TypeError):
        return None
    for rows in zip(above, here, below):
        for a, b, c in zip(*rows):
            if abs((a - b) - (b - c)) > SAME * STEP * (1 + abs(a - c) / STEP):
                return None
    return [[(a - c) / (2 * STEP) for a, c in zip(*rows)] for rows in zip(above, below)]


def main(count, seed):
    r, number, used = random.Random(seed), 0, {}
    print("# Derivatives of machines' motions in 60 digits, by make_derivatives.py: time, then those of s and v of every body.")
    while number < count:
        d = machine(r)
        order = list(numbers(d))
        r.shuffle(order)
        if not second.touched(d) or any("amplitude" not in f["force"] and mpf(f["force"]["constant"]) < 0 for f in d["frictions"]):
            continue  # files with these are refused
        try:
            here, m = run(d)
        except (ArithmeticError, ZeroDivisionError, TypeError) as e:
            print(f"left out: {e}", file=sys.stderr)
            continue
        print(f"## machine {number}")
        print("\n".join(second.toml(d, number)))
        for t, row in zip(TIMES, here):
            print("## state", mp.nstr(t, 20), *(mp.nstr(x, 25) for x in row))
        for name, kind, _ in sorted(order, key=lambda own: used.get(own[1], 0))[:NUMBERS]:
            found = derivative(d, name, here)
            used[kind] = used.get(kind, 0) + (0.5 if found is None else 1)
            if found is None:
                print(f"left out: machine {number} by {name}", file=sys.stderr)
                continue
            for t, row in zip(TIMES, found):
                print("## derivative", name, mp.nstr(t, 20), *(mp.nstr(mp.chop(x, ROUNDED), 20) for x in row), flush=True)
        number += 1
    print(used, file=sys.stderr)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else MACHINES, int(sys.argv[2]) if len(sys.argv) > 2 else 47)
