"""Sections 6 and 7: multiple scales and the three tests of a fixed point."""

from typing import Any, Dict, List, Tuple

import mpmath
import pytest
import sympy
from equations import Formula, eq, sym, zero

B, C, A_3 = (sympy.Symbol(n, positive=True) for n in ("B", "C", "A_3"))
phi = sympy.Symbol("varphi", real=True)
rho, kappa = sym("rho"), sym("kappa")
pi = sympy.pi
BASIC = {"varepsilon": 0.1, "kappa": 0.75, "hat_f_10": 1.5, "hat_sigma_1": 0.4, "hat_gamma_1": 1.0,
         "hat_alpha": 0.6, "hat_sigma_30": 0.0, "hat_gamma_3": 0.6}  # fmt: skip
SETS: List[Dict[str, float]] = [
    BASIC,
    {**BASIC, "hat_sigma_1": -0.5, "hat_gamma_1": 0.4, "hat_sigma_30": 0.5, "hat_gamma_3": 0.2, "hat_alpha": 0.1},
    {**BASIC, "kappa": 0.3, "hat_f_10": 2.2, "hat_sigma_30": -0.7},
]


def numbers(values: Dict[str, float]) -> Dict[str, Any]:
    """Values as mpmath numbers, with ρ."""
    known: Dict[str, Any] = {k: mpmath.mpf(v) for k, v in values.items()}
    known["rho"] = evaluated(34, "rho", known)
    return known


NUMERIC: Dict[str, Any] = {
    "number": mpmath.mpf, "pi": mpmath.pi, "i": mpmath.mpc(0, 1), "sin": mpmath.sin, "cos": mpmath.cos, "sqrt": mpmath.sqrt,
    "asin": mpmath.asin, "acos": mpmath.acos, "atan2": mpmath.atan2, "abs": abs, "Re": mpmath.re, "Im": mpmath.im,
    "conjugate": mpmath.conj, "exp": mpmath.exp, "cot": mpmath.cot, "arg": mpmath.arg,
    "exponent": lambda x: int(x) if x == mpmath.floor(mpmath.re(x)) else x,  # a matrix takes no other
}  # fmt: skip


def evaluated(number: int, key: str, known: Dict[str, Any]) -> Any:
    """The number an equation gives."""
    return eq(number)(key, {**NUMERIC, **known})


def roots(known: Dict[str, Any]) -> Tuple[Any, Any]:
    """Both roots of the quadratic (42)."""
    q = eq(42).values({**NUMERIC, **known})
    square = mpmath.sqrt(q["b"] ** 2 - 4 * q["a"] * q["c"])
    return (-q["b"] - square) / (2 * q["a"]), (-q["b"] + square) / (2 * q["a"])


def fixed_points(values: Dict[str, float]) -> List[Dict[str, Any]]:
    """All that is known at both fixed points."""
    found = []
    known = numbers(values)
    for c in roots(known):
        k = {**known, "C": c}
        k["B"] = mpmath.sqrt(evaluated(35, "B^2", k))
        k["Phi"] = evaluated(35, "Phi", k)
        k["alpha"], k["alpha_0"] = evaluated(43, "alpha", k), evaluated(43, "alpha_0", k)
        k["delta"] = mpmath.arg(k["alpha"] * c + k["alpha_0"])
        k["psi"] = k["delta"] - k["Phi"]
        if c > 0:
            k["A_3"], k["psi_3"] = evaluated(45, "A_3", k), evaluated(45, "psi_3", k)
            found.append(k)
    return found


def harmonic(function: Any) -> Tuple[Any, Any]:
    """First Fourier coefficients (sine, cosine) of Z shifted: of an expression linear in sine and cosine of phi."""
    sine = sympy.integrate(function * sympy.sin(phi), (phi, 0, 2 * pi)) / pi
    cosine = sympy.integrate(function * sympy.cos(phi), (phi, 0, 2 * pi)) / pi
    return sine, cosine


def first_coefficient() -> Any:
    """The cosine coefficient of the sawtooth, from its straight pieces; (31) is tested to have them."""
    return 2 / pi * sympy.integrate((1 - 2 * phi / pi) * sympy.cos(phi), (phi, 0, pi))


def test_eq_31_sawtooth() -> None:
    """(31) is 1 at 0, falls evenly to -1 at π, has period 2π and the first Fourier coefficient 8/π²."""
    def z(x: Any) -> Any:
        return eq(31).relations[0].right({**NUMERIC, "varphi": mpmath.mpf(x)})

    for x in (0, 0.3, 1.2, 2.9, 3.1):
        assert abs(z(x) - (1 - 2 * x / mpmath.pi)) < 1e-12
        assert abs(z(-x) - z(x)) < 1e-12 and abs(z(x + 2 * mpmath.pi) - z(x)) < 1e-12
    assert zero(first_coefficient() - 8 / pi**2)


def test_eq_32_33_form_of_the_motion() -> None:
    """(32) solves (30) and (24) to leading order and gives (33) by (29)."""
    tau, psi, psi_3 = sym("tau"), sym("psi"), sym("psi_3")
    Z = sympy.Function("Z")
    env: Dict[str, Any] = {"Z": Z, "B": B, "C": C, "A_3": A_3}
    leading = {sym("Omega_1"): 1}
    env["eta"] = eq(32)("eta", env)
    U, W, X_3 = (eq(32)(k, env) for k in ("U", "W", "X_3"))
    u, x = U.subs(leading), X_3.subs(leading)
    # At ε = 0 both are free oscillations; the right sides of (30) and (24) have the factor ε or are -X3.
    assert zero(u.diff(tau, 2) + u - eq(30).relations[0].right({"varepsilon": 0}))
    assert zero(x.diff(tau, 2) - eq(24)("X_3pp", {"varepsilon": 0, "X_3": x}))
    # U + W is the sawtooth alone: straight between the impacts, as (24) has it at β = 0.
    assert zero(U + W - C * Z(env["eta"] - sym("Phi"))) and eq(24)("X_2pp", {"beta": 0}) == 0
    for key in ("X_1", "X_2"):
        assert zero(eq(29)(key, {"U": U, "W": W}) - eq(33)(key, env))
    assert psi in U.free_symbols and psi_3 in X_3.free_symbols


def test_eq_34_impact_conditions() -> None:
    """Contact and restitution of (32) at η = Φ, with the slopes ∓2/π of (31), give (34)."""
    Phi, x, y = sym("Phi"), sym("x"), sym("y")
    # x = B sin Φ, y = B cos Φ
    contact = C - x - 1
    after, before = -2 * C / pi - y, 2 * C / pi - y
    found = sympy.solve([contact, after + kappa * before], [x, y], dict=True)[0]
    values = {r.key: r.right({"C": C}) for r in eq(34).relations}
    assert zero(found[x] - values[r"B\sin\Phi"])
    assert zero(found[y] - values[r"B\cos\Phi"].subs(rho, values["rho"]))
    assert Phi in eq(34).relations[0].left().free_symbols


def test_eq_35_manifold_and_its_phase() -> None:
    """(35) holds the sum of the squares of (34) and the angle of its quotient."""
    first, second = (r.right({"C": C}) for r in eq(34).relations[:2])
    assert zero(first**2 + second**2 - eq(35)("B^2", {"C": C}))
    for c in (0.4, 1.3, 5.0):
        env = {**NUMERIC, "C": mpmath.mpf(c), "rho": mpmath.mpf("0.2")}
        b, angle = mpmath.sqrt(eq(35)("B^2", env)), eq(35)("Phi", env)
        assert abs(b * mpmath.sin(angle) - (c - 1)) < 1e-12 and abs(b * mpmath.cos(angle) + 0.2 * c) < 1e-12


def test_eq_36_minimum_of_the_manifold() -> None:
    """(36) is where the derivative of (35) is zero."""
    square = eq(35)("B^2", {"C": C})
    place = sympy.solve(square.diff(C), C)[0]
    assert zero(place - eq(36)("C_min"))
    assert zero(square.subs(C, place) - eq(36)("B_min") ** 2) and square.diff(C, 2).subs(rho, 0) > 0


def test_eq_37_branches_invert_the_manifold() -> None:
    """(37) solves (35) for C, on either side of C_min."""
    square = eq(35)("B^2", {"C": C})
    for key, sign in (("C_L", -1), ("C_R", 1)):
        branch = eq(37)(key, {"B": B})
        assert zero(sympy.expand(square.subs(C, branch) - B**2))
        at = {B: 2, rho: sympy.Rational(1, 5)}
        assert sign * (branch - eq(36)("C_min")).subs(at) > 0


def test_eq_38_slopes_along_the_manifold() -> None:
    """(38) differentiates (35) implicitly."""
    square, angle = eq(35)("B^2", {"C": C}), eq(35)("Phi", {"C": C})
    slope = 2 * B / square.diff(C)  # dC/dB
    m = eq(38)("m", {"C": C})
    values = {r.key: r.right({"B": B, "m": m}) for r in eq(38).relations}
    assert zero(values[r"\frac{\mathrm{d}C}{\mathrm{d}B}"] - slope)
    turn = sympy.simplify(angle.diff(C)) * slope
    assert zero((values[r"\frac{\mathrm{d}\Phi}{\mathrm{d}B}"] - turn).subs(B, sympy.sqrt(square)))


def test_eq_39_68_gap_after_the_impact() -> None:
    """(39) is W of (32) with (34) put in, and (68) has the same form with ρ* and Z*."""
    Phi = sym("Phi")
    Z = sympy.Function("Z")
    W = eq(32)("W", {"eta": phi + Phi, "Z": Z, "C": C, "B": B})
    first, second = (r.right({"C": C}) for r in eq(34).relations[:2])
    expected = sympy.expand_trig(W).expand().subs({B * sympy.sin(Phi): first, B * sympy.cos(Phi): second})
    expected = expected.subs(B * sympy.sin(Phi), first)
    assert zero(expected - eq(39).relations[0].right({"Z": Z, "C": C}))
    assert zero(eq(68).relations[0].right({"Z_ast": Z, "C": C, "rho_ast": rho}) - expected)


def slow_flow(parse: bool) -> Dict[str, Any]:
    """Rates of B, ψ, A3, ψ3: of the page, or derived by balancing first harmonics."""
    known: Dict[str, Any] = {"B": B, "C": C, "A_3": A_3}
    if parse:
        known["chi"] = eq(41)("chi", known)
        rates = [r.right(known) for r in [*eq(40).relations, *eq(41).relations[1:]]]
        return dict(zip(("B", "psi", "A_3", "psi_3"), rates))
    f, g_1, g_3, s_1, s_30 = (sym(n) for n in ("hat_f_10", "hat_gamma_1", "hat_gamma_3", "hat_sigma_1", "hat_sigma_30"))
    alpha, psi, psi_3, Phi = (sym(n) for n in ("hat_alpha", "psi", "psi_3", "Phi"))
    c_1 = first_coefficient()
    # U and X3 of (32) with the phase φ = τ0 + σ1 τ1 - ψ or - ψ3.
    U = eq(32)("U", {"B": B, "eta": eq(32)("eta", {"tau": (phi + psi) / sym("Omega_1")})})
    X_3 = eq(32)("X_3", {"A_3": A_3, "tau": (phi + psi_3) / sym("Omega_1")})
    # Twice the mixed derivative, against the forcing at order ε.
    rate_b, rate_psi, rate_a, rate_psi3 = sympy.symbols("rB rpsi rA rpsi3")
    mixed = 2 * (rate_b * U.diff(B) + (s_1 - rate_psi) * U.diff(phi)).diff(phi)
    forcing = f * sympy.sin(phi + psi) - g_1 * U.diff(phi) + c_1 * C * sympy.cos(phi - Phi)
    first = sympy.solve(harmonic(sympy.expand_trig(mixed - forcing)), [rate_b, rate_psi], dict=True)[0]
    # X2 ≈ C Z(φ + ψ3 - ψ - Φ), with μ13 β² = α.
    mixed = 2 * (rate_a * X_3.diff(A_3) + (s_1 - rate_psi3) * X_3.diff(phi)).diff(phi)
    block = c_1 * C * sympy.cos(phi + psi_3 - psi - Phi)
    forcing = -g_3 * X_3.diff(phi) - s_30 * X_3 - alpha * (X_3 - block)
    second = sympy.solve(harmonic(sympy.expand_trig(mixed - forcing)), [rate_a, rate_psi3], dict=True)[0]
    # (34): B sin Φ = C - 1, B cos Φ = -ρ C.
    manifold = {sympy.sin(Phi): (C - 1) / B, sympy.cos(Phi): -rho * C / B}
    return {
        "B": first[rate_b].subs(manifold),
        "psi": first[rate_psi].subs(manifold),
        "A_3": second[rate_a],
        "psi_3": second[rate_psi3],
    }


def test_eq_32_40_41_slow_flow_from_the_balance_of_harmonics() -> None:
    """The solvability conditions of (30) and of X3's equation in (24) for the form (32) are (40), (41)."""
    page, derived = slow_flow(True), slow_flow(False)
    for key in page:
        assert zero(sympy.expand_trig(page[key]) - derived[key]), key


def test_eq_42_quadratic_by_elimination() -> None:
    """Zeros of (40), with sin² + cos² = 1 and (35), give (42)."""
    flow = slow_flow(True)
    psi, f = sym("psi"), sym("hat_f_10")
    x, y = sym("x"), sym("y")  # f sin ψ, f cos ψ
    rates = [sympy.expand(flow[k]).subs(f * sympy.sin(psi), x).subs(f * sympy.cos(psi), y) for k in ("B", "psi")]
    found = sympy.solve(rates, [x, y], dict=True)[0]
    manifold = eq(35)("B^2", {"C": C})
    left = sympy.expand(((found[x] ** 2 + found[y] ** 2) - f**2)).subs(B, sympy.sqrt(manifold))
    q = eq(42).values()
    assert zero(left - (q["a"] * C**2 + q["b"] * C + q["c"]))


def test_eq_43_44_complex_form() -> None:
    """f̂ e^{iδ} of (43) is what the zeros of (40) say, and its squared modulus (44) is (42)."""
    psi, f = sym("psi"), sym("hat_f_10")
    flow = slow_flow(True)
    x, y = sym("x"), sym("y")
    rates = [sympy.expand(flow[k]).subs(f * sympy.sin(psi), x).subs(f * sympy.cos(psi), y) for k in ("B", "psi")]
    found = sympy.solve(rates, [x, y], dict=True)[0]
    alpha, alpha_0 = eq(43)("alpha"), eq(43)("alpha_0")
    turn = (-rho * C + sympy.I * (C - 1)) / B  # e^{iΦ} by (34)
    force = (found[y] + sympy.I * found[x]) * turn
    force = sympy.expand(force).subs(B, sympy.sqrt(eq(35)("B^2", {"C": C})))
    assert zero(force - eq(43).relations[0].right({"C": C, "alpha": alpha, "alpha_0": alpha_0}))
    modulus: Formula = lambda z: sympy.sqrt(sympy.expand(z * sympy.conjugate(z)))
    both = {"alpha": alpha, "alpha_0": alpha_0, "abs": modulus}
    q = eq(42).values()
    values = {r.key: sympy.expand(sympy.expand(r.right(both)), complex=True) for r in eq(44).relations}
    for key in ("a", "b", "c"):
        assert zero(values[key] - q[key]), key
    assert zero(values["b^2-4ac"] - (q["b"] ** 2 - 4 * q["a"] * q["c"]))


@pytest.mark.parametrize("values", SETS)
def test_eq_45_amplitude_and_phase_of_the_secondary(values: Dict[str, float]) -> None:
    """With (45) and the phases of (43), all four rates of (40), (41) are zero."""
    found = fixed_points(values)
    assert found
    for k in found:
        k["chi"] = evaluated(41, "chi", k)
        for relation in [*eq(40).relations, *eq(41).relations[1:]]:
            assert abs(relation.right({**NUMERIC, **k})) < 1e-12, relation.key


def test_eq_45_fixed_point_of_the_default_set() -> None:
    """(42) and (45) at the default set against an independent solution of (40), (41) by Newton's method."""
    k = numbers(BASIC)

    def rates(b: Any, psi: Any, a: Any, psi_3: Any) -> List[Any]:
        c = evaluated(37, "C_R", {**k, "B": b})
        known = {**k, "B": b, "C": c, "psi": psi, "A_3": a, "psi_3": psi_3, "Phi": evaluated(35, "Phi", {**k, "C": c})}
        known["chi"] = evaluated(41, "chi", known)
        return [r.right({**NUMERIC, **known}) for r in [*eq(40).relations, *eq(41).relations[1:]]]

    b, _, a, _ = mpmath.findroot(rates, (0.4, 0.5, 1.0, 0.5))
    upper = fixed_points(BASIC)[-1]
    assert abs(b - upper["B"]) < 1e-10 and abs(abs(a) - upper["A_3"]) < 1e-10
    assert abs(upper["C"] - mpmath.mpf("1.340127767")) < 1e-9


def test_eq_46_force_and_fold() -> None:
    """(46): the least |αC + α0| over real C lies at C_f and has the given value."""
    alpha, alpha_0 = mpmath.mpc("-0.7", "0.9"), mpmath.mpc("0.4", "1.1")
    known = {"alpha": alpha, "alpha_0": alpha_0}
    values = {r.key: r.right({**NUMERIC, **known, "C": mpmath.mpf("1.7")}) for r in eq(46).relations}
    assert abs(values["f(C)"] - abs(alpha * mpmath.mpf("1.7") + alpha_0)) < 1e-12
    fold = values["C_f"]
    least = mpmath.findroot(lambda c: mpmath.diff(lambda x: abs(alpha * x + alpha_0), c), 0.3)
    assert abs(least - fold) < 1e-8 and abs(abs(alpha * fold + alpha_0) - values["f(C_f)"]) < 1e-12
    assert abs(values["f(0)"] - abs(alpha_0)) < 1e-12


def test_eq_46_56_admissible_range_of_the_default_set() -> None:
    """The force (46) at the limits of (56) is the range the code reports, 0.891 to 2.136."""
    k = numbers(BASIC)
    k["alpha"], k["alpha_0"] = evaluated(43, "alpha", k), evaluated(43, "alpha_0", k)
    low, high = (evaluated(46, "f(C)", {**k, "C": evaluated(56, key, k)}) for key in ("C_Smin", "C_Smax"))
    assert abs(low - 0.891) < 5e-4 and abs(high - 2.136) < 5e-4


@pytest.mark.parametrize("values", SETS)
def test_eq_47_amplitudes_of_block_and_box(values: Dict[str, float]) -> None:
    """A2 of (47) is the largest |X2| of (33); A1's turning points are where its derivative is zero."""
    for k in fixed_points(values):
        k["q_1"] = evaluated(47, "q_1", k)

        def sampled(key: str, at: Any) -> Any:
            Z: Formula = lambda x: eq(31).relations[0].right({**NUMERIC, "varphi": x})
            return eq(33)(key, {**NUMERIC, **k, "Z": Z, "eta": at})

        block = max(abs(sampled("X_2", k["Phi"] + mpmath.pi * i / 50)) for i in range(100))
        assert abs(block - evaluated(47, "A_2", k)) < 1e-12
        for eta in (mpmath.acos(-k["q_1"]), -mpmath.acos(-k["q_1"])):
            since = (eta - k["Phi"]) % (2 * mpmath.pi)
            if since < mpmath.pi:
                slope = mpmath.diff(lambda x: sampled("X_1", x), eta)
                assert abs(slope) < 1e-8


def gap(c: Any, r: Any, at: Any) -> Any:
    Z: Formula = lambda x: eq(31).relations[0].right({**NUMERIC, "varphi": x})
    return eq(39).relations[0].right({**NUMERIC, "C": c, "rho": r, "varphi": at, "Z": Z})


@pytest.mark.parametrize("value", [0.2, 0.75, 1.0])
def test_eq_48_49_geometric_limit(value: float) -> None:
    """(48) is the maximum of (39) over the half period; below (49) there is none inside."""
    k = numbers({"kappa": value})

    def maximum(c: Any) -> Any:
        known = {**k, "C": c}
        known["B"], known["Phi"] = mpmath.sqrt(evaluated(35, "B^2", known)), evaluated(35, "Phi", known)
        values = eq(48).values({**NUMERIC, **known})
        return values["W_max"], values["q_m"]

    turning = evaluated(49, "C_t", k)
    assert abs(maximum(turning)[1] - 1) < 1e-10
    # W(φ) + W(π-φ) = 2ρC sin φ.
    for x in (0.4, 1.9):
        total = gap(2, k["rho"], mpmath.mpf(x)) + gap(2, k["rho"], mpmath.pi - x)
        assert abs(total - 4 * k["rho"] * mpmath.sin(x)) < 1e-12
    for c in (turning * mpmath.mpf("1.05"), turning * 2, mpmath.mpf(6), mpmath.mpf(9)):
        samples = [gap(c, k["rho"], mpmath.pi * i / 1000) for i in range(1001)]
        inner = max(range(1, 1000), key=lambda i: samples[i] if samples[i] >= samples[i - 1] and samples[i] >= samples[i + 1] else -99)
        assert abs(maximum(c)[0] - samples[inner]) < 1e-4
        below = turning * mpmath.mpf("0.97")
        assert all(gap(below, k["rho"], mpmath.pi * i / 200) <= 1 + 1e-12 for i in range(201))
    if value == 0.75:
        limit = mpmath.findroot(lambda c: maximum(c)[0] - 1, 6)
        assert abs(limit - 6.07) < 5e-3  # the paper says 6.07, and B = 5.1 there
        assert abs(mpmath.sqrt(evaluated(35, "B^2", {**k, "C": limit})) - 5.10) < 5e-3


def jacobian() -> Tuple[sympy.Matrix, Dict[Any, Any]]:
    """The derivative of (40), (41) with C and Φ functions of B."""
    flow = slow_flow(True)
    Phi = sym("Phi")
    C_B, Phi_B = sym("C_B"), sym("Phi_B")
    names = [("B", B), ("psi", sym("psi")), ("A_3", A_3), ("psi_3", sym("psi_3"))]
    matrix = sympy.zeros(4)
    for i, (row, _) in enumerate(names):
        for j, (_, variable) in enumerate(names):
            matrix[i, j] = flow[row].diff(variable)
        matrix[i, 0] += flow[row].diff(C) * C_B + flow[row].diff(Phi) * Phi_B
    return matrix, {"C_B": C_B, "Phi_B": Phi_B}


def test_eq_50_jacobian_by_differentiation() -> None:
    """(50) holds all entries of the derivative of (40), (41) that are not zero."""
    derived, _ = jacobian()
    given = {r.key: r.right({"B": B, "C": C, "A_3": A_3, "chi": eq(41)("chi")}) for r in eq(50).relations}
    assert len(given) == 12
    for i in range(4):
        for j in range(4):
            assert zero(derived[i, j] - given.get(f"J_{i + 1}{j + 1}", 0)), (i, j)


@pytest.mark.parametrize("values", SETS)
def test_eq_51_eigenvalues_in_closed_form(values: Dict[str, float]) -> None:
    """(51) gives trace and determinant of the blocks of (50) at the fixed points."""
    found = fixed_points(values)
    assert found
    for k in found:
        k["m"] = evaluated(38, "m", k)
        k["C_B"], k["chi"] = k["B"] / k["m"], evaluated(41, "chi", k)
        k["Phi_B"] = -k["rho"] * k["C_B"] / k["B"] ** 2
        J = {r.key: r.right({**NUMERIC, **k}) for r in eq(50).relations}
        k.update({x: evaluated(44, x, k) for x in ("a", "b")})
        assert abs(J["J_11"] + J["J_22"] - evaluated(51, "t_1", k)) < 1e-10
        assert abs(J["J_11"] * J["J_22"] - J["J_12"] * J["J_21"] - evaluated(51, "d_1", k)) < 1e-10
        third = evaluated(51, "Lambda_3", k)
        assert abs(J["J_33"] + J["J_44"] - 2 * third.real) < 1e-10
        assert abs(J["J_33"] * J["J_44"] - J["J_34"] * J["J_43"] - abs(third) ** 2) < 1e-10


def block_map(known: Dict[str, Any], shift: Any, speed: Any) -> Tuple[Any, Any]:
    """The next impact of a block that leaves the upper stop, from even flight and the impact law of (27) as ε → 0."""
    b, angle, restitution = known["B"], known["Phi"], known["kappa"]
    U: Formula = lambda x: b * mpmath.sin(x)
    begin = angle + shift
    end = mpmath.findroot(lambda x: U(begin) + 1 - speed * (x - begin) - (U(x) - 1), angle + mpmath.pi)
    velocity = (1 + restitution) * b * mpmath.cos(end) + restitution * speed
    return end - angle - mpmath.pi, velocity


def test_eq_52_block_between_two_impacts() -> None:
    """(52) holds for the block followed from the upper to the lower stop."""
    k = fixed_points(BASIC)[-1]
    for shift, change in ((0.02, 0.01), (-0.03, 0.04)):
        speed = 2 * k["C"] / mpmath.pi + change
        at, after = block_map(k, mpmath.mpf(shift), speed)
        known = {**k, "vartheta": mpmath.mpf(shift), "vartheta_1": at, "V": speed,
                 "U": lambda x: k["B"] * mpmath.sin(x), "Up": lambda x: k["B"] * mpmath.cos(x)}  # fmt: skip
        position, velocity = eq(52).relations
        assert abs(position.left({**NUMERIC, **known}) - position.right({**NUMERIC, **known})) < 1e-12
        assert abs(velocity.right({**NUMERIC, **known}) - after) < 1e-12


def derived_d() -> sympy.Matrix:
    """(52) linearized about the symmetric motion."""
    Phi = sym("Phi")
    shift, next_shift, speed = sym("vartheta"), sym("vartheta_1"), sym("V")
    env = {"U": lambda x: B * sympy.sin(x), "Up": lambda x: B * sympy.cos(x), "C": C}
    position, velocity = eq(52).relations
    residual = position.left(env) - position.right(env)
    # sin(Φ + 0) and cos(Φ + 0) by (34); C/(1+κ) and ρ by its definition.
    steady = {shift: 0, next_shift: 0, speed: 2 * C / pi}
    manifold = {sympy.sin(Phi): (C - 1) / B, sympy.cos(Phi): -eq(34)("rho") * C / B}
    slope = {v: residual.diff(v).subs(steady).subs(manifold) for v in (shift, next_shift, speed)}
    first = [-slope[shift] / slope[next_shift], -slope[speed] / slope[next_shift]]
    after = velocity.right(env)
    pull = after.diff(next_shift).subs(steady).subs(manifold)
    second = [pull * first[0], pull * first[1] + after.diff(speed)]
    return sympy.Matrix([first, second])


def test_eq_53_54_matrix_d_derived() -> None:
    """(52) linearized is the matrix (53), with determinant and trace (54)."""
    h = eq(53)("h", {"C": C})
    D = eq(53)("D", {"C": C, "h": h})
    assert zero(D - derived_d())
    values = {r.key: r.right({"C": C}) for r in eq(54).relations}
    assert zero(D.det() - values[r"\detD"]) and zero(D.trace() - values[r"\mathrm{tr}D"])


def test_eq_53_matrix_d_by_differences() -> None:
    """(53) against differences of the block's map, followed without linearization."""
    k = fixed_points(BASIC)[-1]
    k["h"] = evaluated(53, "h", k)
    D = eq(53)("D", {**NUMERIC, **k, "matrix": mpmath.matrix})
    step, speed = mpmath.mpf(10) ** -5, 2 * k["C"] / mpmath.pi
    for j, (dx, dv) in enumerate(((step, 0), (0, step))):
        up, down = block_map(k, dx, speed + dv), block_map(k, -dx, speed - dv)
        for i in range(2):
            assert abs((up[i] - down[i]) / (2 * step) - D[i, j]) < 1e-7


def test_eq_55_jury_conditions() -> None:
    """(55) says whether both eigenvalues of a 2 × 2 matrix lie in the unit circle."""
    for trace in (-2.5, -1.75, -0.4, 0.6, 1.3, 2.2):
        for determinant in (-1.2, -0.5, 0.2, 0.7, 1.1):
            root = mpmath.sqrt(mpmath.mpc(trace**2 / 4 - determinant))
            inside = all(abs(trace / 2 + s * root) < 1 for s in (1, -1))
            # |det| < 1 follows from both: |tr| < 1 + det has det > -1.
            text = [(r.sign, "".join(r.left_tokens), r.right_tokens) for r in eq(55).relations]
            assert [t[0] for t in text] == ["<", "<"] and text[0][2] == ("1",)
            assert "".join(text[1][2]) == r"1+\detD" and text[1][1] == r"\lvert\mathrm{tr}D\rvert"
            assert inside == (determinant < 1 and abs(trace) < 1 + determinant), (trace, determinant)


def test_eq_56_limits_of_stable_periodic_motion() -> None:
    """At (56) the multipliers of (54) pass +1 and -1."""
    trace, determinant = derived_d().trace(), derived_d().det()
    saddle = sympy.solve(sympy.simplify(1 - trace + determinant), C)
    breaking = sympy.solve(sympy.simplify(1 + trace + determinant), C)
    assert len(saddle) == len(breaking) == 1
    limit = eq(56)("C_Smin", {"rho": eq(34)("rho")})
    assert zero(saddle[0] - limit) and zero(breaking[0] - eq(56)("C_Smax"))
    assert zero(eq(56)("C_Smin") - eq(36)("C_min"))
    assert abs(float(limit.subs(kappa, 0.75)) - 0.9918) < 5e-6 and abs(float(eq(56)("C_Smax")) - 1.6815) < 5e-5


def test_eq_57_masri_plane() -> None:
    """Both forms of (57) agree by (21), and ζ is the box's damping ratio."""
    force = sympy.solve(sym("hat_f_10") - eq(21)("hat_f_10"), sym("F_10"))[0]
    values = [r.right({"F_10": force}) for r in eq(57).relations if r.key == "xi_M"]
    assert len(values) == 2 and zero(values[0] - values[1])
    m, k, c = (sympy.Symbol(n, positive=True) for n in ("m_1", "k_1", "c_1"))
    frequency = eq(20)("omega_10", {"m_1": m, "k_1": k})
    ratio = c / (2 * sympy.sqrt(k * m))
    group = eq(21)("hat_gamma_1", {"m_1": m, "c_1": c, "omega_10": frequency})
    assert zero(eq(57)("hat_gamma_1", {"zeta": ratio}) - group)
