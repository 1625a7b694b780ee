"""Periodic orbits of the paper's machine by the order of their impacts."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import _native
from ._arguments import Floats, array, displacement, number, whole
from ._base import Value
from ._start import Start
from ._arguments import SI_COORDINATES
from ._paper_parameters import find
from ._progress import Bar
from ._show import lines, pieces
from ._result import Result
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_WEIGHTS = {"x1": (1.0, 0.0, 0.0), "x2": (0.0, 1.0, 0.0), "x3": (0.0, 0.0, 1.0), "w": (-1.0, 1.0, 0.0)}

#: Labels of special points of a branch.
PAPER_LABELS = {
    "LP": "fold: the branch reverses in the parameter",
    "BP": "branch point: on a symmetric orbit the symmetry breaks",
    "PD": "period doubling",
    "NS": "Neimark-Sacker: a second frequency appears",
    "GR": "grazing: the block touches a stop at zero speed",
    "CH": "an impact at zero speed is pressed into its stop: chatter beyond this point",
    "EP": "end of the parameter's range",
    "MX": "the branch could not be followed further",
}


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperOrbit(Result):
    """A certified periodic orbit: it has the impacts of its word and no others."""

    machine: ParameterValues
    "Machine of the orbit."
    word: str
    "Stops in order: letters U and L, or - without impacts. It is the shortest word of the orbit, which may be shorter than the requested word."
    symmetric: bool
    "Whether the word is half of a symmetric orbit, whose second half is the mirror image of the first."
    periods: int
    "Period in drive periods."
    passages: int
    "Traversals of the orbit by the requested word: more than 1 if the word repeats the word of a shorter orbit."
    phases: Floats
    "Phases of the drive at the impacts, shape (n,), rad."
    speeds: Floats
    "Approach speeds |w'| before the impacts, shape (n,), m/s."
    multipliers: NDArray[np.complex128]
    "Multipliers, largest first, shape (6,), over :attr:`multiplier_periods`."
    multiplier_periods: float
    "Drive periods that the multipliers cover: the period, or half of it for a symmetric orbit; the multipliers of the period are then their squares."
    stable: bool
    "Whether the orbit attracts neighbouring motions."
    _half_periods: int = dataclasses.field(repr=False)

    @property
    def period(self) -> float:
        """The period, s."""
        return self.periods * self.machine.period

    def _handle(self) -> _native.PaperOrbit:
        closing = -1 if self.symmetric else 1
        return _native.PaperOrbit(self.machine._system, self.word, closing, self._half_periods, self.phases)

    def motion(self, theta: ArrayLike) -> tuple[Floats, Floats]:
        """Returns displacements (m) and velocities (m/s), shape (n, 3) each, at drive phases (rad), shape (n,); at an impact, just after it."""
        return self._handle().motion(array("theta", theta, "an array of shape (n,) of phases in rad"))

    @property
    def start(self) -> Start:
        """A start on the orbit, at time 0."""
        s, v = self.motion([self.machine.drive_phase])
        return Start({"time": 0.0, **dict(zip(SI_COORDINATES, np.concatenate([s[0], v[0]]).tolist()))})

    def maxima(self, of: Optional[str] = None) -> Floats:
        """Returns local maxima of x1, x2, x3 or w over the period, shape (k,), m; by default of x2."""
        return self._handle().maxima(_WEIGHTS[displacement(of)])

    def follow(self, name: str, low: Value, high: Value, *, of: Optional[str] = None, progress: bool = False) -> PaperBranch:
        """Follows the orbit along a parameter, stable or unstable, and returns the branch with its bifurcations (docs/theory.md, section 14).

        Parameters
        ----------
        name
            The parameter.
        low, high
            Range of the parameter, which contains the machine's own value; in SI or as texts with units.
        of
            The displacement whose maxima are kept, as in :meth:`PaperMachine.bifurcation`.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        RuntimeError
            If the orbit cannot be followed.
        """
        name, ends = _span(self.machine, name, low, high)
        value = getattr(self.machine, name)
        if not ends[0] <= value <= ends[1]:
            raise ValueError(f"low = {low!r}, high = {high!r}: expected a range that contains {name} = {value!r} of the machine")
        of = displacement(of)
        with Bar(progress, 1, "branches") as bar:
            found = _native.paper_follow(self._handle(), name, ends, _WEIGHTS[of], bar.report)
        return _branch(self.machine, name, of, found)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperBranch(Result):
    """A branch of periodic orbits along a parameter."""

    machine: ParameterValues
    "The machine; along the branch its parameter `name` varies."
    name: str
    "Name of the parameter."
    word: str
    "Stops in order, for all its orbits."
    symmetric: bool
    "Whether the word is half of a symmetric orbit."
    periods: int
    "Period in drive periods."
    closed: bool
    "Whether the branch ends where it begins."
    value: Floats
    "Parameter along the branch, shape (n,)."
    phases: list[Floats]
    "Phases of the drive at the impacts, rad, an array for each point."
    multipliers: NDArray[np.complex128]
    "Multipliers, largest first, shape (n, 6), over :attr:`multiplier_periods`."
    stable: NDArray[np.bool_]
    "Whether the piece from each point to the next is stable, shape (n,)."
    labels: NDArray[np.str_]
    "Kind of special point at each point, shape (n,): a key of :data:`PAPER_LABELS`, or empty."
    of: str
    "Displacement whose maxima are recorded."
    maxima: list[Floats]
    "Local maxima of the displacement, m, the largest first, an array for each point."

    @property
    def period(self) -> Floats:
        """The period of each orbit, shape (n,), s."""
        own = self.machine
        drive = [own.replace({self.name: float(x)}).period for x in self.value] if own._changes_period(self.name) else np.full(len(self.value), own.period)
        return self.periods * np.array(drive)

    @property
    def multiplier_periods(self) -> float:
        """Span of the multipliers in drive periods: the period, or half of it for a symmetric orbit."""
        return 0.5 * self.periods if self.symmetric else float(self.periods)

    @property
    def special(self) -> list[tuple[str, float]]:
        """Special points as (label, value of the parameter), in the order of the branch."""
        return [(str(self.labels[i]), float(self.value[i])) for i in np.flatnonzero(self.labels != "")]

    def _picture(self) -> str:
        measure = np.array([m[0] if len(m) else np.nan for m in self.maxima])
        return lines(pieces(self.value, measure, self.stable), self.name, f"largest maximum of {self.of} (m)")


def _span(machine: ParameterValues, name: str, low: Value, high: Value) -> tuple[str, tuple[float, float]]:
    """Returns the name of a parameter and its range."""
    if not isinstance(name, str):
        raise TypeError(f"name = {name!r}: expected the name of a parameter")
    return find(name), (number("low", machine._in_si(name, low)), number("high", machine._in_si(name, high)))


def _branch(machine: ParameterValues, name: str, of: str, found: dict[str, Any]) -> PaperBranch:
    labels = np.array(found.pop("labels"), dtype="U2")
    return PaperBranch(machine=machine, name=name, labels=labels, of=of, periods=found.pop("period"), **found)


def find_branches(
    machine: ParameterValues, name: str, ends: tuple[Value, Value], of: Optional[str], options: tuple[int, int, int], progress: bool
) -> list[PaperBranch]:
    """Finds all branches over a range of a parameter."""
    name, low_high = _span(machine, name, *ends)
    of = displacement(of)
    seeds, depth, settle = options
    seeds, depth = whole("seeds", seeds, 1, 10_000), whole("depth", depth, 0, 40)
    settle = whole("settle", settle, 0, 10_000_000)
    # If a depth is given, random starts find isolated branches that motions along the range miss.
    starts = 0 if depth == 0 else 512
    with Bar(progress, 0, "branches") as bar:
        found = _native.paper_branches(machine._system, name, low_high, _WEIGHTS[of], seeds, depth, settle, starts, bar.report)
    return [_branch(machine, name, of, one) for one in found]


def find_orbit(
    machine: ParameterValues,
    word: Optional[str],
    settled: Optional[tuple[_native.System, list[float], int]],
    period: int,
    symmetric: bool,
    tries: int,
    progress: bool,
) -> PaperOrbit:
    """Finds the orbit of a word, or the orbit of a settled motion."""
    with Bar(progress, 1, "orbits") as bar:
        if settled is not None:
            found = _native.paper_settled_orbit(*settled, bar.report)
        else:
            if not isinstance(word, str):
                raise TypeError(f"word = {word!r}: expected a word of the letters U and L, e.g. 'UL'")
            closing, half_periods = (-1, period) if symmetric else (1, 2 * period)
            all_found = _native.paper_orbit(machine._system, word, closing, half_periods, tries, bar.report)
            # Orbits of the word itself come before orbits of a shorter word.
            rank = (all_found[0].word, all_found[0].closing, all_found[0].passages)
            alike = [orbit for orbit in all_found if (orbit.word, orbit.closing, orbit.passages) == rank]
            found = next((orbit for orbit in alike if orbit.stable), alike[0])
    return PaperOrbit(
        machine,
        found.word,
        found.closing < 0,
        found.period,
        found.passages,
        found.phases,
        found.speeds,
        found.multipliers,
        found.multiplier_periods,
        found.stable,
        found.half_periods,
    )
