"""Sections 9 and 10: the exact two-impact orbit and its stability."""

from functools import lru_cache
from typing import Any, Dict, List

import mpmath
import pytest
import sympy
from equations import Formula, eq, sym, zero
from simulation import DIGITS, accelerations, basic, differences, flight, other, strike
from approximation import NUMERIC, fixed_points

CASES = ["basic", "other"]
TIGHT = mpmath.mpf(10) ** -20
NUMERIC_MATRIX: Dict[str, Any] = {**NUMERIC, "matrix": mpmath.matrix}


def evaluated(number: int, key: str, known: Dict[str, Any]) -> Any:
    return eq(number)(key, {**NUMERIC_MATRIX, **known})


def build(p: Dict[str, Any]) -> Dict[str, Any]:
    """The orbit of the larger root by the formulas of the page, lengths in L and times in 1/ω1."""
    k: Dict[str, Any] = {**p, "varepsilon": p["m_2"] / p["m_1"]}
    k.update(eq(69).values({**NUMERIC, **k}))
    k["A"] = evaluated(70, "A", k)
    k["H"] = evaluated(71, "H", k)
    k["H_w"] = evaluated(71, "H_w", k)
    k["g"] = evaluated(72, "g", k)
    k["M"] = eq(72)("M", {**NUMERIC, **k, "exp": mpmath.expm})
    k["I"] = mpmath.eye(6)
    k["G_plus"] = evaluated(72, "G_plus", k)
    k["G_minus"] = evaluated(72, "G_minus", k)
    k["G_w"] = k["G_plus"][1] - k["G_plus"][0]
    k["G_wp_plus"], k["G_wp_minus"] = (k[x][4] - k[x][3] for x in ("G_plus", "G_minus"))
    k["R"] = evaluated(73, "R", k)
    quadratic: Formula = lambda p: eq(74).relations[0].left({**NUMERIC, **k, "p": p})
    c, one, minus = quadratic(mpmath.mpf(0)), quadratic(mpmath.mpf(1)), quadratic(mpmath.mpf(-1))
    a, b = (one + minus) / 2 - c, (one - minus) / 2
    k["quadratic"] = (a, b, c)
    k["p"] = (-b + mpmath.sqrt(b * b - 4 * a * c)) / (2 * a)
    arg = eq(75).relations[0].right_tokens
    assert arg[0] == r"\arg"
    k["delta"] = evaluated(75, "delta", k)
    turned = mpmath.expjpi(k["delta"] / mpmath.pi)
    h = [k["H"] * turned, 0, 0, 1j * k["H"] * turned, 0, 0]
    # (77): Im entry by entry.
    k["after"] = k["p"] * k["G_plus"] + mpmath.matrix([mpmath.im(x) for x in h])
    k["before"] = evaluated(77, "sigma_minus", {**k, "sigma_plus": k["after"]})
    return k


@lru_cache(maxsize=None)
def orbit(case: str) -> Dict[str, Any]:
    with mpmath.workdps(DIGITS):
        return build(basic() if case == "basic" else other())


def si(k: Dict[str, Any], state: Any, theta: Any) -> List[Any]:
    """A dimensionless state in SI units, with the phase of the drive."""
    speed = k["L"] * k["omega_1"]
    return [k["L"] * state[i] for i in range(3)] + [speed * state[i] for i in range(3, 6)] + [theta]


def test_eq_69_70_71_flight_in_units_of_gap_and_phase() -> None:
    """(3) in units of L and 1/ω1 has the coefficients (69), the matrix (70) and the response (71)."""
    L, w = sympy.symbols("L omega_1", positive=True)
    x = [sym(f"x{i}") for i in (1, 2, 3)]
    v = [sym(f"v{i}") for i in (1, 2, 3)]
    env: Dict[str, Any] = {"lambda": 0, "f_1": 0, "f_2": 0, "f_3": 0, "L": L, "omega_1": w}
    for i in (1, 2, 3):
        env[f"x_{i}"], env[f"dot_x_{i}"] = L * x[i - 1], L * w * v[i - 1]
    coefficients = eq(69).values(env)
    A = eq(70)("A", coefficients)
    state = sympy.Matrix(x + v)
    force = sympy.Matrix([0, 0, 0, coefficients["F"] * sympy.sin(sym("theta")), 0, 0])
    found = A * state + force
    for i, relation in enumerate(eq(3).relations):
        expected = sympy.solve(relation.left(env) - relation.right(env), sym(f"ddot_x_{i + 1}"))[0] / (L * w**2)
        assert zero(found[3 + i] - expected) and found[i] == v[i]
    # (71): x = H e^{iθ} solves x'' = -κ1 x - d1 x' + F e^{iθ}.
    H = eq(71)("H")
    assert zero(-H + sym("kappa_1") * H + sympy.I * sym("d_1") * H - sym("F"))
    assert zero(eq(71)("H_w", {"H": H}) + H)


def test_eq_72_alternating_impulses() -> None:
    """G⁺ of (72) is what impulses g, -g, … half a period apart, for ever, leave just after an upper one."""
    with mpmath.workdps(DIGITS):
        k = orbit("other")
        total, power = k["g"], -k["M"]
        for _ in range(20):  # twice as many impulses each time
            total, power = total + power * total, power * power
        assert mpmath.norm(total - k["G_plus"]) < mpmath.mpf(10) ** -12
        assert mpmath.norm(k["M"] * k["G_plus"] + k["G_minus"]) < TIGHT
        # g is a unit impulse (of m2 ω1 L) on the box at the upper stop: it changes v1 by m2/m1, v2
        # by -1.
        assert list(k["g"]) == [0, 0, 0, k["m_2"] / k["m_1"], -1, 0]


@pytest.mark.parametrize("case", CASES)
def test_eq_72_73_75_77_orbit_repeats_and_meets_the_impact_law(case: str) -> None:
    """The orbit of (72) to (77), propagated by series, meets stop and impact law and is its mirror image after half a period."""
    with mpmath.workdps(DIGITS):
        k = orbit(case)
        before, after = si(k, k["before"], k["delta"]), si(k, k["after"], k["delta"])
        assert k["p"] > 0 and abs(after[1] - after[0] - k["L"]) < TIGHT
        # Independent impact law, at the speed of approach.
        assert before[4] - before[3] > 0
        assert max(abs(a - b) for a, b in zip(strike(k, before), after)) < TIGHT
        end = flight(k, after, mpmath.pi / k["omega_1"])
        assert max(abs(a + b) for a, b in zip(end[:6], before[:6])) < TIGHT
        impulse = k["m_1"] * (after[3] - before[3])
        assert abs(impulse - k["p"] * k["m_2"] * k["omega_1"] * k["L"]) < TIGHT
        response = eq(73).relations[1]
        assert abs(response.left({**NUMERIC, **k}) - response.right({**NUMERIC, **k})) < TIGHT
        # (77) literally: h = (H, 0, 0, iH, 0, 0).
        h = mpmath.matrix([k["H"], 0, 0, 1j * k["H"], 0, 0])
        imaginary: Formula = lambda m: m.apply(mpmath.im)
        whole = eq(77)("sigma_plus", {**NUMERIC, **k, "h": h, "Im": imaginary})
        assert mpmath.norm(whole - k["after"]) < TIGHT


def test_eq_73_74_76_quadratic_and_discriminant() -> None:
    """The modulus of (73) is (74), and (76) its discriminant."""
    p, h = sym("p"), sym("h")
    right = eq(73).relations[1].right()
    left = eq(74).relations[0].left({"abs": lambda _: h})
    assert eq(74).relations[0].right() == 0
    assert zero(sympy.expand(right * sympy.conjugate(right)) - h**2 - left)
    a, b, c = sympy.Poly(sympy.expand(left), p).all_coeffs()
    discriminant = eq(76)
    assert not discriminant.relations
    from equations import Reader, tokens_of

    found = Reader(tokens_of(discriminant.tex), {"abs": lambda _: h}).all()
    assert zero(found - (b**2 - 4 * a * c))


def test_eq_72_77_golden_orbit_of_the_default_set() -> None:
    """The impulse by (72) to (77) of the default set's orbit, which the Rust tests hold to as well."""
    k = orbit("basic")
    assert abs(k["p"] * k["omega_1"] * k["L"] - mpmath.mpf("1.597276346")) < 1e-9  # p/m2 in SI units


def saltation(k: Dict[str, Any]) -> Any:
    """S of (78) at the upper impact, with J, n and the fields as the page states them."""
    J = mpmath.eye(6)
    share = (1 + k["kappa"]) / (1 + k["varepsilon"])
    for row, factor in ((3, share * k["varepsilon"]), (4, -share)):
        J[row, 3] -= factor
        J[row, 4] += factor
    force = mpmath.matrix([0, 0, 0, k["F"] * mpmath.sin(k["delta"]), 0, 0])
    f = {"f_plus": k["A"] * k["after"] + force, "f_minus": k["A"] * k["before"] + force}
    n = mpmath.matrix([-1, 1, 0, 0, 0, 0])

    class Normal:
        """n, whose transpose makes an outer product on the right and a number on the left."""

        T = n.T

    above = (f["f_plus"] - J * f["f_minus"]) * n.T
    below = (n.T * f["f_minus"])[0]
    tokens = "".join(eq(78).relations[0].right_tokens)
    assert tokens == r"J+\frac{(f^+-Jf^-)n^T}{n^Tf^-}"
    return J + above / below


@pytest.mark.parametrize("case", CASES)
def test_eq_78_saltation_matrix_by_perturbation(case: str) -> None:
    """S of (78) against differences of flight, impact and flight back, over a fixed time through the impact."""
    with mpmath.workdps(DIGITS):
        k = orbit(case)
        S = saltation(k)
        before = si(k, k["before"], k["delta"])
        early, step = mpmath.mpf("0.01") / k["omega_1"], mpmath.mpf(10) ** -10
        start = flight(k, before, -early)
        units = [k["L"]] * 3 + [k["L"] * k["omega_1"]] * 3

        def through(x: List[Any]) -> List[Any]:
            """The state a while before the impact to the state a while after it, both carried back to its instant."""
            z = flight(k, [a * u for a, u in zip(x, units)] + [k["delta"]], -early)
            gap: Formula = lambda t: (lambda y: y[1] - y[0] - k["L"])(flight(k, z, t))
            hit = mpmath.findroot(gap, early)
            y = flight(k, strike(k, flight(k, z, hit)), early - hit)
            return [a / u for a, u in zip(y[:6], units)]

        at = [a / u for a, u in zip(before[:6], units)]
        assert start[6] < before[6]
        found = differences(through, at, step)
        assert mpmath.norm(found - S) < mpmath.mpf(10) ** -12 * (1 + mpmath.norm(S))
        # The matrix acts on the gap as the page says.
        row = [S[1, j] - S[0, j] for j in range(6)]
        assert max(abs(a - b) for a, b in zip(row, [k["kappa"], -k["kappa"], 0, 0, 0, 0])) < TIGHT


@pytest.mark.parametrize("case", CASES)
def test_eq_79_half_cycle_map_by_differences(case: str) -> None:
    """D_h of (79) against differences from one impact to just after the next; D_T is the stroboscopic map of a whole period."""
    with mpmath.workdps(DIGITS):
        k = orbit(case)
        D = evaluated(79, "D_h", {**k, "S": saltation(k)})
        units = [k["L"]] * 3 + [k["L"] * k["omega_1"]] * 3
        half, step = mpmath.pi / k["omega_1"], mpmath.mpf(10) ** -10
        middle = half / 3
        # From mid-flight, where a deviation moves no impact out of the interval.
        after = si(k, k["after"], k["delta"])
        start = flight(k, after, middle)

        def over(count: int) -> Any:
            def map(x: List[Any]) -> List[Any]:
                z = [a * u for a, u in zip(x, units)] + [start[6]]
                left = count * half
                for _ in range(count):
                    side = mpmath.sign(z[4] - z[3])
                    gap: Formula = lambda t: (lambda y: side * (y[1] - y[0]) - k["L"])(flight(k, z, t))  # noqa: B023
                    hit = mpmath.findroot(gap, half - middle if left > half * count - 0.1 * half else half)
                    z, left = strike(k, flight(k, z, hit)), left - hit
                return [a / u for a, u in zip(flight(k, z, left)[:6], units)]

            return map

        at = [a / u for a, u in zip(start[:6], units)]
        carry = mpmath.expm(k["A"] * middle * k["omega_1"])
        whole = evaluated(79, "D_T", {"D_h": D})
        for count, sign, matrix in ((1, -1, D), (2, 1, whole)):
            found = sign * differences(over(count), at, step)
            expected = carry * matrix * carry**-1
            assert mpmath.norm(found - expected) < mpmath.mpf(10) ** -11 * (1 + mpmath.norm(expected)), count
        radius = max(abs(x) for x in mpmath.eig(D, left=False, right=False))
        if case == "basic":
            assert abs(radius - mpmath.mpf("0.912416827")) < 1e-9


@pytest.mark.parametrize("case", CASES)
def test_eq_80_determinants(case: str) -> None:
    """(80): det S = κ², the product of the multipliers of (79), and their distances from one."""
    with mpmath.workdps(DIGITS):
        k = orbit(case)
        S = saltation(k)
        assert abs(mpmath.det(S) - evaluated(80, r"\detS", k)) < TIGHT
        product = mpmath.mpf(1)
        D = evaluated(79, "D_h", {**k, "S": S})
        for multiplier in mpmath.eig(D, left=False, right=False):
            product = product * multiplier
        assert abs(product - eq(80).relations[1].right({**NUMERIC, **k})) < mpmath.mpf(10) ** -15
        unit = mpmath.eye(6)
        found = mpmath.det(unit - D) / mpmath.det(unit + mpmath.expm(mpmath.pi * k["A"]))
        assert abs(found - eq(80).relations[2].right({**NUMERIC, **k})) < TIGHT * (1 + abs(found))


def test_eq_58_multipliers_as_the_mass_ratio_vanishes() -> None:
    """Two multipliers of (79) tend to the multipliers of (53), four to (58), with errors of first and of second order."""
    values = {"varepsilon": 0.1, "kappa": 0.75, "hat_f_10": 1.2, "hat_sigma_1": 0.4, "hat_gamma_1": 0.8, "hat_alpha": 0.6,
              "hat_sigma_30": 0.1, "hat_gamma_3": 0.6}  # fmt: skip
    errors: List[Dict[str, Any]] = []
    for size in ("1e-3", "1e-4"):
        e = mpmath.mpf(size)
        known: Dict[str, Any] = {x: mpmath.mpf(str(v)) for x, v in values.items()}
        known.update(varepsilon=e, mu_13=1 / e, beta=mpmath.sqrt(e * known["hat_alpha"]), L=mpmath.mpf(1),
                     m_1=mpmath.mpf(1), k_1=mpmath.mpf(1), omega_10=mpmath.mpf(1))  # fmt: skip
        for relation in eq(23).relations:
            known[relation.key] = relation.right({**NUMERIC, **known})
        k = build({x: known[x] for x in ("m_1", "k_1", "c_1", "m_2", "m_3", "k_3", "c_3", "k_23", "L", "kappa", "F_10", "omega_1")})
        left = mpmath.eig(evaluated(79, "D_h", {**k, "S": saltation(k)}), left=False, right=False)
        point = fixed_points({**values, "varepsilon": float(e)})[-1]
        point["m"] = eq(38)("m", point)
        point["h"] = evaluated(53, "h", point)
        point.update({x: evaluated(44, x, point) for x in ("a", "b")})
        trace, determinant = evaluated(51, "t_1", point), evaluated(51, "d_1", point)
        square = mpmath.sqrt(mpmath.mpc(trace**2 / 4 - determinant))
        third = evaluated(51, "Lambda_3", point)
        fast = list(mpmath.eig(evaluated(53, "D", point), left=False, right=False))
        limit, order = eq(58).relations[0], []

        def remainder(size: Any) -> int:
            order.append(size)  # noqa: B023
            return 0

        formula = {**NUMERIC, "varepsilon": e, "O": remainder}
        eigenvalues = (trace / 2 + square, trace / 2 - square, third, mpmath.conj(third))
        slow = [limit.right({**formula, "Lambda_j": x}) for x in eigenvalues]
        assert all(size == e**2 for size in order) and len(order) == 4
        found = {"fast": mpmath.mpf(0), "slow": mpmath.mpf(0)}
        for kind, expected in [("fast", x) for x in fast] + [("slow", x) for x in slow]:
            nearest = min(left, key=lambda m: abs(m - expected))  # noqa: B023
            found[kind] = max(found[kind], abs(nearest - expected))
            left.remove(nearest)
        errors.append(found)
    wide, narrow = errors
    assert 7 < wide["fast"] / narrow["fast"] < 13, errors
    assert 70 < wide["slow"] / narrow["slow"] < 130, errors


def test_eq_69_accelerations_of_the_oracle() -> None:
    """The oracle's own equations and (69), (70) agree at a state; so neither has a term the other lacks."""
    k = orbit("other")
    z = si(k, k["before"], k["delta"])
    force = mpmath.matrix([0, 0, 0, k["F"] * mpmath.sin(k["delta"]), 0, 0])
    field = k["A"] * k["before"] + force
    scale = k["L"] * k["omega_1"] ** 2
    assert all(abs(a / scale - field[3 + i]) < 1e-12 for i, a in enumerate(accelerations(k, z)))
