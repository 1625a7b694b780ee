"""Section 15: momentum over a step, and the limit of Euler's rule."""

import mpmath
import sympy
from equations import eq, sym, zero
from simulation import DIGITS, at, basic, run, series
from test_energy import NODES, WEIGHTS, start


def test_eq_114_momentum_over_impacts() -> None:
    """(114): along a simulated motion with impacts the sum of the impulses (10) is what the smooth forces leave of the momenta."""
    p = basic()
    with mpmath.workdps(DIGITS):
        found = run(p, start(p), mpmath.mpf(9))
        assert len(found.impacts) >= 2
        smooth = [mpmath.mpf(0), mpmath.mpf(0)]
        for z, h in found.pieces:
            x = series(p, z)
            for node, weight in zip(NODES, WEIGHTS):
                for u in (node, 1 - node):
                    x_1, x_2, x_3, v_1, _, _, theta = at(p, z, x, u * h)
                    drive = p["F_10"] * mpmath.sin(theta) - p["c_1"] * v_1 - p["k_1"] * x_1
                    smooth[0] += weight * h * drive
                    smooth[1] += weight * h * p["k_23"] * (x_3 - x_2)
        given = mpmath.mpf(0)
        for _, before, after in found.impacts:
            given += p["m_1"] * (after[3] - before[3])
        first, (last, h) = found.pieces[0][0], found.pieces[-1]
        end = at(p, last, series(p, last), h)
        names = {**p, "v_a": first[3], "v_b": end[3], "u_a": first[4], "u_b": end[4], "S_1": smooth[0], "S_2": smooth[1]}
        box, block = eq(114)("P", names), eq(114)("Q", names)
        # Ten nodes of the rule have 16 digits.
        assert abs(box) > 0.01 and abs(box - given) < 1e-13 and abs(box + block) < 1e-13


def test_eq_115_limit_of_eulers_rule() -> None:
    """(115): at that step the eigenvalues of m x'' + c x' + k x = 0 are mapped onto the unit circle."""
    m, c, k = sym("m"), sym("c"), sym("k")
    h = eq(115)("h_E")
    root = sympy.Symbol("lambda")
    first, second = sympy.roots(m * root**2 + c * root + k, root)
    # For a complex pair, the product is the square of the modulus.
    assert zero((1 + h * first) * (1 + h * second) - 1)
    # A body that only creeps back needs shorter steps, below 2/|λ| of the faster mode.
    creeping = {m: 1, c: 3, k: 1}
    faster = min(first.subs(creeping), second.subs(creeping))
    assert abs(1 + h.subs(creeping) * faster) > 1
    least = sympy.Rational(2 * creeping[m], creeping[c])
    assert least <= 2 / abs(faster) <= 2 * least
