"""Bifurcation diagrams and basins of attraction of the paper's machine."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _native
from ._arguments import COORDINATES, MOST_PERIODS, SI_COORDINATES, Floats, StartOfMachine, choice, coordinates, discarded_and_kept, displacement, evenly_spaced, state, whole
from ._paper_parameters import find
from ._progress import Bar
from ._show import Line, cells, lines
from ._result import Result, direction
from ._paper_values import ParameterValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

#: Largest number of values of a diagram; largest number of cells of a plane in one direction.
_MOST_VALUES = 1_000_000
_MOST_CELLS = 20_000


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperDirection(Result):
    """Settled motions of one direction of a diagram."""

    value: Floats
    "Parameter, shape (n,), in its unit, ascending."
    kind: NDArray[np.str_]
    "Class, shape (n,): 1T, 2T, ..., quasi-periodic, chaotic; periodic, settling; not settled if undecided; refused without a motion."
    period: NDArray[np.int32]
    "Period in drive periods, shape (n,); 0 if there is none up to 32."
    impacts: Floats
    "Number of impacts per drive period at the upper and at the lower stop, shape (n, 2)."
    rests: NDArray[np.bool_]
    "Whether the block rests at a stop at some time, shape (n,)."
    maxima: Floats
    "Distinct local maxima of the displacement, shape (k,), units of L, to six digits after the point."
    at: NDArray[np.int64]
    "Index in `value` of each maximum, shape (k,)."
    met: NDArray[np.uint32]
    "Number of occurrences of each maximum, shape (k,)."
    exponents: Optional[Floats]
    "Lyapunov exponents, largest first, shape (n, 7), in units of omega10, if they were requested; 0 where refused."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperDiagram(Result):
    """A bifurcation diagram in both directions."""

    machine: ParameterValues
    "The machine whose parameter varies."
    name: str
    "Name of the parameter."
    of: str
    "Displacement whose maxima are recorded."
    up: PaperDirection
    "Motions with the parameter increasing."
    down: PaperDirection
    "Motions with the parameter decreasing, in ascending order of values."
    hysteresis: NDArray[np.bool_]
    "Whether the two directions end on attractors that are neither equal nor mirror images, shape (n,)."

    def _picture(self) -> str:
        down, up = (Line(way.value[way.at], way.maxima, label, dots=True, colour=k) for k, (way, label) in enumerate(((self.down, "falling"), (self.up, "rising"))))
        return lines([down, up], self.name, f"maxima of {self.of} (units of L)")


def diagram_of(
    machine: ParameterValues,
    parameter: dict[str, ArrayLike],
    start: StartOfMachine,
    periods: tuple[int, int],
    of: Optional[str],
    exponents: Union[bool, int],
    progress: bool,
) -> PaperDiagram:
    """Returns the result of :meth:`PaperMachine.bifurcation`."""
    machine._needs_period("a bifurcation diagram")
    if len(parameter) != 1:
        raise TypeError(f"parameters {list(parameter)}: expected exactly one parameter with its values, e.g. f10=np.linspace(0.5, 5, 451)")
    ((given, values),) = parameter.items()
    name, of = find(given), displacement(of)
    ends, count = evenly_spaced(given, machine._in_si(given, values), _MOST_VALUES)
    discard, keep = discarded_and_kept(periods)
    over = None if exponents is False else 1500 if exponents is True else whole("exponents", exponents, 1, 10_000_000)
    own = None if start is None else state("start", start, machine._system)
    with Bar(progress, 1, "parts") as bar:
        found = _native.paper_bifurcation(
            machine._system, own, name, ends, count, discard, keep, of, over, bar.report
        )
    return PaperDiagram(machine, name, of, direction(PaperDirection, found["up"]), direction(PaperDirection, found["down"]), found["hysteresis"])


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperAttractor(Result):
    """An attractor: class, period, impacts and states of a settled motion."""

    kind: str
    "Class: 1T, 2T, ..., quasi-periodic, chaotic."
    period: Optional[int]
    "Period in drive periods, up to 32."
    impacts: Floats
    "Number of impacts per drive period at the upper and at the lower stop, shape (2,)."
    rests: bool
    "Whether the block rests at a stop at some time."
    symmetric: bool
    "Whether the attractor is its own mirror image."
    states: Floats
    "States at successive whole drive periods of one period, shape (p, 6): x1, x2, x3 (units of L), v1, v2, v3 (L omega10)."
    mirror_states: Floats
    "States of the mirror image, shape (p, 6); none under constant loads."
    sizes: Floats
    "Root mean square of x1, x2, x3 at whole and half drive periods, shape (3,), units of L."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PaperBasins(Result):
    """Basins of attraction over two initial values."""

    machine: ParameterValues
    "The machine."
    names: tuple[str, str]
    "Initial values on the horizontal and vertical axis, by name, in units of L or L omega10."
    x: Floats
    "Centres of the cells on the horizontal axis, shape (nx,), units of L or L omega10."
    y: Floats
    "Centres of the cells on the vertical axis, shape (ny,)."
    attractors: tuple[PaperAttractor, ...]
    "Attractors, numbered by their first cell."
    cells: NDArray[np.int32]
    """Index of the attractor that the motion from each cell's centre reaches, shape (ny, nx). Without an attractor: -1 for a start outside the
    stops, -2 if the motion has not settled, -3 if it is on a chaotic or quasi-periodic attractor, but which one is undecided."""
    mirror: NDArray[np.bool_]
    "Whether the motion reaches the attractor's mirror image, shape (ny, nx)."
    edges: tuple[float, float, float, float] = dataclasses.field(repr=False)
    "Ends of the plane: left, right, bottom, top."

    def _picture(self) -> str:
        return cells(self.cells, self.edges, *self.names)


def basins_of(
    machine: ParameterValues, ranges: dict[str, tuple[float, float, int]], settle: int, start: list[float], progress: bool
) -> PaperBasins:
    """Returns the result of :meth:`PaperMachine.basins`."""
    machine._needs_period("a plane of basins")
    if len(ranges) != 2:
        raise TypeError(f"ranges {list(ranges)}: expected two of {', '.join(COORDINATES)}, e.g. v2=(-2, 2, 100)")
    x, y = (_range(name, given, machine) for name, given in ranges.items())
    x_name, y_name = COORDINATES[x[0]], COORDINATES[y[0]]
    settle = whole("settle", settle, 0, MOST_PERIODS)
    ones = machine._system.dimensional([1.0] * 6)  # L, and L omega10
    scaled = [value / one for value, one in zip(start, ones)]
    with Bar(progress, 1, "parts") as bar:
        found = _native.paper_basins(machine._system, x, y, scaled, settle, bar.report)
    attractors = tuple(PaperAttractor(**a) for a in found["attractors"])
    edges = (x[1], x[2], y[1], y[2])
    return PaperBasins(
        machine, (x_name, y_name), _centres(x), _centres(y), attractors, found["cells"], found["mirror"], edges
    )


def _range(name: str, given: Any, machine: ParameterValues) -> tuple[int, float, float, int]:
    own = choice("a name of a range", name.replace("_", "."), (*COORDINATES, *SI_COORDINATES))
    index = (*COORDINATES, *SI_COORDINATES).index(own) % 6
    try:
        first, last, cells = given
    except (TypeError, ValueError):
        raise TypeError(f"{name} = {given!r}: expected (from, to, cells) such as (-2, 2, 100)") from None
    ends = [coordinates(name, {own: end}) for end in (first, last)]
    low, high = (end.si[index] if own in SI_COORDINATES else end.scaled[index] for end in ends)
    if low is None or high is None or not low < high:
        raise ValueError(f"{name} = {given!r}: expected from < to")
    if own in SI_COORDINATES:
        ones = machine._system.dimensional([1.0] * 6)  # L, and L omega10
        low, high = low / ones[index], high / ones[index]
    return index, low, high, whole(f"{name}[2]", cells, 1, _MOST_CELLS)


def _centres(axis: tuple[int, float, float, int]) -> Floats:
    _, low, high, count = axis
    found: Floats = low + (high - low) * (np.arange(count) + 0.5) / count
    return found
