"""Motions of bodies in modal coordinates with residual flexibility, contacts, springs and loads, in
40 digits, for `tests/residual.rs`.

    python3 crates/machine/tests/data/make_residual.py > crates/machine/tests/data/residual.txt
    python3 crates/machine/tests/data/make_residual.py by > crates/machine/tests/data/residual_by.txt

Each state of the contacts has a motion by Taylor series in time in mpmath, as in
`make_frictional.py`. Nothing is taken from the engine: at each order the forces follow from
Gaussian elimination with the displacements of the nodes, B q + G (F - p), written out here; the
slider of a contact is a place w. The state after an event is found by trying all states of its
contact. A row holds the machine as TOML (line breaks as `|`), the end, the events (`NAME word
time`), the coordinates and rates of the modes and the sliders' places at the end, and the factor by
which the motion magnifies a change of the start. With `by`, a row holds the machine, the end, a
number of the machine, and the derivatives of the coordinates and rates at the end by this number,
from motions that differ by 1e-15 of it.
"""

import copy
import random
import sys

from mpmath import cos, matrix, mp, mpf, nstr, pi, sin

from make_frictional import ORDERS, exact, passage, rounded, slope, value

mp.dps = 50


class Machine:
    def __init__(self, own):
        self.own = own
        self.omega = [2 * pi * exact(f) for f in own["frequencies"]]
        self.zeta = exact(own["damping_ratio"])
        self.rows = [[exact(x) for x in row] for row in own["rows"]]
        self.G = [[exact(x) for x in row] for row in own["G"]]
        self.loads = [(l["node"], [exact(l[x]) for x in ("constant", "amplitude", "frequency", "phase")]) for l in own["load"]]
        self.springs = [(s["arms"], exact(s["k"]), exact(s["preload"])) for s in own["spring"]]
        self.contacts = []
        for c in own["contact"]:
            flexible = 1 / exact(c["stiffness"]) if "stiffness" in c else mpf(0)
            slides = "friction" in c
            self.contacts.append(
                dict(n=c["normal"], t=c.get("tangent"), gap=exact(c["gap"]), cn=flexible, slides=slides,
                     ct=1 / exact(c["tangential_stiffness"]) if slides else None,
                     mu=exact(c["friction"]) if slides else None, w=exact(c["slider"]) if slides else None)
            )
        stiff = sum(1 / (c["cn"] + self.between(c["n"], c["n"])) * self.size(c["n"]) for c in self.contacts)
        stiff += sum(3 / (c["ct"] + self.between(c["t"], c["t"])) * self.size(c["t"]) for c in self.contacts if c["slides"])
        stiff += sum(k * self.size(arms) for arms, k, _ in self.springs)
        rate = (max(self.omega) ** 2 + stiff) ** mpf("0.5")
        rate = max([rate] + [2 * pi * l[1][2] for l in self.loads])
        self.step = mpf(nstr(mpf(1) / rate, 5))

    def size(self, arms):
        return sum(x * x for x in self.modal(arms))

    def modal(self, arms):
        """The factors of the modes in an elongation."""
        return [sum(a * self.rows[node][k] for node, a in arms) for k in range(len(self.omega))]

    def between(self, one, other):
        return sum(a * b * self.G[i][j] for i, a in one for j, b in other)

    def components(self, states):
        """Forces that act: (arms, compliance, row of x or of the force that it is a multiple of)."""
        all = []
        for k, (arms, stiffness, preload) in enumerate(self.springs):
            all.append(("spring", k, arms, 1 / stiffness, None))
        for i, c in enumerate(self.contacts):
            if states[i] == "open":
                continue
            all.append(("n", i, c["n"], c["cn"], None))
            if c["slides"]:
                slip = {"stick": None, "slip+": c["mu"], "slip-": -c["mu"]}[states[i]]
                all.append(("t", i, c["t"], c["ct"], slip))
        return all

    def solver(self, states):
        """Forces of all components from the right sides."""
        all = self.components(states)
        place = {(kind, i): k for k, (kind, i, *_ ) in enumerate(all)}
        size = len(all)
        A = matrix(size, size)
        for r, (kind, i, arms, compliance, slip) in enumerate(all):
            if slip is not None:
                A[r, r], A[r, place["n", i]] = 1, -slip
                continue
            for c, (_, _, other, _, _) in enumerate(all):
                A[r, c] = self.between(arms, other)
            A[r, r] += compliance
        inverse = A ** -1 if size else None
        return all, place, inverse

    def series(self, t, q, v, w, states):
        """Taylor coefficients of modes, rates, forces of components and true elongations."""
        n = len(q)
        all, place, inverse = self.solver(states)
        Q, V, P = [[x] for x in q], [[x] for x in v], [[] for _ in all]
        waves = [(node, c, a, 2 * pi * f, sin(2 * pi * f * t + p), cos(2 * pi * f * t + p)) for node, (c, a, f, p) in self.loads]
        facts, loads = [mpf(1)] * len(waves), [[] for _ in waves]
        rows = {arms_of(arms): self.modal(arms) for _, _, arms, _, _ in all}
        for k in range(ORDERS):
            for i, (node, c, a, om, sn, cs) in enumerate(waves):
                turn = [sn, cs, -sn, -cs][k % 4]
                loads[i].append(a * turn * facts[i] + (c if k == 0 else 0))
                facts[i] = facts[i] * om / (k + 1)
            right = matrix(len(all), 1)
            for r, (kind, i, arms, compliance, slip) in enumerate(all):
                if slip is not None:
                    continue
                x = sum(b * Q[j][k] for j, b in enumerate(rows[arms_of(arms)]))
                x += sum(self.between(arms, [(node, 1)]) * loads[l][k] for l, (node, *_ ) in enumerate(waves))
                if k == 0:
                    x -= self.contacts[i]["gap"] if kind == "n" else (w[i] if kind == "t" else 0)
                    if kind == "spring":
                        x += compliance * self.springs[i][2]
                right[r] = x
            p = inverse * right if len(all) else []
            for r in range(len(all)):
                P[r].append(p[r])
            force = [-self.omega[j] ** 2 * Q[j][k] - 2 * self.zeta * self.omega[j] * V[j][k] for j in range(n)]
            for r, (_, _, arms, _, _) in enumerate(all):
                for j, b in enumerate(rows[arms_of(arms)]):
                    force[j] -= b * p[r]
            for l, (node, *_ ) in enumerate(waves):
                for j in range(n):
                    force[j] += self.rows[node][j] * loads[l][k]
            for j in range(n):
                Q[j].append(V[j][k] / (k + 1))
                V[j].append(force[j] / (k + 1))
        return Q, V, P, loads, all, place

    def elongation(self, arms, made):
        """The true elongation as a polynomial."""
        Q, _, P, loads, all, _ = made
        modal = self.modal(arms)
        e = [sum(b * Q[j][k] for j, b in enumerate(modal)) for k in range(ORDERS)]
        for l, (node, _) in enumerate(self.loads):
            g = self.between(arms, [(node, 1)])
            e = [x + g * y for x, y in zip(e, loads[l])]
        for r, (_, _, other, _, _) in enumerate(all):
            g = self.between(arms, other)
            e = [x - g * y for x, y in zip(e, P[r])]
        return e

    def slider(self, i, made):
        """The place of a slider that does not hold, as a polynomial."""
        c = self.contacts[i]
        e = self.elongation(c["t"], made)
        if ("t", i) in made[5]:
            T = made[2][made[5]["t", i]]
            e = [x - c["ct"] * y for x, y in zip(e, T)]
        return e

    def functions(self, made, states):
        """Event functions as polynomials, each with its contact and its word: they rise through 0."""
        _, _, P, _, _, place = made
        all = []
        for i, c in enumerate(self.contacts):
            if states[i] == "open":
                x = self.elongation(c["n"], made)
                x[0] -= c["gap"]
                all.append((i, "press", x))
                continue
            N = P[place["n", i]]
            all.append((i, "free", [-y for y in N]))
            if not c["slides"]:
                continue
            if states[i] == "stick":
                T = P[place["t", i]]
                all.append((i, "slip+", [a - c["mu"] * b for a, b in zip(T, N)]))
                all.append((i, "slip-", [-a - c["mu"] * b for a, b in zip(T, N)]))
            else:
                sg = 1 if states[i] == "slip+" else -1
                all.append((i, "stick", [-sg * y for y in slope(self.slider(i, made))]))
        return all


def arms_of(arms):
    return tuple(map(tuple, arms))


def first(p, h):
    """The first coefficient that is not zero, with its order."""
    size = max(abs(y) * h ** j for j, y in enumerate(p))
    for k, y in enumerate(p):
        if abs(y) * h ** k > mpf(10) ** -32 * size:
            return k, y
    return None, mpf(0)


def run(own, end):
    m = Machine(own)
    end = exact(end)
    q, v = [exact(x) for x in own["q"]], [exact(x) for x in own["v"]]
    # The starts of the rows are open.
    states = ["open"] * len(m.contacts)
    w = [None] * len(m.contacts)
    t, events, fresh = mpf(0), [], set()
    made = m.series(t, q, v, w, states)
    for i, word, p in m.functions(made, states):
        if p[0] >= 0:
            return None
    while t < end:
        h = min(m.step, end - t)
        made = m.series(t, q, v, w, states)
        found = None
        for i, word, p in m.functions(made, states):
            at = passage(p, h, (i, word) in fresh)
            if at is not None and (found is None or at < found[0]):
                found = (at, i, word)
        go = found[0] if found else h
        for i, c in enumerate(m.contacts):
            if c["slides"] and states[i] != "stick":
                w[i] = value(m.slider(i, made), go)
        q = [value(x, go) for x in made[0]]
        v = [value(x, go) for x in made[1]]
        t += go
        fresh = set()
        if not found:
            continue
        _, i, word = found
        events.append((i, word, t))
        slides = m.contacts[i]["slides"]
        tried = {"press": ["stick", "slip+", "slip-"] if slides else ["stick"], "free": ["open"]}.get(word, [word])
        good = []
        for state in tried:
            other = states[:i] + [state] + states[i + 1 :]
            made = m.series(t, q, v, w, other)
            ok, zero = True, set()
            for j, name, p in m.functions(made, other):
                own_zero = j == i and abs(p[0]) < mpf(10) ** -36
                if own_zero:
                    p = [mpf(0)] + p[1:]
                    zero.add((j, name))
                ok = ok and first(p, m.step)[1] < 0
            if ok:
                good.append((other, zero))
        assert len(good) == 1, (word, len(good), nstr(t, 10))
        states, fresh = good[0]
    for i, c in enumerate(m.contacts):
        if c["slides"] and states[i] != "stick":
            w[i] = value(m.slider(i, m.series(t, q, v, w, states)), mpf(0))
    return q, v, [x for x in w if x is not None], events


def text(own):
    name = lambda k: f"m.p{k // 2}.{'nt'[k % 2]}"
    number = lambda x: repr(float(x))
    numbers = lambda all: "[" + ", ".join(number(x) for x in all) + "]"

    def ends(arms):
        first = [f'"{name(k)}"' for k, a in arms if a < 0] or ['"ground"']
        return f"[{first[0]}, " + "".join(f'"{name(k)}"' for k, a in arms if a > 0) + "]"

    lines = ['name = "Random"', "[modal.m]", f"frequencies = {numbers(own['frequencies'])}",
             f"damping_ratio = {number(own['damping_ratio'])}"]
    points = len(own["rows"]) // 2
    nodes = [f"p{i} = {{ n = {numbers(own['rows'][2 * i])}, t = {numbers(own['rows'][2 * i + 1])} }}" for i in range(points)]
    lines.append(f"nodes = {{ {', '.join(nodes)} }}")
    labels = ", ".join(f'"p{k // 2}.{"nt"[k % 2]}"' for k in range(2 * points))
    lines.append(f"residual = {{ nodes = [{labels}], flexibility = [{', '.join(numbers(row) for row in own['G'])}] }}")
    lines.append(f"start = {{ q = {numbers(own['q'])}, v = {numbers(own['v'])} }}")
    for i, s in enumerate(own["spring"]):
        lines.append(f"[spring.k{i}]|between = {ends(s['arms'])}|stiffness = {number(s['k'])}|preload = {number(s['preload'])}")
    for i, c in enumerate(own["contact"]):
        keys = [key for key in ("gap", "stiffness", "tangential_stiffness", "friction", "slider") if key in c]
        rest = "|".join(f"{key} = {number(c[key])}" for key in keys)
        tangent = f"tangent = {ends(c['tangent'])}|" if "tangent" in c else ""
        lines.append(f"[contact.c{i}]|normal = {ends(c['normal'])}|{tangent}{rest}")
    for i, l in enumerate(own["load"]):
        rest = "|".join(f"{key} = {number(l[key])}" for key in ("constant", "amplitude", "frequency", "phase"))
        lines.append(f'[load.f{i}]|on = "{name(l["node"])}"|{rest}')
    return "|".join(lines)


def chosen(seed):
    """A body with two to four points, which move along a normal and a tangent each."""
    r = random.Random(seed)
    points, modes = r.choice([2, 2, 3, 4]), r.choice([3, 4, 6])
    own = dict(frequencies=[rounded(0.7 * (k + 1) ** 1.5 * r.uniform(0.9, 1.1)) for k in range(modes)],
               damping_ratio=rounded(r.uniform(0.005, 0.03)), spring=[], contact=[], load=[])
    size = 2 * points
    own["rows"] = [[rounded(r.uniform(-1, 1)) for _ in range(modes)] for _ in range(size)]
    root = [[r.uniform(-1, 1) for _ in range(size)] for _ in range(size)]
    scale = 10 ** r.uniform(-3, -2)
    G = [[scale * (sum(a * b for a, b in zip(x, y)) / size + (0.6 if i == j else 0)) for j, y in enumerate(root)] for i, x in enumerate(root)]
    own["G"] = [[rounded(G[min(i, j)][max(i, j)]) for j in range(size)] for i in range(size)]
    own["q"] = [rounded(r.uniform(-0.03, 0.03)) for _ in range(modes)]
    own["v"] = [rounded(r.uniform(-0.5, 0.5)) for _ in range(modes)]
    for i in range(points):
        one = [[2 * i, 1.0]] if i == 0 or r.random() < 0.7 else [[2 * i - 2, -1.0], [2 * i, 1.0]]
        c = dict(normal=one, gap=rounded(r.uniform(0.03, 0.08)))
        if r.random() < 0.7:
            c["stiffness"] = rounded(10 ** r.uniform(1.5, 3))
        if r.random() < 0.75:
            c["tangent"] = [[k + 1, a] for k, a in one]
            c["tangential_stiffness"] = rounded(10 ** r.uniform(1.3, 2.8))
            c["friction"] = rounded(r.uniform(0.1, 0.5))
            c["slider"] = 0.0
        own["contact"].append(c)
    for _ in range(r.choice([0, 1, 1, 2])):
        own["spring"].append(dict(arms=[[r.randrange(size), 1.0]], k=rounded(10 ** r.uniform(0.5, 2)), preload=rounded(r.uniform(-0.2, 0.2))))
    for _ in range(r.choice([1, 2])):
        own["load"].append(dict(node=r.randrange(size), constant=rounded(r.uniform(-0.3, 0.3)), amplitude=rounded(r.uniform(0.5, 3)),
                                frequency=rounded(r.uniform(0.3, 1.5)), phase=rounded(r.uniform(0, 6))))
    return own, rounded(r.uniform(1.5, 3))


def magnified(own, end, q, v):
    """The factor by which the end is moved by a change of all starts."""
    other = copy.deepcopy(own)
    for i in range(len(own["q"])):
        other["q"][i] = exact(own["q"][i]) + (-1) ** i * mpf(10) ** -20
    found = run(other, end)
    return max([mpf(1)] + [abs(x - y) * mpf(10) ** 20 for x, y in zip(found[0] + found[1], q + v)])


KEYS = {
    "contact": ["gap", "stiffness", "tangential_stiffness", "friction"],
    "spring": ["k", "preload"],
    "load": ["constant", "amplitude", "frequency"],
}


def varied(own, kind, i, key, by):
    other = copy.deepcopy(own)
    other[kind][i][key] = exact(own[kind][i][key]) + by
    return other


def derivatives(own, end):
    """The names of numbers, each with the derivatives at the end."""
    for kind, keys in KEYS.items():
        for i, element in enumerate(own[kind]):
            for key in (key for key in keys if key in element):
                by = mpf(10) ** -15 * max(abs(exact(element[key])), mpf("1e-3"))
                ends = [run(varied(own, kind, i, key, sign * by), end) for sign in (1, -1)]
                sides = [found[0] + found[1] for found in ends]
                letter, key = {"contact": "c", "spring": "k", "load": "f"}[kind], {"k": "stiffness"}.get(key, key)
                yield f"{kind}.{letter}{i}.{key}", [(x - y) / (2 * by) for x, y in zip(*sides)]


def main():
    numbers = [int(x) for x in sys.argv[1:] if x != "by"]
    is_by = "by" in sys.argv
    for seed in range(*numbers) if numbers else range(100, 108) if is_by else range(26):
        own, end = chosen(seed)
        found = run(own, end)
        if found is None or len(found[3]) < 3 or len(found[3]) > (20 if is_by else 80):
            continue
        q, v, w, events = found
        factor = magnified(own, end, q, v)
        if factor > (1e3 if is_by else 1e5):
            continue
        if is_by:
            for name, by in derivatives(own, end):
                print(";".join([text(own), repr(end), name, " ".join(nstr(x, 30) for x in by)]), flush=True)
            continue
        said = " ".join(f"c{i} {word} {nstr(t, 40)}" for i, word, t in events)
        print(";".join([text(own), repr(end), said, " ".join(nstr(x, 40) for x in q + v + w), nstr(factor, 6)]), flush=True)


if __name__ == "__main__":
    main()
