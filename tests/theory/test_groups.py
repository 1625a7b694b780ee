"""Sections 4 and 5: dimensionless groups, centre-of-mass coordinates."""

from typing import Any, Dict

import sympy
from equations import eq, sym, zero

POSITIVE = "m_1 m_2 m_3 k_1 k_3 k_23 c_1 c_3 L F_10 omega_1".split()


def si() -> Dict[str, Any]:
    """SI parameters as positive symbols, and the box's frequency."""
    p: Dict[str, Any] = {name: sympy.Symbol(name, positive=True) for name in POSITIVE}
    p["omega_10"] = eq(20)("omega_10", p)
    return p


def groups() -> Dict[str, Any]:
    """All groups as functions of the SI parameters."""
    p = si()
    first = eq(21).values(p)
    second = eq(22).relations
    beta2 = second[0].right({**p, **first})
    found = {**first, "beta2": beta2, "hat_alpha_23": beta2 / first["varepsilon"]}
    assert zero(eq(22)("hat_alpha_23", {**first, "beta": sympy.sqrt(beta2)}) - found["hat_alpha_23"])
    for key in ("hat_sigma_30", "hat_gamma_3", "mu_13"):
        found[key] = eq(22)(key, {**p, **first})
    return {**found, "beta": sympy.sqrt(beta2)}


def test_eq_20_21_22_24_flight_in_dimensionless_form() -> None:
    """(3) in the units of (20) with the groups (21), (22) is (24)."""
    p, g = si(), groups()
    omega_10, L = p["omega_10"], p["L"]
    tau = sym("tau")
    x = {f"X_{i}": sym(f"X_{i}") for i in (1, 2, 3)}
    x.update({f"X_{i}p": sym(f"X_{i}p") for i in (1, 2, 3)})
    # x = L X, d/dt = ω10 d/dτ, ω1 t = Ω1 τ.
    env: Dict[str, Any] = {**p, "lambda": 0, "f_1": 0, "f_2": 0, "f_3": 0}
    for i in (1, 2, 3):
        env[f"x_{i}"], env[f"dot_x_{i}"] = L * x[f"X_{i}"], L * omega_10 * x[f"X_{i}p"]
        assert zero(eq(20)("X_i", {"x_i": env[f"x_{i}"], "L": L}) - x[f"X_{i}"])
    time = tau / omega_10
    assert zero(eq(20)("tau", {"omega_10": omega_10, "t": time}) - tau)
    env["theta"] = eq(4)("theta", {**p, "t": time, "theta_0": 0})
    for i, relation in enumerate(eq(3).relations, 1):
        expected = sympy.solve(relation.left(env) - relation.right(env), sym(f"ddot_x_{i}"))[0] / (L * omega_10**2)
        assert zero(eq(24)(f"X_{i}pp", {**g, **x, "tau": tau}) - expected), i
    assert zero(g["Omega_1"] - p["omega_1"] / omega_10)


def test_eq_23_groups_to_si_and_back() -> None:
    """(23) undoes (21), (22)."""
    p, g = si(), groups()
    env = {**g, **{k: p[k] for k in ("m_1", "k_1", "L", "omega_10")}}
    back = {}
    for relation in eq(23).relations:
        env[relation.key] = back[relation.key] = relation.right(env)
    assert set(back) == {"m_2", "m_3", "c_1", "k_3", "c_3", "k_23", "F_10", "omega_1"}
    for name, value in back.items():
        assert zero(value - p[name]), name


def test_eq_25_26_weak_parametrization() -> None:
    """The third of (25) follows from the others; with these masses (26) is the group of (22)."""
    p, g = si(), groups()
    weak = {"m_3": p["m_2"]}
    assert zero((g["mu_13"] - eq(25)("mu_13", g)).subs(p["m_3"], p["m_2"]))
    assert zero(g["beta2"] - eq(25)(r"\beta^2", g))
    assert zero(p["k_23"] - eq(25)("k_23", {**g, **p, **weak}))
    assert zero((eq(26)("hat_alpha", g) - g["hat_alpha_23"]).subs(p["m_3"], p["m_2"]))


def test_eq_27_impact_in_dimensionless_form() -> None:
    """(11) in the units of (20) is (27), at either stop."""
    p, g = si(), groups()
    speed = p["L"] * p["omega_10"]
    for s in (1, -1):
        env: Dict[str, Any] = {**p, "m_r": eq(10)("m_r", p), "s": s}
        env["v"] = eq(10)("v", {"s": s, "dot_w_minus": speed * sym("Wp_minus")})
        for i in (1, 2):
            env[f"dot_x_{i}_minus"] = speed * sym(f"X_{i}p_minus")
            expected = eq(11)(f"dot_x_{i}_plus", env) / speed
            assert zero(eq(27)(f"X_{i}p_plus", g) - expected), (i, s)


def test_eq_28_centre_of_mass_coordinates() -> None:
    """The halves of (28) undo each other, and U' is continuous at the impact (27)."""
    U, W = eq(28)("U"), eq(28)("W")
    assert zero(eq(28)("X_1", {"U": U, "W": W}) - sym("X_1"))
    assert zero(eq(28)("X_2", {"U": U, "W": W}) - sym("X_2"))
    after = eq(28)("U", {"X_1": eq(27)("X_1p_plus"), "X_2": eq(27)("X_2p_plus")})
    before = eq(28)("U", {"X_1": sym("X_1p_minus"), "X_2": sym("X_2p_minus")})
    assert zero(after - before)


def test_eq_29_expansion_of_the_inverse() -> None:
    """(29) is (28) with 1/(1+ε) to second order: exact but for terms of order ε³."""
    e = sym("varepsilon")
    for key in ("X_1", "X_2"):
        difference = sympy.expand(sympy.series(eq(28)(key) - eq(29)(key), e, 0, 3).removeO())
        assert difference == 0, (key, difference)


def test_eq_30_equation_of_the_centre_of_mass() -> None:
    """(24) gives (30) without approximation."""
    e = sym("varepsilon")
    acceleration = eq(24)("X_1pp") + e * eq(24)("X_2pp")
    U = eq(28)("U")
    assert zero(acceleration + U - eq(30).relations[0].right())
    assert eq(30).relations[0].key == "U''+U"
