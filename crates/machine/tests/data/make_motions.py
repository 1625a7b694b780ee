"""Motions of random machines in 50 digits: python make_motions.py > motions.txt

A second, independent method that uses nothing from the crate: power series in time of each mode, roots by bisection with a bound on
every interval, impacts by trying all sets of impulses. The mode after an event is found by trying all modes and keeping each in
which every watched quantity begins with the right sign; if there are several, all must give the same motion. Machines without a
unique motion are omitted. Bounces are followed down to 1e-20 m/s.
"""

import itertools
import random
import sys

from mpmath import matrix, mp, mpf, pi, sin

mp.dps = 50
ZERO = mpf(10) ** -32  # above the rounding of sums and roots, below any value that short decimals give
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
    """Returns the first time in (0, h] at which p, negative at first, is positive; None if provably there is none."""
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
    """A machine; `number` reads its numbers, `times` are the times at which states are wanted."""

    def __init__(self, d, number=mpf, times=TIMES):
        self.d, self.n, self.number, self.times = d, len(d["bodies"]), number, times
        # The inverse of the inertia, which is zero for prescribed bodies.
        self.inverse = [1 / number(b["mass"]) if "mass" in b else mpf(0) for b in d["bodies"]]
        self.g = number(d["gravity"])
        signals = [*d["loads"], *(b["motion"] for b in d["bodies"] if "motion" in b)]
        signals += [f[key] for f in d["frictions"] for key in ("force", "static") if key in f and "follows" not in f]
        self.knots = sorted({number(t) for s in signals for t, _ in s.get("steps", [])})

    def row(self, arms):
        r = [mpf(0)] * self.n
        for i, x in arms:
            r[i] += self.number(x)
        return r

    def signal(self, s, t, k):
        """Taylor coefficient of order k of constant + rate t + steps + amplitude sin(2π f t + phase)."""
        number = self.number
        c = number(s["constant"]) + sum(number(h) for at, h in s.get("steps", []) if number(at) <= t) if k == 0 else mpf(0)
        if "rate" in s:
            c += number(s["rate"]) * (t if k == 0 else 1 if k == 1 else 0)
        if "amplitude" in s:
            w = 2 * pi * number(s["frequency"])
            c += number(s["amplitude"]) * w**k / mp.factorial(k) * sin(w * t + number(s["phase"]) + k * pi / 2)
        return c

    def series(self, q, v, t, mode, orders=ORDERS):
        """Returns coefficients of q (by body), of contact forces, of every element's e; None if contacts are redundant."""
        d, n, number = self.d, self.n, self.number
        held = [(self.row(s["arms"]), "s", i) for i, s in enumerate(d["stops"]) if mode["s"][i] == "closed"]
        held += [(self.row(f["arms"]), "f", i) for i, f in enumerate(d["frictions"]) if mode["f"][i] == "stuck"]
        g = matrix(len(held), len(held))
        for a, (wa, _, _) in enumerate(held):
            for b, (wb, _, _) in enumerate(held):
                g[a, b] = sum(wa[i] * wb[i] * self.inverse[i] for i in range(n))
        inverse = None
        if held:
            if any(g[a, a] == 0 for a in range(len(held))):
                return None
            if abs(mp.det(g)) < mpf(10) ** -20 * mp.fprod(g[a, a] for a in range(len(held))):
                return None
            inverse = g**-1
        qs, lam = [[q[i], v[i]] for i in range(n)], [[] for _ in held]
        arms = {key: [self.row(x["arms"]) for x in d[key]] for key in ("springs", "stops", "frictions")}
        for k in range(orders - 2):
            f = [mpf(0)] * n
            if k == 0:
                for i, b in enumerate(d["bodies"]):
                    if "mass" in b:
                        f[i] += number(b["mass"]) * self.g * number(b["gravity"])
            for load in d["loads"]:
                f[load["body"]] += self.signal(load, t, k)

            def add(w, force):
                for i in range(n):
                    f[i] -= w[i] * force

            for s, w in zip(d["springs"], arms["springs"]):
                e, rate = sum(w[i] * qs[i][k] for i in range(n)), sum(w[i] * qs[i][k + 1] * (k + 1) for i in range(n))
                add(w, number(s["stiffness"]) * e + number(s["damping"]) * rate)
            for s, w, state in zip(d["stops"], arms["stops"], mode["s"]):
                if state in ("pressed", "capped", "rebounding"):
                    x = sum(w[i] * qs[i][k] for i in range(n)) - (number(s["gap"]) if k == 0 else 0)
                    rate = sum(w[i] * qs[i][k + 1] * (k + 1) for i in range(n))
                    spring = number(s["stiffness"]) * x
                    dashpot = {"pressed": number(s["damping"]) * rate, "capped": spring, "rebounding": 0}[state]
                    add(w, spring + dashpot)
            for i, (w, state) in enumerate(zip(arms["frictions"], mode["f"])):
                if state in ("up", "down", "held up", "held down"):
                    add(w, (1 if state.endswith("up") else -1) * self.level(i, mode, t, k, qs))
            prescribed = [self.signal(b["motion"], t, k + 2) if "motion" in b else mpf(0) for b in d["bodies"]]
            if held:
                drift = [p * (k + 1) * (k + 2) for p in prescribed]
                b = matrix([sum(w[i] * (f[i] * self.inverse[i] + drift[i]) for i in range(n)) for w, _, _ in held])
                x = inverse * b
                for j, (w, _, _) in enumerate(held):
                    lam[j].append(x[j])
                    add(w, x[j])
            for i in range(n):
                qs[i].append(f[i] * self.inverse[i] / ((k + 1) * (k + 2)) + prescribed[i])
        forces = {(kind, i): lam[j] for j, (_, kind, i) in enumerate(held)}
        return qs, forces

    def level(self, i, mode, t, k, qs, key=None):
        """Returns the Taylor coefficient of the friction level in a mode: static or kinetic."""
        f, key = self.d["frictions"][i], key or mode["l"][i]
        if "follows" not in f:
            return self.signal(f[key], t, k)
        s, state = self.d["stops"][f["follows"]], mode["s"][f["follows"]]
        if state not in ("pressed", "capped", "rebounding"):
            return mpf(0)
        w = self.row(s["arms"])
        x = sum(w[j] * qs[j][k] for j in range(self.n)) - (self.number(s["gap"]) if k == 0 else 0)
        rate = sum(w[j] * qs[j][k + 1] * (k + 1) for j in range(self.n))
        spring = self.number(s["stiffness"]) * x
        return self.number(f[key]) * (spring + {"pressed": self.number(s["damping"]) * rate, "capped": spring, "rebounding": 0}[state])

    def e(self, qs, arms):
        w = self.row(arms)
        return [sum(w[i] * qs[i][k] for i in range(self.n)) for k in range(len(qs[0]))]

    def watched(self, qs, forces, t, mode):
        """Returns series that are negative in the mode or zero throughout; and the series that are zero throughout."""
        found, still = [], []
        rate_of = lambda e: [(k + 1) * e[k + 1] for k in range(len(e) - 1)]
        neg = lambda p: [-x for x in p]
        for i, (s, state) in enumerate(zip(self.d["stops"], mode["s"])):
            x = self.e(qs, s["arms"])
            x[0] -= self.number(s["gap"])
            if state in ("open", "below"):
                found.append(x)
            elif state == "closed":
                found.append(neg(forces[("s", i)]))
            elif state == "idle":
                still.append(x[2:])
            elif state == "hit":
                continue
            else:
                k, c = self.number(s["stiffness"]), self.number(s["damping"])
                force = [k * a + c * b for a, b in zip(x, rate_of(x))]
                excess = [a - 2 * k * b for a, b in zip(force, x)]
                if s["law"] == "pull":
                    found.append(neg(x))
                elif s["law"] == "undamped-rebound":
                    rate = rate_of(x)
                    found += [neg(x)] + ([] if c == 0 else [neg(rate) if state == "pressed" else rate])
                elif state == "pressed":
                    found += [neg(force), neg(x)]
                    if s["law"] == "elastogap" and c > 0:
                        found.append(excess)
                elif state == "free":
                    found += [force, neg(x)]
                else:
                    found += [neg(excess), neg(x)]
        for i, (f, state) in enumerate(zip(self.d["frictions"], mode["f"])):
            level = [self.level(i, mode, t, k, qs) for k in range(len(qs[0]) - 1)]
            if state == "off":
                found.append([self.level(i, mode, t, k, qs, "force") for k in range(len(qs[0]) - 1)])
                continue
            found.append(neg(level))
            rate = rate_of(self.e(qs, f["arms"]))
            if state == "stuck":
                force = forces[("f", i)]
                found += [[a - b for a, b in zip(force, level)], [-a - b for a, b in zip(force, level)]]
            elif state.startswith("held"):
                still.append(rate[1:])
            else:
                found.append(neg(rate) if state == "up" else rate)
        return found, still

    def impacts(self, q, v, touching, t):
        """Applies Newton's impact law in Moreau's form until nothing closes. In second and later impacts of an instant, stops without
        closing velocity take part if they stay closed."""
        number = self.number
        for turn in range(EVENTS):
            ws = {i: self.row(self.d["stops"][i]["arms"]) for i in touching}
            u = {i: sum(w[k] * v[k] for k in range(self.n)) for i, w in ws.items()}
            if all(x <= ZERO for x in u.values()):
                return v
            taking = [i for i in touching if u[i] >= -ZERO]
            if turn > 0 and any(u[i] <= ZERO for i in taking):
                mode, _ = self.try_all(q, v, t, set(), [i for i in taking if u[i] > ZERO])
                taking = [i for i in taking if u[i] > ZERO or mode["s"][i] != "open"]
            eps = {i: number(self.d["stops"][i]["restitution"]) for i in taking}
            for i in taking:
                if u[i] < SLOW:
                    eps[i] = mpf(0)
            best = None
            for r in range(len(taking), 0, -1):
                for s in itertools.combinations(taking, r):
                    g = matrix(r, r)
                    for a, i in enumerate(s):
                        for b, j in enumerate(s):
                            g[a, b] = sum(ws[i][k] * ws[j][k] * self.inverse[k] for k in range(self.n))
                    if abs(mp.det(g)) < mpf(10) ** -20 * mp.fprod(g[a, a] for a in range(r)):
                        continue
                    p = g**-1 * matrix([(1 + eps[i]) * max(u[i], 0) for i in s])
                    if any(x < -ZERO for x in p):
                        continue
                    after = [v[k] - sum(p[a] * ws[i][k] for a, i in enumerate(s)) * self.inverse[k] for k in range(self.n)]
                    if all(sum(ws[i][k] * after[k] for k in range(self.n)) <= -eps[i] * max(u[i], 0) + ZERO for i in taking):
                        best, took = after, sum(1 for x in p if x > ZERO)
            if best is None:
                raise ArithmeticError("no impulses")
            v = best
            self.hits += took
        raise ArithmeticError("impacts without end")

    def select(self, q, v, t):
        """Returns the next mode by trying all. If a friction slips although it is within its static level, it is released, and the
        search is repeated."""
        released = set()
        while True:
            mode, slips = self.try_all(q, v, t, released)
            leaving = {i for i in slips if "static" in self.d["frictions"][i]} - released
            if not leaving:
                return mode
            released |= leaving

    def try_all(self, q, v, t, released, closing=()):
        choices_s, choices_f, levels, resting = [], [], [], set()
        for i, s in enumerate(self.d["stops"]):
            if i in closing:
                choices_s.append(["hit"])
                continue
            w = self.row(s["arms"])
            x = sum(w[k] * q[k] for k in range(self.n)) - self.number(s["gap"])
            u = sum(w[k] * v[k] for k in range(self.n))
            if "restitution" in s:
                touching = abs(x) < ZERO and abs(u) < ZERO
                choices_s.append(["open", "closed", "idle"] if touching else ["open"])
            elif x < -ZERO:
                choices_s.append(["below"])
            else:
                damped = self.number(s["damping"]) > 0
                others = {"no-pull": ["free"], "elastogap": ["free"] + ["capped"] * damped, "pull": []}
                states = ["pressed"] + others.get(s["law"], ["rebounding"] * damped)
                choices_s.append(states + (["below"] if abs(x) < ZERO else []))
        for i, f in enumerate(self.d["frictions"]):
            w = self.row(f["arms"])
            u = sum(w[k] * v[k] for k in range(self.n))
            rests = abs(u) < ZERO
            if rests:
                resting.add(i)
            levels.append("static" if rests and i not in released and "static" in f else "force")
            choices_f.append(["up", "down", "stuck", "held up", "held down", "off"] if rests else ["up" if u > 0 else "down", "off"])
        fits = []
        for ss in itertools.product(*choices_s):
            for fs in itertools.product(*choices_f):
                mode = {"s": list(ss), "f": list(fs), "l": levels}
        # Modes that a few orders prove wrong need no further orders.
                for orders in (4, ORDERS):
                    found = self.series(q, v, t, mode, orders)
                    if found is None or not self.fits(*found, t, mode):
                        break
                else:
                    fits.append((mode, found[0]))
        if not fits:
            raise ArithmeticError("no mode")
        mode, qs = fits[0]
        h = self.step(qs)
        for _, other in fits[1:]:
            if any(abs(a - b) * h**k > 100 * ZERO for x, y in zip(qs, other) for k, (a, b) in enumerate(zip(x, y))):
                raise ArithmeticError(f"{len(fits)} modes")
        slips = [i for i in resting if all(m["f"][i] in ("up", "down") for m, _ in fits)]
        return mode, slips

    def fits(self, qs, forces, t, mode):
        h = self.step(qs) if len(qs[0]) == ORDERS else mpf(1) / 8
        scale = lambda p: max([mpf(1)] + [abs(x) * h**j for j, x in enumerate(p)])
        found, still = self.watched(qs, forces, t, mode)
        for p in found:
            k = leading(p, h, scale(p))
            if k is not None and p[k] > 0:
                return False
        return all(leading(p, h, scale(p)) is None for p in still)

    def step(self, qs):
        size = max([mpf(10) ** -3] + [abs(x[0]) for x in qs] + [abs(x[1]) for x in qs])
        h = mpf(1) / 8
        while any(abs(c) * h ** (ORDERS - 3 + j) * ORDERS**2 > TAIL * size for x in qs for j, c in enumerate(x[-3:])):
            h /= 2
        return h

    def start(self):
        """Coordinates and rates at time 0."""
        zero = mpf(0)
        given = lambda b, key, k: self.number(b[key]) if "mass" in b else self.signal(b["motion"], zero, k)
        return [given(b, "s", 0) for b in self.d["bodies"]], [given(b, "v", 1) for b in self.d["bodies"]]

    def run(self):
        q, v = self.start()
        t, out, events, self.hits = mpf(0), [], 0, 0
        mode = None
        for end in self.times:
            while t < end:
                if mode is None:
                    rigid = [i for i, s in enumerate(self.d["stops"]) if "restitution" in s]
                    x = {i: sum(a * b for a, b in zip(self.row(self.d["stops"][i]["arms"]), q)) - self.number(self.d["stops"][i]["gap"]) for i in rigid}
                    v = self.impacts(q, v, [i for i in rigid if abs(x[i]) < ZERO], t)
                    mode = self.select(q, v, t)
                qs, forces = self.series(q, v, t, mode)
                goal = min([end] + [knot for knot in self.knots if knot > t])
                h = min(self.step(qs), goal - t)
                first = None
                for p in self.watched(qs, forces, t, mode)[0]:
                    k = leading(p, self.step(qs), max([mpf(1)] + [abs(x) * h**j for j, x in enumerate(p)]))
                    if k is None:
                        continue
                    root = first_root(p[k:], h)
                    if root is not None and (first is None or root < first):
                        first = root
                dt = h if first is None else first
                q = [value(x, dt) for x in qs]
                v = [value([(k + 1) * x[k + 1] for k in range(ORDERS - 1)], dt) for x in qs]
                at_knot = first is None and t + h >= goal and goal in self.knots
                t = goal if first is None and h == goal - t else t + dt
                if first is not None or at_knot:
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
    steps = lambda s: ["steps = [" + ", ".join(f"[{t}, {h}]" for t, h in s["steps"]) + "]"] if "steps" in s else []
    keys = lambda s: numbers(s, "constant", "rate", "amplitude", "frequency", "phase") + steps(s)
    flat = lambda s: ", ".join(keys(s))
    for i, b in enumerate(d["bodies"]):
        lines.append(f"[body.b{i}]")
        if "motion" in b:
            lines.append(f"motion = {{ {flat(b['motion'])} }}")
        else:
            lines += [f"mass = {b['mass']}", f"gravity = {b['gravity']}", f"start = {{ s = {b['s']}, v = {b['v']} }}"]
    for i, s in enumerate(d["springs"]):
        lines += [f"[spring.k{i}]", ends(s["arms"]), *numbers(s, "stiffness", "damping")]
    for i, s in enumerate(d["stops"]):
        lines += [f"[stop.s{i}]", ends(s["arms"]), *numbers(s, "gap", "restitution", "stiffness", "damping")]
        lines += [f'law = "{s["law"]}"'] if "law" in s else []
    for i, f in enumerate(d["frictions"]):
        if "follows" in f:
            lines += [f"[friction.f{i}]", ends(f["arms"]), f'follows = "s{f["follows"]}"', f"coefficient = {f['force']}"]
            lines += [f"static_coefficient = {f['static']}"] if "static" in f else []
            continue
        lines += [f"[friction.f{i}]", ends(f["arms"]), f"force = {{ {flat(f['force'])} }}"]
        lines += [f"static = {{ {flat(f['static'])} }}"] if "static" in f else []
    for i, load in enumerate(d["loads"]):
        lines += [f"[load.l{i}]", f'on = "b{load["body"]}"', *keys(load)]
    return lines


def touched(d):
    bodies = {i for key in ("springs", "stops", "frictions") for x in d[key] for i, _ in x["arms"]}
    return len(bodies | {load["body"] for load in d["loads"]}) == len(d["bodies"])


def show(name, d, number, m, out):
    """Prints a machine and its motion, as the test reads them."""
    print(f"## machine {name}")
    print("\n".join(toml(d, number)))
    for t, q, v in out:
        print("## state", mp.nstr(t, 20), *(mp.nstr(x, 25) for pair in zip(q, v) for x in pair))
    print(f"## impacts {m.hits}", flush=True)


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
        show(number, d, number, m, out)
        number += 1
    print(f"{left_out} left out", file=sys.stderr)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 88)
