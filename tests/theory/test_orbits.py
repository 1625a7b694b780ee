"""Section 14: periodic orbits with any impact word."""

from functools import lru_cache
from typing import Any, List, Tuple

import mpmath
import sympy
from equations import eq, tokens_of
from orbits import Phases, Word
from simulation import DIGITS, accelerations, basic, differences, flight, run, strike

TIGHT = mpmath.mpf(10) ** -18
# Central differences of 1e-10 leave their square, amplified by the orbit's third derivatives.
DIFFERENCE = mpmath.mpf(10) ** -14
STEP = mpmath.mpf(10) ** -10
# Phases of the motion with the word UUL at f10 = 2.7, to some digits.
UUL_PHASES = [3.4248, 6.5312, 8.3225]
# Phases of the word UUL where its second impact has no speed, with the force, and the flight that
# ends there.
TOUCH, TOUCH_FLIGHT = [3.462, 6.6588, 8.4478, 0.28998], 0


@lru_cache(maxsize=None)
def three() -> Tuple[Word, Phases]:
    """Three impacts a period at f10 = 2.7: upper, upper, lower."""
    with mpmath.workdps(DIGITS):
        word = Word(basic(F_10="0.27"), [1, 1, -1], 1, 2)
        return word, word.solve(UUL_PHASES)


@lru_cache(maxsize=None)
def two() -> Tuple[Word, Phases]:
    """The symmetric motion of the default set by half its word."""
    with mpmath.workdps(DIGITS):
        word = Word(basic(), [1], -1, 1)
        return word, word.solve([5.5])


def test_eq_98_99_100_motion_without_impacts() -> None:
    """(98): p solves the equations of motion under the drive and under loads, with (99) and (100)."""
    with mpmath.workdps(DIGITS):
        word = Word(basic(F_10="0.02"), [1], 1, 2, (0.03, -0.01, 0.004))
        k = word.k
        for theta in (mpmath.mpf("0.3"), mpmath.mpf(2)):
            y = word.particular(theta)
            speed = k["L"] * k["omega_1"]
            z = [k["L"] * y[i] for i in range(3)] + [speed * y[i] for i in range(3, 6)] + [theta]
            loads = [k[f"f_{i}"] / k[f"m_{i}"] for i in (1, 2, 3)]
            found = [a + f for a, f in zip(accelerations(k, z), loads)]
            second = [-(k["L"] * k["omega_1"] ** 2) * (y[0] - k["x_1s"]), 0, 0]
            assert max(abs(a - b) for a, b in zip(found, second)) < TIGHT
            assert abs(word.forced(theta)[0] - (y[1] - y[0])) < TIGHT
        assert [r.key for r in eq(98).relations] == ["yp", "p", "zp"]
        # A gap off its centre by δ: the pair of loads moves the block by -δ against the stops.
        delta = mpmath.mpf("0.02")
        pair = Word(basic(), [1], 1, 2, (0, -k["k_23"] * delta, k["k_23"] * delta))
        assert abs(pair.k["w_s"] + delta / k["L"]) < TIGHT


def test_eq_101_102_103_orbit_returns_and_meets_the_impact_law() -> None:
    """(101) to (103): the phases at which the residual is zero are the phases of the motion by the equations of motion alone."""
    with mpmath.workdps(DIGITS):
        for (word, phases), half in ((three(), 2), (two(), 1)):
            start = word.si(phases)
            found = run(word.k, start, half * mpmath.pi / word.k["omega_1"] - mpmath.mpf(10) ** -12)
            times = [(phase - phases[0]) / word.k["omega_1"] for phase in word.arrivals(phases)[:-1]]
            assert len(found.impacts) == len(times)
            assert max([abs(a[0] - b) for a, b in zip(found.impacts, times)] + [0]) < mpmath.mpf(10) ** -16
            end = run(word.k, start, half * mpmath.pi / word.k["omega_1"] + mpmath.mpf("0.1")).impacts[-1][2]
            assert max(abs(a - word.sigma * b) for a, b in zip(end[:6], start)) < mpmath.mpf(10) ** -16
        assert "".join(tokens_of(eq(103).tex)).count("=") == 4


def test_eq_102_the_map_at_fixed_phases_contracts() -> None:
    """M of (102) shortens states in the norm of the energy, though the orbit is unstable."""
    with mpmath.workdps(DIGITS):
        word, phases = three()
        k = word.k
        # (88) in units of L and ω1 L, by (1).
        w = k["omega_1"]
        stiffness = mpmath.matrix([[k["k_1"], 0, 0], [0, k["k_23"], -k["k_23"]], [0, -k["k_23"], k["k_3"] + k["k_23"]]])
        energy = mpmath.zeros(6)
        for i in range(3):
            energy[3 + i, 3 + i] = k[f"m_{i + 1}"] * w**2
            for j in range(3):
                energy[i, j] = stiffness[i, j]
        lower = mpmath.cholesky(energy)
        for shift in (0, 0.2, 0.5):
            M = word.map([phases[0], phases[1] + shift, phases[2]])
            in_energy = lower.T * M * (lower.T) ** -1
            assert max(mpmath.svd_r(in_energy, compute_uv=False)) < 1
            assert max(abs(x) for x in mpmath.eig(M, left=False, right=False)) < 1


def test_eq_104_105_derivatives_by_differences() -> None:
    """(104), (105): the derivative of the residual against central differences, away from an orbit too."""
    with mpmath.workdps(DIGITS):
        word, phases = three()
        for at in (phases, [p + d for p, d in zip(phases, (0.1, -0.05, 0.2))]):
            at = [mpmath.mpf(x) for x in at]
            found = differences(word.residual, at, STEP)
            assert mpmath.norm(found - word.derivative(at)) < DIFFERENCE * (1 + mpmath.norm(found))


def test_eq_106_multipliers_by_differences_of_the_motion() -> None:
    """(106) against differences of the motion over a period, from mid-flight."""
    with mpmath.workdps(DIGITS):
        word, phases = three()
        k = word.k
        units = [k["L"]] * 3 + [k["L"] * k["omega_1"]] * 3
        middle = (phases[1] - phases[0]) / 3
        carry = mpmath.expm(k["A"] * middle)
        z = carry * word.start(phases) + word.particular(phases[0] + middle)
        period = 2 * mpmath.pi / k["omega_1"]

        def map(x: List[Any]) -> List[Any]:
            end = run(k, [a * u for a, u in zip(x, units)] + [phases[0] + middle], period).end
            return [a / u for a, u in zip(end[:6], units)]

        found = differences(map, list(z), STEP)
        expected = carry * word.monodromy(phases) * carry**-1
        assert mpmath.norm(found - expected) < mpmath.mpf(10) ** -11 * (1 + mpmath.norm(expected))


def test_eq_107_108_determinants() -> None:
    """(107) for both words and both signs, and the zeros of (108) where a multiplier is 1 or -1."""
    with mpmath.workdps(DIGITS):
        for word, phases in (three(), two()):
            rates, n = word.rates(phases), len(phases)
            product = mpmath.mpf(1)
            for rate in rates:
                product = product * rate
            for c in (1, -1):
                left = mpmath.det(word.monodromy(phases) - c * mpmath.eye(6)) * product
                closed = mpmath.det(c * word.sigma * mpmath.eye(6) - word.map(phases))
                right = c * (-1) ** (n - 1) * mpmath.det(word.derivative(phases, c)) * closed
                assert abs(left - right) < TIGHT * (1 + abs(left))
        # The symmetry of the default set breaks where t_PD of (108) is zero.
        def breaking(force: Any) -> Any:
            word = Word(basic(F_10=force), [1], -1, 1)
            return mpmath.det(word.derivative(word.solve([5.5]), -1))

        force = mpmath.findroot(breaking, (mpmath.mpf("0.2039"), mpmath.mpf("0.204")), solver="secant", tol=1e-40)
        word = Word(basic(F_10=force), [1], -1, 1)
        multipliers = mpmath.eig(word.monodromy(word.solve([5.5])), left=False, right=False)
        assert min(abs(m + 1) for m in multipliers) < mpmath.mpf(10) ** -15
        assert abs(force - mpmath.mpf("0.2039588865238")) < mpmath.mpf(10) ** -13
        assert [r.key for r in eq(108).relations] == ["t_LP", "t_PD"]


def test_eq_109_a_touch_belongs_to_both_words() -> None:
    """At a zero of (109) the orbit without the touching impact is the same motion, and touches the stop."""
    with mpmath.workdps(DIGITS):
        guess = [mpmath.mpf(x) for x in TOUCH]

        def equations(*u: Any) -> List[Any]:
            word = Word(basic(F_10=u[3]), [1, 1, -1], 1, 2)
            phases = list(u[:3])
            slow = word.rates(phases)[TOUCH_FLIGHT] * word.stop(TOUCH_FLIGHT + 1)
            return [*word.residual(phases), slow]

        u = list(mpmath.findroot(equations, guess, tol=1e-40, maxsteps=20))
        longer = Word(basic(F_10=u[3]), [1, 1, -1], 1, 2)
        gone = (TOUCH_FLIGHT + 1) % 3
        kept = [i for i in range(3) if i != gone]
        shorter = Word(basic(F_10=u[3]), [longer.stops[i] for i in kept], 1, 2)
        phases = shorter.solve([float(u[i]) for i in kept])
        assert max(abs(phases[a] - u[b]) for a, b in enumerate(kept)) < mpmath.mpf(10) ** -15
        assert abs(u[3] * 10 - mpmath.mpf("2.899802377121")) < mpmath.mpf(10) ** -12
        # The derivative of the longer word is regular there.
        assert abs(mpmath.det(longer.derivative(u[:3]))) > 0.01
        # (109) states the same: its last relation is the velocity's.
        assert eq(109).relations[-1].right_tokens == ("0",) and eq(109).relations[-1].left_tokens[0] == "s"


def test_eq_110_bordered_matrix() -> None:
    """g of (110) is the determinant over the determinant of the bordered matrix, so that both are zero together."""
    entries = sympy.symbols("a b c d u1 u2 v1 v2", real=True)
    a, b, c, d, u1, u2, v1, v2 = entries
    matrix = sympy.Matrix([[a, b, u1], [c, d, u2], [v1, v2, 0]])
    g = matrix.LUsolve(sympy.Matrix([0, 0, 1]))[2]
    assert sympy.simplify(g - (a * d - b * c) / matrix.det()) == 0
    assert r"\begin" in eq(110).tex


def falling(p: Any, z: List[Any], f_2: Any, span: Any) -> List[Any]:
    """A flight of (6) with a load on a block without a spring, by the equations of the block alone."""
    end = flight(p, z, span)
    fall = f_2 / p["m_2"]
    end[1] += fall * span**2 / 2
    end[4] += fall * span
    return end


def test_eq_111_112_113_block_without_a_spring() -> None:
    """(111), (112), (113): phases at which the residual is zero are the phases of a motion by the equations of motion; its impulses balance the load."""
    with mpmath.workdps(DIGITS):
        cases = [([1, -1], 1, 2, 0, [5.5, 8.6]), ([1], -1, 1, 0, [5.5]), ([-1], 1, 2, -0.05, [1.0]), ([1, -1], 1, 2, -0.002, [5.5, 8.6])]
        for stops, sigma, half, load, guess in cases:
            word = Word(basic(k_23=0), stops, sigma, half, (0, load, 0))
            phases = word.solve(guess)
            k, f_2 = word.k, word.k["f_2"]
            z, impulse = word.si(phases), mpmath.mpf(0)
            start = list(z)
            reduced = k["m_1"] * k["m_2"] / (k["m_1"] + k["m_2"])
            for i, (begin, end) in enumerate(zip(phases, word.arrivals(phases))):
                z = falling(k, z, f_2, (end - begin) / k["omega_1"])
                stop = word.stop(i + 1)
                assert abs(z[1] - z[0] - stop * k["L"]) < TIGHT
                assert stop * (z[4] - z[3]) > 0
                impulse += stop * (1 + k["kappa"]) * reduced * stop * (z[4] - z[3])
                z = strike(k, z)
            assert max(abs(a - sigma * b) for a, b in zip(z[:6], start)) < TIGHT
            if sigma == 1:
                assert abs(impulse - f_2 * word.span / k["omega_1"]) < TIGHT
        # The block moved along is a neutral direction of M, so that I - M is singular. B is not.
        word = Word(basic(k_23=0), [1, -1], 1, 2)
        phases = [mpmath.mpf(5.5), mpmath.mpf(8.6)]
        M = word.map(phases)
        assert max(abs(M[i, 1] - (1 if i == 1 else 0)) for i in range(6)) < TIGHT
        assert abs(mpmath.det(word.closed(phases))) > 0.01
        assert [r.key for r in eq(111).relations] == ["zp", "d", "x_1s", "x_2s", "x_3s"]
        assert eq(112).relations[-1].key == "R_n" and eq(113).relations[0].right_tokens == tuple(tokens_of(r"\frac{f_2 \Theta}{\omega_1}"))
