"""Motions of chains with contacts x^p (1 + 3/2 c x') and with odd powers, in 40 digits, for
`tests/contacts.rs`.

    python3 crates/machine/tests/data/make_contacts.py > crates/machine/tests/data/contacts.txt
    python3 crates/machine/tests/data/make_contacts.py by > crates/machine/tests/data/contacts_by.txt

The motion is a Taylor series in time in mpmath with steps that leave out less than 1e-40. At the
edge of a power whose exponent is not an integer the series are shorter and shorter, down to a
displacement of 1e-19, within which the force is left out: it would change a speed by less than
1e-40. Events are roots of the series. Nothing is taken from the engine, and no substitution of
time is used. A row holds the machine as TOML (line breaks as `|`), the end, the times at which
contacts begin and end, the coordinates and rates at the end, and the factor by which the motion
magnifies a change of the start. With `by`, a row holds the machine, the end, a number of the
machine, and the derivatives of coordinates and rates at the end by this number, from motions that
differ by 1e-18 of it.
"""

import copy
import random
import sys

from mpmath import cos, mp, mpf, nstr, pi, sin

mp.dps = 48
ORDERS = 44
LEFT_OUT = mpf(10) ** -40
EDGE = mpf(10) ** -19
SHIFT = mpf(10) ** -18


def exact(x):
    """A number of the file as it is written there, or a varied number."""
    return x if isinstance(x, mpf) else mpf(repr(x))


def power_next(x, w, p, k):
    """The coefficient of order k of x^p."""
    if k == 0:
        return x[0] ** p
    return sum((p * j + j - k) * x[j] * w[k - j] for j in range(1, k + 1)) / (k * x[0])


def row(chain, ends, values):
    a, b = ends
    return (values[b] if b is not None else 0) - (values[a] if a is not None else 0)


def series(chain, t, s, v, states):
    """Coefficients of coordinates and rates, and of the functionals of the elements."""
    count = len(s)
    masses = [exact(m) for m in chain["mass"]]
    ss, vs = [[x] for x in s], [[x] for x in v]
    gravity = exact(chain["gravity"])
    amplitude, frequency = (exact(x) for x in chain["load"])
    omega = 2 * pi * frequency
    wave = [sin(omega * t), cos(omega * t)]
    args = [[] for _ in chain["element"]]
    rates = [[] for _ in chain["element"]]
    powers = [[] for _ in chain["element"]]
    kept = [[] for _ in chain["element"]]
    for k in range(ORDERS):
        sk, vk = [x[k] for x in ss], [x[k] for x in vs]
        force = [gravity * m if k == 0 else mpf(0) for m in masses]
        force[0] += amplitude * wave[0]
        for own in chain["spring"]:
            f = exact(own["k"]) * row(chain, own["ends"], sk) + exact(own["d"]) * row(chain, own["ends"], vk)
            act(force, own["ends"], f)
        for i, own in enumerate(chain["element"]):
            e, r = row(chain, own["ends"], sk), row(chain, own["ends"], vk)
            rates[i].append(r)
            p = exact(own["p"])
            if own["kind"] == "contact":
                args[i].append(e - exact(own["gap"]) if k == 0 else e)
                if states[i] != "press":
                    powers[i].append(mpf(0))
                    continue
                still = p != int(p) and args[i][0] < EDGE
                w = mpf(0) if still else next_power(args[i], powers[i], p, k, kept[i])
                powers[i].append(w)
                c = exact(own["c"]) * 3 / 2
                product = sum(powers[i][j] * rates[i][k - j] for j in range(k + 1)) if c else 0 if c else 0
                f = exact(own["k"]) * (w + c * product) + exact(own["d"]) * r
                act(force, own["ends"], f)
            else:
                x = r if own["kind"] == "rate" else e
                args[i].append(states[i] * x)
                still = p != int(p) and args[i][0] < EDGE
                w = mpf(0) if still else next_power(args[i], powers[i], p, k, kept[i])
                powers[i].append(w)
                act(force, own["ends"], exact(own["k"]) * states[i] * w)
        for i in range(count):
            ss[i].append(vk[i] / (k + 1))
            vs[i].append(force[i] / masses[i] / (k + 1))
        wave = [omega * wave[1] / (k + 1), -omega * wave[0] / (k + 1)]
    return ss, vs, args, rates


def next_power(x, w, p, k, kept):
    """The coefficient of order k of x^p; integer powers do not divide by x. `kept` has the lower
    integer powers."""
    if p != int(p):
        return power_next(x, w, p, k)
    factor = x
    for m in range(int(p) - 1):
        if len(kept) <= m:
            kept.append([])
        kept[m].append(sum(factor[j] * x[k - j] for j in range(k + 1)))
        factor = kept[m]
    return factor[k]


def act(force, ends, f):
    a, b = ends
    if b is not None:
        force[b] -= f
    if a is not None:
        force[a] += f


def value(c, h):
    total = mpf(0)
    for x in reversed(c):
        total = total * h + x
    return total


def first_root(c, h):
    """First passage of a series from above zero to below within h; the start may be zero."""
    parts = 32
    low, before = mpf(0), value(c, h / 2**40)
    if before <= 0:
        return None if c[0] <= 0 and before <= 0 and c[0] != 0 else (mpf(0) if c[0] > 0 else None)
    for i in range(1, parts + 1):
        high = h * i / parts
        if value(c, high) < 0:
            for _ in range(150):
                middle = (low + high) / 2
                if value(c, middle) < 0:
                    high = middle
                else:
                    low = middle
            return high
        low = high
    return None


def leaving(chain, i, state, args, rates):
    """Functionals that end the state of an element, each positive inside it, and the next state."""
    own = chain["element"][i]
    x, r = args[i], rates[i]
    if own["kind"] != "contact":
        return [(x, -state)]
    slope = [exact(own["c"]) * 3 / 2 * y for y in r]
    pull = [1 + slope[0]] + slope[1:]
    minus = lambda c: [-y for y in c]
    if state == "open":
        return [(minus(x), "press")]
    if state == "free":
        return [(x, "open"), (minus(pull), "press")]
    return [(x, "open"), (pull, "free")]


def follow(chain, end):
    """End state and times of events."""
    t = mpf(0)
    s = [exact(x[0]) for x in chain["start"]]
    v = [exact(x[1]) for x in chain["start"]]
    states = []
    for own in chain["element"]:
        if own["kind"] == "contact":
            states.append("open")
        else:
            x = row(chain, own["ends"], v if own["kind"] == "rate" else s)
            states.append(1 if x >= 0 else -1)
    events = []
    while t < end:
        ss, vs, args, rates = series(chain, t, s, v, states)
        size = max(max(abs(x) for x in s), max(abs(x) for x in v))
        last = [max(abs(c[k]) for c in ss + vs) for k in (ORDERS - 1, ORDERS)]
        h = min(end - t, mpf(1) / 100)
        for x, k in zip(last, (ORDERS - 1, ORDERS)):
            if x > 0:
                h = min(h, (LEFT_OUT * size / x) ** (mpf(1) / k))
        for i, own in enumerate(chain["element"]):
            inside = own["kind"] != "contact" or states[i] == "press"
            if inside and exact(own["p"]) != int(own["p"]) and abs(args[i][0]) < EDGE:
                # Within the edge the force is left out.
                speed = abs(args[i][1]) if abs(args[i][1]) > 0 else mpf(1)
                h = min(h, EDGE / speed)
        found = None
        for i in range(len(states)):
            for c, new in leaving(chain, i, states[i], args, rates):
                root = first_root(c, h if found is None else found[0])
                if root is not None and (found is None or root < found[0]):
                    found = (root, i, new)
        h = h if found is None else found[0]
        s, v = [value(c, h) for c in ss], [value(c, h) for c in vs]
        t += h
        if found is None:
            continue
        _, i, new = found
        if chain["element"][i]["kind"] == "contact":
            events.append((t, i, states[i], new))
        states[i] = new
        if len(events) > 60:
            return None
    return s, v, events


def text(chain):
    """The machine as TOML."""
    name = lambda x: '"ground"' if x is None else f'"b{x}"'
    lines = ['name = "Contacts"', f'gravity = {chain["gravity"]!r}']
    for i, m in enumerate(chain["mass"]):
        s, v = chain["start"][i]
        lines.append(f"body.b{i} = {{ mass = {m!r}, gravity = 1.0, start = {{ s = {s!r}, v = {v!r} }} }}")
    for i, own in enumerate(chain["spring"]):
        a, b = map(name, own["ends"])
        lines.append(
            f'spring.k{i} = {{ between = [{a}, {b}], stiffness = {own["k"]!r}, damping = {own["d"]!r} }}'
        )
    for i, own in enumerate(chain["element"]):
        a, b = map(name, own["ends"])
        both = f'between = [{a}, {b}]'
        if own["kind"] == "contact":
            loss = f'damping = {own["d"]!r}' if own["d"] else f'dissipation = {own["c"]!r}'
            lines.append(
                f'stop.e{i} = {{ {both}, gap = {own["gap"]!r}, stiffness = {own["k"]!r}, '
                f'exponent = {own["p"]!r}, {loss} }}'
            )
        elif own["kind"] == "rate" and own["p"] == 2:
            lines.append(f'damper.e{i} = {{ {both}, quadratic = {own["k"]!r} }}')
        else:
            section = "damper" if own["kind"] == "rate" else "spring"
            lines.append(
                f'{section}.e{i} = {{ {both}, coefficient = {own["k"]!r}, exponent = {own["p"]!r} }}'
            )
    amplitude, frequency = chain["load"]
    lines.append(f'load.l = {{ on = "b0", amplitude = {amplitude!r}, frequency = {frequency!r} }}')
    return "|".join(lines)


def contact(ends, gap, k, p, c=0.0, d=0.0):
    return {"kind": "contact", "ends": ends, "gap": gap, "k": k, "p": p, "c": c, "d": d}


def odd(kind, ends, k, p):
    return {"kind": kind, "ends": ends, "k": k, "p": p}


def machines():
    """Machines with their ends, and with the ends of their derivatives (0: none)."""
    ball = {"gravity": 9.81, "mass": [0.3], "start": [(0.0, 0.0)], "spring": [], "load": (0.0, 1.0)}
    yield {**ball, "element": [contact((None, 0), 0.02, 2e6, 1.5)]}, 0.9, 0
    yield {**ball, "element": [contact((None, 0), 0.02, 2e6, 1.5, c=0.15)]}, 0.9, 0.21
    yield {**ball, "element": [contact((None, 0), 0.02, 3e5, 1.25, c=0.1)]}, 0.6, 0
    yield {**ball, "element": [contact((None, 0), 0.02, 2e7, 2.2, c=0.1)]}, 0.6, 0
    yield {**ball, "element": [contact((None, 0), 0.02, 4e7, 2.0, c=0.2)], "load": (1.0, 7.0)}, 0.7, 0.3
    driven = {**ball, "gravity": 0.0, "spring": [{"ends": (None, 0), "k": 300.0, "d": 0.4}], "load": (6.0, 4.0)}
    yield {
        **driven,
        "element": [contact((None, 0), 0.01, 1e6, 1.5, c=0.3), contact((0, None), 0.015, 2e5, 3.0)],
    }, 1.2, 0
    yield {
        **driven,
        "element": [contact((None, 0), 0.012, 1e6, 1.5, d=3.0), odd("rate", (None, 0), 0.5, 2)],
    }, 1.2, 0.4
    yield {**driven, "element": [odd("rate", (None, 0), 0.9, 1.5), odd("e", (None, 0), 900.0, 1.75)]}, 0.6, 0.2
    beads = {
        "gravity": 0.0, "mass": [0.2, 0.1, 0.3], "start": [(0.0, 1.5), (0.0, 0.0), (0.0, 0.0)],
        "spring": [{"ends": (None, 2), "k": 400.0, "d": 0.0}], "load": (0.0, 1.0),
    }
    yield {
        **beads,
        "element": [contact((1, 0), 0.001, 1e7, 1.5), contact((2, 1), 0.002, 2e7, 1.5, c=0.05)],
    }, 0.25, 0


def numbers_of(chain):
    """Numbers of a chain by their names in a file: the object and the key that hold each."""
    found = {"body.b0.mass": (chain["mass"], 0), "body.b0.start.v": (chain["start"], (0, 1))}
    for i, own in enumerate(chain["element"]):
        if own["kind"] == "contact":
            found[f"stop.e{i}.gap"], found[f"stop.e{i}.stiffness"] = (own, "gap"), (own, "k")
            key = "d" if own["d"] else "c"
            found[f"stop.e{i}.{'damping' if own['d'] else 'dissipation'}"] = (own, key)
        elif own["kind"] == "rate" and own["p"] == 2:
            found[f"damper.e{i}.quadratic"] = (own, "k")
        else:
            found[f"{'damper' if own['kind'] == 'rate' else 'spring'}.e{i}.coefficient"] = (own, "k")
    return found


def varied(chain, name):
    """A copy of a chain with one number changed, and the change."""
    chain = copy.deepcopy(chain)
    holder, key = numbers_of(chain)[name]
    place, i = key if isinstance(key, tuple) else (key, None)
    before = exact(holder[place] if i is None else holder[place][i])
    change = SHIFT * before if before else SHIFT
    if i is None:
        holder[place] = before + change
    else:
        numbers = list(holder[place])
        numbers[i] = before + change
        holder[place] = tuple(numbers)
    return chain, change


def main():
    for chain, end, end_by in machines():
        end = end_by if "by" in sys.argv else end
        if not end:
            continue
        own = follow(chain, exact(end))
        states = [*own[0], *own[1]]
        shifted, change = varied(chain, "body.b0.start.v")
        beside = follow(shifted, exact(end))
        if "by" in sys.argv:
            for name in numbers_of(chain):
                other, change = varied(chain, name)
                beside = follow(other, exact(end))
                both = zip(states, [*beside[0], *beside[1]])
                numbers = ",".join(nstr((b - a) / change, 18) for a, b in both)
                print(f"{text(chain)};{end};{name};{numbers}", flush=True)
            continue
        factor = max(abs(a - b) for a, b in zip(states, [*beside[0], *beside[1]])) / change
        times = ",".join(nstr(event[0], 22) for event in own[2])
        kinds = ",".join(f"{event[1]}{event[2][0]}{event[3][0]}" for event in own[2])
        numbers = ",".join(nstr(x, 22) for x in states)
        print(f"{text(chain)};{end};{kinds};{times};{numbers};{nstr(factor, 3)}", flush=True)


main()
