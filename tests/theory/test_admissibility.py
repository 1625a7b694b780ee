"""Section 7: the three tests of a fixed point."""

from typing import Any, Dict, Tuple

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
    fixed_points,
    kappa,
    numbers,
    pi,
    rho,
    slow_flow,
)
from equations import Formula, eq, sym, zero


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
