"""The equations of docs/assembly-law.md, checked by other methods: multipliers instead of elimination, all sets of contacts instead
of a minimum, sums instead of closed forms. They are matrices and inequalities, which the reader of docs/theory.md cannot parse, so
they are written again here; a test checks that none is missing."""

import itertools
import random
import re
from typing import Callable, Dict, List, Sequence, Set, Tuple

import pytest
from equations import ROOT
from mpmath import matrix, mp, mpf

PAGE = ROOT / "docs" / "assembly-law.md"

# Equations that state no result: there is nothing they could be checked against.
DEFINITIONS: Dict[int, str] = {
    1: "defines elongations",
    4: "defines the augmented state",
    11: "says how a motion leaves zero; a second method in 50 digits chooses modes by it (crates/machine/tests/data)",
    12: "a choice of the law: what falls from its static level",
    14: "a choice of the code: what counts as zero",
    37: "says what a state of first order is",
    38: "the force of a spring in series, from its inner place",
    47: "a choice of the law: the levels of a friction that follows a stop",
    48: "defines a mode's coordinate with its node",
    50: "says which part of a stepped stiffness acts",
    52: "defines a freewheel",
    57: "defines a curved force and its coordinate",
    62: "defines the force of a contact and a power with two sides (crates/machine/tests/contacts.rs)",
    63: "a choice of the code: where a power at its edge counts as no force",
    64: "says which path leads to the equilibrium (crates/machine/tests/curves_rest.rs)",
    65: "defines a contact with friction",
    69: "says how far a slider that does not stick has moved (crates/machine/tests/residual.rs)",
}

ROUNDING = mpf(10) ** -30


def setup_function() -> None:
    mp.dps = 40


def teardown_function() -> None:
    mp.dps = 40  # the equations of derivatives want more, other files' tests less


def number(r: random.Random) -> mpf:
    return mpf(r.randint(-999, 999)) / 500


def vector(r: random.Random, n: int) -> matrix:
    return matrix([number(r) for _ in range(n)])


def masses(r: random.Random, n: int) -> matrix:
    return mp.diag([mpf(r.randint(1, 99)) / 10 for _ in range(n)])


def rows(r: random.Random, count: int, n: int) -> matrix:
    return matrix([[number(r) for _ in range(n)] for _ in range(count)])


def dot(a: matrix, b: matrix) -> mpf:
    return (a.T * b)[0]


def close(a: matrix, b: matrix) -> bool:
    return mp.norm(a - b) < ROUNDING * (1 + mp.norm(a))


def checked() -> Set[int]:
    text = (ROOT / "tests" / "theory" / "test_assembly_law.py").read_text(encoding="utf-8")
    names = re.findall(r"^def test_law((?:_\d+)+)_[a-z]", text, re.M)
    return {int(n) for name in names for n in name[1:].split("_")}


def test_every_equation_is_checked_or_a_definition() -> None:
    page = PAGE.read_text(encoding="utf-8")
    there = [int(n) for n in re.findall(r"\\tag\{A(\d+)\}", page)]
    # Numbers are given once and stay, since code and tests cite them.
    assert sorted(there) == list(range(1, len(there) + 1)), there
    assert set(there) == checked() | set(DEFINITIONS), set(there) ^ (checked() | set(DEFINITIONS))
    assert not checked() & set(DEFINITIONS)


def test_equations_that_the_code_cites_are_there() -> None:
    count = PAGE.read_text(encoding="utf-8").count(r"\tag{A")
    for path in (ROOT / "assembly" / "src").rglob("*.rs"):
        for n in re.findall(r"\(A(\d+)\)", path.read_text(encoding="utf-8")):
            assert int(n) <= count, f"{path}: (A{n})"


def reduced(r: random.Random) -> Tuple[matrix, matrix, matrix, matrix, matrix]:
    """Four free bodies, one prescribed, one link: m, B, D, the link's arms on all five, the prescribed acceleration."""
    arms = [number(r) or mpf(1) for _ in range(5)]
    m, pivot = masses(r, 4), max(range(4), key=lambda i: abs(arms[i]))
    kept = [i for i in range(4) if i != pivot]
    b, d = mp.zeros(4, 3), mp.zeros(4, 1)
    for column, i in enumerate(kept):
        b[i, column] = mpf(1)
        b[pivot, column] = -arms[i] / arms[pivot]
    d[pivot] = -arms[4] / arms[pivot]
    return m, b, d, matrix(arms), number(r)


def test_law_2_3_motion_under_links() -> None:
    r = random.Random(2)
    for _ in range(20):
        m, b, d, arms, p2 = reduced(r)
        forces = vector(r, 4)
        q2 = mp.lu_solve(b.T * m * b, b.T * (forces - m * d * p2))
        # Using a multiplier: m s'' = F + a μ with a s'' + a_p p'' = 0.
        full = mp.zeros(5, 5)
        full[0:4, 0:4] = m
        for i in range(4):
            full[i, 4], full[4, i] = -arms[i], arms[i]
        s2 = mp.lu_solve(full, matrix([*forces, -arms[4] * p2]))
        assert close(b * q2 + d * p2, s2[0:4, 0])
        assert abs(sum(arms[i] * (b * q2 + d * p2)[i] for i in range(4)) + arms[4] * p2) < ROUNDING
        w = b.T * matrix(arms[0:4, 0])
        assert mp.norm(w) < ROUNDING  # no q moves along the link's direction


def test_law_5_forces_of_contacts() -> None:
    r = random.Random(5)
    for _ in range(20):
        mass, w, free = masses(r, 4), rows(r, 4, 2), vector(r, 4)
        drift = vector(r, 2)
        g = w.T * mass**-1 * w
        force = mp.lu_solve(g, w.T * free + drift)
        after = free - mass**-1 * w * force
        assert mp.norm(w.T * after + drift) < ROUNDING


def test_law_6_bound_of_the_coefficients() -> None:
    r = random.Random(6)
    for _ in range(20):
        a, row, z = rows(r, 4, 4), vector(r, 4), vector(r, 4)
        w = [mpf(r.randint(1, 50)) / 10 for _ in range(4)]
        rate = max(sum(abs(a[i, j]) * w[j] for j in range(4)) / w[i] for i in range(4))
        size = max(abs(z[j]) / w[j] for j in range(4))
        dual = sum(abs(row[j]) * w[j] for j in range(4))
        for k in range(8):
            assert abs(dot(row, a**k * z)) <= dual * rate**k * size * (1 + ROUNDING)


def impulses(g: matrix, u: matrix, eps: Sequence[mpf]) -> List[matrix]:
    """All solutions of (A7) with independent impulses."""
    found, n = [], len(eps)
    for count in range(n + 1):
        for s in itertools.combinations(range(n), count):
            p = mp.zeros(n, 1)
            if s:
                part = matrix([[g[i, j] for j in s] for i in s])
                if abs(mp.det(part)) < mpf(10) ** -15:
                    continue
                x = mp.lu_solve(part, matrix([(1 + eps[i]) * u[i] for i in s]))
                for i, value in zip(s, x):
                    p[i] = value
            after = u - g * p
            if all(x >= -ROUNDING for x in p) and all(after[i] <= -eps[i] * u[i] + ROUNDING for i in range(n)):
                found.append(p)
    return found


def test_law_7_8_9_impacts_are_minima_and_lose_energy() -> None:
    r = random.Random(7)
    for _ in range(40):
        n = 3
        mass, v = masses(r, 3), vector(r, 3)
        w = rows(r, 3, n)
        if r.random() < 0.3:
            w[0:3, 2] = w[0:3, 1]  # a redundant stop
        moved = mp.zeros(n, 1) if r.random() < 0.5 else vector(r, n) / 10
        eps = [mpf(r.randint(0, 10)) / 10 for _ in range(n)]
        u = w.T * v + moved
        # Only closing stops take part.
        taking = [i for i in range(n) if u[i] >= 0]
        if not taking:
            continue
        wt = matrix([[w[k, i] for i in taking] for k in range(3)])
        ut, et = matrix([u[i] for i in taking]), [eps[i] for i in taking]
        mt = matrix([moved[i] for i in taking])
        g = wt.T * mass**-1 * wt
        found = impulses(g, ut, et)
        if mp.norm(mt) == 0:
            assert found  # without prescribed bodies a solution exists
        for p in found:
            after = v - mass**-1 * wt * p
            # (A7) to (A8): the velocity is unique, and closer than any other admissible velocity.
            assert close(after, v - mass**-1 * wt * found[0])
            distance = dot(after - v, mass * (after - v))
            for _ in range(20):
                other = after + vector(r, 3)
                if all(dot(wt[0:3, i], other) + mt[i] <= -et[i] * ut[i] for i in range(len(taking))):
                    assert distance <= dot(other - v, mass * (other - v)) + ROUNDING
            # (A9)
            change = (dot(after, mass * after) - dot(v, mass * v)) / 2
            lost = sum((1 - et[i]) * ut[i] * p[i] for i in range(len(taking))) / 2
            work = sum(p[i] * mt[i] for i in range(len(taking)))
            assert abs(change + lost - work) < ROUNDING and lost >= -ROUNDING


def box_solutions(g: matrix, b: matrix, lo: Sequence[mpf], hi: Sequence[mpf]) -> List[matrix]:
    """All λ for which b - Gλ is zero inside the box, not positive at the lower and not negative at the upper end."""
    found, n = [], len(lo)
    for states in itertools.product("lfh", repeat=n):
        x = matrix([lo[i] if s == "l" else hi[i] if s == "h" else mpf(0) for i, s in enumerate(states)])
        free = [i for i, s in enumerate(states) if s == "f"]
        if free:
            part = matrix([[g[i, j] for j in free] for i in free])
            if abs(mp.det(part)) < mpf(10) ** -15:
                continue
            y = mp.lu_solve(part, matrix([(b - g * x)[i] for i in free]))
            for i, value in zip(free, y):
                x[i] = value
        left = b - g * x
        inside = all(lo[i] - ROUNDING <= x[i] <= hi[i] + ROUNDING for i in range(n))
        signs = all(
            {"l": left[i] <= ROUNDING, "h": left[i] >= -ROUNDING, "f": True}[s] for i, s in enumerate(states)
        )
        if inside and signs:
            found.append(x)
    return found


def test_law_10_the_next_motion_is_a_minimum() -> None:
    r = random.Random(10)
    for _ in range(30):
        a = rows(r, 3, 3)
        if r.random() < 0.3:
            a[0:3, 2] = -a[0:3, 0]
        g, b = a.T * a, a.T * vector(r, 3)
        hi = [abs(number(r)) for _ in range(3)]
        lo = [mpf(0) if r.random() < 0.5 else -h for h in hi]
        found = box_solutions(g, b, lo, hi)
        assert found
        value: Callable[[matrix], mpf] = lambda x: dot(x, g * x) / 2 - dot(b, x)
        for x in found:
            assert close(g * x, g * found[0])  # accelerations are unique
            for _ in range(20):
                other = matrix([lo[i] + (hi[i] - lo[i]) * mpf(r.random()) for i in range(3)])
                assert value(x) <= value(other) + ROUNDING


def test_law_13_16_compliant_stops_never_pull_and_never_gain() -> None:
    r = random.Random(13)
    for _ in range(200):
        k, c = mpf(r.randint(1, 900)), mpf(r.randint(0, 90))
        x, rate = abs(number(r)), number(r) * 20
        no_pull = max(mpf(0), k * x + c * rate)
        gap = k * x + min(k * x, max(-k * x, c * rate))
        assert no_pull >= 0 and 0 <= gap <= 2 * k * x
        for force in (no_pull, gap):
            # The power taken beyond the stored energy ½ k x²: c x'², -k x x' or k x x'.
            lost = (force - k * x) * rate
            assert lost >= -ROUNDING
            assert min(abs(lost - known) for known in (c * rate**2, -k * x * rate, k * x * rate)) < ROUNDING


def test_law_15_height_and_end_of_bounces() -> None:
    for eps, u, a in ((mpf("0.5"), mpf(2), mpf(9)), (mpf("0.9"), mpf("0.1"), mpf(3))):
        rebound = eps * u
        top = rebound / a
        assert abs(rebound * top - a * top**2 / 2 - rebound**2 / (2 * a)) < ROUNDING
        total, speed = mpf(0), rebound
        for _ in range(2000):
            total += 2 * speed / a
            speed *= eps
        assert abs(total - 2 * eps * u / (a * (1 - eps))) < ROUNDING


def test_law_17_18_balance_of_powers() -> None:
    r = random.Random(17)
    for _ in range(20):
        m, b, d, _, p2 = reduced(r)
        q, v, p, p1 = vector(r, 3), vector(r, 3), number(r), number(r)
        s, s1 = b * q + d * p, b * v + d * p1
        weight, loads = vector(r, 4), vector(r, 4)
        # Springs with dashpots between the bodies, the prescribed one included: arms on (s, p).
        elements = [(vector(r, 4), number(r), abs(number(r)), abs(number(r)), number(r)) for _ in range(3)]
        forces, stored, lost, motions = weight + loads, mpf(0), mpf(0), mpf(0)
        for arms, own, k, c, preload in elements:
            e, rate = dot(arms, s) + own * p, dot(arms, s1) + own * p1
            force = preload + k * e + c * rate
            forces -= arms * force
            stored += (k * e + preload) * rate
            lost += c * rate**2
            # The part of e' due to prescribed bodies, including through links.
            motions += force * (dot(arms, d) + own) * p1
        q2 = mp.lu_solve(b.T * m * b, b.T * (forces - m * d * p2))
        s2 = b * q2 + d * p2
        power = dot(s1, m * s2) + stored - dot(weight, s1)
        motions += dot(m * s2 - weight - loads, d) * p1
        assert abs(power - (dot(loads, s1) + motions - lost)) < ROUNDING


def test_law_19_20_proximal_steps_end_in_equilibrium() -> None:
    r = random.Random(19)
    for _ in range(4):
        mass = masses(r, 3)
        a = rows(r, 3, 2)
        stiffness = a * a.T  # singular
        w = rows(r, 3, 2)
        start, kappa = vector(r, 2) - matrix([2, 2]), [mpf(0), mpf(1) / 7]
        # A force in the range of the springs, so that an equilibrium exists.
        force = a * vector(r, 2)
        q, left = mp.zeros(3, 1), mpf(1)
        for _ in range(40):
            mu = mpf(1) / 10**6
            inverse = (stiffness + mu * mass) ** -1
            free = inverse * (force + mu * mass * q)
            g = w.T * inverse * w + mp.diag(kappa)
            force_of = box_solutions(g, w.T * free + start, [mpf(0)] * 2, [mpf(10) ** 9] * 2)[0]
            after = inverse * (force + mu * mass * q - w * force_of)
            left, q = mp.norm(mu * mass * (after - q)), after
        x = w.T * q + start - mp.diag(kappa) * force_of
        assert mp.norm(stiffness * q - force + w * force_of) < mpf(10) ** -20 and left < mpf(10) ** -20
        assert all(value <= ROUNDING for value in x) and all(value >= -ROUNDING for value in force_of)
        assert abs(dot(x, force_of)) < ROUNDING


@mp.workdps(80)
def test_law_21_variations_over_an_impact_by_differences() -> None:
    """A ball on a moving floor, e = h - sin t, from its start to a time after its impact."""
    g, restitution, end, step = mpf("9.81"), mpf("0.7"), mpf("0.6"), mpf(10) ** -25
    start = [mpf(1), mpf("-0.3")]

    def fall(h: mpf, v: mpf, t: mpf) -> Tuple[mpf, mpf]:
        return h + v * t - g * t**2 / 2, v - g * t

    def meeting(h: mpf, v: mpf) -> mpf:
        t = mpf("0.35")
        for _ in range(12):  # Newton steps; each doubles the digits
            height, speed = fall(h, v, t)
            t -= (height - mp.sin(t)) / (speed - mp.cos(t))
        return t

    def after(h: mpf, v: mpf) -> matrix:
        t = meeting(h, v)
        height, speed = fall(h, v, t)
        rebound = speed - (1 + restitution) * (speed - mp.cos(t))
        return matrix(fall(height, rebound, end - t))

    for direction in [(1, 0), (0, 1), (2, -3)]:
        plus, minus = (after(*(x + sign * step * d for x, d in zip(start, direction))) for sign in (1, -1))
        # z = (h, v, sin t, cos t, 1): the floor's states do not vary, but move with the time of
        # the event.
        t = meeting(*start)
        speed = fall(*start, t)[1]
        rebound = speed - (1 + restitution) * (speed - mp.cos(t))
        delta = matrix([direction[0] + direction[1] * t, direction[1], 0, 0])
        incoming = matrix([speed, -g, mp.cos(t), -mp.sin(t)])
        outgoing = matrix([rebound, -g, mp.cos(t), -mp.sin(t)])
        row = matrix([1, 0, -1, 0])
        later = -dot(row, delta) / dot(row, incoming)
        met = delta + incoming * later
        met[1] -= (1 + restitution) * (met[1] - met[3])
        left = met - outgoing * later
        expected = matrix([left[0] + left[1] * (end - t), left[1]])
        assert close((plus - minus) / (2 * step), expected), direction


@pytest.mark.parametrize("seed", range(4))
def test_law_22_a_row_after_any_time_bounds_the_second_derivative(seed: int) -> None:
    r, count, h = random.Random(seed), 16, mpf(1) / 64
    a, row, z = rows(r, 5, 5), vector(r, 5), vector(r, 5)
    later = [row.T * mp.expm(a * h * k) for k in range(count + 1)]
    reaches = [max(abs(behind[j]) for behind in later) for j in range(5)]

    def bound(x: matrix) -> mpf:
        return mp.fsum(reach * abs(y) for reach, y in zip(reaches, x))

    second = a * a * z
    # A second-order difference omits h²/12 of the fourth derivative at some point in between; the
    # reaches are a little larger between the samples.
    left_out = h**2 / 12 * bound(a * a * second) * mpf("1.5")
    for k in range(1, count):
        before, now, after = ((later[i] * z)[0] for i in (k - 1, k, k + 1))
        by_difference = (before - 2 * now + after) / h**2
        assert abs(by_difference - (later[k] * second)[0]) < left_out
        assert abs(by_difference) < bound(second) + left_out


@pytest.mark.parametrize("seed", range(4))
def test_law_23_the_flow_over_twice_a_length(seed: int) -> None:
    r, length = random.Random(seed), mpf(1) / 2
    a, z = rows(r, 4, 4), vector(r, 4)

    def integral(time: mpf) -> matrix:
        """The block of exp of ((A, 1), (0, 0)) that is the integral of exp(A s)."""
        whole = mp.zeros(8, 8)
        whole[:4, :4], whole[:4, 4:] = a * time, mp.eye(4) * time
        return mp.expm(whole)[:4, 4:]

    def change(time: mpf) -> matrix:
        return mp.expm(a * time) - mp.eye(4)

    j, d = integral(length), change(length)
    assert close(2 * j + d * j, integral(2 * length))
    assert close(2 * d + d * d, change(2 * length))
    assert close(z + j * (a * z), mp.expm(a * length) * z)


def test_law_24_powers_in_as_many_rows_as_coordinates() -> None:
    r = random.Random(24)
    left, right, z = rows(r, 9, 3), rows(r, 9, 3), vector(r, 3)
    q, triangle = mp.qr(left, mode="skinny")
    assert (triangle.rows, triangle.cols) == (3, 3)
    assert abs(dot(left * z, right * z) - dot(triangle * z, q.T * right * z)) < ROUNDING * mp.norm(left) * mp.norm(right)


def test_law_25_neutral_directions() -> None:
    """Two shafts with a spring and a dashpot between them, and a dashpot or none from the first to ground."""
    for drag in (mpf("0.4"), mpf(0)):
        inertias, k, c = (mpf("0.5"), mpf("0.75")), mpf(30), mpf(2)
        w = matrix([[-1, 1]])
        stiffness, damping = k * w.T * w, c * w.T * w
        damping[0, 0] += drag
        a = mp.zeros(4, 4)
        for i in range(2):
            a[i, 2 + i] = mpf(1)
            for j in range(2):
                a[2 + i, j], a[2 + i, 2 + j] = -stiffness[i, j] / inertias[i], -damping[i, j] / inertias[i]
        time = mpf("0.7")
        later = mp.expm(a * time)
        # Along the coordinates u = (1, 1), a variation does not change.
        places, rates = matrix([1, 1, 0, 0]), matrix([0, 0, 1, 1])
        assert mp.norm(later * places - places) < ROUNDING
        # Along the rates it becomes (t u, u) if nothing acts on both, and shrinks if a dashpot
        # does.
        kept = mp.norm(later * rates - (time * places + rates)) < ROUNDING
        assert kept == (drag == 0)


def by_parameter(f: Callable[[mpf], matrix]) -> matrix:
    """The derivative of a function of the parameter at 0 by central differences, with an error of 1e-50 in 80 digits."""
    step = mpf(10) ** -25
    return (f(step) - f(-step)) / (2 * step)


def moving(r: random.Random, count: int, n: int) -> Tuple[Callable[[mpf], matrix], matrix]:
    """A matrix that is a quadratic function of the parameter, and its derivative at 0."""
    a, b, c = (rows(r, count, n) for _ in range(3))
    return lambda p: a + p * b + p**2 * c, b


def moving_masses(r: random.Random, n: int) -> Tuple[Callable[[mpf], matrix], matrix]:
    """An inertia matrix that depends on the parameter, and its derivative at 0."""
    a, b = rows(r, n, n), rows(r, n, n)
    m = a * a.T + mp.eye(n)
    return lambda p: m + p * (b + b.T), b + b.T


def test_law_26_series_and_doubling_of_a_derivative() -> None:
    mp.dps = 80
    r = random.Random(26)
    for _ in range(4):
        (a, a_by), (row, row_by), z, delta, h = moving(r, 3, 3), moving(r, 1, 3), vector(r, 3), vector(r, 3), mpf("0.3")
        exact = by_parameter(lambda p: mp.expm(a(p) * h, method="taylor") * (z + p * delta))
        value = by_parameter(lambda p: row(p) * mp.expm(a(p) * h, method="taylor") * (z + p * delta))
        terms, term, by = (z.copy(), delta.copy()), z, delta
        for k in range(90):
            term, by = a(0) * term * h / (k + 1), (a(0) * by + a_by * term) * h / (k + 1)
            terms = (terms[0] + term, terms[1] + by)
        assert close(terms[1], exact)
        assert close(row(0) * terms[1] + row_by * terms[0], value)
        change = lambda p, t: mp.expm(a(p) * t, method="taylor") - mp.eye(3)  # noqa: B023, E731
        d, e = change(0, h), by_parameter(lambda p: change(p, h))
        assert close(2 * d + d * d, change(0, 2 * h))
        assert close(2 * e + d * e + e * d, by_parameter(lambda p: change(p, 2 * h)))


def test_law_27_bodies_behind_a_link_and_their_inertia() -> None:
    mp.dps = 80
    r = random.Random(27)
    for _ in range(6):
        (arms, arms_by), (own, own_by), q = moving(r, 1, 4), moving(r, 1, 4), vector(r, 3)
        m, m_by = masses(r, 4), masses(r, 4)

        def rows_of(p: mpf) -> matrix:
            """B if the first three bodies are kept."""
            b = mp.zeros(4, 3)
            for i in range(3):
                b[i, i], b[3, i] = mpf(1), -arms(p)[i] / arms(p)[3]  # noqa: B023
            return b

        s, s_by = rows_of(mpf(0)) * q, by_parameter(lambda p: rows_of(p) * q)  # noqa: B023
        assert close(arms(0) * s_by, -arms_by * s) and s_by[0] == s_by[1] == s_by[2] == 0
        assert close(own(0) * s_by + own_by * s, by_parameter(lambda p: own(p) * rows_of(p) * q))  # noqa: B023
        b, b_by, inertia = rows_of(mpf(0)), by_parameter(rows_of), mp.zeros(3, 3)
        for i in range(4):
            inertia += m_by[i, i] * b[i, :].T * b[i, :]
            inertia += m[i, i] * (b_by[i, :].T * b[i, :] + b[i, :].T * b_by[i, :])
        assert close(inertia, by_parameter(lambda p: rows_of(p).T * (m + p * m_by) * rows_of(p)))  # noqa: B023


def test_law_28_signals_by_frequency_rate_and_height() -> None:
    mp.dps = 80
    t, step, begin = mpf("1.7"), mpf("0.4"), mpf("1.2")
    for f in [mpf("0.3"), mpf(5)]:
        omega = 2 * mp.pi * f
        turned = by_parameter(lambda p: matrix([mp.cos(2 * mp.pi * (f + p) * t), mp.sin(2 * mp.pi * (f + p) * t)]))  # noqa: B023
        assert close(2 * mp.pi * t * matrix([-mp.sin(omega * t), mp.cos(omega * t)]), turned)
    moved = by_parameter(lambda p: matrix([(2 + p) * t + (step + p) * (t > begin) - (step + p) * (t > 2)]))
    assert close(matrix([t + 1]), moved)


def test_law_29_accelerations_and_forces_of_contacts() -> None:
    mp.dps = 80
    r = random.Random(29)
    for _ in range(6):
        (m, m_by), (w, w_by) = moving_masses(r, 4), moving(r, 4, 2)
        (f, f_by), (drift, drift_by) = moving(r, 4, 1), moving(r, 2, 1)

        def solved(left: matrix, directions: matrix, right: matrix, moved: matrix) -> matrix:
            whole = mp.zeros(6, 6)
            whole[:4, :4], whole[:4, 4:], whole[4:, :4] = left, directions, directions.T
            return mp.lu_solve(whole, matrix(list(right) + list(moved)))

        both = lambda p: solved(m(p), w(p), f(p), -drift(p))  # noqa: B023, E731
        a, force = both(0)[:4, :], both(0)[4:, :]
        found = solved(m(0), w(0), f_by - m_by * a - w_by * force, -drift_by - w_by.T * a)
        assert close(found, by_parameter(both))


def test_law_30_over_an_event_by_differences() -> None:
    """A flight to h·z = 0, a linear map there, and a flight by another system to a fixed time."""
    mp.dps = 80
    r = random.Random(30)
    for _ in range(6):
        (a, a_by), (b, b_by), (jump, jump_by) = moving(r, 3, 3), moving(r, 3, 3), moving(r, 3, 3)
        (h, h_by), z, delta, meets, end = moving(r, 1, 3), vector(r, 3), vector(r, 3), mpf("0.2"), mpf("0.5")
        flow = lambda of, t: mp.expm(of * t, method="taylor")  # noqa: E731
        # The row is shifted so that it passes zero at this time.
        met = flow(a(0), meets) * z
        level = (h(0) * met)[0]

        def passes(p: mpf) -> mpf:
            t = meets  # noqa: B023
            for _ in range(8):  # Newton steps; each doubles the digits
                state = flow(a(p), t) * (z + p * delta)  # noqa: B023
                t -= ((h(p) * state)[0] - level) / (h(p) * a(p) * state)[0]  # noqa: B023
            return t

        def after(p: mpf) -> matrix:
            t = passes(p)
            return flow(b(p), end - t) * jump(p) * flow(a(p), t) * (z + p * delta)  # noqa: B023

        before = by_parameter(lambda p: flow(a(p), meets) * (z + p * delta))  # noqa: B023
        incoming, outgoing = a(0) * met, b(0) * jump(0) * met
        later = -(h(0) * before + h_by * met)[0] / (h(0) * incoming)[0]
        assert close(matrix([later]), by_parameter(lambda p: matrix([passes(p)])))
        left = jump(0) * (before + incoming * later) + jump_by * met - outgoing * later
        flown = by_parameter(lambda p: flow(b(p), end - meets) * (jump(0) * met + p * left))  # noqa: B023
        assert close(flown, by_parameter(after))


def test_law_31_impulses_of_stops() -> None:
    mp.dps = 80
    r = random.Random(31)
    for _ in range(6):
        (m, m_by), (w, w_by), (v, v_by), (eps, eps_by) = moving_masses(r, 4), moving(r, 4, 2), moving(r, 4, 1), moving(r, 2, 1)

        def of(p: mpf) -> Tuple[matrix, matrix]:
            share = m(p) ** -1 * w(p)  # noqa: B023
            closing = w(p).T * v(p)  # noqa: B023
            impulse = (w(p).T * share) ** -1 * matrix([(1 + eps(p)[j]) * closing[j] for j in range(2)])  # noqa: B023
            return impulse, v(p) - share * impulse  # noqa: B023

        impulse, after = of(mpf(0))
        inverse, closing = m(0) ** -1, w(0).T * v(0)
        bent = inverse * (w_by - m_by * inverse * w(0)) * impulse
        right = matrix([
            (1 + eps(0)[j]) * (w(0).T * v_by)[j] + (w_by.T * (after + eps(0)[j] * v(0)))[j] + eps_by[j] * closing[j]
            for j in range(2)
        ])  # fmt: skip
        impulse_by = (w(0).T * inverse * w(0)) ** -1 * (right - w(0).T * bent)
        assert close(impulse_by, by_parameter(lambda p: of(p)[0]))  # noqa: B023
        assert close(v_by - bent - inverse * w(0) * impulse_by, by_parameter(lambda p: of(p)[1]))  # noqa: B023


def test_law_32_starts_at_rest() -> None:
    mp.dps = 80
    r = random.Random(32)
    for _ in range(6):
        (k, k_by), (w, w_by), (f, f_by) = moving_masses(r, 4), moving(r, 4, 2), moving(r, 4, 3)
        (held, held_by), (signals, signals_by) = moving(r, 2, 3), moving(r, 3, 1)

        def solved(left: matrix, directions: matrix, right: matrix, moved: matrix) -> matrix:
            whole = mp.zeros(6, 6)
            whole[:4, :4], whole[:4, 4:], whole[4:, :4] = left, directions, directions.T
            return mp.lu_solve(whole, matrix(list(right) + list(moved)))

        rest = lambda p: solved(k(p), w(p), f(p) * signals(p), -held(p) * signals(p))  # noqa: B023, E731
        q, force = rest(0)[:4, :], rest(0)[4:, :]
        # F' z contains the springs' part, -K' q.
        forces = f_by * signals(0) - k_by * q + f(0) * signals_by - w_by * force
        moved = -(w_by.T * q + held_by * signals(0) + held(0) * signals_by)
        assert close(solved(k(0), w(0), forces, moved), by_parameter(rest))


def test_law_33_what_contacts_take_from_a_motion_beside_their_rest() -> None:
    """Two frictions below their level and two stops with a force hold; then they are given velocities."""
    r = random.Random(33)
    for _ in range(6):
        m, w, v = masses(r, 6), rows(r, 4, 6).T, vector(r, 6)
        held = matrix([number(r), number(r), abs(number(r)), abs(number(r))])
        level = [abs(held[0]) + mpf(1) / 7, abs(held[1]) + mpf(2) / 7]
        # A velocity that opens the stops; the springs balance the forces of the contacts.
        v -= m**-1 * w * mp.lu_solve(w.T * m**-1 * w, w.T * v - matrix([number(r), number(r), -1, -mpf(1) / 3]))
        rates, springs = w.T * v, w * held
        forces = matrix([level[0] * mp.sign(rates[0]), level[1] * mp.sign(rates[1]), 0, 0])
        acceleration = m**-1 * (springs - w * forces)
        power = dot(v, m * acceleration)
        assert abs(power - dot(rates, held - forces)) < ROUNDING * (1 + abs(power))
        most = -sum((level[c] - abs(held[c])) * abs(rates[c]) for c in range(2))
        most -= sum(held[c] * abs(rates[c]) for c in (2, 3))
        assert power <= most + ROUNDING


def test_law_34_backwards_over_flights_and_an_event() -> None:
    """A sum of a value at the end and of an event's time, for the motion of (A35)."""
    mp.dps = 45
    r = random.Random(33)
    for _ in range(2):
        (a, a_by), (b, b_by), (jump, _) = moving(r, 3, 3), moving(r, 3, 3), moving(r, 3, 3)
        (h, h_by), z, delta, meets, end = moving(r, 1, 3), vector(r, 3), vector(r, 3), mpf("0.2"), mpf("0.5")
        value, c = vector(r, 3), number(r)
        flow = lambda of, t: mp.expm(of * t, method="taylor")  # noqa: E731
        met = flow(a(0), meets) * z
        level = (h(0) * met)[0]

        def summed(p: mpf) -> matrix:
            t = meets  # noqa: B023
            for _ in range(8):
                state = flow(a(p), t) * (z + p * delta)  # noqa: B023
                t -= ((h(p) * state)[0] - level) / (h(p) * a(p) * state)[0]  # noqa: B023
            last = flow(b(p), end - t) * jump(0) * flow(a(p), t) * (z + p * delta)  # noqa: B023
            return matrix([dot(value, last) + c * t])  # noqa: B023

        def integral(of: matrix, by: matrix, span: mpf, mu: matrix, begun: matrix) -> mpf:
            """The derivative with respect to a matrix, in a direction."""
            return mp.quad(lambda t: dot(flow(of.T, span - t) * mu, by * flow(of, t) * begun), [0, span])

        after = flow(b(0).T, end - meets) * value
        through = jump(0).T * after
        incoming, outgoing = a(0) * met, b(0) * jump(0) * met
        speed = (h(0) * incoming)[0]
        tau = c + dot(incoming, through) - dot(outgoing, after)
        before = through - tau / speed * h(0).T
        total = dot(flow(a(0).T, meets) * before, delta) - tau / speed * (h_by * met)[0]
        total += integral(a(0), a_by, meets, before, z) + integral(b(0), b_by, end - meets, value, jump(0) * met)
        step = mpf(10) ** -15
        assert abs(total - (summed(step) - summed(-step))[0] / (2 * step)) < mpf(10) ** -26 * (1 + abs(total))


def test_law_35_backwards_through_contacts() -> None:
    mp.dps = 80
    r = random.Random(34)
    for _ in range(6):
        (m, m_by), (w, w_by) = moving_masses(r, 4), moving(r, 4, 2)
        (f, f_by), (drift, drift_by) = moving(r, 4, 1), moving(r, 2, 1)
        y, by_force = vector(r, 4), vector(r, 2)

        def both(p: mpf) -> matrix:
            whole = mp.zeros(6, 6)
            whole[:4, :4], whole[:4, 4:], whole[4:, :4] = m(p), w(p), w(p).T  # noqa: B023
            return mp.lu_solve(whole, matrix(list(f(p)) + list(-drift(p))))  # noqa: B023

        a, force = both(mpf(0))[:4, :], both(mpf(0))[4:, :]
        inverse = m(0) ** -1
        d = (w(0).T * inverse * w(0)) ** -1 * (by_force - w(0).T * inverse * y)
        z = inverse * (y + w(0) * d)
        found = dot(z, f_by - m_by * a - w_by * force) + dot(d, drift_by + w_by.T * a)
        exact = by_parameter(lambda p: matrix([dot(matrix(list(y) + list(by_force)), both(p))]))  # noqa: B023
        assert close(matrix([found]), exact)


def test_law_36_backwards_over_an_impact() -> None:
    mp.dps = 80
    r = random.Random(35)
    for _ in range(6):
        (m, m_by), (w, w_by), (v, v_by), (eps, eps_by) = moving_masses(r, 4), moving(r, 4, 2), moving(r, 4, 1), moving(r, 2, 1)
        mu = vector(r, 4)

        def of(p: mpf) -> Tuple[matrix, matrix]:
            share, closing = m(p) ** -1 * w(p), w(p).T * v(p)  # noqa: B023
            impulse = (w(p).T * share) ** -1 * matrix([(1 + eps(p)[j]) * closing[j] for j in range(2)])  # noqa: B023
            return impulse, v(p) - share * impulse  # noqa: B023

        impulse, after = of(mpf(0))
        inverse = m(0) ** -1
        pi = (w(0).T * inverse * w(0)) ** -1 * w(0).T * inverse * mu
        kappa = inverse * (mu - w(0) * pi)
        closing = w(0).T * v(0)
        own = matrix([(w_by.T * (after + eps(0)[j] * v(0)))[j] + eps_by[j] * closing[j] for j in range(2)])
        found = -dot(pi, own) - dot(kappa, (w_by - m_by * inverse * w(0)) * impulse)
        before = mu - w(0) * matrix([pi[j] * (1 + eps(0)[j]) for j in range(2)])
        exact = by_parameter(lambda p: matrix([dot(mu, of(p)[1])]))  # noqa: B023
        assert close(matrix([found + dot(before, v_by)]), exact)


def test_law_39_a_spring_in_series_with_a_dashpot() -> None:
    r = random.Random(39)
    for _ in range(20):
        k, c, e, x, rate = mpf(r.randint(1, 99)), mpf(r.randint(1, 99)), number(r), number(r), number(r)
        b = k * (e - x)
        moves = k / c * (e - x)
        assert mp.almosteq(k * (rate - moves), k * rate - k / c * b)
        # The rate of b²/2k is b b'/k.
        assert mp.almosteq(b * k * (rate - moves) / k, b * rate - b * b / c)


def test_law_40_the_loop_of_a_slider() -> None:
    # Corners of a cycle of the amplitude X: held over 2 R/k, then slipping at the level.
    r = random.Random(40)
    for _ in range(20):
        k, level = mpf(r.randint(1, 99)), mpf(r.randint(1, 99)) / 10
        most = level / k * mpf(r.randint(11, 40)) / 10
        held = 2 * level / k
        loop = [(most, level), (most - held, -level), (-most, -level), (-most + held, level)]
        pairs = zip(loop, loop[1:] + loop[:1])
        area = mp.fsum(a * d - c * b for (a, b), (c, d) in pairs) / 2
        assert mp.almosteq(abs(area), 4 * level * (most - level / k))


def test_law_41_integrals_of_a_harmonic() -> None:
    r = random.Random(41)
    for _ in range(5):
        a, omega, phase, t = number(r), mpf(r.randint(1, 50)) / 10, number(r), mpf(r.randint(1, 30)) / 10
        f = lambda x: a * mp.sin(omega * x + phase)  # noqa: E731
        once = a / omega * (mp.cos(phase) - mp.cos(omega * t + phase))
        twice = a / omega**2 * (mp.sin(phase) - mp.sin(omega * t + phase)) + a * mp.cos(phase) / omega * t
        assert mp.almosteq(mp.quad(f, [0, t]), once, 1e-25)
        assert mp.almosteq(mp.quad(lambda x: (t - x) * f(x), [0, t]), twice, 1e-25)


def test_law_42_integrals_over_turns() -> None:
    r = random.Random(42)
    for _ in range(10):
        # A held signal: values over parts of the period.
        parts = [(mpf(r.randint(1, 9)) / 10, number(r)) for _ in range(4)]
        period = mp.fsum(span for span, _ in parts)

        def over(turns: int) -> Tuple[mpf, mpf]:
            q = p = mpf(0)
            for _ in range(turns):
                for span, value in parts:
                    p, q = p + q * span + value * span**2 / 2, q + value * span
            return q, p

        (once, twice), turns = over(1), r.randint(2, 9)
        q, p = over(turns)
        assert mp.almosteq(q, turns * once)
        assert mp.almosteq(p, turns * twice + mpf(turns * (turns - 1)) / 2 * period * once)


def swept(law: str, begin: mpf, end: mpf, span: mpf, t: mpf) -> mpf:
    """The phase of (A48) over 2π, without its start."""
    if law == "linear":
        return begin * t + (end - begin) / (2 * span) * t**2
    growth = mp.log(end / begin)
    return begin * span * (mp.exp(growth * t / span) - 1) / growth


def test_law_43_phases_of_sweeps() -> None:
    r = random.Random(43)
    for law in ["linear", "logarithmic"]:
        for _ in range(5):
            begin, end, span = (mpf(r.randint(1, 90)) / 10 for _ in range(3))
            t = span * r.randint(1, 9) / 10
            frequency = mp.diff(lambda x: swept(law, begin, end, span, x), t)
            part = t / span
            exact = begin + (end - begin) * part if law == "linear" else begin * (end / begin) ** part
            assert mp.almosteq(frequency, exact, 1e-20)


def test_law_44_bounds_of_derivatives_of_sweeps() -> None:
    r = random.Random(44)
    for law in ["linear", "logarithmic"]:
        for _ in range(3):
            begin, end, span = (mpf(r.randint(5, 40)) / 10 for _ in range(3))
            t = span * r.randint(0, 8) / 10
            wave = lambda x: mp.exp(2j * mp.pi * swept(law, begin, end, span, x))  # noqa: E731
            found = [abs(c) * mp.factorial(n) for n, c in enumerate(mp.taylor(wave, t, 12))]
            speed = 2 * mp.pi * mp.diff(lambda x: swept(law, begin, end, span, x), t)
            bounds = [mpf(1)]
            for n in range(12):
                if law == "linear":
                    turn = 2 * mp.pi * abs(end - begin) / span
                    last = n * turn * bounds[n - 1] if n else mpf(0)
                    bounds.append(speed * bounds[n] + last)
                else:
                    growth = abs(mp.log(end / begin)) / span
                    bounds.append(
                        mp.fsum(mp.binomial(n, k) * speed * growth**k * bounds[n - k] for k in range(n + 1))
                    )
            assert all(size <= bound * (1 + mpf(10) ** -10) for size, bound in zip(found, bounds))


def lines(r: random.Random, count: int) -> Tuple[List[mpf], List[mpf]]:
    """Points of a force: rising elongations, any forces."""
    places = [number(r)]
    for _ in range(count - 1):
        places.append(places[-1] + mpf(r.randint(1, 99)) / 50)
    return places, [number(r) for _ in places]


def of_points(e: List[mpf], f: List[mpf], x: mpf) -> mpf:
    """Straight lines through points; the first and the last line continue."""
    j = min(max(sum(1 for place in e if place <= x), 1), len(e) - 1)
    return f[j - 1] + (f[j] - f[j - 1]) / (e[j] - e[j - 1]) * (x - e[j - 1])


def test_law_45_lines_as_a_spring_and_corners() -> None:
    r = random.Random(45)
    for _ in range(20):
        e, f = lines(r, r.randint(2, 6))
        slopes = [(f[j] - f[j - 1]) / (e[j] - e[j - 1]) for j in range(1, len(e))]
        for x in [*e, e[0] - 1, e[-1] + 1, (e[0] + e[1]) / 2]:
            corners = mp.fsum(
                (slopes[j] - slopes[j - 1]) * max(mpf(0), x - e[j]) for j in range(1, len(slopes))
            )
            whole = f[0] + slopes[0] * (x - e[0]) + corners
            assert abs(whole - of_points(e, f, x)) < ROUNDING * 100


def test_law_46_lines_as_bounded_forces() -> None:
    r = random.Random(46)
    for _ in range(20):
        e, f = lines(r, r.randint(3, 6))
        slopes = [(f[j] - f[j - 1]) / (e[j] - e[j - 1]) for j in range(1, len(e))]
        least = min(slopes)
        for x in [*e, e[0] - 1, e[-1] + 1, (e[0] + e[1]) / 2]:
            # The first line covers all below its end, the last line all beyond its beginning.
            whole = f[1] + least * (x - e[1]) + (slopes[0] - least) * min(mpf(0), x - e[1])
            for j in range(2, len(e)):
                way = (x if j == len(e) - 1 else min(x, e[j])) - e[j - 1]
                whole += (slopes[j - 1] - least) * max(mpf(0), way)
            assert abs(whole - of_points(e, f, x)) < ROUNDING * 100


def test_law_53_what_a_freewheel_takes_away() -> None:
    r = random.Random(57)
    for _ in range(40):
        mass, v, w = masses(r, 3), vector(r, 3), rows(r, 3, 3)
        u = w.T * v
        g = w.T * mass**-1 * w
        # For stops that open and freewheels that close, whatever their rates.
        found = impulses(g, u, [mpf(0)] * 3)
        assert found  # v = 0 is allowed
        for p in found:
            after = v - mass**-1 * w * p
            assert close(after, v - mass**-1 * w * found[0])
            assert all(x <= ROUNDING for x in w.T * after)  # nothing is left to do
            lost = (dot(v, mass * v) - dot(after, mass * after)) / 2
            assert abs(lost - dot(p, u) / 2) < ROUNDING and abs(lost - dot(p, g * p) / 2) < ROUNDING
            distance = dot(after - v, mass * (after - v))
            for _ in range(20):
                other = after + vector(r, 3) / 10
                if all(x <= 0 for x in w.T * other):
                    assert distance <= dot(other - v, mass * (other - v)) + ROUNDING
    # A wall and two equal masses: in turns, velocities decrease by (1 - eps)/2.
    eps, a, b = mpf(3) / 5, mpf(2), mpf(2)
    for _ in range(200):
        before, a = a, -eps * a
        a = b = (a + b) / 2
        assert abs(a - (1 - eps) / 2 * before) < ROUNDING
    assert abs(a) < ROUNDING
    walls = matrix([[1, -1], [0, 1]])
    for p in impulses(walls.T * walls, walls.T * matrix([-eps * 2, 2]), [mpf(0)] * 2):
        assert mp.norm(matrix([-eps * 2, 2]) - walls * p) < ROUNDING


def test_law_49_normal_coordinates() -> None:
    r = random.Random(49)
    for _ in range(5):
        n = 4
        a, b = (matrix([[number(r) for _ in range(n)] for _ in range(n)]) for _ in range(2))
        mass, stiffness = a * a.T + mp.eye(n), b * b.T
        lower = mp.cholesky(mass)
        inverse = lower**-1
        squares, vectors = mp.eigsy(inverse * stiffness * inverse.T)
        shapes = inverse.T * vectors
        assert close(shapes.T * mass * shapes, mp.eye(n))
        assert close(shapes.T * stiffness * shapes, mp.diag(list(squares)))
        q = vector(r, n)
        assert close(shapes * (shapes.T * mass * q), q)


def test_law_51_energy_of_a_step() -> None:
    r = random.Random(51)
    for _ in range(20):
        before, after, x = mpf(r.randint(0, 99)), mpf(r.randint(0, 99)), number(r)
        stored = [k * x**2 / 2 for k in (before, after)]
        assert mp.almosteq(stored[1] - stored[0], (after - before) * x**2 / 2)


def saturated(x: mpf, low: mpf, high: mpf) -> mpf:
    return min(max(x, low), high)


def test_law_54_a_limit_as_two_corners() -> None:
    r = random.Random(54)
    for _ in range(50):
        x, low = number(r) * 3, -abs(number(r))
        high = low + abs(number(r)) + 1
        assert mp.almosteq(saturated(x, low, high), x - max(0, x - high) + max(0, low - x))


def test_law_55_differences_grow_at_most_by_the_rate_of_the_blocks() -> None:
    """Coulomb friction and a saturated feedback: two motions in small steps that are implicit in friction."""
    r = random.Random(55)
    for _ in range(5):
        k, g, level, dt = abs(number(r)), number(r), abs(number(r)), mpf("0.002")
        bound = 1 + 2 * (k + abs(g))
        pairs = [[number(r), number(r), number(r)] for _ in range(2)]
        begin = mp.sqrt(sum((a - b) ** 2 for a, b in zip(*pairs)))
        for step in range(500):
            for z in pairs:
                free = z[1] + dt * (-k * z[0] + g * saturated(z[2], mpf(-1), mpf(1)))
                slipped = max(abs(free) - dt * level, mpf(0)) * mp.sign(free)
                z[0], z[1], z[2] = z[0] + dt * z[1], slipped, z[2] + dt * (z[0] - z[2])
            now = mp.sqrt(sum((a - b) ** 2 for a, b in zip(*pairs)))
            assert now <= begin * mp.exp(bound * dt * (step + 1)) * (1 + mpf("1e-3"))


def test_law_56_variations_over_a_sample() -> None:
    r = random.Random(56)
    for _ in range(20):
        a, b, c, d = (number(r) for _ in range(4))
        x, u, low, high = number(r), number(r), mpf(-1), mpf(1)
        state, moved = (x, u), (number(r), number(r))

        def sample(z: tuple[mpf, mpf]) -> list[mpf]:
            return [saturated(c * z[0] + d * z[1], low, high), a * z[0] + b * z[1]]

        h = mpf("1e-12")
        after, before = (sample((state[0] + e * moved[0], state[1] + e * moved[1])) for e in (h, -h))
        inside = low < c * x + d * u < high
        exact = [(c * moved[0] + d * moved[1]) * inside, a * moved[0] + b * moved[1]]
        for found, wanted in zip([(p - q) / (2 * h) for p, q in zip(after, before)], exact):
            assert abs(found - wanted) < mpf("1e-9")


def curve(c: Dict[int, mpf], x: mpf) -> mpf:
    return sum(value * x**m for m, value in c.items())


def coefficients_of_power(x: Sequence[mpf], m: int, count: int) -> List[mpf]:
    """Coefficients of x(u)^m by repeated products of whole polynomials."""
    power = [mpf(1)]
    for _ in range(m):
        product = [mpf(0)] * (len(power) + len(x) - 1)
        for i, a in enumerate(power):
            for j, b in enumerate(x):
                product[i + j] += a * b
        power = product
    return (power + [mpf(0)] * count)[:count]


def test_law_58_coefficients_of_a_motion_on_a_curved_spring() -> None:
    """q'' = -k q - c3 q^3 by (A58), against derivatives of the right side found by differentiation in time."""
    r = random.Random(58)
    for _ in range(5):
        k, c, h = abs(number(r)), number(r), mpf("0.1")
        q, v = [number(r)], [number(r)]
        for n in range(12):
            cube = coefficients_of_power(q, 3, n + 1)[n]
            q.append(h / (n + 1) * v[n])
            v.append(h / (n + 1) * (-k * q[n] - c * cube))
        # Energy along the polynomial is constant up to the order that was left out.
        small = mpf("1e-4")
        place = sum(x * small**i for i, x in enumerate(q))
        rate = sum(x * small**i for i, x in enumerate(v))
        energy = [y * y / 2 + k * x * x / 2 + c * x**4 / 4 for x, y in ((q[0], v[0]), (place, rate))]
        assert abs(energy[0] - energy[1]) < mpf("1e-38")


def test_law_59_the_tail_of_a_power_is_bounded() -> None:
    r = random.Random(59)
    order = 10
    for _ in range(20):
        x = [number(r) / mpf(2) ** i for i in range(order + 1)]
        rho = mpf(2)
        scale = max(abs(a) * rho**i for i, a in enumerate(x))
        for m in range(2, 6):
            all_terms = coefficients_of_power(x, m, m * order + 1)
            tail = sum(abs(a) for a in all_terms[order:])
            ratio = mpf(order + m) / ((order + 1) * rho)
            bound = scale**m * mp.binomial(order + m - 1, m - 1) * rho**-order / (1 - ratio)
            assert tail <= bound


#: Operations of formulas with their slopes.
OPERATIONS = {
    "exp": (mp.exp, mp.exp),
    "ln": (mp.log, lambda a: 1 / a),
    "sin": (mp.sin, mp.cos),
    "cos": (mp.cos, lambda a: -mp.sin(a)),
    "tanh": (mp.tanh, lambda a: 1 - mp.tanh(a) ** 2),
    "atan": (mp.atan, lambda a: 1 / (1 + a**2)),
    "root": (mp.sqrt, lambda a: 1 / (2 * mp.sqrt(a))),
    "pole": (lambda a: a**-2, lambda a: -2 * a**-3),
}


def argument(r: random.Random, orders: int) -> List[mpf]:
    """Coefficients whose sum of sizes beyond the first is at most 0.3, with a positive first one."""
    others = [number(r) / mpf(2) ** i for i in range(1, orders + 1)]
    size = sum(abs(x) for x in others)
    return [mpf("0.5") + abs(number(r)) / 4] + [mpf("0.3") * x / size for x in others]


def test_law_60_series_of_operations_from_their_slopes() -> None:
    r = random.Random(60)
    for name, (value, slope) in OPERATIONS.items():
        a = argument(r, 6)
        at = lambda f: mp.taylor(lambda u: f(mp.polyval(a[::-1], u)), 0, 8)
        w, g = at(value), at(slope)
        for k in range(1, 9):
            own = sum(j * a[j] * g[k - j] for j in range(1, min(k, 6) + 1)) / k
            assert abs(own - w[k]) < mpf("1e-15"), (name, k, own, w[k])
    for p in (mpf("0.5"), mpf("1.5"), mpf(-1), mpf(-2)):
        a = argument(r, 6)
        w = mp.taylor(lambda u: mp.polyval(a[::-1], u) ** p, 0, 8)
        for k in range(1, 9):
            own = sum((p * j - k + j) * a[j] * w[k - j] for j in range(1, min(k, 6) + 1)) / (k * a[0])
            assert abs(own - w[k]) < mpf("1e-15"), (p, k, own, w[k])


def test_law_61_coefficients_of_operations_are_bounded() -> None:
    """All coefficients beyond K = 4 are below C at radius 1, by Cauchy's integrals over a circle of nodes."""
    r = random.Random(61)
    order, nodes = 4, 64
    for _ in range(4):
        a = argument(r, order)
        s = sum(abs(x) for x in a[1:])
        weighted = sum(k * abs(x) for k, x in enumerate(a))
        away, near = max(abs(a[0]) - s, 0), mp.cos(s) ** 2
        bounds = {
            "ln": -mp.log(1 - s / a[0]),
            "root": (a[0] + s) ** mpf("0.5"),
            "pole": (a[0] - s) ** -2,
            "tanh": s / (mp.sinh(away) ** 2 + near),
            "atan": s / (mp.sqrt(1 + a[0] ** 2) - s) ** 2,
        }
        for name, (value, slope) in OPERATIONS.items():
            circle = [mp.expjpi(2 * mpf(n) / nodes) for n in range(nodes)]
            coefficients = []
            for f in (value, slope):
                values = [f(mp.polyval(a[::-1], u)) for u in circle]
                coefficients.append(
                    [abs(sum(x / u**k for x, u in zip(values, circle)) / nodes) for k in range(nodes // 2)]
                )
            w, g = coefficients
            assert weighted <= order + 1
            bound = bounds.get(name, max(w[: order + 1] + g[: order + 1]))
            assert all(x <= bound for x in w[order + 1 :]), (name, bound)


def test_law_66_the_rate_of_a_slider_and_of_the_distance_from_its_limit() -> None:
    r = random.Random(66)
    for _ in range(20):
        kn, kt, mu, w, at = (abs(number(r)) + 1 for _ in range(5))
        sign = r.choice([-1, 1])
        normal, tangent = ([number(r) for _ in range(4)] for _ in range(2))

        def n_force(t: mpf, x: List[mpf] = normal, k: mpf = kn) -> mpf:
            return k * mp.polyval(x, t)

        def e_t(t: mpf, x: List[mpf] = tangent) -> mpf:
            return mp.polyval(x, t)

        rate = sign * mp.diff(e_t, at) - mu * mp.diff(n_force, at) / kt
        stuck = mp.diff(lambda t: sign * kt * (e_t(t) - w) - mu * n_force(t), at)
        slips = mp.diff(lambda t: sign * (e_t(t) - sign * mu * n_force(t) / kt), at)
        assert abs(stuck / kt - rate) < mpf(10) ** -12 and abs(slips - rate) < mpf(10) ** -12


def test_law_67_the_loss_of_a_slider_over_a_step() -> None:
    r = random.Random(67)
    slipped = 0
    for _ in range(200):
        kt = abs(number(r)) + 1
        first, last = abs(number(r)), abs(number(r))
        way, sign = 3 * number(r), 1
        if way < 0:
            sign = -1
        begin = first * number(r) / 2
        begin = max(-first, min(first, begin))

        def limit(part: mpf, a: mpf = first, b: mpf = last) -> mpf:
            return a + part * (b - a)

        # The stretch begins to follow its limit at the part at which both are equal.
        slope = sign * way - (last - first)
        part = (first - sign * begin) / slope if slope > 0 else mpf(2)
        if not 0 <= part < 1:
            continue
        slipped += 1
        lost = mp.quad(lambda s, slope=slope: kt * limit(s) * abs(slope), [part, 1])
        moved = abs(slope) * (1 - part)
        assert abs(lost - kt * (limit(part) + last) * moved / 2) < mpf(10) ** -20 * (1 + lost)
    assert slipped > 30, slipped


def test_law_68_forces_on_residual_flexibility_are_those_of_all_modes() -> None:
    """All coordinates that the kept ones lack, without mass, hold the springs' forces in balance."""
    r = random.Random(68)
    for _ in range(10):
        kept, left, count = 2, 5, 3
        stiffness = mp.diag([mpf(r.randint(10, 99)) for _ in range(left)])
        own, other = rows(r, count, kept), rows(r, count, left)
        springs = mp.diag([mpf(r.randint(1, 50)) for _ in range(count)])
        eta = vector(r, kept)
        flexibility = other * stiffness**-1 * other.T
        forces = mp.lu_solve(springs**-1 + flexibility, own * eta)
        # Balance of the coordinates that are left out: stiffness times zeta = -B^T p, p = k (B eta + B zeta).
        zeta = mp.lu_solve(stiffness + other.T * springs * other, -other.T * springs * own * eta)
        assert close(springs * (own * eta + other * zeta), forces)


def test_law_70_stored_energy_is_the_work_done() -> None:
    r = random.Random(70)
    for _ in range(10):
        count = 3
        root = rows(r, count, count)
        flexibility, compliance = root * root.T, mp.diag([mpf(r.randint(1, 9)) / 10 for _ in range(count)])
        places, loads = ([[number(r) for _ in range(3)] for _ in range(count)] for _ in range(2))

        def at(polynomials: List[List[mpf]], t: mpf) -> matrix:
            return matrix([mp.polyval(p, t) for p in polynomials])

        def force(t: mpf, g: matrix = flexibility, c: matrix = compliance, s: List = places, f: List = loads) -> matrix:
            return mp.lu_solve(c + g, at(s, t) + g * at(f, t))

        def stored(t: mpf, g: matrix = flexibility, c: matrix = compliance, f: List = loads) -> mpf:
            p = force(t)
            left = at(f, t) - p
            return (p.T * c * p)[0] / 2 + (left.T * g * left)[0] / 2

        def moved(t: mpf, g: matrix = flexibility, f: List = loads) -> matrix:
            return g * (at(f, t) - force(t))

        t = number(r)
        rate = matrix([mp.diff(lambda u, i=i: moved(u)[i], t) for i in range(count)])
        drawn = matrix([mp.diff(lambda u, i=i: at(places, u)[i], t) for i in range(count)])
        # Loads do work on the displacements that they see; the modes on the elements.
        work = (at(loads, t).T * rate)[0] + (force(t).T * drawn)[0]
        assert abs(mp.diff(stored, t) - work) < mpf(10) ** -12 * (1 + abs(work))


def test_law_71_one_state_of_a_contact_is_consistent_below_the_bound() -> None:
    r = random.Random(71)
    several = 0
    for _ in range(60):
        root = rows(r, 2, 2)
        g = root * root.T
        cn, ct = (mpf(r.randint(1, 9)) / 50 for _ in range(2))
        bound = (g[0, 0] + cn) / abs(g[0, 1])
        for factor, is_unique in ((mpf("0.95"), True), (mpf("1.5"), False)):
            mu, most = factor * bound, 0
            for _ in range(20):
                x, y = number(r), number(r)
                found = 1 if x <= 0 else 0
                n, t = mp.lu_solve(matrix([[cn + g[0, 0], g[0, 1]], [g[0, 1], ct + g[1, 1]]]), matrix([x, y]))
                found += n > 0 and abs(t) <= mu * n
                for sign in (1, -1):
                    n = x / (cn + g[0, 0] + sign * mu * g[0, 1])
                    # The slider moves in the direction of the force.
                    way = y - (ct + g[1, 1]) * sign * mu * n - g[0, 1] * n
                    found += n > 0 and sign * way > 0
                if is_unique:
                    assert found == 1, (found, x, y)
                most = max(most, abs(found - 1))
            several += not is_unique and most > 0
    assert several > 20, several


def test_law_72_forces_of_coupled_contacts_vary() -> None:
    r = random.Random(72)
    mp.dps = 60
    for _ in range(20):
        root = rows(r, 3, 3)
        flexibility, x, shift = root * root.T, vector(r, 3), vector(r, 3)
        softness, friction = [mpf(r.randint(1, 9)) / 10 for _ in range(3)], mpf(r.randint(1, 9)) / 100

        def matrix_at(q: mpf, g: matrix = flexibility, c: List[mpf] = softness, mu: mpf = friction) -> matrix:
            # Force 2 slips along the normal force 0: only the forces 0 and 1 are active.
            slip = mu * (1 + q)
            whole = matrix([[g[i, j] + (slip * g[i, 2] if j == 0 else 0) for j in range(2)] for i in range(2)])
            return whole + mp.diag([c[0] * (1 + 2 * q), c[1]])

        def force(q: mpf, of: List[mpf] = list(x), by: List[mpf] = list(shift)) -> matrix:
            return mp.lu_solve(matrix_at(q), matrix([of[i] + q * by[i] for i in range(2)]))

        change = matrix([[2 * softness[0] + friction * flexibility[0, 2], 0], [friction * flexibility[1, 2], 0]])
        exact = mp.lu_solve(matrix_at(mpf(0)), matrix(list(shift)[:2]) - change * force(mpf(0)))
        step = mpf(10) ** -20
        assert mp.norm((force(step) - force(-step)) / (2 * step) - exact) < mpf(10) ** -25 * (1 + mp.norm(exact))
