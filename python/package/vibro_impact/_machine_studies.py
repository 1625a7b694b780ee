"""Basins of attraction, sections and exponents of machines of your own."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _native
from ._arguments import MOST_PERIODS, Floats, number, whole
from ._machine_many import SectionLike, section_of
from ._machine_start import StartLike, numbers_of
from ._progress import Bar
from ._start import Start
from ._show import Line, cells, lines
from ._result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._machine_description import MachineDescription

#: Largest number of cells of a plane in one direction; largest number of points of a section.
_MOST_CELLS = 5_000
_MOST_POINTS = 10_000_000


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Attractor(Result):
    """An attractor of a machine of your own."""

    kind: str
    "Class: 1T, 2T, ..., quasi-periodic, chaotic."
    period: Optional[int]
    "Period in returns to the section, up to 32."
    contacts: float
    "Number of impacts and first touches per return."
    rests: bool
    "Whether a stop stays closed or a friction element sticks at some time."
    interval: float
    "Mean time between returns, s."
    word: str
    "Events of the orbit in order; empty without a period or events."
    stability: str
    "Stability of the orbit; empty if none was found."
    start: Start
    "A start on the attractor, or near it if it has no period."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Basins(Result):
    """Basins of attraction over two numbers of the start."""

    machine: MachineDescription
    "The machine."
    names: tuple[str, str]
    "Start parameters on the horizontal and vertical axis: ``block.s``, ``block.v``, ``time``."
    x: Floats
    "Centres of the cells on the horizontal axis, shape (nx,), SI."
    y: Floats
    "Centres of the cells on the vertical axis, shape (ny,), SI."
    attractors: tuple[Attractor, ...]
    "Attractors, numbered by their first cell; all motions without a period count as one attractor of their class."
    cells: NDArray[np.int32]
    """Index of the attractor that the motion from each cell's centre reaches, shape (ny, nx). Without an attractor: -1 if the start violates a
    rigid stop, -2 if the motion is undecided, -3 if it ends, -4 if it comes to rest."""
    ended: Optional[str]
    "Reason why a motion ended, for the first one that did."
    edges: tuple[float, float, float, float] = dataclasses.field(repr=False)
    "Ends of the plane: left, right, bottom, top."

    def _picture(self) -> str:
        return cells(self.cells, self.edges, *self.names)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Section(Result):
    """A Poincaré section of a machine of your own: ``section["box.s"]`` is a column."""

    machine: MachineDescription
    "Machine of the motion."
    at: Union[float, str, None]
    "Section: a period, s, or an element's name; None for the common period of the harmonics."
    t: Floats
    "Times, shape (n,), s."
    phase: Optional[Floats]
    "Phase of the drive's common period, shape (n,), rad; None without a drive."
    speed: Optional[Floats]
    "Closing speed at a stop's events, shape (n,), m/s or rad/s; None for other sections."
    values: Floats
    "Values of all columns of the machine, shape (n, k); at an event, just after it."

    def __getitem__(self, column: str) -> Floats:
        names = self.machine.columns
        if column not in names:
            raise KeyError(f"{column}: no such column; expected one of {', '.join(names)}")
        found: Floats = self.values[:, names.index(column)]
        return found

    def _picture(self) -> str:
        if self.phase is not None and self.speed is not None:
            return lines([Line(self.phase, self.speed, dots=True)], "phase (rad)", f"closing speed of {self.at}, SI")
        names = self.machine.columns
        place = next((name for name in names if name.endswith(".s")), names[0])
        rate = place[:-2] + ".v"
        return lines([Line(self[place], self[rate if rate in names else place], dots=True)], place, rate)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Spectrum(Result):
    """All Lyapunov exponents of a motion of a machine of your own."""

    machine: MachineDescription
    "Machine of the motion."
    exponents: Floats
    "Exponents, 1/s, largest first; -inf for directions that contacts remove. The exponent 0 of the drive's phase is left out."
    errors: Floats
    "Standard errors of the exponents, 1/s; for a periodic orbit, the difference between two periods."
    period: Optional[int]
    """Period, in returns, of the orbit on which the motion has settled; the exponents are then ln|μ|/T with the orbit's period T and multipliers μ.
    None for a motion without a period, whose exponents are averages."""
    t: Floats
    "Times after the start of averaging, shape (n,), s."
    running: Floats
    "Running exponents at these times, shape (n, k), 1/s."

    def _picture(self) -> str:
        some = [Line(self.t, self.running[:, k], colour=k) for k in range(min(self.running.shape[1], 8))]
        return lines(some, "time (s)", "running exponents (1/s)")


def basins_of(
    machine: MachineDescription, ranges: dict[str, Any], start: StartLike, settle: int, section: SectionLike, progress: bool
) -> Basins:
    """Returns the result of :meth:`Machine.basins`."""
    if len(ranges) != 2:
        raise TypeError(f"ranges {list(ranges)}: expected two numbers of a start, e.g. {{'block.s': ('-4 mm', '4 mm', 60)}}")
    x, y = (_range(machine, name, given) for name, given in ranges.items())
    settle = whole("settle", settle, 0, MOST_PERIODS)
    with Bar(progress, 0, "parts") as bar:
        found = _native.basins(
            machine._described, x, y, numbers_of(machine, start), settle, section_of(section), bar.report
        )
    attractors = tuple(Attractor(**{**a, "start": Start(dict(a["start"]))}) for a in found["attractors"])
    edges = (x[1], x[2], y[1], y[2])
    return Basins(machine, (x[0], y[0]), _centres(x), _centres(y), attractors, found["cells"], found["ended"], edges)


def _range(machine: MachineDescription, name: str, given: Any) -> tuple[str, float, float, int]:
    try:
        first, last, cells = given
    except (TypeError, ValueError):
        raise TypeError(f"{name} = {given!r}: expected (from, to, cells) such as ('-4 mm', '4 mm', 60)") from None
    name = name[5:] if name.startswith("body.") else name
    low, high = (dict(numbers_of(machine, {name: value}))[name] for value in (first, last))
    if not low < high:
        raise ValueError(f"{name} = {given!r}: expected from < to")
    return name, low, high, whole(f"{name}[2]", cells, 1, _MOST_CELLS)


def _centres(axis: tuple[str, float, float, int]) -> Floats:
    _, low, high, count = axis
    found: Floats = low + (high - low) * (np.arange(count) + 0.5) / count
    return found


def poincare_of(
    machine: MachineDescription, section: SectionLike, phase: float, options: tuple[StartLike, int, int], progress: bool
) -> Section:
    """Returns the result of :meth:`Machine.poincare`."""
    start, periods, settle = options
    periods, settle = whole("periods", periods, 1, _MOST_POINTS), whole("settle", settle, 0, MOST_PERIODS)
    with Bar(progress, periods, "points") as bar:
        found = _native.section(
            machine._described, numbers_of(machine, start), number("phase", phase), settle, periods, section_of(section), bar.report
        )
    return Section(machine, section, **found)


def spectrum_of(
    machine: MachineDescription, periods: int, settle: int, section: SectionLike, start: StartLike, progress: bool
) -> Spectrum:
    """Returns the result of :meth:`Machine.spectrum`."""
    periods, settle = whole("periods", periods, 8, MOST_PERIODS), whole("settle", settle, 0, MOST_PERIODS)
    with Bar(progress, periods, "periods") as bar:
        found = _native.spectrum(
            machine._described, numbers_of(machine, start), settle, periods, section_of(section), bar.report
        )
    return Spectrum(machine, **found)
