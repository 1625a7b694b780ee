"""Shared by the checks of sections 6 and 7: symbols, parameter sets, fixed points, the slow flow."""

from typing import Any, Dict, List, Tuple

import mpmath
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
