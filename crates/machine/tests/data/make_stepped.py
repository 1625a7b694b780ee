"""A gear mesh and a buffer whose stiffnesses step, in 40 digits: python make_stepped.py > stepped.txt

Independent of the crate: Taylor's method for the whole machine as a linear system on each piece. The signs of the buffer's elongation and
force at each knot and each bisected crossing give its state. Rows `event` with time and the buffer's new state, then rows
`state` with time, s and v of both bodies, and the work of the steps.
"""

from mpmath import mp, mpf

mp.dps = 40
ORDER, PART = 24, 32
MESH, MESH_PERIOD = [("0", "300"), ("0.03", "500"), ("0.11", "50")], mpf("0.17")
PAD, PAD_PERIOD = [("0", "600"), ("0.07", "1600"), ("0.09", "600")], mpf("0.13")
GAP, DASHPOT, WEIGHT = mpf("0.01"), mpf(4), mpf("0.5") * mpf("9.81")
TIMES = [mpf(k) / 4 - mpf(1) / 64 for k in range(1, 9)]  # not at knots


def value(pieces, period, t):
    """The stiffness just after t, and the next knot."""
    turn = mp.floor(t / period + mpf(10) ** -30)
    since = t - turn * period + mpf(10) ** -30
    own = [mpf(k) for start, k in pieces if mpf(start) <= since][-1]
    later = [mpf(start) for start, _ in pieces if mpf(start) > since] + [period]
    return own, turn * period + later[0]


def rates(y, mesh, pad, state):
    a, va, b, vb = y
    tie = 150 * (b - a) + (vb - va) / 2
    push = pad * (a - GAP) + DASHPOT * va if state == "pressed" else 0
    return [va, -mesh * a - va + tie - push, vb, (WEIGHT - tie) / mpf("0.5")]


def linear(y, mesh, pad, state):
    """The part of the rates that is linear in y."""
    zero = rates([mpf(0)] * 4, mesh, pad, state)
    return [r - z for r, z in zip(rates(y, mesh, pad, state), zero)]


def series(y, mesh, pad, state):
    terms = [y, rates(y, mesh, pad, state)]
    for n in range(2, ORDER + 1):
        terms.append([x / n for x in linear(terms[-1], mesh, pad, state)])
    return terms


def at(terms, h):
    return [mp.polyval([term[i] for term in reversed(terms)], h) for i in range(4)]


def limits(y, pad, state):
    """Functions that are negative while the buffer keeps its state, with the states that follow."""
    x, force = y[0] - GAP, pad * (y[0] - GAP) + DASHPOT * y[1]
    if state == "below":
        return [(x, "pressed")]
    if state == "pressed":
        return [(-force, "free")]
    return [(-x, "below"), (force, "pressed")]


def decide(y, pad):
    if y[0] < GAP:
        return "below"
    return "pressed" if pad * (y[0] - GAP) + DASHPOT * y[1] > 0 else "free"


def main():
    print("# By make_stepped.py.")
    y, t, put_in = [mpf("0.02"), mpf(1), mpf(0), mpf(0)], mpf(0), mpf(0)
    mesh, pad = value(MESH, MESH_PERIOD, t)[0], value(PAD, PAD_PERIOD, t)[0]
    state = decide(y, pad)
    for goal in TIMES:
        while t < goal - mpf(10) ** -30:
            knots = [value(MESH, MESH_PERIOD, t)[1], value(PAD, PAD_PERIOD, t)[1]]
            end = min([goal, t + mpf(1) / 256] + knots)
            terms, h, found = series(y, mesh, pad, state), end - t, None
            for i in range(PART):
                low, high = h * i / PART, h * (i + 1) / PART
                new = [own for own in limits(at(terms, high), pad, state) if own[0] > 0]
                if new:
                    for _ in range(130):
                        middle = (low + high) / 2
                        if any(own[0] > 0 for own in limits(at(terms, middle), pad, state)):
                            high = middle
                        else:
                            low = middle
                    found = [own for own in limits(at(terms, high), pad, state) if own[0] > 0][0][1]
                    h = high
                    break
            y, t = at(terms, h), (t + h if found else end)
            if found:
                state = found
                print("event", mp.nstr(t, 22), state)
            elif any(abs(end - knot) < mpf(10) ** -25 for knot in knots):
                new = value(MESH, MESH_PERIOD, t)[0], value(PAD, PAD_PERIOD, t)[0]
                put_in += (new[0] - mesh) * y[0] ** 2 / 2 + (new[1] - pad) * max(mpf(0), y[0] - GAP) ** 2 / 2
                mesh, pad = new
                if decide(y, pad) != state:
                    state = decide(y, pad)
                    print("event", mp.nstr(t, 22), state)
        print("state", mp.nstr(t, 22), *[mp.nstr(x, 22) for x in y], mp.nstr(put_in, 22))


main()
