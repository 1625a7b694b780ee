"""Steady states of the paper's machine in closed form."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Optional

import numpy as np

from . import _native
from ._arguments import Floats, array
from ._result import Result
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_THEORIES = ("multiple_scales", "strong_coupling", "exact_orbit")


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class SteadyState(Result):
    """The symmetric motion with two impacts per drive period, by one theory."""

    machine: ParameterValues
    "Machine of the motion."
    theory: str
    "Theory: multiple_scales (weak coupling, small mass ratio), strong_coupling (small mass ratio) or exact_orbit (any parameters)."
    sheet: str
    "Sheet of the solution: upper or lower."
    amplitudes: Floats
    "Largest |x1|, |x2|, |x3|, shape (3,), m."
    drive_phase: float
    "Phase of the drive when the block hits the upper stop, rad."
    geometric: bool
    "Whether the block stays between the stops between its impacts."
    fixed_point: bool
    "Whether the slow flow's fixed point is stable; true for the exact orbit, which has no slow flow."
    periodic_motion: bool
    "Whether all multipliers lie inside the unit circle."
    eigenvalues: NDArray[np.complex128]
    "Eigenvalues of the slow flow's Jacobian, shape (4,), per unit of the slow time; empty for the exact orbit."
    multipliers: NDArray[np.complex128]
    "Multipliers of half a cycle: shape (2,), or (6,) for the exact orbit."
    bifurcation: str
    "Type of bifurcation that the largest multiplier indicates."

    @property
    def stable(self) -> bool:
        """Whether the motion exists and is attracting: all three tests pass."""
        return self.geometric and self.fixed_point and self.periodic_motion

    @property
    def A1(self) -> float:
        """Amplitude of the box in units of L."""
        return float(self.amplitudes[0] / self.machine.stop_gap)

    @property
    def A2(self) -> float:
        """Amplitude of the block in units of L."""
        return float(self.amplitudes[1] / self.machine.stop_gap)

    @property
    def A3(self) -> float:
        """Amplitude of the secondary oscillator in units of L."""
        return float(self.amplitudes[2] / self.machine.stop_gap)

    def motion(self, theta: ArrayLike) -> tuple[Floats, Floats]:
        """Returns displacements (m) and velocities (m/s), shape (n, 3) each, at phases of the drive (rad), shape (n,); just after an impact.

        The phase at time t is ``drive_frequency * t + machine.drive_phase``.
        """
        phases = array("theta", theta, "an array of shape (n,) of phases in rad")
        return _native.paper_steady_motion(self.machine._system, self.theory, self.sheet == "upper", phases)

    @property
    def start(self) -> Floats:
        """The state at time 0, shape (6,): a start for :meth:`PaperMachine.simulate`."""
        s, v = self.motion([self.machine.drive_phase])
        return np.concatenate([s[0], v[0]])


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class SteadyStates(Result):
    """The steady states of a machine by three theories; None for a theory without a solution."""

    multiple_scales: Optional[SteadyState]
    "Results of the paper's sections 3 and 4."
    strong_coupling: Optional[SteadyState]
    "Results of the paper's section 5 in closed form."
    exact_orbit: Optional[SteadyState]
    "The exact orbit of the full system."
    reasons: dict[str, str]
    "Reason why a theory has no result, by its name."


def steady_states(machine: ParameterValues, sheet: str) -> SteadyStates:
    """Returns the steady states on a sheet."""
    states: list[Optional[SteadyState]] = []
    reasons = {}
    for theory in _THEORIES:
        found, reason = _native.paper_steady(machine._system, theory, sheet == "upper")
        states.append(None if found is None else SteadyState(machine, theory, sheet, **found))
        if reason is not None:
            reasons[theory] = reason
    return SteadyStates(states[0], states[1], states[2], reasons)
