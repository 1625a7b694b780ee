"""Periodic orbits by the order of their impacts."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Optional

import numpy as np

from . import _native
from ._arguments import Floats, Start, array, choice, number, state
from ._parameters import find
from ._progress import Bar
from ._result import Result
from ._values import ParameterValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_WEIGHTS = {"x1": (1.0, 0.0, 0.0), "x2": (0.0, 1.0, 0.0), "x3": (0.0, 0.0, 1.0), "w": (-1.0, 1.0, 0.0)}

#: What is special at a point of a branch.
LABELS = {
    "LP": "fold: the branch turns round in the parameter",
    "BP": "branch point: on a symmetric orbit the symmetry breaks",
    "PD": "period doubling",
    "NS": "Neimark-Sacker: a second frequency appears",
    "GR": "grazing: the block touches a stop with speed zero",
    "CH": "an impact with speed zero is pressed into its stop: chatter beyond",
    "EP": "end of the parameter's range",
    "MX": "the branch could not be followed on",
}


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Orbit(Result):
    """A certified periodic orbit: it has the impacts of its word and no others."""

    machine: ParameterValues
    "Whose orbit it is."
    word: str
    "The stops in order, letters U and L, - without impacts: the shortest word of the orbit, which may be shorter than the one that was asked for."
    symmetric: bool
    "Whether the word is half of a symmetric orbit, whose second half is the mirror image of the first."
    period: int
    "The period in drive periods."
    passages: int
    "How often the word that was asked for passes the orbit: more than 1 where it is no orbit of its own."
    phases: Floats
    "Phases of the drive at the impacts, shape (n,), rad."
    speeds: Floats
    "|w'| before the impacts, shape (n,), m/s."
    multipliers: NDArray[np.complex128]
    "Multipliers, largest first, shape (6,), over :attr:`multiplier_periods`."
    multiplier_periods: float
    "Drive periods over which the multipliers are: the period, for a symmetric orbit half of it, so that those of the period are their squares."
    stable: bool
    "Whether it attracts its neighbourhood."
    _half_periods: int = dataclasses.field(repr=False)

    def _handle(self) -> _native.Orbit:
        closing = -1 if self.symmetric else 1
        return _native.Orbit(self.machine._system, self.word, closing, self._half_periods, self.phases)

    def motion(self, theta: ArrayLike) -> tuple[Floats, Floats]:
        """Displacements (m) and velocities (m/s), shape (n, 3) each, at phases of the drive (rad), shape (n,); just after an impact."""
        return self._handle().motion(array("theta", theta, "an array of shape (n,) of phases in rad"))

    @property
    def start(self) -> Floats:
        """The state at time 0, shape (6,): a start for :meth:`Machine.simulate`."""
        s, v = self.motion([self.machine.drive_phase])
        return np.concatenate([s[0], v[0]])

    def maxima(self, of: str = "x2") -> Floats:
        """Local maxima of x1, x2, x3 or w over the period, shape (k,), m."""
        return self._handle().maxima(_WEIGHTS[choice("of", of, tuple(_WEIGHTS))])

    def follow(self, name: str, low: float, high: float, *, of: str = "x2", progress: bool = False) -> Branch:
        """The branch of the orbit along a parameter, stable or not, with its bifurcations (docs/theory.md, section 14).

        Parameters
        ----------
        name
            The parameter.
        low, high
            Its range, which holds the machine's own value.
        of
            The displacement whose maxima are kept.

        Raises
        ------
        ValueError, TypeError
            For arguments out of their range.
        RuntimeError
            Where the orbit cannot be followed.
        """
        if not isinstance(name, str):
            raise TypeError(f"name = {name!r}: allowed is the name of a parameter")
        name = find(name)
        ends = number("low", low), number("high", high)
        value = getattr(self.machine, name)
        if not ends[0] <= value <= ends[1]:
            raise ValueError(f"low = {low!r}, high = {high!r}: allowed is a range that holds {name} = {value!r} of the machine")
        weights = _WEIGHTS[choice("of", of, tuple(_WEIGHTS))]
        with Bar(progress, 1, "branches") as bar:
            found = _native.follow(self._handle(), name, ends, weights, bar.report)
        labels = np.array(found.pop("labels"), dtype="U2")
        return Branch(machine=self.machine, name=name, labels=labels, of=of, **found)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Branch(Result):
    """A branch of periodic orbits along a parameter."""

    machine: ParameterValues
    "The machine with all other parameters."
    name: str
    "The parameter."
    word: str
    "The stops in order, of all its orbits."
    symmetric: bool
    "Whether the word is half of a symmetric orbit."
    period: int
    "The period in drive periods."
    closed: bool
    "Whether it ends where it begins."
    value: Floats
    "The parameter along the branch, shape (n,)."
    phases: list[Floats]
    "Phases of the drive at the impacts, rad, an array for each point."
    multipliers: NDArray[np.complex128]
    "Multipliers, largest first, shape (n, 6), over :attr:`multiplier_periods`."
    stable: NDArray[np.bool_]
    "Whether the piece from a point to the next is stable, shape (n,)."
    labels: NDArray[np.str_]
    "What is special at a point, shape (n,): a key of :data:`LABELS`, or empty."
    of: str
    "The displacement whose maxima are kept."
    maxima: list[Floats]
    "Local maxima of it, m, the largest first, an array for each point."

    @property
    def multiplier_periods(self) -> float:
        """Drive periods over which the multipliers are: the period, for a symmetric orbit half of it."""
        return 0.5 * self.period if self.symmetric else float(self.period)

    @property
    def special(self) -> list[tuple[str, float]]:
        """Special points as (label, value of the parameter), in the branch's order."""
        return [(str(self.labels[i]), float(self.value[i])) for i in np.flatnonzero(self.labels != "")]


def find_orbit(
    machine: ParameterValues,
    word: Optional[str],
    start: Start,
    period: int,
    symmetric: bool,
    settle: int,
    tries: int,
    progress: bool,
) -> Orbit:
    """The orbit of a word, or that of a settled motion."""
    with Bar(progress, 1, "orbits") as bar:
        if word is None:
            found = _native.settled_orbit(machine._system, state("start", start, machine._system), settle, bar.report)
        else:
            if not isinstance(word, str):
                raise TypeError(f"word = {word!r}: allowed is a word of the letters U and L, e.g. 'UL'")
            closing, half_periods = (-1, period) if symmetric else (1, 2 * period)
            all_found = _native.orbit(machine._system, word, closing, half_periods, tries, bar.report)
            # Those of the word itself, if there are some, before those of a shorter one.
            rank = (all_found[0].word, all_found[0].closing, all_found[0].passages)
            alike = [orbit for orbit in all_found if (orbit.word, orbit.closing, orbit.passages) == rank]
            found = next((orbit for orbit in alike if orbit.stable), alike[0])
    return Orbit(
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
