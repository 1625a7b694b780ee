"""Motions of machines at the edge of the law, in 50 digits: python make_families.py > families.txt

Families of random machines by the second method of make_motions.py: touching by a billionth of the gap, redundant stops, loops of friction,
buffers that are pressed again before they are left, corners that are met at one instant, levels of friction that pass or touch
zero, buffers a million times as stiff as the mount. Every number is the double that a file's reader returns.
"""

import random
import sys

from make_motions import Machine, first_root, show, toml, touched, value
from mpmath import mp, mpf

TIMES = [mpf(k) / 8 - mpf(1) / 64 for k in range(1, 9)]


def exact(text):
    return mpf(float(text))


def num(x):
    return repr(float(x))


def empty(gravity="0"):
    return {"gravity": gravity, "bodies": [], "springs": [], "stops": [], "frictions": [], "loads": []}


def body(d, mass, s=0.0, v=0.0, gravity=0.0):
    d["bodies"].append({"mass": num(mass), "gravity": num(gravity), "s": num(s), "v": num(v)})


def base(d, amplitude, frequency, phase=0.0, rate=0.0):
    motion = {"constant": "0", "rate": num(rate), "amplitude": num(amplitude), "frequency": num(frequency), "phase": num(phase)}
    d["bodies"].append({"motion": motion})


def spring(d, arms, k, c=0.0):
    d["springs"].append({"arms": arms, "stiffness": num(k), "damping": num(c)})


def rigid(d, arms, gap, e):
    d["stops"].append({"arms": arms, "gap": num(gap), "restitution": num(e)})


def buffer(d, arms, gap, k, c, law):
    d["stops"].append({"arms": arms, "gap": num(gap), "stiffness": num(k), "damping": num(c), "law": law})


def friction(d, arms, level, static=None):
    as_signal = lambda x: x if isinstance(x, dict) else {"constant": num(x)}
    d["frictions"].append({"arms": arms, "force": as_signal(level)} | ({"static": as_signal(static)} if static is not None else {}))


def wave(constant, amplitude, frequency, phase=0.0):
    return {"constant": num(constant), "amplitude": num(amplitude), "frequency": num(frequency), "phase": num(phase)}


def load(d, i, s):
    d["loads"].append({"body": i, **s})


def log(r, a, b):
    return 10 ** r.uniform(a, b)


def peak(d, arms, after, until, rate):
    """Returns the first maximum of an elongation (or of its rate) between two times in a machine without events."""
    m = Machine(d, exact)
    q, v = m.start()
    t, mode = mpf(0), {"s": [], "f": [], "l": []}
    while t < until:
        qs, _ = m.series(q, v, t, mode)
        h = m.step(qs)
        e = m.e(qs, arms)
        if rate:
            e = [(k + 1) * x for k, x in enumerate(e[1:])]
        slope = [(k + 1) * x for k, x in enumerate(e[1:])]
        if slope[0] > 0 and t >= after:
            root = first_root([-x for x in slope], h)
            if root is not None:
                return value(e, root)
        q, v = [value(x, h) for x in qs], [value([(k + 1) * x[k + 1] for k in range(len(x) - 1)], h) for x in qs]
        t += h
    return None


def grazing(r):
    """An elongation that comes within a billionth of a gap, or exceeds it by as much; or a rate near a belt's rate."""
    n = r.randint(1, 3)
    d = empty(r.choice(["0", "9.81"]))
    for _ in range(n):
        body(d, log(r, -1, 1), 0.0, r.uniform(-1, 2), r.choice([0.0, 1.0]))
    for i in range(n):
        spring(d, [(i, 1)], log(r, 1, 3), r.choice([0.0, r.random()]))
    for i in range(1, n):
        spring(d, [(i - 1, -1), (i, 1)], log(r, 1, 3), r.choice([0.0, r.random()]))
    load(d, r.randrange(n), wave(r.uniform(-1, 1), r.uniform(1, 9), r.uniform(0.5, 3), r.uniform(0, 6)))
    arms = [(0, 1)] if n == 1 or r.random() < 0.5 else [(0, -1), (1, 1)]
    kind = r.choice(["rigid", "rigid", "buffer", "friction"])
    top = peak(d, arms, mpf("0.05"), mpf("0.8"), kind == "friction")
    if top is None or abs(top) < 0.01 or (kind != "friction" and top < 0.01):
        return None
    edge = top - r.choice([1, -1]) * abs(top) * mpf("1e-9")
    if kind == "rigid":
        rigid(d, arms, edge, r.choice([0.0, 0.5, 0.9, 1.0]))
    elif kind == "buffer":
        buffer(d, arms, edge, log(r, 2, 5), r.choice([0.0, 5 * r.random()]), r.choice(["no-pull", "elastogap"]))
    else:
        base(d, 0.0, 1.0, 0.0, edge)
        friction(d, arms + [(n, -1)], r.uniform(0.1, 3), r.choice([None, 4.0]))
    return d


def redundant(r):
    """Redundant stops: duplicated, as a multiple, or as a sum of others."""
    n = r.randint(1, 3)
    d = empty("9.81")
    for i in range(n):
        body(d, log(r, -1, 1), 0.5 * i + r.choice([0.0, 0.25]), r.choice([0.0, -1.0, r.uniform(-1, 1)]), -1.0)
    e = lambda: r.choice([0.0, 0.0, 0.5, 0.25])
    chain = [[(0, -1)]] + [[(i - 1, 1), (i, -1)] for i in range(1, n)]
    for arms in chain:
        rigid(d, arms, 0.0, e())
    for _ in range(r.randint(1, 2)):
        i = r.randrange(n)
        kind = r.choice(["twice", "multiple", "sum"])
        if kind == "twice":
            rigid(d, chain[i], 0.0, e())
        elif kind == "multiple":
            rigid(d, [(b, 2 * a) for b, a in chain[i]], 0.0, e())
        else:
            rigid(d, [(i, -1)], 0.0, e())
    for i in range(n):
        if r.random() < 0.7:
            spring(d, [(i, 1)], log(r, 0, 2), r.choice([0.0, 1.0]))
    load(d, r.randrange(n), wave(r.uniform(0, 30), r.uniform(10, 90), r.uniform(0.5, 3), r.uniform(0, 6)))
    if r.random() < 0.4:
        friction(d, chain[r.randrange(n)], r.uniform(0.1, 3))
    return d


def loops(r):
    """Redundant frictions: two on one pair, or three between three bodies and the ground."""
    n = r.randint(1, 3)
    d = empty()
    for _ in range(n):
        body(d, log(r, -0.5, 0.5), 0.0, r.choice([0.0, 0.0, 1.0]))
    pairs = [[(i, 1)] for i in range(n)] + [[(i, -1), (j, 1)] for i in range(n) for j in range(i + 1, n)]
    chosen = pairs if n == 3 and r.random() < 0.3 else [r.choice(pairs) for _ in range(r.randint(2, 4))]
    for arms in chosen[:4]:
        level = r.choice([1.0, 0.5, r.uniform(0.2, 2)])
        static = r.choice([None, None, level * r.uniform(1, 1.6)])
        if r.random() < 0.3:
            friction(d, arms, wave(level, 0.5 * level, r.uniform(0.5, 3), r.uniform(0, 6)))
        else:
            friction(d, arms, level, static)
    for i in range(n):
        if r.random() < 0.6:
            spring(d, [(i, 1)], log(r, 0, 2.5))
    load(d, r.randrange(n), wave(0.0, r.uniform(1, 8), r.uniform(0.5, 3), r.choice([0.0, r.uniform(0, 6)])))
    if r.random() < 0.3:
        load(d, r.randrange(n), {"constant": "0"} | {"steps": [[num(r.choice([0.25, 0.3])), num(r.uniform(-5, 5))]]})
    return d


def repressed(r):
    """Buffers that release beyond their gap and are pressed again there."""
    n = r.randint(1, 2)
    d = empty(r.choice(["0", "9.81"]))
    for i in range(n):
        body(d, log(r, -1, 0.5), r.uniform(-0.1, 0.3), r.uniform(-2, 2), r.choice([0.0, 1.0]))
    base(d, r.uniform(0.05, 0.3), r.uniform(2, 6), r.uniform(0, 6))
    for i in range(n):
        spring(d, [(i, 1)], log(r, 1, 2.5), r.random())
    for _ in range(r.randint(1, 2)):
        arms = r.choice([[(0, 1), (n, -1)], [(n, 1), (0, -1)]] + ([[(0, 1), (1, -1)]] if n == 2 else []))
        buffer(d, arms, r.uniform(-0.2, 0.05), log(r, 0.5, 2.5), log(r, -0.5, 1.5), r.choice(["no-pull", "no-pull", "elastogap"]))
    if n == 2:
        rigid(d, [(0, -1), (1, 1)], 0.5, r.choice([0.5, 0.8]))
    if r.random() < 0.3:
        friction(d, [(0, 1)], r.uniform(0.1, 1))
    load(d, 0, {"constant": num(r.uniform(-5, 5))})
    return d


def corners(r):
    """Several events at one instant: flights and decelerations that end at a dyadic time."""
    d = empty()
    t = r.choice([0.25, 0.5])
    count = r.randint(1, 3)
    kind = r.choice(["flight", "flight", "slowed", "symmetric", "chain"])
    if kind == "flight":
    # All bodies reach their stops, to the ground or to one another, at t.
        for i in range(count):
            body(d, r.choice([1.0, 0.5, 2.0, 0.125]), 0.0, r.choice([1.0, 2.0, 0.5, 4.0]))
        ends = [float(b["v"]) * t for b in d["bodies"]]
        for i in range(count):
            choice = r.choice(["ground", "neighbour", "buffer", "both", "friction"])
            before = (i - 1) % count
            if choice in ("ground", "both"):
                rigid(d, [(i, 1)], ends[i], r.choice([0.0, 0.5, 1.0]))
            if choice in ("buffer", "both"):
                buffer(d, [(i, 1)], ends[i], log(r, 1, 3), r.choice([0.0, 3.0]), r.choice(["no-pull", "elastogap"]))
            if choice == "neighbour" and count > 1 and ends[i] != ends[before]:
                a, b = (i, before) if ends[i] > ends[before] else (before, i)
                rigid(d, [(a, 1), (b, -1)], ends[a] - ends[b], r.choice([0.0, 0.5, 1.0]))
            if choice == "friction" and count > 1:
                friction(d, [(i, 1), (before, -1)], {"constant": "0", "steps": [[num(t), "1.0"]]}, r.choice([None, {"constant": "0", "steps": [[num(t), "1.5"]]}]))
    elif kind == "slowed":
        # Friction brings bodies to rest at t, at the edge of a stop.
        for i in range(count):
            a = r.choice([1.0, 2.0, 4.0])
            body(d, 1.0, 0.0, a * t)
            friction(d, [(i, 1)], a, r.choice([None, 1.5 * a]))
            end = 0.5 * a * t * t
            choice = r.choice(["rigid", "buffer", "none"])
            if choice == "rigid":
                rigid(d, [(i, 1)], end, r.choice([0.0, 0.5]))
            elif choice == "buffer":
                buffer(d, [(i, 1)], end, log(r, 1, 3), r.choice([0.0, 3.0]), r.choice(["no-pull", "elastogap"]))
    elif kind == "symmetric":
        # Equal bodies on both sides of one body, with equal stops: every event happens twice at
        # the same time.
        k, c, m, gap, v, e = log(r, 1, 2.5), r.choice([0.0, 1.0]), log(r, -0.5, 0.5), r.uniform(0.01, 0.1), r.uniform(0.5, 2), r.choice([0.0, 0.5, 0.8])
        body(d, log(r, -0.5, 0.5))
        for sign in (1, -1):
            body(d, m, 0.0, sign * v)
            spring(d, [(0, -1), (len(d["bodies"]) - 1, 1)], k, c)
        for i, sign in ((1, 1), (2, -1)):
            if r.random() < 0.5 or i == 1:
                rigid(d, [(0, -sign), (i, sign)], gap, e)
            else:
                rigid(d, [(i, sign)], gap, e)
            rigid(d, [(0, sign), (i, -sign)], gap, e)
        if r.random() < 0.5:
            for i in (1, 2):
                friction(d, [(0, -1), (i, 1)], 0.5)
        if r.random() < 0.5:
            spring(d, [(0, 1)], log(r, 0, 2))
    else:
        # A row of touching bodies, hit by one or by two bodies at t.
        count = r.randint(2, 4)
        e = [r.choice([0.0, 0.5, 1.0]) for _ in range(count)]
        for i in range(count):
            moves = 1.0 if i == 0 else -1.0 if i == count - 1 and r.random() < 0.5 else 0.0
            body(d, r.choice([1.0, 0.5, 2.0, 0.01]), -t if i == 0 else t if moves < 0 else 0.0, moves)
        for i in range(1, count):
            rigid(d, [(i - 1, 1), (i, -1)], 0.0, e[i])
        if r.random() < 0.5:
            rigid(d, [(count - 1, 1)], t if float(d["bodies"][-1]["v"]) < 0 else 0.0, e[0])
        if r.random() < 0.4:
            friction(d, [(1, 1)], r.choice([0.5, 1.0]))
    i = r.randrange(len(d["bodies"]))
    if r.random() < 0.5:
        load(d, i, {"constant": "0", "steps": [[num(t), num(r.choice([-1.0, 1.0, 3.0]))]]})
    else:
        load(d, i, {"constant": "0", "steps": [[num(t + 0.125), num(r.uniform(-5, 5))]]})
    return d


def levels(r):
    """Levels of friction that pass or touch zero, some where bodies rest or come to rest."""
    n = r.randint(1, 2)
    d = empty(r.choice(["0", "9.81"]))
    for _ in range(n):
        body(d, log(r, -0.5, 0.5), 0.0, r.choice([0.0, 1.0, r.uniform(-1, 1)]), r.choice([0.0, 1.0]))
    for i in range(n):
        if r.random() < 0.7:
            spring(d, [(i, 1)], log(r, 0, 2.5), r.choice([0.0, 0.5]))
    for _ in range(r.randint(1, 3)):
        a, f = r.choice([1.0, 2.0, r.uniform(0.5, 4)]), r.choice([1.0, 2.0, 4.0, r.uniform(0.5, 4)])
        constant = r.choice([0.0, a, -a, 0.5 * a, -0.5 * a])
        phase = r.choice([0.0, 0.0, r.uniform(0, 6)])
        arms = r.choice([[(i, 1)] for i in range(n)] + ([[(0, -1), (1, 1)]] if n == 2 else []))
        force = wave(constant, a, f, phase)
        if r.random() < 0.3:
            force["steps"] = [[num(0.375), num(-a)], [num(0.5), num(a)]]
        static = None
        if r.random() < 0.3:
            static = {k: num(1.25 * float(x)) if k in ("constant", "amplitude") else x for k, x in force.items()}
            if "steps" in force:
                static["steps"] = [[t, num(1.25 * float(h))] for t, h in force["steps"]]
        friction(d, arms, force, static)
    load(d, r.randrange(n), wave(0.0, r.uniform(0.5, 4), r.choice([1.0, 2.0, r.uniform(0.5, 3)]), r.choice([0.0, r.uniform(0, 6)])))
    return d


def stiff(r):
    """Buffers a million times as stiff as the mount."""
    n = r.randint(1, 2)
    d = empty(r.choice(["0", "9.81"]))
    mount = log(r, 1, 2.5)
    for _ in range(n):
        body(d, log(r, -0.5, 0.5), r.choice([0.0, r.uniform(-0.2, 0.05)]), r.uniform(-1, 2), r.choice([0.0, 1.0]))
    for i in range(n):
        spring(d, [(i, 1)] if i == 0 or r.random() < 0.5 else [(0, -1), (i, 1)], mount, r.choice([0.0, 0.5]))
    for _ in range(r.randint(1, 2)):
        arms = r.choice([[(0, 1)], [(0, -1)]] + ([[(0, -1), (1, 1)], [(0, 1), (1, -1)]] if n == 2 else []))
        gap = r.choice([0.05, 0.1, r.uniform(0.02, 0.2)])
        c = r.choice([0.0, log(r, 1, 4), log(r, 4, 5)])
        buffer(d, arms, gap, 1e6 * mount, c, r.choice(["no-pull", "elastogap"]))
    if n == 2 and r.random() < 0.5:
        rigid(d, [(0, -1), (1, 1)], 0.3, r.choice([0.5, 1.0]))
    if r.random() < 0.4:
        friction(d, [(0, 1)], r.uniform(0.1, 2))
    load(d, 0, wave(0.0, r.uniform(5, 50), r.uniform(0.5, 3), r.uniform(0, 6)))
    return d


def laws(r):
    """Buffers that may pull, and buffers without a dashpot in the rebound, with walls and friction; some bodies are at rest there or
    reverse at the edge."""
    n = r.randint(1, 2)
    d = empty(r.choice(["0", "9.81"]))
    law = lambda: r.choice(["pull", "undamped-rebound"])
    for i in range(n):
        body(d, log(r, -1, 0.5), r.uniform(-0.1, 0.3), r.choice([0.0, r.uniform(-2, 2)]), r.choice([0.0, 1.0]))
    base(d, r.uniform(0.05, 0.3), r.uniform(2, 6), r.uniform(0, 6))
    for i in range(n):
        spring(d, [(i, 1)], log(r, 1, 2.5), r.random())
        if r.random() < 0.5:
            buffer(d, [(i, 1)], float(d["bodies"][i]["s"]), log(r, 1, 3), r.choice([0.0, 10 * r.random()]), law())
    for _ in range(r.randint(1, 2)):
        arms = r.choice([[(0, 1), (n, -1)], [(n, 1), (0, -1)]] + ([[(0, 1), (1, -1)]] if n == 2 else []))
        buffer(d, arms, r.uniform(-0.2, 0.05), log(r, 0.5, 2.5), log(r, -0.5, 1.5), law())
    if n == 2:
        rigid(d, [(0, -1), (1, 1)], 0.5, r.choice([0.5, 0.8]))
    if r.random() < 0.3:
        friction(d, [(0, 1)], r.uniform(0.1, 1))
    load(d, 0, {"constant": num(r.uniform(-5, 5))})
    return d


def follows(r):
    """Friction that follows the force of a buffer of any law, on the buffer's own or other bodies, with and without static levels."""
    n = r.randint(1, 2)
    d = empty(r.choice(["0", "9.81"]))
    for i in range(n):
        body(d, log(r, -1, 0.5), r.uniform(-0.1, 0.2), r.choice([0.0, r.uniform(-2, 2)]), r.choice([0.0, 1.0]))
    base(d, r.uniform(0.05, 0.3), r.uniform(2, 6), r.uniform(0, 6))
    for i in range(n):
        spring(d, [(i, 1)], log(r, 1, 2.5), r.random())
    arms = r.choice([[(0, 1), (n, -1)], [(0, 1)]] + ([[(0, 1), (1, -1)]] if n == 2 else []))
    law = r.choice(["no-pull", "elastogap", "pull", "undamped-rebound"])
    buffer(d, arms, r.uniform(-0.2, 0.05), log(r, 1, 2.5), r.choice([0.0, log(r, -0.5, 1.5)]), law)
    along = r.choice([[(0, 1)], [(n - 1, 1)], [(n - 1, 1), (n, -1)]])
    d["frictions"].append({"arms": along, "follows": 0, "force": num(r.uniform(0.1, 0.9))})
    if r.random() < 0.5:
        d["frictions"][0]["static"] = num(float(d["frictions"][0]["force"]) * r.uniform(1.1, 1.8))
    if n == 2 and r.random() < 0.5:
        rigid(d, [(0, -1), (1, 1)], 0.5, r.choice([0.5, 0.8]))
    load(d, 0, {"constant": num(r.uniform(-5, 5))})
    return d


FAMILIES = [grazing, redundant, loops, repressed, corners, levels, stiff, laws, follows]


def main(seed, count, only):
    left_out = {}
    print("# Machines at the edge of the law and their motions in 50 digits, by make_families.py: time, then s and v of every body.")
    for family in FAMILIES:
        if only and family.__name__ not in only:
            continue
        r, number = random.Random(f"{seed} {family.__name__}"), 0
        while number < count:
            d = family(r)
            if d is None or not touched(d):
                continue
            m = Machine(d, exact, TIMES)
            try:
                out = m.run()
            except (ArithmeticError, ZeroDivisionError) as e:
                key = (family.__name__, str(e))
                left_out[key] = left_out.get(key, 0) + 1
                if str(e) in ("no mode", "2 modes"):
                    print("\n".join(toml(d, "left_out")), "\n#", e, file=sys.stderr)
                number += 1
                continue
            show(f"{family.__name__}{number}", d, number, m, out)
            number += 1
    for (name, why), times in left_out.items():
        print(f"left out: {name}, {why}: {times}", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "1", int(sys.argv[2]) if len(sys.argv) > 2 else 8, sys.argv[3:])
