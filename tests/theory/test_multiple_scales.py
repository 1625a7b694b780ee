"""Section 6: multiple scales."""

from typing import Any, Dict, List

import mpmath
import pytest
import sympy
from approximation import (
    A_3,
    B,
    BASIC,
    C,
    NUMERIC,
    SETS,
    evaluated,
    first_coefficient,
    fixed_points,
    kappa,
    numbers,
    phi,
    pi,
    rho,
    slow_flow,
)
from equations import Formula, eq, sym, zero


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
    # At ε = 0 both are free oscillations; the right sides of (30) and (24) have the factor ε or are
    # -X3.
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
    """(39) is W of (32) with (34) inserted, and (68) has the same form with ρ* and Z*."""
    Phi = sym("Phi")
    Z = sympy.Function("Z")
    W = eq(32)("W", {"eta": phi + Phi, "Z": Z, "C": C, "B": B})
    first, second = (r.right({"C": C}) for r in eq(34).relations[:2])
    expected = sympy.expand_trig(W).expand().subs({B * sympy.sin(Phi): first, B * sympy.cos(Phi): second})
    expected = expected.subs(B * sympy.sin(Phi), first)
    assert zero(expected - eq(39).relations[0].right({"Z": Z, "C": C}))
    assert zero(eq(68).relations[0].right({"Z_ast": Z, "C": C, "rho_ast": rho}) - expected)


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
