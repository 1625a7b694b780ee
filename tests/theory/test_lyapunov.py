"""Section 11: variations and Lyapunov exponents."""

from typing import Any, Dict, List

import mpmath
import pytest
import sympy
from equations import eq, sym, zero
from simulation import DIGITS, Parameters, basic, differences, flight, other, run, strike
from approximation import NUMERIC

STEP = mpmath.mpf(10) ** -9


def start(p: Parameters) -> List[Any]:
    return [mpmath.mpf("0.1"), mpmath.mpf("0.5"), mpmath.mpf("-0.2"), mpmath.mpf("0.3"), mpmath.mpf("1.4"), mpmath.mpf("0.1"),
            mpmath.mpf("0.4")]  # fmt: skip


def test_eq_82_variation_of_the_phase() -> None:
    """(82) differentiates cos θ and sin θ."""
    theta = sym("theta")
    first, second = eq(82).relations
    assert "".join(first.left_tokens) == r"\delta\cos\theta" and "".join(second.left_tokens) == r"\delta\sin\theta"
    assert zero(first.right() - sympy.cos(theta).diff(theta) * sym("delta_theta"))
    assert zero(second.right() - sympy.sin(theta).diff(theta) * sym("delta_theta"))


def test_eq_83_centre_of_mass() -> None:
    """(83) is the centre of mass of box and block up to a constant share, its halves undo each other, impacts keep its rate."""
    m_1, m_2 = sym("m_1"), sym("m_2")
    m_r = {"m_r": eq(10)("m_r")}
    centre = eq(83)("x_c", m_r)
    x_2 = sym("x_1") + sym("w")
    assert zero(centre - (m_1 * sym("x_1") + m_2 * x_2) / (m_1 + m_2))
    assert zero(eq(83)("x_1", {**m_r, "x_c": centre}) - sym("x_1"))
    for s in (1, -1):
        v = eq(10)("v", {"s": s, "dot_w_minus": sym("dot_w")})
        after = eq(11)("dot_x_1_plus", {**m_r, "v": v, "s": s, "dot_x_1_minus": sym("dot_x_1")})
        late = eq(83)("x_c", {**m_r, "x_1": after, "w": eq(9)("dot_w_plus", {"dot_w_minus": sym("dot_w")})})
        assert zero(late - eq(83)("x_c", {**m_r, "x_1": sym("dot_x_1"), "w": sym("dot_w")}))


def coordinates(p: Parameters, z: List[Any]) -> Dict[str, Any]:
    """A variation's x_c, w, x3 and rates."""
    m = p["m_1"] + p["m_2"]
    return {"x_c": (p["m_1"] * z[0] + p["m_2"] * z[1]) / m, "w": z[1] - z[0], "x_3": z[2],
            "dot_x_c": (p["m_1"] * z[3] + p["m_2"] * z[4]) / m, "dot_w": z[4] - z[3], "dot_x_3": z[5],
            "theta": z[6]}  # fmt: skip


@pytest.mark.parametrize("p", [basic(), other()], ids=["basic", "other"])
def test_eq_84_jump_of_variations_by_differences(p: Parameters) -> None:
    """(84) against differences of flight, impact and flight back, for all seven directions, at either stop."""
    with mpmath.workdps(DIGITS):
        found = run(p, start(p), mpmath.mpf(12))
        sides = set()
        for _, before, after in found.impacts[:3]:
            side = mpmath.sign(before[4] - before[3])
            sides.add(int(side))
            early = mpmath.mpf("0.001")

            def through(x: List[Any]) -> List[Any]:
                z = flight(p, x, -early)
                hit = mpmath.findroot(lambda t: (lambda y: side * (y[1] - y[0]) - p["L"])(flight(p, z, t)), early)  # noqa: B023
                return flight(p, strike(p, flight(p, z, hit)), early - hit)

            jump = differences(through, before, STEP)
            free = {}
            for name, z in (("a_w_minus", before), ("a_w_plus", after)):
                known = {**p, "theta": z[6], "x_1": z[0], "w": z[1] - z[0], "x_3": z[2], "dot_x_1": z[3], "dot_x_3": z[5]}
                known.update(f_1=mpmath.mpf(0), f_2=mpmath.mpf(0), f_3=mpmath.mpf(0))
                free[name] = eq(6).values({**NUMERIC, **known})["a_w"]
            rate = before[4] - before[3]
            for j in range(7):
                unit = [mpmath.mpf(i == j) for i in range(7)]
                was = coordinates(p, unit)
                now = coordinates(p, list(jump * mpmath.matrix(unit)))
                known = {**NUMERIC, **p, **free, "dot_w_minus": rate}
                known.update({f"delta_{key}_minus": value for key, value in was.items()})
                expected = {**was, "w": eq(84)("delta_w_plus", known), "dot_w": eq(84)("delta_dot_w_plus", known),
                            "dot_x_c": eq(84)("delta_dot_x_c_plus", known)}  # fmt: skip
                for key in was:
                    size = 1 + abs(expected[key])
                    assert abs(now[key] - expected[key]) < mpmath.mpf(10) ** -13 * size, (key, j)
        assert sides == {1, -1}


@pytest.mark.parametrize("p", [basic(), other()], ids=["basic", "other"])
def test_eq_86_sum_of_the_exponents(p: Parameters) -> None:
    """(86) times the time is the log-determinant of the derivative of the whole motion, by differences."""
    with mpmath.workdps(DIGITS):
        count = 2
        time = count * 2 * mpmath.pi / p["omega_1"]
        found = run(p, start(p), time)
        assert len(found.impacts) >= 3
        # No impact is so near the end that a neighbour has it on the other side.
        assert time - found.impacts[-1][0] > mpmath.mpf("1e-3")
        derivative = differences(lambda z: run(p, z, time).end, start(p), STEP)
        known = {**NUMERIC, **p, "K_i": mpmath.mpf(len(found.impacts)), "K": mpmath.mpf(count), "T": time / count}
        tokens = list(eq(86).relations[0].right_tokens)
        at = tokens.index(r"\ln")
        assert tokens[at + 1] == r"\kappa"
        # ln κ as a separate name, which the reader knows.
        from equations import Reader

        value = Reader(tokens[:at] + ["l"] + tokens[at + 2 :], {**known, "l": mpmath.log(p["kappa"])}).all()
        assert abs(mpmath.log(abs(mpmath.det(derivative))) - value * time) < mpmath.mpf(10) ** -12


def test_eq_86_87_exponents_of_the_exact_orbit() -> None:
    """With two impacts a period, the exponents (87) of multipliers with the product (80) have the sum (86)."""
    from equations import Reader

    def logarithm(number: int, inner: Any, known: Dict[str, Any]) -> Any:
        tokens = list(eq(number).relations[0].right_tokens)
        at = tokens.index(r"\ln")
        end = at + 2 if tokens[at + 1] == r"\kappa" else tokens.index(r"\rvert") + 1
        return Reader(tokens[:at] + ["l"] + tokens[end:], {**known, "l": inner}).all()

    # Logarithms and frequencies as symbols: ln κ = k, Σ ln|μ| = 2k - π(d1 + d3).
    w, k = sympy.Symbol("omega_1", positive=True), sym("lnkappa")
    d = eq(69).values({"omega_1": w})
    product = eq(80).relations[1].right({**d, "kappa": sympy.exp(k)})
    total = sympy.simplify(sympy.expand_log(sympy.log(product), force=True))
    left = logarithm(87, total, {"omega_1": w})
    K = sym("K")
    right = logarithm(86, k, {"K": K, "K_i": 2 * K, "T": 2 * sympy.pi / w})
    assert zero(sympy.expand(left - right))
