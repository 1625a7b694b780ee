"""Motions of bodies with contacts of normal and tangential stiffness and Coulomb friction, in 40
digits, for `tests/frictional.rs`.

    python3 crates/machine/tests/data/make_frictional.py > crates/machine/tests/data/frictional.txt
    python3 crates/machine/tests/data/make_frictional.py by > crates/machine/tests/data/frictional_by.txt

Each state of the contacts has a motion by Taylor series in time in mpmath, whose steps leave out
less than 1e-42. Events are roots of the series' polynomials, looked for between all extrema of the
event functions on a fine grid. Nothing is taken from the engine: the laws are written out here as
forces, and the slider of a contact is carried as a place w, not as a stretch. A row holds the
machine as TOML (line breaks as `|`), the end, the events (`NAME word time`), the coordinates, the
rates and the sliders' places at the end, and the factor by which the motion magnifies a change of
the start. With `by`, a row holds the machine, the end, a number of the machine, and the derivatives
of coordinates and rates at the end by this number, from motions that differ by 1e-15 of it.
"""

import copy
import random
import sys

from mpmath import cos, mp, mpf, nstr, pi, sin

mp.dps = 50
ORDERS = 40
GRID = 24
SHIFT = mpf(10) ** -15


def exact(x):
    """A number of the file as it is written there, or a varied number."""
    return x if isinstance(x, mpf) else mpf(repr(x))


def row(ends, values):
    a, b = ends
    return (values[b] if b is not None else 0) - (values[a] if a is not None else 0)


def act(force, ends, f):
    a, b = ends
    if b is not None:
        force[b] -= f
    if a is not None:
        force[a] += f


class Machine:
    def __init__(self, own):
        self.own = own
        self.mass = [exact(m) for m in own["mass"]]
        self.springs = [(s["ends"], exact(s["k"]), exact(s["d"])) for s in own["spring"]]
        self.loads = [[exact(l[x]) for x in ("constant", "amplitude", "frequency", "phase")] for l in own["load"]]
        self.contacts = []
        for c in own["contact"]:
            kn = exact(c["stiffness"])
            gap = -exact(c["preload"]) / kn if "preload" in c else exact(c["gap"])
            self.contacts.append(
                dict(n=c["normal"], t=c["tangent"], gap=gap, kn=kn, kt=exact(c["tangential_stiffness"]),
                     mu=exact(c["friction"]), w=exact(c["slider"]))
            )
        kmax = sum(k for _, k, _ in self.springs) + sum(c["kn"] + c["kt"] * (1 + c["mu"]) for c in self.contacts)
        dmax = sum(d for _, _, d in self.springs)
        rate = (2 * kmax / min(self.mass)) ** mpf("0.5") + 2 * dmax / min(self.mass)
        rate = max(rate, max([2 * pi * l[2] for l in self.loads] + [mpf(1)]))
        self.step = mpf(nstr(mpf(1.2) / rate, 5))

    def begin(self):
        s = [exact(x) for x in self.own["s"]]
        v = [exact(x) for x in self.own["v"]]
        w, states = [], []
        for c in self.contacts:
            x, et = row(c["n"], s) - c["gap"], row(c["t"], s)
            if x <= 0:
                w.append(et)
                states.append("open")
                continue
            most = c["mu"] * c["kn"] * x / c["kt"]
            own = min(max(c["w"], et - most), et + most)
            w.append(own)
            # The starts of the rows are not at a limit.
            assert abs(et - own) < most
            states.append("stick")
        return s, v, w, states

    def series(self, t, s, v, w, states):
        """Taylor coefficients of places and rates, and of each contact's x, xt, N and T."""
        n = len(s)
        S, V = [[x] for x in s], [[x] for x in v]
        waves = []
        for c, a, f, p in self.loads:
            om = 2 * pi * f
            waves.append([c, a, om, sin(om * t + p), cos(om * t + p), mpf(1)])
        for k in range(ORDERS):
            sk, vk = [x[k] for x in S], [x[k] for x in V]
            force = [mpf(0)] * n
            for i, wave in enumerate(waves):
                c, a, om, sn, cs, fact = wave
                turn = [sn, cs, -sn, -cs][k % 4]
                force[i] += a * turn * fact + (c if k == 0 else 0)
                wave[5] = fact * om / (k + 1)
            for ends, kk, d in self.springs:
                act(force, ends, kk * row(ends, sk) + d * row(ends, vk))
            for i, c in enumerate(self.contacts):
                if states[i] == "open":
                    continue
                N = c["kn"] * (row(c["n"], sk) - (c["gap"] if k == 0 else 0))
                act(force, c["n"], N)
                if states[i] == "stick":
                    T = c["kt"] * (row(c["t"], sk) - (w[i] if k == 0 else 0))
                else:
                    T = (1 if states[i] == "slip+" else -1) * c["mu"] * N
                act(force, c["t"], T)
            for i in range(n):
                S[i].append(vk[i] / (k + 1))
                V[i].append(force[i] / self.mass[i] / (k + 1))
        return S, V

    def functions(self, S, V, w, states):
        """Event functions as polynomials, each with its contact and its word: they rise through 0."""
        all = []
        at = lambda ends, X: [row(ends, [x[k] for x in X]) for k in range(ORDERS)]
        for i, c in enumerate(self.contacts):
            x = at(c["n"], S)
            x[0] -= c["gap"]
            if states[i] == "open":
                all.append((i, "press", x))
                continue
            N = [c["kn"] * y for y in x]
            all.append((i, "free", [-y for y in N]))
            if states[i] == "stick":
                T = at(c["t"], S)
                T[0] -= w[i]
                T = [c["kt"] * y for y in T]
                all.append((i, "slip+", [a - c["mu"] * b for a, b in zip(T, N)]))
                all.append((i, "slip-", [-a - c["mu"] * b for a, b in zip(T, N)]))
            else:
                sg = 1 if states[i] == "slip+" else -1
                rt, rn = at(c["t"], V), at(c["n"], V)
                all.append((i, "stick", [-sg * a + c["mu"] * c["kn"] / c["kt"] * b for a, b in zip(rt, rn)]))
        return all


def value(p, h):
    sum = mpf(0)
    for c in reversed(p):
        sum = sum * h + c
    return sum


def slope(p):
    return [k * c for k, c in enumerate(p)][1:]


def root(p, lo, hi):
    """The root of a rising passage between lo (p < 0) and hi (p >= 0)."""
    d = slope(p)
    for _ in range(20):
        mid = (lo + hi) / 2
        if value(p, mid) < 0:
            lo = mid
        else:
            hi = mid
    x = (lo + hi) / 2
    for _ in range(8):
        x = x - value(p, x) / value(d, x)
    assert lo - (hi - lo) <= x <= hi + (hi - lo)
    return x


def passage(p, end, fresh):
    """The first rising passage of a polynomial in (0, end]. With `fresh` it begins at a zero."""
    first = mpf(0)
    if fresh:
        # The function has left zero downwards: divide the zero out.
        p = list(p)
        lead = next(k for k, c in enumerate(p) if abs(c) * end ** k > mpf(10) ** -30 * max(abs(y) * end ** j for j, y in enumerate(p)))
        p = p[lead:]
        assert p[0] < 0, nstr(p[0], 5)
    d = slope(p)
    last, value_last, slope_last = first, value(p, first), value(d, first)
    for k in range(1, GRID + 1):
        h = end * k / GRID
        now, slope_now = value(p, h), value(d, h)
        if now >= 0:
            return root(p, last, h)
        if slope_last > 0 > slope_now:
            # A maximum below zero or a passage and its return between grid points.
            lo, hi = last, h
            for _ in range(100):
                mid = (lo + hi) / 2
                if value(d, mid) > 0:
                    lo = mid
                else:
                    hi = mid
            if value(p, lo) >= 0:
                return root(p, last, lo)
        last, slope_last = h, slope_now
    return None


def run(machine, end):
    m = Machine(machine)
    end = exact(end)
    s, v, w, states = m.begin()
    t, events, fresh = mpf(0), [], set()
    while t < end:
        h = min(m.step, end - t)
        S, V = m.series(t, s, v, w, states)
        found = None
        for i, word, p in m.functions(S, V, w, states):
            at = passage(p, h, (i, word) in fresh)
            if at is not None and (found is None or at < found[0]):
                found = (at, i, word)
        go = found[0] if found else h
        s = [value(x, go) for x in S]
        v = [value(x, go) for x in V]
        t += go
        fresh = set()
        for i, c in enumerate(m.contacts):
            if states[i].startswith("slip"):
                sg = 1 if states[i] == "slip+" else -1
                w[i] = row(c["t"], s) - sg * c["mu"] * c["kn"] * (row(c["n"], s) - c["gap"]) / c["kt"]
            elif states[i] == "open":
                w[i] = row(c["t"], s)
        if not found:
            continue
        _, i, word = found
        c = m.contacts[i]
        events.append((i, word, t))
        if word == "press":
            rt, rn = row(c["t"], v), row(c["n"], v)
            stick = c["kt"] * abs(rt) < c["mu"] * c["kn"] * rn
            states[i] = "stick" if stick else ("slip+" if rt > 0 else "slip-")
            fresh = {(i, "free")} | ({(i, "slip+"), (i, "slip-")} if stick else set())
        elif word == "free":
            states[i] = "open"
            fresh = {(i, "press")}
        elif word == "stick":
            fresh = {(i, states[i])}
            states[i] = "stick"
        else:
            states[i] = word
    return s, v, w, events


def number(x):
    return repr(float(x)) if not isinstance(x, mpf) else nstr(x, 45)


def text(own):
    name = lambda i: '"ground"' if i is None else f'"b{i}"'
    pair = lambda ends: f"[{name(ends[0])}, {name(ends[1])}]"
    lines = ['name = "Random"']
    for i, m in enumerate(own["mass"]):
        lines.append(f"body.b{i} = {{ mass = {number(m)}, start = {{ s = {number(own['s'][i])}, v = {number(own['v'][i])} }} }}")
    for i, s in enumerate(own["spring"]):
        lines.append(f"spring.k{i} = {{ between = {pair(s['ends'])}, stiffness = {number(s['k'])}, damping = {number(s['d'])} }}")
    for i, c in enumerate(own["contact"]):
        closing = f"preload = {number(c['preload'])}" if "preload" in c else f"gap = {number(c['gap'])}"
        rest = ", ".join(f"{key} = {number(c[key])}" for key in ("stiffness", "tangential_stiffness", "friction", "slider"))
        lines.append(f"contact.c{i} = {{ normal = {pair(c['normal'])}, tangent = {pair(c['tangent'])}, {closing}, {rest} }}")
    for i, l in enumerate(own["load"]):
        rest = ", ".join(f"{key} = {number(l[key])}" for key in ("constant", "amplitude", "frequency", "phase"))
        lines.append(f'load.f{i} = {{ on = "b{i}", {rest} }}')
    return "|".join(lines)


def rounded(x):
    return float(f"{x:.4g}")


def chosen(seed):
    """Bodies that move in two directions: even ones along normals, odd ones along tangents."""
    r = random.Random(seed)
    points = r.choice([1, 1, 2, 2, 3])
    n = 2 * points
    own = dict(mass=[rounded(r.uniform(0.5, 2)) for _ in range(n)], spring=[], contact=[], load=[], s=[], v=[])
    for i in range(n):
        own["spring"].append(dict(ends=[None, i], k=rounded(r.uniform(5, 40)), d=rounded(r.uniform(0.05, 0.5))))
        own["s"].append(rounded(r.uniform(-0.1, 0.1)))
        own["v"].append(rounded(r.uniform(-1, 1)))
        push = i % 2 == 0
        own["load"].append(
            dict(constant=rounded(r.uniform(1, 6)) if push else rounded(r.uniform(-2, 2)),
                 amplitude=rounded(r.uniform(2, 14)), frequency=rounded(r.uniform(0.3, 1.6)), phase=rounded(r.uniform(0, 6)))
        )
    # Coupling of the two directions, as of an oblique body.
    for i in range(0, n, 2):
        own["spring"].append(dict(ends=[i, i + 1], k=rounded(r.uniform(2, 15)), d=rounded(r.uniform(0, 0.2))))
    for i in range(points - 1):
        own["spring"].append(dict(ends=[2 * i, 2 * i + 2], k=rounded(r.uniform(2, 20)), d=0.1))
        own["spring"].append(dict(ends=[2 * i + 1, 2 * i + 3], k=rounded(r.uniform(2, 20)), d=0.1))
    for i in range(points):
        between = i > 0 and r.random() < 0.4
        ends = lambda k: [2 * i - 2 + k, 2 * i + k] if between else [None, 2 * i + k]
        c = dict(normal=ends(0), tangent=ends(1), stiffness=rounded(r.uniform(30, 600)),
                 tangential_stiffness=rounded(r.uniform(20, 400)),
                 friction=r.choice([rounded(r.uniform(0.1, 0.9)), rounded(r.uniform(0.1, 0.9)), 3.0]),
                 slider=rounded(r.uniform(-0.02, 0.02)))
        if r.random() < 0.4:
            c["preload"] = rounded(r.uniform(0.5, 8))
        else:
            c["gap"] = rounded(r.uniform(0, 0.05))
        own["contact"].append(c)
        # The start is open or sticks.
        x = (own["s"][ends(0)[1]] - (own["s"][ends(0)[0]] if between else 0))
        et = (own["s"][ends(1)[1]] - (own["s"][ends(1)[0]] if between else 0))
        c["slider"] = rounded(et + 0.0001)
    return own, rounded(r.uniform(2, 5))


def starts_inside(machine):
    """Whether no contact slips at the start."""
    own = Machine(machine)
    s = [exact(x) for x in machine["s"]]
    for c in own.contacts:
        x, et = row(c["n"], s) - c["gap"], row(c["t"], s)
        if x > 0 and c["kt"] * abs(et - c["w"]) >= mpf("0.99") * c["mu"] * c["kn"] * x:
            return False
    return True


def magnified(machine, end, s, v):
    """The factor by which the end is moved by changes of all starts."""
    other = copy.deepcopy(machine)
    for i, sign in zip(range(len(machine["s"])), [1, 1, -1, 1, -1, -1]):
        other["s"][i] = exact(machine["s"][i]) + sign * mpf(10) ** -20
    a, b, _, _ = run(other, end)
    return max([mpf(1)] + [abs(x - y) * mpf(10) ** 20 for x, y in zip(a + b, s + v)])


NAMES = {"contact": ["stiffness", "tangential_stiffness", "friction", "gap", "preload"]}


def varied(machine, i, key, by):
    other = copy.deepcopy(machine)
    other["contact"][i][key] = exact(machine["contact"][i][key]) + by
    return other


def main():
    is_by = "by" in sys.argv
    seeds = range(100, 109) if is_by else range(36)
    for seed in seeds:
        machine, end = chosen(seed)
        # Derivatives need many runs: only of machines with at most two contacts.
        if not starts_inside(machine) or (is_by and len(machine["mass"]) > 4):
            continue
        s, v, w, events = run(machine, end)
        if not is_by:
            found = " ".join(f"c{i} {word} {nstr(t, 40)}" for i, word, t in events)
            factor = magnified(machine, end, s, v)
            numbers = " ".join(nstr(x, 40) for x in s + v + w)
            print(";".join([text(machine), repr(end), found, numbers, nstr(factor, 6)]), flush=True)
            continue
        for i, contact in enumerate(machine["contact"]):
            for key in [key for key in NAMES["contact"] if key in contact]:
                step = SHIFT * abs(exact(contact[key]))
                if step == 0:
                    continue
                ends = [run(varied(machine, i, key, sign * step), end) for sign in (1, -1)]
                same = [[e[:2] for e in own[3]] for own in ends]
                assert same[0] == same[1] == [e[:2] for e in events]
                by = [(a - b) / (2 * step) for a, b in zip(ends[0][0] + ends[0][1], ends[1][0] + ends[1][1])]
                print(";".join([text(machine), repr(end), f"contact.c{i}.{key}", " ".join(nstr(x, 30) for x in by)]), flush=True)


if __name__ == "__main__":
    main()
