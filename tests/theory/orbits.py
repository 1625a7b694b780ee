"""Periodic orbits with any impact word in any number of digits, by the equations of section 14 of docs/theory.md."""

from typing import Any, Callable, Dict, List, Tuple

import mpmath
from approximation import NUMERIC
from equations import eq
from simulation import DIGITS, differences

Known = Dict[str, Any]
Phases = List[Any]
MATRIX: Dict[str, Any] = {**NUMERIC, "matrix": mpmath.matrix}


def evaluated(number: int, key: str, known: Known) -> Any:
    return eq(number)(key, {**MATRIX, **known})


class Word:
    """Stops, closing sign and length in half drive periods, with a machine and its loads."""

    def __init__(self, p: Known, stops: List[int], sigma: int, half: int, loads: Tuple[float, ...] = (0, 0, 0)):
        self.stops, self.sigma, self.span = stops, sigma, half * mpmath.pi
        k: Known = {**p, "varepsilon": p["m_2"] / p["m_1"], **{f"f_{i + 1}": mpmath.mpf(f) for i, f in enumerate(loads)}}
        k.update(eq(69).values({**NUMERIC, **k}))
        k["A"] = eq(70)("A", {**NUMERIC, **k, "matrix": mpmath.matrix})
        k["H"] = evaluated(71, "H", k)
        k["H_w"] = evaluated(71, "H_w", k)
        self.free = k["k_23"] == 0
        rest = eq(111) if self.free else eq(99)
        k.update({name: rest(name, {**NUMERIC, **k}) for name in ("x_1s", "x_3s")})
        k["x_2s"] = rest("x_2s", {**NUMERIC, **k})
        # d of (111), by its one entry that is not zero.
        self.pull = k["f_2"] / (k["m_2"] * k["omega_1"] ** 2 * k["L"]) if self.free else 0
        k["w_s"] = eq(100)("w_s", {**NUMERIC, **k})
        self.k = k
        share = (1 + k["kappa"]) / (1 + k["varepsilon"])
        # g_w of (101) is J's rank-one part: J = I - share g_w n_v^T.
        self.kick = -share * mpmath.matrix([0, 0, 0, -k["varepsilon"], 1, 0])
        self.J = mpmath.eye(6)
        for row in (3, 4):
            self.J[row, 3] -= self.kick[row]
            self.J[row, 4] += self.kick[row]

        self.flights: Dict[Any, Any] = {}

    def flight(self, span: Any) -> Any:
        """Returns the map of a flight over a span, cached."""
        if span not in self.flights:
            self.flights[span] = mpmath.expm(self.k["A"] * span)
        return self.flights[span]

    def state_after(self, span: Any, z: Any) -> Any:
        """A flight of a state, with the fall of a free block."""
        return self.flight(span) * z + self.pull * mpmath.matrix([0, span**2 / 2, 0, 0, span, 0])

    def stop(self, i: int) -> int:
        return self.stops[i] if i < len(self.stops) else self.sigma * self.stops[0]

    def forced(self, phase: Any) -> List[Any]:
        """w_p of (100) and its first two derivatives."""
        turned = self.k["H_w"] * mpmath.expjpi(phase / mpmath.pi)
        return [mpmath.im(turned) + self.k["w_s"], mpmath.re(turned), -mpmath.im(turned)]

    def particular(self, phase: Any) -> Any:
        """p of (98)."""
        turned = self.k["H"] * mpmath.expjpi(phase / mpmath.pi)
        k = self.k
        return mpmath.matrix([mpmath.im(turned) + k["x_1s"], k["x_2s"], k["x_3s"], mpmath.re(turned), 0, 0])

    def arrivals(self, phases: Phases) -> Phases:
        return list(phases[1:]) + [phases[0] + self.span]

    def law(self, z: Any, phase: Any) -> Any:
        """(101)."""
        return self.J * z + self.kick * self.forced(phase)[1]

    def pass_once(self, phases: Phases, z: Any) -> Tuple[Any, List[Any], List[Any]]:
        before, after = [], []
        for start, end in zip(phases, self.arrivals(phases)):
            before.append(self.state_after(end - start, z))
            z = self.law(before[-1], end)
            after.append(z)
        return z, before, after

    def map(self, phases: Phases) -> Any:
        """M of (102)."""
        M = mpmath.eye(6)
        for start, end in zip(phases, self.arrivals(phases)):
            M = self.J * self.flight(end - start) * M
        return M

    def start(self, phases: Phases) -> Any:
        """z_1 of (103)."""
        r, _, _ = self.pass_once(phases, mpmath.zeros(6, 1))
        if self.free:
            r[1] = self.stops[0] - self.forced(phases[0])[0]
        return mpmath.lu_solve(self.closed(phases), r)

    def closed(self, phases: Phases, c: Any = 1) -> Any:
        """The matrix of (103), or B of (112)."""
        B = c * self.sigma * mpmath.eye(6) - self.map(phases)
        if self.free:
            for column in range(6):
                B[1, column] = [-1, 1, 0, 0, 0, 0][column]
        return B

    def residual(self, phases: Phases) -> List[Any]:
        start = self.start(phases)
        end, before, _ = self.pass_once(phases, start)
        ends = enumerate(zip(before, self.arrivals(phases)))
        found = [z[1] - z[0] + self.forced(end)[0] - self.stop(i + 1) for i, (z, end) in ends]
        if self.free:
            found[-1] = end[1] - self.sigma * start[1]
        return found

    def rates(self, phases: Phases) -> List[Any]:
        _, before, _ = self.pass_once(phases, self.start(phases))
        return [z[4] - z[3] + self.forced(end)[1] for z, end in zip(before, self.arrivals(phases))]

    def delays(self, phases: Phases) -> List[Any]:
        """q of (104) at the end of each flight."""
        found = []
        _, before, after = self.pass_once(phases, self.start(phases))
        A = self.k["A"]
        for b, a, end in zip(before, after, self.arrivals(phases)):
            force = mpmath.matrix([mpmath.re(self.k["H"] * mpmath.expjpi(end / mpmath.pi)), 0, 0,
                                   -mpmath.im(self.k["H"] * mpmath.expjpi(end / mpmath.pi)), 0, 0])  # fmt: skip
            found.append(self.J * (A * b + force) - (A * a + force))
        return found

    def derivative(self, phases: Phases, c: Any = 1) -> Any:
        """(105)."""
        n = len(phases)
        spans = [end - start for start, end in zip(phases, self.arrivals(phases))]
        E = [self.flight(span) for span in spans]
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
        assert "".join(eq(105).relations[0].right_tokens) == r"W(c\sigmaI-M)^{-1}Q+P+V"
        return names["W"] * inverse * names["Q"] + P + V

    def monodromy(self, phases: Phases) -> Any:
        """(106) with (78)."""
        D = mpmath.eye(6)
        normal = mpmath.matrix([[-1, 1, 0, 0, 0, 0]])
        ends = zip(phases, self.arrivals(phases), self.delays(phases), self.rates(phases))
        for start, end, q, rate in ends:
            D = (self.J - q * normal / rate) * self.flight(end - start) * D
        return self.sigma * D

    def solve(self, guess: List[float]) -> Phases:
        """Newton's method with (105), for a free block with differences."""
        phases = [mpmath.mpf(x) for x in guess]
        for _ in range(30):
            slope = differences(self.residual, phases, mpmath.mpf(10) ** -10) if self.free else self.derivative(phases)
            step = mpmath.lu_solve(slope, -mpmath.matrix(self.residual(phases)))
            phases = [a + b for a, b in zip(phases, step)]
            if mpmath.norm(step) < mpmath.mpf(10) ** (5 - DIGITS):
                return phases
        raise AssertionError("no convergence")

    def si(self, phases: Phases) -> List[Any]:
        """The state just after the first impact in SI, with the phase of the drive."""
        y = self.start(phases) + self.particular(phases[0])
        speed = self.k["L"] * self.k["omega_1"]
        return [self.k["L"] * y[i] for i in range(3)] + [speed * y[i] for i in range(3, 6)] + [phases[0]]
