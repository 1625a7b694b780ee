"""Section 13: periodic orbits with any impact word."""

from functools import lru_cache
from typing import Any, Callable, Dict, List, Tuple

import mpmath
import sympy
from approximation import NUMERIC
from equations import eq, tokens_of
from simulation import DIGITS, accelerations, basic, differences, run
from test_exact_orbit import evaluated

TIGHT = mpmath.mpf(10) ** -18
# Central differences of 1e-10 leave their square, amplified by the orbit's third derivatives.
DIFFERENCE = mpmath.mpf(10) ** -14
STEP = mpmath.mpf(10) ** -10

Known = Dict[str, Any]
Phases = List[Any]


class Word:
    """Stops, closing sign and length in half drive periods, with a machine and its loads."""

    def __init__(self, p: Known, stops: List[int], sigma: int, half: int, loads: Tuple[float, ...] = (0, 0, 0)):
        self.stops, self.sigma, self.span = stops, sigma, half * mpmath.pi
        k: Known = {**p, "varepsilon": p["m_2"] / p["m_1"], **{f"f_{i + 1}": mpmath.mpf(f) for i, f in enumerate(loads)}}
        k.update(eq(69).values({**NUMERIC, **k}))
        k["A"] = eq(70)("A", {**NUMERIC, **k, "matrix": mpmath.matrix})
        k["H"] = evaluated(71, "H", k)
        k["H_w"] = evaluated(71, "H_w", k)
        k.update({name: eq(98)(name, {**NUMERIC, **k}) for name in ("x_1s", "x_3s")})
        k["x_2s"] = eq(98)("x_2s", {**NUMERIC, **k})
        k["w_s"] = eq(99)("w_s", {**NUMERIC, **k})
        self.k = k
        share = (1 + k["kappa"]) / (1 + k["varepsilon"])
        # g_w of (100) is J's rank-one part: J = I - share g_w n_v^T.
        self.kick = -share * mpmath.matrix([0, 0, 0, -k["varepsilon"], 1, 0])
        self.J = mpmath.eye(6)
        for row in (3, 4):
            self.J[row, 3] -= self.kick[row]
            self.J[row, 4] += self.kick[row]

    def stop(self, i: int) -> int:
        return self.stops[i] if i < len(self.stops) else self.sigma * self.stops[0]

    def forced(self, phase: Any) -> List[Any]:
        """w_p of (99) and its first two derivatives."""
        turned = self.k["H_w"] * mpmath.expjpi(phase / mpmath.pi)
        return [mpmath.im(turned) + self.k["w_s"], mpmath.re(turned), -mpmath.im(turned)]

    def particular(self, phase: Any) -> Any:
        """p of (97)."""
        turned = self.k["H"] * mpmath.expjpi(phase / mpmath.pi)
        k = self.k
        return mpmath.matrix([mpmath.im(turned) + k["x_1s"], k["x_2s"], k["x_3s"], mpmath.re(turned), 0, 0])

    def arrivals(self, phases: Phases) -> Phases:
        return list(phases[1:]) + [phases[0] + self.span]

    def law(self, z: Any, phase: Any) -> Any:
        """(100)."""
        return self.J * z + self.kick * self.forced(phase)[1]

    def pass_once(self, phases: Phases, z: Any) -> Tuple[Any, List[Any], List[Any]]:
        before, after = [], []
        for start, end in zip(phases, self.arrivals(phases)):
            before.append(mpmath.expm(self.k["A"] * (end - start)) * z)
            z = self.law(before[-1], end)
            after.append(z)
        return z, before, after

    def map(self, phases: Phases) -> Any:
        """M of (101)."""
        M = mpmath.eye(6)
        for start, end in zip(phases, self.arrivals(phases)):
            M = self.J * mpmath.expm(self.k["A"] * (end - start)) * M
        return M

    def start(self, phases: Phases) -> Any:
        """z_1 of (102)."""
        r, _, _ = self.pass_once(phases, mpmath.zeros(6, 1))
        return mpmath.lu_solve(self.sigma * mpmath.eye(6) - self.map(phases), r)

    def residual(self, phases: Phases) -> List[Any]:
        _, before, _ = self.pass_once(phases, self.start(phases))
        ends = enumerate(zip(before, self.arrivals(phases)))
        return [z[1] - z[0] + self.forced(end)[0] - self.stop(i + 1) for i, (z, end) in ends]

    def rates(self, phases: Phases) -> List[Any]:
        _, before, _ = self.pass_once(phases, self.start(phases))
        return [z[4] - z[3] + self.forced(end)[1] for z, end in zip(before, self.arrivals(phases))]

    def delays(self, phases: Phases) -> List[Any]:
        """q of (103) at the end of each flight."""
        found = []
        _, before, after = self.pass_once(phases, self.start(phases))
        A = self.k["A"]
        for b, a, end in zip(before, after, self.arrivals(phases)):
            force = mpmath.matrix([mpmath.re(self.k["H"] * mpmath.expjpi(end / mpmath.pi)), 0, 0,
                                   -mpmath.im(self.k["H"] * mpmath.expjpi(end / mpmath.pi)), 0, 0])  # fmt: skip
            found.append(self.J * (A * b + force) - (A * a + force))
        return found

    def derivative(self, phases: Phases, c: Any = 1) -> Any:
        """(104)."""
        n = len(phases)
        spans = [end - start for start, end in zip(phases, self.arrivals(phases))]
        E = [mpmath.expm(self.k["A"] * span) for span in spans]
        gap: Callable[[Any], Any] = lambda z: z[1] - z[0]
        W, M = mpmath.matrix(n, 6), mpmath.eye(6)
        for i in range(n):
            M = E[i] * M
            for j in range(6):
                W[i, j] = M[1, j] - M[0, j]
            M = self.J * M
        q = self.delays(phases)
        P, Q = mpmath.matrix(n, n), mpmath.matrix(6, n)
        Q[:, 0] = c * q[n - 1]
        for column in range(1, n):
            z = q[column - 1]
            for i in range(column, n):
                z = E[i] * z
                P[i, column] = gap(z)
                z = self.J * z
            Q[:, column] = z
        V = mpmath.matrix(n, n)
        for i, rate in enumerate(self.rates(phases)):
            V[i, (i + 1) % n] = rate * (c if i == n - 1 else 1)
        inverse = (c * self.sigma * mpmath.eye(6) - M) ** -1
        names = {"W": W, "P": P, "Q": Q, "V": V, "M": M, "c": c, "sigma": self.sigma, "I": mpmath.eye(6)}
        assert "".join(eq(104).relations[0].right_tokens) == r"W(c\sigmaI-M)^{-1}Q+P+V"
        return names["W"] * inverse * names["Q"] + P + V

    def monodromy(self, phases: Phases) -> Any:
        """(105) with (78)."""
        D = mpmath.eye(6)
        normal = mpmath.matrix([[-1, 1, 0, 0, 0, 0]])
        ends = zip(phases, self.arrivals(phases), self.delays(phases), self.rates(phases))
        for start, end, q, rate in ends:
            D = (self.J - q * normal / rate) * mpmath.expm(self.k["A"] * (end - start)) * D
        return self.sigma * D

    def solve(self, guess: List[float]) -> Phases:
        """Newton's method with (104)."""
        phases = [mpmath.mpf(x) for x in guess]
        for _ in range(30):
            step = mpmath.lu_solve(self.derivative(phases), -mpmath.matrix(self.residual(phases)))
            phases = [a + b for a, b in zip(phases, step)]
            if mpmath.norm(step) < mpmath.mpf(10) ** (5 - DIGITS):
                return phases
        raise AssertionError("no convergence")

    def si(self, phases: Phases) -> List[Any]:
        """The state just after the first impact in SI, with the phase of the drive."""
        y = self.start(phases) + self.particular(phases[0])
        speed = self.k["L"] * self.k["omega_1"]
        return [self.k["L"] * y[i] for i in range(3)] + [speed * y[i] for i in range(3, 6)] + [phases[0]]


@lru_cache(maxsize=None)
def three() -> Tuple[Word, Phases]:
    """Three impacts a period at f10 = 2.7: upper, upper, lower."""
    with mpmath.workdps(DIGITS):
        word = Word(basic(F_10="0.27"), [1, 1, -1], 1, 2)
        return word, word.solve([UUL_PHASES[0], UUL_PHASES[1], UUL_PHASES[2]])


@lru_cache(maxsize=None)
def two() -> Tuple[Word, Phases]:
    """The symmetric motion of the default set by half its word."""
    with mpmath.workdps(DIGITS):
        word = Word(basic(), [1], -1, 1)
        return word, word.solve([5.5])


# From the simulator, to some digits.
UUL_PHASES = [0.0, 0.0, 0.0]


def test_eq_97_98_99_motion_without_impacts() -> None:
    """(97): p solves the equations of motion under the drive and under loads, with (98) and (99)."""
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
        assert [r.key for r in eq(97).relations] == ["yp", "p", "zp"]
        # A gap off its centre by δ: the pair of loads moves the block by -δ against the stops.
        delta = mpmath.mpf("0.02")
        pair = Word(basic(), [1], 1, 2, (0, -k["k_23"] * delta, k["k_23"] * delta))
        assert abs(pair.k["w_s"] + delta / k["L"]) < TIGHT


def test_eq_100_101_102_orbit_returns_and_meets_the_impact_law() -> None:
    """(100) to (102): the phases at which the residual is zero are those of the motion by the equations of motion alone."""
    with mpmath.workdps(DIGITS):
        for (word, phases), half in ((three(), 2), (two(), 1)):
            start = word.si(phases)
            found = run(word.k, start, half * mpmath.pi / word.k["omega_1"] - mpmath.mpf(10) ** -12)
            times = [(phase - phases[0]) / word.k["omega_1"] for phase in word.arrivals(phases)[:-1]]
            assert len(found.impacts) == len(times)
            assert max([abs(a[0] - b) for a, b in zip(found.impacts, times)] + [0]) < mpmath.mpf(10) ** -16
            end = run(word.k, start, half * mpmath.pi / word.k["omega_1"] + mpmath.mpf("0.1")).impacts[-1][2]
            assert max(abs(a - word.sigma * b) for a, b in zip(end[:6], start)) < mpmath.mpf(10) ** -16
        assert "".join(tokens_of(eq(102).tex)).count("=") == 4


def test_eq_101_the_map_at_fixed_phases_contracts() -> None:
    """M of (101) shortens states in the norm of the energy, though the orbit is unstable."""
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


def test_eq_103_104_derivatives_by_differences() -> None:
    """(103), (104): the derivative of the residual against central differences, away from an orbit too."""
    with mpmath.workdps(DIGITS):
        word, phases = three()
        for at in (phases, [p + d for p, d in zip(phases, (0.1, -0.05, 0.2))]):
            at = [mpmath.mpf(x) for x in at]
            found = differences(word.residual, at, STEP)
            assert mpmath.norm(found - word.derivative(at)) < DIFFERENCE * (1 + mpmath.norm(found))


def test_eq_105_multipliers_by_differences_of_the_motion() -> None:
    """(105) against differences of the motion over a period, from mid-flight."""
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


def test_eq_106_107_determinants() -> None:
    """(106) for both words and both signs, and the zeros of (107) where a multiplier is 1 or -1."""
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
        # The symmetry of the default set breaks where t_PD of (107) is zero.
        def breaking(force: Any) -> Any:
            word = Word(basic(F_10=force), [1], -1, 1)
            return mpmath.det(word.derivative(word.solve([5.5]), -1))

        force = mpmath.findroot(breaking, (mpmath.mpf("0.2039"), mpmath.mpf("0.204")), solver="secant", tol=1e-40)
        word = Word(basic(F_10=force), [1], -1, 1)
        multipliers = mpmath.eig(word.monodromy(word.solve([5.5])), left=False, right=False)
        assert min(abs(m + 1) for m in multipliers) < mpmath.mpf(10) ** -15
        assert abs(force - mpmath.mpf("0.2039588865238")) < mpmath.mpf(10) ** -13
        assert [r.key for r in eq(107).relations] == ["t_LP", "t_PD"]


def test_eq_108_a_touch_belongs_to_both_words() -> None:
    """At a zero of (108) the orbit without the touching impact is the same motion, and touches the stop."""
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
        # (108) says as much: all residuals and one speed.
        assert len(eq(108).relations) == 2


def test_eq_109_bordered_matrix() -> None:
    """g of (109) is the determinant over that of the bordered matrix, so that both are zero together."""
    entries = sympy.symbols("a b c d u1 u2 v1 v2", real=True)
    a, b, c, d, u1, u2, v1, v2 = entries
    matrix = sympy.Matrix([[a, b, u1], [c, d, u2], [v1, v2, 0]])
    g = matrix.LUsolve(sympy.Matrix([0, 0, 1]))[2]
    assert sympy.simplify(g - (a * d - b * c) / matrix.det()) == 0
    assert r"\begin" in eq(109).tex
