"""Periodic orbits of machines of your own, stable or unstable, and their branches along a parameter."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _native
from ._arguments import Floats, number, seconds, whole
from ._machine_locus import Locus, locus_of, ranges_of
from ._machine_many import SectionLike, positive, section_of
from ._machine_start import StartLike, numbers_of
from ._base import merged
from ._progress import Bar
from ._start import Start
from ._show import lines, pieces
from ._result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._machine_description import MachineDescription

#: Labels of special points of a branch of a machine of your own.
LABELS = {
    "LP": "fold: the branch reverses in the parameter",
    "BP": "branch point: two branches cross",
    "PD": "period doubling",
    "NS": "Neimark-Sacker: a second frequency appears",
    "GR": "grazing: a stop is touched at zero speed",
    "ST": "a friction element starts or stops sticking, or slips once more",
    "CC": "two events of different elements swap their order",
    "SA": "an output of a block reaches or leaves a limit",
    "CH": "impacts stop accumulating",
    "EP": "end of the parameter's range",
    "MX": "the branch could not be followed further",
}

#: Labels of points at which curves over two parameters begin.
_BEGINS = tuple(label for label in LABELS if label not in ("EP", "MX"))
#: Number of points on either side of a special point that may start the search for an orbit.
_BESIDE = 6

_MOST_RETURNS = 10_000_000


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Orbit(Result):
    """A periodic orbit of a machine of your own."""

    machine: MachineDescription
    "Machine of the orbit."
    word: str
    "Events in order: ``impact steel, press buffer, free buffer``."
    period: float
    "Period, s."
    periods: Optional[int]
    "Period in common periods of the drive; None for a machine without a drive."
    multipliers: NDArray[np.complex128]
    "Multipliers of the period, largest first, without the ones that theory fixes at 1."
    stability: str
    "``stable``, ``unstable``, ``neutral`` (a machine without losses) or ``undecided``."
    violation: Optional[str]
    "Reason why the orbit is not a motion of the machine; None if it is one."
    start: Start
    "A start on the orbit, in the middle of its longest flight."
    events: list[tuple[float, str, str]]
    "Time (s), kind and element of each event."
    _handle: Optional[_native.Orbit] = dataclasses.field(repr=False)

    @property
    def stable(self) -> bool:
        """Whether the orbit attracts neighbouring motions."""
        return self.stability == "stable"

    def measure(self, name: str) -> float:
        """Returns a measure of :func:`measure_many` over one period, such as ``amplitude.box.s``, in SI; not a power, class or exponent."""
        if not isinstance(name, str):
            raise TypeError(f"name = {name!r}: expected the name of an output, such as 'amplitude.box.s'")
        return self._solved().measure(name)

    def gradient(self, name: str) -> dict[str, Optional[float]]:
        """Returns the derivatives of a measure, as in :meth:`measure`, with respect to every parameter except the start, by name, in SI.

        ``orbit.gradient("amplitude.box.s")["stop.steel.gap"]``. The orbit keeps its word for the derivative. A value is None if no derivative exists:
        at a fold, or if the machine has no periodic orbit after any change of the parameter, for example of one of several frequencies, which then
        have no common period.
        """
        if not isinstance(name, str):
            raise TypeError(f"name = {name!r}: expected the name of an output, such as 'amplitude.box.s'")
        return {parameter: value for parameter, value, _ in self._solved().gradient(name)}

    def energies(self) -> Optional[dict[str, float]]:
        """Returns the energy that each load supplies and each other element takes, J per period; None if the orbit is too unstable for a motion to
        stay on it."""
        found = self._solved().energies()
        return None if found is None else dict(found)

    def follow(
        self, name: str, low: Union[float, str], high: Union[float, str], *, of: Optional[str] = None, progress: bool = False
    ) -> Branch:
        """Follows the orbit along a parameter, stable or unstable, and returns the branch with its bifurcations.

        Parameters
        ----------
        name
            The parameter.
        low, high
            Range of the parameter, which contains the machine's own value; in SI or as texts with units.
        of
            The measure that is kept for each orbit; by default the amplitude of the first free body.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range.
        RuntimeError
            If the orbit cannot be followed.
        """
        ends, of = _ends(self.machine, name, low, high), _of(self.machine, of)
        with Bar(progress, 1, "branches") as bar:
            found = _native.follow(self._solved(), name, ends, of, bar.report)
        return _branch(self.machine, name, of, found)

    def _solved(self) -> _native.Orbit:
        """Returns the library's orbit; an orbit from another process is solved for again from its start."""
        handle = self._handle
        if handle is None:
            time = self.period if self.periods is None else None
            own = (self.machine._described, list(self.start.items()), 0, None, self.word or None, self.periods, time, 0)
            handle = _native.orbit(*own)
            object.__setattr__(self, "_handle", handle)
        return handle

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_handle": None}


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Branch(Result):
    """A branch of periodic orbits along a parameter."""

    machine: MachineDescription
    "The machine; along the branch its parameter `name` varies."
    name: str
    "Name of the parameter."
    word: str
    "Events of all its orbits."
    periods: Optional[int]
    "Period in common periods of the drive."
    closed: bool
    "Whether the branch ends where it begins."
    parent: Optional[tuple[int, int]]
    "Branch and point at the start of this branch; None if it begins at a settled motion."
    value: Floats
    "Parameter along the branch, shape (n,), SI."
    period: Floats
    "Period of each orbit, shape (n,), s."
    multipliers: list[NDArray[np.complex128]]
    "Multipliers of each orbit, largest first."
    stability: NDArray[np.str_]
    "Stability of the piece from each point to the next, shape (n,)."
    stable: NDArray[np.bool_]
    "Whether the piece from each point to the next is stable, shape (n,)."
    labels: NDArray[np.str_]
    "Kind of special point at each point, shape (n,): a key of :data:`LABELS`, or empty."
    elements: NDArray[np.str_]
    "Element that the special point concerns, shape (n,); empty for other points."
    of: str
    "Name of the recorded output."
    measure: Floats
    "Value of the output for each orbit, shape (n,), SI."
    starts: list[Optional[Start]]
    """A start on each orbit; None if it is unknown. With the machine of a point,
    ``machine.replace({branch.name: branch.value[i]})``, it leads :meth:`Machine.orbit` back to the orbit."""

    @property
    def special(self) -> list[tuple[str, float, str]]:
        """Special points as (label, value of the parameter, element), in the order of the branch."""
        return [(str(self.labels[i]), float(self.value[i]), str(self.elements[i])) for i in np.flatnonzero(self.labels != "")]

    def locus(
        self, point: int, ranges: Optional[Mapping[str, tuple[Any, Any]]] = None, *, progress: bool = False, **more: tuple[Any, Any]
    ) -> Locus:
        """Follows a special point of this branch over two parameters and returns the curve: ``vibro locus FILE``.

        ``branch.locus(k, {branch.name: (0.01, 0.05), "stop.floor.restitution": (0.4, 0.8)})`` for each k of ``np.flatnonzero(branch.labels == "LP")``

        Parameters
        ----------
        point
            Index of the special point among the points of this branch.
        ranges, **more
            The branch's parameter and a second one, each with (from, to), in SI or as texts with units. The curve begins at the machine's own
            value of the second parameter and stays in both ranges.

        Raises
        ------
        ValueError, TypeError
            If an argument is out of its range, if no curve begins at the point, or if no curve passes through it.
        """
        point = whole("point", point, 0, len(self.value) - 1)
        label, value, name = str(self.labels[point]), float(self.value[point]), self.name
        if label not in _BEGINS:
            expected = [k for k in range(len(self.value)) if self.labels[k] in _BEGINS]
            raise ValueError(f"point = {point}: no curve begins at this point ({label or 'not special'}); expected one of {expected}")
        own, second = ranges_of(self.machine, name, merged(ranges, more, "ranges"))
        low, high = own[1]
        if not low <= value <= high:
            raise ValueError(f"{name} = {value} at point {point}: the curve begins here, so it must lie in the range {low} to {high}")
        near = (k for step in range(1, _BESIDE + 1) for k in (point - step, point + step) if 0 <= k < len(self.value) and not self.labels[k])
        orbits = ((k, self.starts[k]) for k in near if low <= self.value[k] <= high)
        beside = [(float(self.value[k]), float(self.period[k]), list(start.items())) for k, start in orbits if start is not None]
        return locus_of(self.machine, (own, second), (label, str(self.elements[point]), value), beside, progress)

    def _picture(self) -> str:
        return lines(pieces(self.value, self.measure, self.stable), self.name, f"{self.of}, SI")


def _ends(machine: MachineDescription, name: str, low: Union[float, str], high: Union[float, str]) -> tuple[float, float]:
    if not isinstance(name, str):
        raise TypeError(f"name = {name!r}: expected the name of a parameter")
    return number("low", machine._in_si(name, low)), number("high", machine._in_si(name, high))


def _of(machine: MachineDescription, of: Optional[str]) -> str:
    if of is None:
        return next((name for name in machine.measures if name.startswith("amplitude.")), "impacts")
    if not isinstance(of, str):
        raise TypeError(f"of = {of!r}: expected the name of an output, such as 'amplitude.box.s'")
    return of


def _branch(machine: MachineDescription, name: str, of: str, found: dict[str, Any]) -> Branch:
    for key in ("stability", "labels", "elements"):
        found[key] = np.array(found[key], dtype=np.str_)
    found["starts"] = [None if numbers is None else Start(dict(numbers)) for numbers in found["starts"]]
    return Branch(machine=machine, name=name, of=of, **found)


def find_orbit(
    machine: MachineDescription,
    wanted: tuple[Optional[str], Union[None, float, str], int],
    start: StartLike,
    settle: int,
    section: SectionLike,
    progress: bool,
) -> Orbit:
    """Finds the orbit on which a motion settles, or an orbit with a given word or period."""
    word, period, tries = wanted
    numbers = numbers_of(machine, start)
    settle, tries = whole("settle", settle, 0, _MOST_RETURNS), whole("tries", tries, 0, 100_000)
    if word is not None and not isinstance(word, str):
        raise TypeError(f"word = {word!r}: expected a text of events, such as 'impact steel, press buffer'")
    periods, time = _period(machine, period)
    with Bar(progress, 1, "orbits" if word is None and period is None else "returns at most") as bar:
        found = _native.orbit(
            machine._described, numbers, settle, section_of(section), word, periods, time, tries, bar.report
        )
    own = Start(dict(found.start))
    return Orbit(
        machine, found.word, found.period, found.periods, found.multipliers, found.stability, found.violation, own, found.events, found
    )


def _period(machine: MachineDescription, period: Union[None, float, str]) -> tuple[Optional[int], Optional[float]]:
    """Returns a period as a number of common periods of the drive, or as a time, s."""
    if period is None:
        return None, None
    if not isinstance(period, str):
        return None, positive("period", period)
    turns = period.strip()
    if turns.endswith("T"):
        if not turns[:-1].strip().isdecimal() or not 1 <= int(turns[:-1]) <= 32:
            raise ValueError(f"period = {period!r}: expected '1T' to '32T', or a time, such as 0.1 or '0.1 s'")
        return int(turns[:-1]), None
    return None, positive("period", seconds("period", period))


def find_branches(
    machine: MachineDescription,
    name: str,
    ends: tuple[Union[float, str], Union[float, str]],
    of: Optional[str],
    options: tuple[StartLike, int, int, int, SectionLike],
    progress: bool,
) -> list[Branch]:
    """Finds all branches over a range of a parameter."""
    start, seeds, depth, settle, section = options
    of, low_high = _of(machine, of), _ends(machine, name, *ends)
    seeds, depth = whole("seeds", seeds, 1, 10_000), whole("depth", depth, 0, 40)
    settle = whole("settle", settle, 0, _MOST_RETURNS)
    with Bar(progress, 0, "branches") as bar:
        found = _native.branches(
            machine._described, name, low_high, of, numbers_of(machine, start), seeds, depth, settle, section_of(section), bar.report
        )
    return [_branch(machine, name, of, one) for one in found]
