"""Section 8: strong coupling."""

from typing import Any, Dict, List, Tuple

import mpmath
import pytest
import sympy
from equations import Formula, eq, sym, zero
from approximation import NUMERIC, numbers

phi = sympy.Symbol("varphi", real=True)
beta, kappa = sympy.Symbol("beta", positive=True), sym("kappa")
C = sympy.Symbol("C", positive=True)
pi = sympy.pi
SETS: List[Dict[str, float]] = [
    {"kappa": 0.75, "hat_f_10": 1.5, "hat_sigma_1": 0.4, "hat_gamma_1": 1.0, "hat_sigma_30": 0.5, "hat_gamma_3": 0.6,
     "mu_13": 1.0, "beta": 0.55, "sheet": 1},
    {"kappa": 0.3, "hat_f_10": 2.5, "hat_sigma_1": -0.2, "hat_gamma_1": 0.7, "hat_sigma_30": 0.1, "hat_gamma_3": 0.3,
     "mu_13": 0.8, "beta": 1.4, "sheet": 0},
]  # fmt: skip


def evaluated(number: int, key: str, known: Dict[str, Any]) -> Any:
    return eq(number)(key, {**NUMERIC, **known})


def point(values: Dict[str, float]) -> Dict[str, Any]:
    """One steady state by the formulas of the page."""
    k = {name: mpmath.mpf(value) for name, value in values.items()}
    for key in ("nu", "rho_ast", "q", "c_1"):
        k[key] = evaluated(60, key, k)
    k["xi"] = evaluated(62, "xi", k)
    for key in ("alpha", "alpha_0"):
        k[key] = evaluated(64, key, k)
    a, b, c = (evaluated(44, key, k) for key in ("a", "b", "c"))
    sign = 1 if values["sheet"] == 1 else -1
    k["C"] = (-b + sign * mpmath.sqrt(b * b - 4 * a * c)) / (2 * a)
    k["delta"] = mpmath.arg(k["alpha"] * k["C"] + k["alpha_0"])
    k["y"], k["y_3"] = evaluated(63, "y", k), k["xi"] * k["C"]
    return k


def z_ast(k: Dict[str, Any], at: Any) -> Any:
    """Z* at any phase: (59) on [0, π], its negative half a period later."""
    at = at % (2 * mpmath.pi)
    sign = 1 if at <= mpmath.pi else -1
    return sign * eq(59).relations[0].right({**NUMERIC, **k, "varphi": at if sign > 0 else at - mpmath.pi})


def block(k: Dict[str, Any], at: Any) -> Any:
    """X2 at the phase since the upper impact."""
    third = mpmath.im(k["y_3"] * mpmath.expjpi(at / mpmath.pi))
    return evaluated(61, "X_2", {**k, "varphi": at, "X_3": third, "Z_ast": lambda x: z_ast(k, x)})


def test_eq_59_modified_sawtooth() -> None:
    """(59) swings with β from 1 to -1 over half a period, becomes Z of (31), and continues as the page says."""
    z = eq(59).relations[0].right({"beta": beta})
    assert zero(z.diff(phi, 2) + beta**2 * z)
    assert zero(z.subs(phi, 0) - 1) and zero(z.subs(phi, pi) + 1)
    assert zero(sympy.limit(z, beta, 0) - (1 - 2 * phi / pi))
    k = {"beta": mpmath.mpf("0.6")}
    for x in (0.4, 2.0, 3.5, 5.9):
        sawtooth = eq(31).relations[0].right({**NUMERIC, "varphi": mpmath.mpf(x)})
        assert abs(mpmath.sin(mpmath.mpf("0.3") * mpmath.pi * sawtooth) / mpmath.sin(mpmath.mpf("0.3") * mpmath.pi) - z_ast(k, x)) < 1e-12


def test_eq_60_slope_restitution_response_and_coefficient() -> None:
    """(60): slope and Fourier coefficient of (59), ρ* of the restitution rule, q of the swing with X3."""
    z = eq(59).relations[0].right({"beta": beta})
    nu = eq(60)("nu", {"beta": beta})
    assert zero(z.diff(phi).subs(phi, 0) + nu)
    # C Z* + Im(r e^{iφ}) has the slopes -νC + Re r after and νC + Re r before the impact; Re r = ρ*
    # C.
    r = sym("r")
    found = sympy.solve((-nu * C + r) + kappa * (nu * C + r), r)[0]
    assert zero(found - C * eq(60)("rho_ast", {"nu": nu}))
    q = eq(60)("q", {"beta": beta})
    third = sympy.sin(phi + sympy.Rational(1, 3))
    assert zero(q * third.diff(phi, 2) + beta**2 * (q * third - third))
    for value in ("0.55", "1.4", "2.5"):
        number = mpmath.mpf(value)
        integral = 2 / mpmath.pi * mpmath.quad(lambda x: z_ast({"beta": number}, x) * mpmath.cos(x), [0, mpmath.pi])
        known = {"beta": number, "nu": evaluated(60, "nu", {"beta": number})}
        assert abs(integral - evaluated(60, "c_1", known)) < 1e-12
    assert zero(sympy.limit(nu, beta, 0) - 2 / pi)
    assert zero(sympy.limit(eq(60)("c_1", {"beta": beta, "nu": nu}), beta, 0) - 8 / pi**2)


@pytest.mark.parametrize("values", SETS)
def test_eq_61_63_68_block_meets_its_equation_and_the_impact_law(values: Dict[str, float]) -> None:
    """X2 of (61) obeys (24) between the impacts, W of (61), (63) contact and restitution, and (68) is that W."""
    k = point(values)
    U: Formula = lambda x: mpmath.im(k["y"] * mpmath.expjpi(x / mpmath.pi))
    W: Formula = lambda x: evaluated(61, "W", {"X_2": block(k, x), "U": U(x)})
    for x in (0.7, 1.6, 2.8):
        third = mpmath.im(k["y_3"] * mpmath.expjpi(x / mpmath.pi))
        expected = evaluated(24, "X_2pp", {**k, "X_2": block(k, x), "X_3": third})
        assert abs(mpmath.diff(lambda v: block(k, v), x, 2) - expected) < 1e-6
        given = eq(68).relations[0].right({**NUMERIC, **k, "varphi": mpmath.mpf(x), "Z_ast": lambda v: z_ast(k, v)})
        assert abs(W(x) - given) < 1e-12
    assert abs(W(mpmath.mpf(0)) - 1) < 1e-12
    after = mpmath.diff(W, mpmath.mpf(0), direction=1, h=mpmath.mpf(10) ** -10)
    before = mpmath.diff(W, mpmath.mpf(0), direction=-1, h=mpmath.mpf(10) ** -10)
    assert abs(after + k["kappa"] * before) < 1e-7
    manifold = eq(63).relations[1]
    assert abs(manifold.left({**NUMERIC, **k}) - manifold.right({**NUMERIC, **k})) < 1e-12


def projected(function: Any) -> Any:
    """The phasor of a function's first harmonic, z of Im(z e^{iφ}), by quadrature over the half periods."""
    pieces = [-mpmath.pi, 0, mpmath.pi]
    return 1j / mpmath.pi * mpmath.quad(lambda x: function(x) * mpmath.expjpi(-x / mpmath.pi), pieces)


@pytest.mark.parametrize("values", SETS)
def test_eq_62_64_balance_of_harmonics(values: Dict[str, float]) -> None:
    """The first harmonics of (30) and of X3's equation in (24), by quadrature, are balanced by (62) and (64)."""
    k = point(values)
    x_2 = projected(lambda x: block(k, x))
    s, b2 = k["hat_sigma_1"], k["beta"] ** 2
    third = (k["hat_sigma_30"] - 2 * s + 1j * k["hat_gamma_3"]) * k["y_3"] + k["mu_13"] * b2 * (k["y_3"] - x_2)
    assert abs(third) < 1e-10
    force = k["hat_f_10"] * mpmath.expjpi(k["delta"] / mpmath.pi)
    assert abs(force - eq(64).relations[0].right({**NUMERIC, **k})) < 1e-12
    first = (-2 * s + 1j * k["hat_gamma_1"]) * k["y"] - force - (x_2 - b2 * (x_2 - k["y_3"]))
    assert abs(first) < 1e-10


def test_eq_60_62_63_64_limit_without_coupling() -> None:
    """At β = 0 the ν, ρ* of (60), ξ of (62), α, α0 of (64) and the phasor (63) agree with section 6, (34) and (43)."""
    known = {"beta": beta}
    nu = sympy.limit(eq(60)("nu", known), beta, 0)
    rho = eq(60)("rho_ast", {"nu": nu})
    assert zero(rho - eq(34)("rho"))
    assert eq(62)("xi", {"beta": 0, "c_1": 8 / pi**2, "q": 0}) == 0
    limit = {"rho_ast": rho, "rho": rho, "q": 0, "xi": 0, "nu": nu}
    # (34): U = B sin(φ + Φ) has the phasor B cos Φ + i B sin Φ.
    first, second = (r.right() for r in eq(34).relations[:2])
    assert zero(sympy.expand(eq(63)("y", limit) - (second.subs(sym("rho"), rho) + sympy.I * first)))
    for key in ("alpha", "alpha_0"):
        assert zero(sympy.expand(eq(64)(key, limit) - eq(43)(key, limit))), key


@pytest.mark.parametrize("values", SETS)
def test_eq_65_slow_flow_of_phasors(values: Dict[str, float]) -> None:
    """(65) from the harmonics of (30), (24) away from the steady state, and zero at it."""
    k = point(values)
    steady = {**k, "k": k["C"] * mpmath.expjpi(-k["delta"] / mpmath.pi)}
    turn = mpmath.expjpi(-k["delta"] / mpmath.pi)
    at = {**steady, "y": k["y"] * turn, "y_3": k["y_3"] * turn}
    assert all(abs(r.right({**NUMERIC, **at})) < 1e-12 for r in eq(65).relations)
    # Anywhere: U = Im(y e^{iΩ1τ}) gives U'' + U = ε Im((2i y' - 2σ1 y) e^{iΩ1τ}) + O(ε²); X2 = |k|
    # Z*(φ) + q X3.
    y, y_3, c, late = mpmath.mpc("0.3", "-0.8"), mpmath.mpc("1.1", "0.2"), mpmath.mpf("1.2"), mpmath.mpf("0.4")
    slaved = c * mpmath.expjpi(-late / mpmath.pi)
    swing = {**k, "C": c, "y_3": y_3 * mpmath.expjpi(late / mpmath.pi)}
    x_2 = projected(lambda x: block(swing, x)) * mpmath.expjpi(-late / mpmath.pi)
    b2, s = k["beta"] ** 2, k["hat_sigma_1"]
    right = k["hat_f_10"] - 1j * k["hat_gamma_1"] * y + x_2 - b2 * (x_2 - y_3)
    first = (right + 2 * s * y) / 2j
    right = -1j * k["hat_gamma_3"] * y_3 - k["hat_sigma_30"] * y_3 - k["mu_13"] * b2 * (y_3 - x_2)
    second = (right + 2 * s * y_3) / 2j
    env = {**NUMERIC, **k, "y": y, "y_3": y_3, "k": slaved}
    assert abs(eq(65).relations[0].right(env) - first) < 1e-10
    assert abs(eq(65).relations[1].right(env) - second) < 1e-10


def test_eq_66_slaved_amplitude() -> None:
    """(66) is the derivative of k = C e^{-iδ} where y - q y3 = (C(-ρ* + i) - i) e^{-iδ}, at δ = 0."""
    rho, delta = sym("rho_ast"), sym("delta")
    c = sym("C")
    difference = (c * (-rho + sympy.I) - sympy.I) * sympy.exp(-sympy.I * delta)
    slaved = c * sympy.exp(-sympy.I * delta)

    def slopes(z: Any) -> sympy.Matrix:
        parts = [sympy.re(sympy.expand(z.diff(v).subs(delta, 0))) for v in (c, delta)]
        parts += [sympy.im(sympy.expand(z.diff(v).subs(delta, 0))) for v in (c, delta)]
        return sympy.Matrix(2, 2, parts)

    assert zero(eq(66)("P") - slopes(slaved) * slopes(difference).inv())


def next_impact(k: Dict[str, Any], shift: Any, change: Any) -> Tuple[Any, Any]:
    """Block from just after the upper impact to just after the lower, U and X3 held: (position - U, speed) folded."""
    b, r = k["beta"], k["q"]
    U: Formula = lambda x: mpmath.im(k["y"] * mpmath.expjpi(x / mpmath.pi))
    dU: Formula = lambda x: mpmath.re(k["y"] * mpmath.expjpi(x / mpmath.pi))
    X: Formula = lambda x: r * mpmath.im(k["y_3"] * mpmath.expjpi(x / mpmath.pi))
    dX: Formula = lambda x: r * mpmath.re(k["y_3"] * mpmath.expjpi(x / mpmath.pi))
    # In phase and block velocity after the impact; the steady velocity by restitution.
    start = U(shift) + 1 - X(shift)
    speed = -k["nu"] * k["C"] + dX(0) + change - dX(shift)
    own: Formula = lambda x: start * mpmath.cos(b * (x - shift)) + speed * mpmath.sin(b * (x - shift)) / b
    rate: Formula = lambda x: -start * b * mpmath.sin(b * (x - shift)) + speed * mpmath.cos(b * (x - shift))
    end = mpmath.findroot(lambda x: own(x) + X(x) - U(x) + 1, mpmath.pi)
    before = rate(end) + dX(end)
    after = dU(end) - k["kappa"] * (before - dU(end))
    steady = -(-k["nu"] * k["C"] + dX(0))
    return end - mpmath.pi, -(after - steady)


@pytest.mark.parametrize("values", SETS)
def test_eq_67_half_cycle_map_by_differences(values: Dict[str, float]) -> None:
    """Trace and determinant (67) against differences of the block's map, followed without linearization."""
    k = point(values)
    assert all(abs(x) < 1e-12 for x in next_impact(k, mpmath.mpf(0), 0))
    step = mpmath.mpf(10) ** -5
    columns = []
    for dx, dv in ((step, 0), (0, step)):
        up, down = next_impact(k, dx + mpmath.mpf(0), dv), next_impact(k, -dx + mpmath.mpf(0), -dv)
        columns.append([(a - b) / (2 * step) for a, b in zip(up, down)])
    (a, c), (b, d) = columns
    page = {r.key: r for r in eq(67).relations}
    known = dict(k)
    x_2 = page["X_2(0)"].right({**NUMERIC, **k})
    assert abs(x_2 - block(k, mpmath.mpf(0))) < 1e-12
    known["X_2"] = lambda phase: x_2 if phase == 0 else None
    for key in ("b_w", "Wp_minus"):
        known[key] = page[key].right({**NUMERIC, **known})
    trace, determinant = (page[key].right({**NUMERIC, **known}) for key in (r"\mathrm{tr}", r"\det"))
    assert abs(a + d - trace) < 1e-7 and abs(a * d - b * c - determinant) < 1e-7


def test_eq_54_67_limit_without_coupling() -> None:
    """At β → 0 the trace of (67) is the trace of (54)."""
    k = numbers({"kappa": 0.75})
    k.update(beta=mpmath.mpf("1e-7"), C=mpmath.mpf("1.4"), y_3=mpmath.mpc(0), q=mpmath.mpf(0))
    k["nu"] = evaluated(60, "nu", k)
    x_2 = eq(67).relations[0].right({**NUMERIC, **k})
    k["X_2"] = lambda _: x_2
    for key in ("b_w", "Wp_minus"):
        k[key] = evaluated(67, key, k)
    assert abs(evaluated(67, r"\mathrm{tr}", k) - evaluated(54, r"\mathrm{tr}D", k)) < 1e-10
