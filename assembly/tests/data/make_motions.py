"""Motions of random machines in 50 digits: python make_motions.py > motions.txt

A second method, written once more and nothing of it from the crate: power series in time of each mode, roots by bisection with a
bound on every interval, impacts by trying all sets of impulses, and the mode that follows an event by trying all modes and keeping
the one in which every watched quantity begins with the right sign. Machines for which more or fewer than one mode does so are left
out. Bounces are followed until they are 1e-20 m/s slow.
"""

import itertools
import random
import sys

from mpmath import matrix, mp, mpf, pi, sin

mp.dps = 50
ZERO = mpf(10) ** -32  # above the rounding of sums and roots, below anything that a machine of short decimals has by itself
ORDERS = 44
TAIL = mpf(10) ** -46
SLOW = mpf(10) ** -20
EVENTS = 900
TIMES = [mpf(1) / 4, mpf(1) / 2, mpf(3) / 4, mpf(1)]


def value(p, t):
    s = mpf(0)
    for c in reversed(p):
        s = s * t + c
    return s


def shifted(p, t):
    """The series about t."""
    p, n = list(p), len(p)
    for i in range(n - 1):
        for j in range(n - 2, i - 1, -1):
            p[j] += t * p[j + 1]
    return p


def leading(p, h, scale):
    """Order of the first coefficient that is not zero."""
    for k, c in enumerate(p[: ORDERS // 2]):
        if abs(c) * h**k > ZERO * scale:
            return k
    return None


def first_root(p, h):
    """The first time in (0, h] at which p, negative at first, is positive; None where it is proved that there is none."""
    stack = [(mpf(0), mpf(h))]
    while stack:
        a, b = stack.pop()
        mid, r = (a + b) / 2, (b - a) / 2
        c = shifted(p, mid)
        if abs(c[0]) > sum(abs(x) * r**k for k, x in enumerate(c) if k):
            if c[0] > 0:
                return a
            continue
        slope = sum(k * abs(x) * r ** (k - 1) for k, x in enumerate(c) if k > 1)
        if abs(c[1]) > slope or r < mpf(10) ** -44:
            if value(p, b) <= 0 or (c[1] < 0 and value(p, a) <= 0):
                continue
            if value(p, a) > 0:
                return a
            for _ in range(200):
                m = (a + b) / 2
                a, b = (m, b) if value(p, m) <= 0 else (a, m)
            return b
        stack += [(mid, b), (a, mid)]
    return None


class Machine:
    def __init__(self, d):
        self.d, self.n = d, len(d["bodies"])
        self.m = [mpf(b["mass"]) for b in d["bodies"]]
        self.g = mpf(d["gravity"])

    def row(self, arms):
        r = [mpf(0)] * self.n
        for i, x in arms:
            r[i] += mpf(x)
        return r

    def signal(self, s, t, k):
        """Taylor coefficient of order k of constant + amplitude sin(2π f t + phase)."""
        c = mpf(s["constant"]) if k == 0 else mpf(0)
        if "amplitude" in s:
            w = 2 * pi * mpf(s["frequency"])
            c += mpf(s["amplitude"]) * w**k / mp.factorial(k) * sin(w * t + mpf(s["phase"]) + k * pi / 2)
        return c

    def series(self, q, v, t, mode):
        """Coefficients of q (by body), of contact forces, of every element's e; None where contacts depend on one another."""
        d, n = self.d, self.n
        held = [(self.row(s["arms"]), "s", i) for i, s in enumerate(d["stops"]) if mode["s"][i] == "closed"]
        held += [(self.row(f["arms"]), "f", i) for i, f in enumerate(d["frictions"]) if mode["f"][i] == "stuck"]
        g = matrix(len(held), len(held))
        for a, (wa, _, _) in enumerate(held):
            for b, (wb, _, _) in enumerate(held):
                g[a, b] = sum(wa[i] * wb[i] / self.m[i] for i in range(n))
        inverse = None
        if held:
            if abs(mp.det(g)) < mpf(10) ** -12:
                return None
            inverse = g**-1
        qs, lam = [[q[i], v[i]] for i in range(n)], [[] for _ in held]
        for k in range(ORDERS - 2):
            f = [mpf(0)] * n
            if k == 0:
                for i, b in enumerate(d["bodies"]):
                    f[i] += self.m[i] * self.g * mpf(b["gravity"])
            for load in d["loads"]:
                f[load["body"]] += self.signal(load, t, k)

            def add(w, force):
                for i in range(n):
                    f[i] -= w[i] * force

            for s in d["springs"]:
                w = self.row(s["arms"])
                e, rate = sum(w[i] * qs[i][k] for i in range(n)), sum(w[i] * qs[i][k + 1] * (k + 1) for i in range(n))
                add(w, mpf(s["stiffness"]) * e + mpf(s["damping"]) * rate)
            for s, state in zip(d["stops"], mode["s"]):
                if state in ("pressed", "capped"):
                    w = self.row(s["arms"])
                    x = sum(w[i] * qs[i][k] for i in range(n)) - (mpf(s["gap"]) if k == 0 else 0)
                    rate = sum(w[i] * qs[i][k + 1] * (k + 1) for i in range(n))
                    spring = mpf(s["stiffness"]) * x
                    add(w, spring + mpf(s["damping"]) * rate if state == "pressed" else 2 * spring)
            for r, state in zip(d["frictions"], mode["f"]):
                if state in ("up", "down"):
                    add(self.row(r["arms"]), (1 if state == "up" else -1) * self.signal(r["force"], t, k))
            if held:
                b = matrix([sum(w[i] * f[i] / self.m[i] for i in range(n)) for w, _, _ in held])
                x = inverse * b
                for j, (w, _, _) in enumerate(held):
                    lam[j].append(x[j])
                    add(w, x[j])
            for i in range(n):
                qs[i].append(f[i] / self.m[i] / ((k + 1) * (k + 2)))
        forces = {(kind, i): lam[j] for j, (_, kind, i) in enumerate(held)}
        return qs, forces

    def e(self, qs, arms):
        w = self.row(arms)
        return [sum(w[i] * qs[i][k] for i in range(self.n)) for k in range(ORDERS)]

    def watched(self, qs, forces, t, mode):
        """Series that are negative in the mode."""
        found = []
        rate_of = lambda e: [(k + 1) * e[k + 1] for k in range(ORDERS - 1)]
        neg = lambda p: [-x for x in p]
        for i, (s, state) in enumerate(zip(self.d["stops"], mode["s"])):
            x = self.e(qs, s["arms"])
            x[0] -= mpf(s["gap"])
            if state in ("open", "below"):
                found.append((("s", i), x))
            elif state == "closed":
                found.append((("s", i), neg(forces[("s", i)])))
            else:
                k, c = mpf(s["stiffness"]), mpf(s["damping"])
                force = [k * a + c * b for a, b in zip(x, rate_of(x))]
                excess = [a - 2 * k * b for a, b in zip(force, x)]
                if state == "pressed":
                    found.append((("s", i), neg(force)))
                    found.append((("s", i), neg(x)))
                    if s["law"] == "elastogap" and c > 0:
                        found.append((("s", i), excess))
                elif state == "free":
                    found += [(("s", i), force), (("s", i), neg(x))]
                else:
                    found += [(("s", i), neg(excess)), (("s", i), neg(x))]
        for i, (f, state) in enumerate(zip(self.d["frictions"], mode["f"])):
            level = [self.signal(f["force"], t, k) for k in range(ORDERS)]
            if state == "off":
                found.append((("f", i), level))
                continue
            found.append((("f", i), neg(level)))
            if state == "stuck":
                force = forces[("f", i)]
                found += [(("f", i), [a - b for a, b in zip(force, level)]), (("f", i), [-a - b for a, b in zip(force, level)])]
            else:
                rate = rate_of(self.e(qs, f["arms"]))
                found.append((("f", i), neg(rate) if state == "up" else rate))
        return found

    def impacts(self, q, v, touching):
        """Newton's impact law in Moreau's form, until nothing closes."""
        while True:
            ws = {i: self.row(self.d["stops"][i]["arms"]) for i in touching}
            u = {i: sum(w[k] * v[k] for k in range(self.n)) for i, w in ws.items()}
            if all(x <= ZERO for x in u.values()):
                return v
            self.hits += 1
            taking = [i for i in touching if u[i] >= -ZERO]
            eps = {i: mpf(self.d["stops"][i]["restitution"]) for i in taking}
            for i in taking:
                if u[i] < SLOW:
                    eps[i] = mpf(0)
            best = None
            for r in range(len(taking), 0, -1):
                for s in itertools.combinations(taking, r):
                    g = matrix(r, r)
                    for a, i in enumerate(s):
                        for b, j in enumerate(s):
                            g[a, b] = sum(ws[i][k] * ws[j][k] / self.m[k] for k in range(self.n))
                    if abs(mp.det(g)) < mpf(10) ** -12:
                        continue
                    p = g**-1 * matrix([(1 + eps[i]) * max(u[i], 0) for i in s])
                    if any(x < -ZERO for x in p):
                        continue
                    after = [v[k] - sum(p[a] * ws[i][k] for a, i in enumerate(s)) / self.m[k] for k in range(self.n)]
                    if all(sum(ws[i][k] * after[k] for k in range(self.n)) <= -eps[i] * max(u[i], 0) + ZERO for i in taking):
                        best = after
            if best is None:
                raise ArithmeticError("no impulses")
            v = best

    def select(self, q, v, t):
        """The mode that follows, by trying all."""
        choices_s, choices_f = [], []
        for s in self.d["stops"]:
            w = self.row(s["arms"])
            x = sum(w[k] * q[k] for k in range(self.n)) - mpf(s["gap"])
            u = sum(w[k] * v[k] for k in range(self.n))
            if "restitution" in s:
                touching = abs(x) < ZERO and abs(u) < ZERO
                choices_s.append(["open", "closed"] if touching else ["open"])
            elif x < -ZERO:
                choices_s.append(["below"])
            else:
                states = ["pressed", "free"] + (["capped"] if s["law"] == "elastogap" and mpf(s["damping"]) > 0 else [])
                choices_s.append(states + (["below"] if abs(x) < ZERO else []))
        for f in self.d["frictions"]:
            w = self.row(f["arms"])
            u = sum(w[k] * v[k] for k in range(self.n))
            choices_f.append(["up", "down", "stuck", "off"] if abs(u) < ZERO else ["up" if u > 0 else "down", "off"])
        fits = []
        for ss in itertools.product(*choices_s):
            for fs in itertools.product(*choices_f):
                mode = {"s": list(ss), "f": list(fs)}
                found = self.series(q, v, t, mode)
                if found is None:
                    continue
                if self.fits(*found, t, mode):
                    fits.append(mode)
        if len(fits) != 1:
            raise ArithmeticError(f"{len(fits)} modes")
        return fits[0]

    def fits(self, qs, forces, t, mode):
        h = self.step(qs)
        for _, p in self.watched(qs, forces, t, mode):
            k = leading(p, h, max([mpf(1)] + [abs(x) * h**j for j, x in enumerate(p)]))
            if k is not None and p[k] > 0:
                return False
            if k is None and mode["s"] + mode["f"] == []:
                return False
        return True

    def step(self, qs):
        size = max([mpf(10) ** -3] + [abs(x[0]) for x in qs] + [abs(x[1]) for x in qs])
        h = mpf(1) / 8
        while any(abs(c) * h ** (ORDERS - 3 + j) * ORDERS**2 > TAIL * size for x in qs for j, c in enumerate(x[-3:])):
            h /= 2
        return h

    def run(self):
        q = [mpf(b["s"]) for b in self.d["bodies"]]
        v = [mpf(b["v"]) for b in self.d["bodies"]]
        t, out, events, self.hits = mpf(0), [], 0, 0
        mode = None
        for end in TIMES:
            while t < end:
                if mode is None:
                    rigid = [i for i, s in enumerate(self.d["stops"]) if "restitution" in s]
                    x = {i: sum(a * b for a, b in zip(self.row(self.d["stops"][i]["arms"]), q)) - mpf(self.d["stops"][i]["gap"]) for i in rigid}
                    v = self.impacts(q, v, [i for i in rigid if abs(x[i]) < ZERO])
                    mode = self.select(q, v, t)
                qs, forces = self.series(q, v, t, mode)
                h = min(self.step(qs), end - t)
                first = None
                for who, p in self.watched(qs, forces, t, mode):
                    k = leading(p, self.step(qs), max([mpf(1)] + [abs(x) * h**j for j, x in enumerate(p)]))
                    if k is None:
                        continue
                    root = first_root(p[k:], h)
                    if root is not None and (first is None or root < first):
                        first = root
                dt = h if first is None else first
                q = [value(x, dt) for x in qs]
                v = [value([(k + 1) * x[k + 1] for k in range(ORDERS - 1)], dt) for x in qs]
                t += dt
                if first is not None:
                    mode, events = None, events + 1
                    if events > EVENTS:
                        raise ArithmeticError("too many events")
            out.append((t, list(q), list(v)))
        return out


def decimal(r, *values):
    return r.choice(values)


def place(r, n):
    a, b = r.randrange(n), r.randrange(n + 1)
    sign = r.choice([1, -1])
    return [(a, sign)] if a == b or b == n else [(a, -sign), (b, sign)]


def signal(r, size):
    s = {"constant": r.choice(["0", f"{size * r.random():.2f}", f"{-size * r.random():.2f}"])}
    if r.random() < 0.7:
        s |= {"amplitude": f"{size * (0.2 + r.random()):.2f}", "frequency": f"{0.3 + 2.5 * r.random():.2f}", "phase": f"{6 * r.random():.2f}"}
    return s


def machine(r):
    n = r.randint(1, 4)
    d = {"gravity": r.choice(["0", "9.81"]), "bodies": [], "springs": [], "stops": [], "frictions": [], "loads": []}
    for _ in range(n):
        d["bodies"].append({"mass": f"{10 ** r.uniform(-1, 1):.3f}", "gravity": r.choice(["0", "1", "-0.5"]), "s": r.choice(["0", "0.5", f"{r.uniform(-1, 1):.2f}"]), "v": r.choice(["0", "1", f"{r.uniform(-1, 1):.2f}"])})
    for _ in range(r.randint(1, n + 1)):
        d["springs"].append({"arms": place(r, n), "stiffness": f"{10 ** r.uniform(0, 2.7):.2f}", "damping": r.choice(["0", f"{2 * r.random():.2f}"])})
    for _ in range(r.randint(0, 3)):
        arms = place(r, n)
        e = sum(mpf(x) * mpf(d["bodies"][i]["s"]) for i, x in arms)
        gap = r.choice(["0", "0.5", f"{r.uniform(-0.5, 1):.2f}"])
        if r.random() < 0.6:
            gap = gap if mpf(gap) >= e else mp.nstr(e + r.choice([0, mpf("0.2")]), 6)
            d["stops"].append({"arms": arms, "gap": gap, "restitution": r.choice(["0", "0.3", "0.5", "0.7", "1"])})
        else:
            d["stops"].append({"arms": arms, "gap": gap, "stiffness": f"{10 ** r.uniform(1, 3.5):.1f}", "damping": r.choice(["0", f"{4 * r.random():.2f}"]), "law": r.choice(["no-pull", "elastogap"])})
    for _ in range(r.randint(0, 2)):
        d["frictions"].append({"arms": place(r, n), "force": signal(r, 1.0)})
    d["loads"].append({"body": r.randrange(n), **signal(r, 3.0)})
    return d


def toml(d, number):
    lines = [f'name = "M{number}"', f"gravity = {d['gravity']}"]
    ends = lambda arms: "arms = { " + ", ".join(f"b{i} = {x}" for i, x in arms) + " }"
    numbers = lambda s, *keys: [f"{k} = {s[k]}" for k in keys if k in s]
    flat = lambda s: ", ".join(numbers(s, "constant", "amplitude", "frequency", "phase"))
    for i, b in enumerate(d["bodies"]):
        lines += [f"[body.b{i}]", f"mass = {b['mass']}", f"gravity = {b['gravity']}", f"start = {{ s = {b['s']}, v = {b['v']} }}"]
    for i, s in enumerate(d["springs"]):
        lines += [f"[spring.k{i}]", ends(s["arms"]), *numbers(s, "stiffness", "damping")]
    for i, s in enumerate(d["stops"]):
        lines += [f"[stop.s{i}]", ends(s["arms"]), *numbers(s, "gap", "restitution", "stiffness", "damping")]
        lines += [f'law = "{s["law"]}"'] if "law" in s else []
    for i, f in enumerate(d["frictions"]):
        lines += [f"[friction.f{i}]", ends(f["arms"]), f"force = {{ {flat(f['force'])} }}"]
    for i, load in enumerate(d["loads"]):
        lines += [f"[load.l{i}]", f'on = "b{load["body"]}"', *numbers(load, "constant", "amplitude", "frequency", "phase")]
    return lines


def touched(d):
    bodies = {i for key in ("springs", "stops", "frictions") for x in d[key] for i, _ in x["arms"]}
    return len(bodies | {load["body"] for load in d["loads"]}) == len(d["bodies"])


def main(count):
    r, number, left_out = random.Random(29), 0, 0
    print("# Machines and their motions in 50 digits, by make_motions.py: each state is time, then s and v of every body.")
    while number < count:
        d = machine(r)
        if not touched(d) or any("amplitude" not in f["force"] and mpf(f["force"]["constant"]) < 0 for f in d["frictions"]):
            continue  # files with these are refused
        m = Machine(d)
        try:
            out = m.run()
        except (ArithmeticError, ZeroDivisionError) as e:
            left_out += 1
            print(f"left out: {e}", file=sys.stderr)
            continue
        print(f"## machine {number}")
        print("\n".join(toml(d, number)))
        for t, q, v in out:
            print("## state", mp.nstr(t, 20), *(mp.nstr(x, 25) for pair in zip(q, v) for x in pair))
        print(f"## impacts {m.hits}", flush=True)
        number += 1
    print(f"{left_out} left out", file=sys.stderr)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 88)
